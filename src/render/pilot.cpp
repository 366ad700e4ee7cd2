#include "render/pilot.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/assert.hpp"
#include "base/process_usage.hpp"
#include "math/rng.hpp"
#include "render/renderer.hpp"

namespace mlt {
namespace {

// One round takes so much of the job's work, and a second as much if the first leaves the choice open. A
// third would cost more than it tells: where the integrators are close, a wrong choice loses little.
constexpr double kPathShare = 1.0 / 144;  ///< by the path tracer
constexpr double kChainShare = 1.0 / 72;  ///< by PSSMLT, whose errors are rarer
constexpr std::uint64_t kMostRounds = 2;
/// So many times above the threshold, or below it, the first round decides. More is asked for PSSMLT, whose
/// advantage is a tenth less after two rounds than after one: the first has not met all rare errors.
constexpr double kClearlyAbove = 1.5;
constexpr double kClearlyBelow = 1.2;
constexpr double kMostPiloted = 0x1p24;      ///< samples of a job; the pilot of a larger one is no larger
constexpr double kPathSamples = 8;           ///< a pixel, so that some of what stratification gains is seen
constexpr std::uint64_t kChainLength = 512;  ///< mutations: some hundred large steps, and many chains
constexpr std::uint64_t kChainGroup = 16;
constexpr std::uint64_t kBootstrapShare = 8;
constexpr std::uint64_t kPlannedPerPixel = 64;  ///< of jobs that state none, or end by the clock or an error

/// Samples or mutations a pixel that the job will take, as far as its request tells.
double planned_per_pixel(const RenderRequest& request) {
  const bool ends = request.target_error || request.seconds;
  const std::uint64_t per_round =
      request.samples_per_pixel.value_or(request.rounds ? kDefaultPerRound : kPlannedPerPixel);
  double planned = static_cast<double>(per_round);
  if (request.rounds) planned *= static_cast<double>(*request.rounds);
  if (ends && !request.rounds) planned = static_cast<double>(std::max(per_round, kPlannedPerPixel));
  if (request.max_per_pixel) planned = std::min(planned, static_cast<double>(*request.max_per_pixel));
  return planned;
}

/// The request of a round of the pilot by `kind`, without all that makes a job's rounds.
RenderRequest pilot_request(const RenderRequest& request, IntegratorKind kind) {
  RenderRequest pilot = request;
  pilot.integrator = kind;
  pilot.rounds.reset();
  pilot.max_per_pixel.reset();
  pilot.target_error.reset();
  pilot.seconds.reset();
  pilot.chains.reset();
  pilot.bootstrap.reset();
  return pilot;
}

/// The path tracer's error a pixel hardly depends on the size of the film, so that a small one will do.
RenderJob path_job(const SceneDescription& scene, const RenderRequest& request, double samples) {
  RenderRequest pilot = pilot_request(request, IntegratorKind::path);
  const std::uint32_t width = request.width.value_or(scene.film_width);
  const std::uint32_t height = request.height.value_or(scene.film_height);
  const double pixels = static_cast<double>(width) * height;
  const double scale = std::sqrt(std::min(1.0, samples / kPathSamples / pixels));
  pilot.width = static_cast<std::uint32_t>(std::max(1.0, std::floor(width * scale)));
  pilot.height = static_cast<std::uint32_t>(std::max(1.0, std::floor(height * scale)));
  pilot.samples_per_pixel = static_cast<std::uint64_t>(kPathSamples);
  RenderJob job = resolve_job(pilot, scene);
  job.hash_film = false;
  return job;
}

/// About one to kChainLength mutations, as many as fill the lanes of the widest instruction set.
std::uint32_t pilot_chains(std::uint64_t mutations) {
  const std::uint64_t groups = (mutations / kChainLength + kChainGroup / 2) / kChainGroup;
  return static_cast<std::uint32_t>(std::max<std::uint64_t>(1, groups) * kChainGroup);
}

/// That of chains does: what leaves a small pixel stays in a large one. They keep the job's film, although
/// there may be less than one mutation a pixel.
RenderJob chain_job(const SceneDescription& scene, const RenderRequest& request, double mutations) {
  RenderRequest pilot = pilot_request(request, IntegratorKind::pssmlt);
  pilot.samples_per_pixel = 1;
  RenderJob job = resolve_job(pilot, scene);
  job.mutations = static_cast<std::uint64_t>(mutations);
  job.chains = pilot_chains(job.mutations);
  job.bootstrap = job.mutations / kBootstrapShare;
  job.hash_film = false;
  job.estimate_error = false;
  return job;
}

/// Kept at the size of the path tracer's film, at which errors are compared.
PilotRender render_round(Renderer& renderer, const RenderJob& job, const RenderJob& path_settings,
                         const std::atomic<bool>& stop, PilotFinding& finding) {
  const RenderStatistics statistics = renderer.run(stop, nullptr, nullptr);
  finding.paths += statistics.samples;
  const bool metropolis = job.integrator == IntegratorKind::pssmlt;
  const double pixels = static_cast<double>(job.width) * job.height;
  PilotRender round;
  const auto reduced = [&](const auto& pixel_at) {
    return reduced_image(job.width, job.height, pixel_at, path_settings.width, path_settings.height);
  };
  round.image = reduced([image = renderer.image()](std::size_t i) { return image.pixels[i]; });
  round.variances = reduced([&renderer](std::size_t i) { return renderer.variance(i); });
  round.per_pixel =
      metropolis ? static_cast<double>(job.mutations) / pixels : static_cast<double>(job.samples_per_pixel);
  round.paths = static_cast<double>(metropolis ? statistics.mutations : statistics.samples);
  round.primary_samples = static_cast<double>(statistics.primary_samples);
  round.found_light = !statistics.black && !statistics.partial;
  return round;
}

/// Adds round number `index`. One without light is black, and counts. By value, so that its images go before
/// the next are made.
void add_round(PilotRender& mean, PilotRender round, std::uint64_t index) {
  if (index == 0) {
    mean = std::move(round);
    return;
  }
  const float share = 1.0f / static_cast<float>(index + 1);
  for (std::size_t i = 0; i < mean.image.pixels.size(); ++i) {
    mean.image.pixels[i] += (round.image.pixels[i] - mean.image.pixels[i]) * share;
    mean.variances.pixels[i] += (round.variances.pixels[i] - mean.variances.pixels[i]) * share;
  }
  mean.paths += round.paths;
  mean.primary_samples += round.primary_samples;
  mean.found_light = mean.found_light || round.found_light;
}

bool is_clear(double advantage) {
  return advantage > kPilotThreshold * kClearlyAbove || advantage < kPilotThreshold / kClearlyBelow;
}

/// Where roulette begins for both integrators, by the path tracer's `late` first round with the default edge
/// and an `early` one: chains err too rarely for a pilot to see what early roulette costs them.
void choose_roulette(const PilotRender& late, const PilotRender& early, PilotFinding& finding) {
  if (!late.found_light || !early.found_light) return;
  finding.early_roulette_error = pilot_error_ratio(early, late);
  finding.roulette =
      finding.early_roulette_error < kEarlyRouletteThreshold ? kEarlyRouletteEdge : kDefaultRouletteEdge;
}

bool chains_are_better(const PilotFinding& finding) {
  return finding.outcome == PilotOutcome::only_chains ||
         (finding.outcome == PilotOutcome::compared && finding.advantage > kPilotThreshold);
}

/// All rounds; the comparison after the last is the finding's. The scene is compiled once, for the chains.
void compare(const SceneDescription& scene, const RenderRequest& request, double samples,
             const std::atomic<bool>& stop, PilotFinding& finding) {
  const RenderJob chain_settings = chain_job(scene, request, samples * kChainShare);
  const RenderJob path_settings = path_job(scene, request, samples * kPathShare);
  Renderer chain_renderer(scene, chain_settings);
  chain_renderer.prepare();
  Renderer path_renderer(chain_renderer, path_settings);
  path_renderer.prepare();
  PilotRender path, pssmlt;
  std::uint64_t seed = request.seed;
  std::uint32_t roulette = path_settings.roulette;
  for (std::uint64_t round = 0; round < kMostRounds && !stop; ++round) {
    seed = mix64(seed + 0x9e3779b97f4a7c15ULL);
    path_renderer.restart(seed, roulette);
    PilotRender path_round = render_round(path_renderer, path_settings, path_settings, stop, finding);
    if (round == 0 && roulette > 0 && !request.roulette) {
      path_renderer.restart(seed, kEarlyRouletteEdge);
      PilotRender early = render_round(path_renderer, path_settings, path_settings, stop, finding);
      choose_roulette(path_round, early, finding);
      roulette = finding.roulette.value_or(roulette);
      if (roulette == kEarlyRouletteEdge) path_round = std::move(early);
    }
    chain_renderer.restart(seed, roulette);
    add_round(path, std::move(path_round), round);
    add_round(pssmlt, render_round(chain_renderer, chain_settings, path_settings, stop, finding), round);
    if (!path.found_light || !pssmlt.found_light) continue;
    finding.advantage =
        pilot_advantage(path, pssmlt, has(chain_renderer.features(), FeatureBit::lobe_choice));
    finding.outcome = PilotOutcome::compared;
    if (is_clear(finding.advantage)) break;
  }
  if (!path.found_light && pssmlt.found_light) finding.outcome = PilotOutcome::only_chains;
  if (!stop && chains_are_better(finding)) finding.chosen = IntegratorKind::pssmlt;
}

/// What was found of the integrators.
std::string describe_choice(const PilotFinding& finding) {
  switch (finding.outcome) {
    case PilotOutcome::too_small:
      return fmt::format("path: no pilot for a job of fewer than {} samples", kLeastPiloted);
    case PilotOutcome::too_large:
      return fmt::format("path: pssmlt has no room for more than {} mutations", kMaxMutations);
    case PilotOutcome::only_chains:
      return fmt::format("pssmlt: of a pilot of {} paths only its chains found light", finding.paths);
    case PilotOutcome::no_light:
      return fmt::format("path: a pilot of {} paths found too little light to compare", finding.paths);
    case PilotOutcome::compared:
      break;
  }
  const char* chosen = finding.chosen == IntegratorKind::path ? "path" : "pssmlt";
  if (!(finding.advantage > 0.0)) {
    return fmt::format("{}: in a pilot of {} paths it made no error", chosen, finding.paths);
  }
  return fmt::format(
      "{}: in a pilot of {} paths pssmlt needed {:.2g} times path's work for the same error; below {:.2g} it "
      "is taken",
      chosen, finding.paths, 1.0 / finding.advantage, 1.0 / kPilotThreshold);
}

}  // namespace

PilotFinding run_pilot(const SceneDescription& scene, const RenderRequest& request,
                       const std::atomic<bool>& stop) {
  MLT_CHECK(request.integrator == IntegratorKind::automatic);
  const ProcessUsage begin = ProcessUsage::now();
  PilotFinding finding;
  const double pixels = static_cast<double>(request.width.value_or(scene.film_width)) *
                        request.height.value_or(scene.film_height);
  const double samples = pixels * planned_per_pixel(request);
  if (samples < static_cast<double>(kLeastPiloted)) {
    finding.outcome = PilotOutcome::too_small;
  } else if (samples > static_cast<double>(kMaxMutations)) {
    finding.outcome = PilotOutcome::too_large;
  } else {
    compare(scene, request, std::min(samples, kMostPiloted), stop, finding);
  }
  const ProcessUsage end = ProcessUsage::now();
  finding.wall_seconds = end.wall - begin.wall;
  finding.cpu_seconds = end.cpu - begin.cpu;
  return finding;
}

RenderRequest decided(RenderRequest request, const PilotFinding& finding) {
  request.integrator = finding.chosen;
  if (finding.roulette) request.roulette = finding.roulette;
  return request;
}

std::string describe(const PilotFinding& finding, const RenderJob& job) {
  std::string text = describe_choice(finding);
  if (finding.chosen == IntegratorKind::pssmlt) {
    text +=
        fmt::format("; {} chains and a bootstrap of {} paths, by the job's size", job.chains, job.bootstrap);
  }
  if (finding.roulette) {
    text += fmt::format(
        "; roulette from edge {}: path's error from edge {} was {:.2g} times that from edge {}",
        *finding.roulette, kEarlyRouletteEdge, finding.early_roulette_error, kDefaultRouletteEdge);
  }
  return text;
}

}  // namespace mlt
