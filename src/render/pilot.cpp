#include "render/pilot.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "base/assert.hpp"
#include "math/rng.hpp"
#include "render/renderer.hpp"

namespace mlt {
namespace {

constexpr double kPathShare = 1.0 / 64;      ///< of the job's samples, that the path tracer's pilot takes
constexpr double kChainShare = 1.0 / 32;     ///< that PSSMLT's takes, whose errors are rarer
constexpr double kMostPiloted = 0x1p24;      ///< samples of a job; the pilot of a larger one is no larger
constexpr double kPathSamples = 8;           ///< a pixel, so that some of what stratification gains is seen
constexpr std::uint64_t kChainLength = 512;  ///< mutations: some hundred large steps, and many chains
constexpr std::uint64_t kBootstrapShare = 4;
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

/// The request of a pilot by `kind`, without all that ends rounds.
RenderRequest pilot_request(const RenderRequest& request, IntegratorKind kind) {
  RenderRequest pilot = request;
  pilot.integrator = kind;
  pilot.rounds.reset();
  pilot.max_per_pixel.reset();
  pilot.target_error.reset();
  pilot.seconds.reset();
  pilot.chains.reset();
  pilot.bootstrap.reset();
  pilot.seed = mix64(request.seed + 0x9e3779b97f4a7c15ULL);
  return pilot;
}

/// The path tracer's error a pixel hardly depends on the size of the film, so that a small one will do.
RenderJob path_job(const SceneDescription& scene, const RenderRequest& request, std::uint32_t width,
                   std::uint32_t height, double samples) {
  RenderRequest pilot = pilot_request(request, IntegratorKind::path);
  const double pixels = static_cast<double>(width) * height;
  const double scale = std::sqrt(std::min(1.0, samples / kPathSamples / pixels));
  pilot.width = static_cast<std::uint32_t>(std::max(1.0, std::floor(width * scale)));
  pilot.height = static_cast<std::uint32_t>(std::max(1.0, std::floor(height * scale)));
  pilot.samples_per_pixel = static_cast<std::uint64_t>(kPathSamples);
  return resolve_job(pilot, scene);
}

/// That of chains does: what leaves a small pixel stays in a large one. They keep the job's film, although
/// there may be less than one mutation a pixel.
RenderJob chain_job(const SceneDescription& scene, const RenderRequest& request, double mutations) {
  RenderRequest pilot = pilot_request(request, IntegratorKind::pssmlt);
  pilot.samples_per_pixel = 1;
  RenderJob job = resolve_job(pilot, scene);
  job.mutations = static_cast<std::uint64_t>(mutations);
  job.chains = static_cast<std::uint32_t>(job.mutations / kChainLength);
  job.bootstrap = job.mutations / kBootstrapShare;
  return job;
}

PilotRender render_pilot(const SceneDescription& scene, const RenderJob& job, const std::atomic<bool>& stop,
                         PilotFinding& finding) {
  Renderer renderer(scene, job);
  renderer.prepare();
  const RenderStatistics statistics = renderer.run(stop, nullptr, nullptr);
  finding.paths += statistics.samples;
  finding.wall_seconds += statistics.wall_seconds;
  finding.cpu_seconds += statistics.cpu_seconds;
  PilotRender render;
  if (!statistics.error.known || statistics.black || statistics.partial) return render;
  const bool metropolis = job.integrator == IntegratorKind::pssmlt;
  const double pixels = static_cast<double>(job.width) * job.height;
  const double paths = static_cast<double>(metropolis ? statistics.mutations : statistics.samples);
  const ImageView view = renderer.image();
  render.image = {view.width, view.height, {view.pixels.begin(), view.pixels.end()}};
  render.variances = renderer.variances();
  render.per_pixel = paths / pixels;
  render.primary_samples = static_cast<double>(statistics.primary_samples) / paths;
  render.found_light = true;
  return render;
}

}  // namespace

PilotFinding run_pilot(const SceneDescription& scene, const RenderRequest& request,
                       const std::atomic<bool>& stop) {
  MLT_CHECK(request.integrator == IntegratorKind::automatic);
  PilotFinding finding;
  const std::uint32_t width = request.width.value_or(scene.film_width);
  const std::uint32_t height = request.height.value_or(scene.film_height);
  const double samples = static_cast<double>(width) * height * planned_per_pixel(request);
  finding.outcome = samples < static_cast<double>(kLeastPiloted)   ? PilotOutcome::too_small
                    : samples > static_cast<double>(kMaxMutations) ? PilotOutcome::too_large
                                                                   : PilotOutcome::no_light;
  if (finding.outcome != PilotOutcome::no_light) return finding;
  const double piloted = std::min(samples, kMostPiloted);
  const PilotRender path =
      render_pilot(scene, path_job(scene, request, width, height, piloted * kPathShare), stop, finding);
  const PilotRender pssmlt =
      render_pilot(scene, chain_job(scene, request, piloted * kChainShare), stop, finding);
  if (stop || !pssmlt.found_light) return finding;
  finding.outcome = path.found_light ? PilotOutcome::compared : PilotOutcome::only_chains;
  if (path.found_light) finding.advantage = pilot_advantage(path, pssmlt);
  if (!path.found_light || finding.advantage > kPilotThreshold) finding.chosen = IntegratorKind::pssmlt;
  return finding;
}

std::string describe(const PilotFinding& finding) {
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

}  // namespace mlt
