// Chains: their number, lengths, large steps, counters and frozen b, on a floor whose every pixel is known in
// closed form and varies by a factor of ten. Below the level of jobs, chains are run here as the kernel runs
// them, so that what no option reaches can be set: where time starts, b inside the weights, and defects.
#include "markov/chain.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "film/fixed_film.hpp"
#include "integrator/features.hpp"
#include "integrator/path.hpp"
#include "markov/bootstrap.hpp"
#include "scenes.hpp"
#include "support/compiled_scene.hpp"
#include "sweep.hpp"

namespace mlt::test {
namespace {

constexpr std::uint32_t kSide = 8;
constexpr std::uint32_t kReplicates = 16;

/// The film's mean, and its dark and its bright edge, each against the closed form.
void add_floor_rows(SweepTable& table, const std::string& name, const std::vector<RenderResult>& replicates) {
  const double slack = 2e-6;
  table.add(name + ", film", film_mean(replicates, lit_floor_radiance(), slack));
  const struct {
    const char* name;
    std::uint32_t x0, x1;
  } edges[] = {{", dark edge", 0, 2}, {", bright edge", 6, 8}};
  for (const auto& edge : edges) {
    const Moments part = moments_of(replicates, [&edge](const ImageView& image) {
      return mean_luminance(image, edge.x0, 0, edge.x1, kSide);
    });
    const double expected = lit_floor_radiance(edge.x0 / 8.0, 0, edge.x1 / 8.0, 1);
    table.add(name + edge.name, against_exact(part, expected, slack));
  }
}

RenderRequest floor_request(std::uint64_t mutations_per_pixel) {
  RenderRequest request = small_request(IntegratorKind::pssmlt, kSide, mutations_per_pixel, 2);
  request.roulette = 0;
  return request;
}

void sweep_chains(SweepTable& table, const std::vector<std::uint32_t>& counts,
                  std::uint64_t mutations_per_pixel) {
  const SceneDescription scene = parse_scene_text(lit_floor(), "floor");
  for (const std::uint32_t chains : counts) {
    RenderRequest request = floor_request(mutations_per_pixel);
    request.chains = chains;
    request.bootstrap = std::max<std::uint64_t>(*request.bootstrap, chains);
    add_floor_rows(table, text_of(chains), render_replicates(scene, request, kReplicates, 1000));
  }
}

void sweep_large_step(SweepTable& table, const std::vector<float>& probabilities,
                      std::uint64_t mutations_per_pixel) {
  const SceneDescription scene = parse_scene_text(lit_floor(), "floor");
  for (const float probability : probabilities) {
    RenderRequest request = floor_request(mutations_per_pixel);
    request.large_step = probability;
    add_floor_rows(table, "p " + text_of(static_cast<double>(probability)),
                   render_replicates(scene, request, kReplicates, 2000));
  }
}

// ---- chains without a job ----

constexpr FeatureMask kAllFeatures = kFeatureMaskCount - 1;

/// The path integrator, with defects planted into its contributions at a given rate.
struct FaultyIntegrator {
  static constexpr std::uint32_t kMaxSplats = 1;
  PathIntegrator<kAllFeatures> paths;
  float rate = 0;

  using Float = float;
  template <class Sampler, class Sink>
  void evaluate(Sampler& sampler, Sink&& sink, bool = true) const {
    // One primary sample more decides, so that a defect is part of the path and replays with it.
    const float u = sampler.next();
    paths.evaluate(sampler, [&](Splat splat, bool) {
      constexpr float kInfinity = std::numeric_limits<float>::infinity();
      if (u < rate) splat.value = Vec3{std::numeric_limits<float>::quiet_NaN(), 1, 1};
      if (u >= rate && u < 2 * rate) splat.value = Vec3{kInfinity, 1, 1};
      if (u >= 2 * rate && u < 3 * rate) splat.value = Vec3{1, -1, 1};
      sink(splat);
    });
  }
};

struct ChainJob {
  std::uint64_t seed = 0;
  std::uint32_t first_time = 1;
  double b_factor = 1;
  float large_step = 0.2f;
  float defect_rate = 0;
  std::uint64_t chains = 16, mutations = 2048, bootstrap = 4096;
  std::uint64_t first_chain = 0;
};

/// As run_bootstrap_chunk, run_chain and develop_metropolis of the kernel and the renderer.
RenderResult run_chains(const SceneDescription& scene, const ChainJob& job) {
  const CompiledScene compiled(scene, kSide, kSide);
  const FaultyIntegrator integrator{{compiled.world(), PathSettings{2, 2}}, job.defect_rate};
  const std::uint32_t capacity = 1 + PathIntegrator<kAllFeatures>::primary_sample_capacity(2);
  std::vector<PrimarySampleOf<float>> samples(capacity);
  std::vector<ProposedSampleOf<float>> saved(capacity);
  std::vector<Splat> current(FaultyIntegrator::kMaxSplats), proposed(FaultyIntegrator::kMaxSplats);

  DefectCounts defects;
  std::vector<BootstrapChunk> chunks(bootstrap_chunk_count(job.bootstrap));
  for (std::uint64_t i = 0; i < chunks.size(); ++i) {
    chunks[i] = evaluate_bootstrap_chunk(integrator, job.seed, i, job.bootstrap, proposed, defects);
  }
  const LuminanceSum bootstrap = accumulate_bootstrap(chunks, job.bootstrap);

  std::vector<FilmPixel> pixels(kSide * kSide);
  const std::uint32_t fraction_bits = film_fraction_bits(job.chains * job.mutations);
  FixedFilm film(pixels, fraction_bits);
  ChainSettings settings;
  settings.seed = job.seed;
  settings.bootstrap = job.bootstrap;
  settings.large_step = job.large_step;
  settings.weight_b = static_cast<float>(bootstrap.mean() * job.b_factor);
  settings.first_time = job.first_time;
  ChainStatistics total;
  for (std::uint64_t i = 0; i < job.chains; ++i) {
    const double position = seed_position(job.seed, 0, i, job.chains, bootstrap.sum);
    const SeedPath start =
        find_seed_path(integrator, job.seed, job.bootstrap, chunks, position, std::span(proposed));
    const ChainTask task{job.first_chain + i, job.mutations, start};
    ChainStatistics statistics;
    ChainGroup<FaultyIntegrator, FixedFilm> chain(integrator, settings, {samples, saved, current, proposed},
                                                  {&task, 1}, {&film, 1}, {&statistics, 1});
    chain.begin();
    chain.advance(job.mutations);
    chain.end();
    total.add(statistics);
  }
  LuminanceSum all = bootstrap;
  all.add(total.large_steps);
  const FilmNormalisation normalisation{all.mean(), static_cast<double>(settings.weight_b), total.mutations,
                                        fraction_bits};
  RenderResult result;
  result.image = ImageBuffer{kSide, kSide, std::vector<Vec3>(pixels.size())};
  develop_film(pixels, normalisation, result.image.pixels, 0, pixels.size());
  result.statistics.longest_rejection_run = total.longest_rejection_run;
  defects.add(total.defects);
  result.statistics.rejected_nan = defects.nan;
  result.statistics.rejected_infinite = defects.infinite;
  result.statistics.rejected_negative = defects.negative;
  return result;
}

std::vector<RenderResult> run_replicates(const SceneDescription& scene, ChainJob job) {
  std::vector<RenderResult> results;
  for (std::uint32_t i = 0; i < kReplicates; ++i) {
    job.seed += 1;
    results.push_back(run_chains(scene, job));
  }
  return results;
}

bool same_image(const RenderResult& a, const RenderResult& b) {
  return a.image.pixels == b.image.pixels;
}

void sweep_frozen_b(SweepTable& table, const std::vector<double>& factors, std::uint64_t mutations) {
  const SceneDescription scene = parse_scene_text(lit_floor(), "floor");
  for (const double factor : factors) {
    ChainJob job;
    job.b_factor = factor;
    job.mutations = mutations;
    add_floor_rows(table, text_of(factor) + " b", run_replicates(scene, job));
  }
}

constexpr const char* kFloorBasis =
    "a lit floor: integrals of Lambert's closed form; Student's test over 16 seeds, plus rounding";

}  // namespace

TEST_CASE("pitfalls 8, 17 and 18: chains, some points") {
  {
    SweepTable table("chains, 2048 mutations in all", "chains", kFloorBasis);
    sweep_chains(table, {1, 32 * kSide * kSide}, 32);
  }
  {
    SweepTable table("probability of large steps", "p", kFloorBasis);
    sweep_large_step(table, {0, 1e-6f, 1}, 64);
  }
  SweepTable table("b inside the weights", "factor", kFloorBasis);
  sweep_frozen_b(table, {0.5, 2}, 128);
}

TEST_CASE("pitfall 17: 1 to 1e5 chains, and chains of one mutation", "[.stress]") {
  {
    SweepTable table("chains, 65536 mutations in all", "chains", kFloorBasis);
    sweep_chains(table, {1, 2, 10, 100, 1000, 10000}, 1024);
  }
  {
    SweepTable table("chains, 131072 mutations in all", "chains", kFloorBasis);
    sweep_chains(table, {100000}, 2048);
  }
  SweepTable table("chains of one mutation each", "chains", kFloorBasis);
  sweep_chains(table, {256 * kSide * kSide}, 256);
}

TEST_CASE("pitfall 19: p_large 0 to 1", "[.stress]") {
  SweepTable table("probability of large steps", "p", kFloorBasis);
  sweep_large_step(table, {0, 1e-6f, 1e-3f, 0.1f, 0.5f, 0.999f, 1}, 4096);
}

TEST_CASE("pitfall 8: b off by up to 100 inside the weights", "[.stress]") {
  SweepTable table("b inside the weights", "factor", kFloorBasis);
  sweep_frozen_b(table, {0.01, 0.1, 0.5, 1, 2, 10, 100}, 8192);
}

TEST_CASE("pitfalls 18 and 22: counters that start just below their wrap, and keys beyond 32 bits") {
  const SceneDescription scene = parse_scene_text(lit_floor(), "floor");
  SweepTable table("counters and keys", "what", "against the film of a chain whose time starts at 1");
  ChainJob job;
  job.mutations = 256;
  job.large_step = 0.01f;
  const RenderResult home = run_chains(scene, job);
  constexpr std::uint64_t kLast = ~std::uint64_t{0};
  const struct {
    const char* name;
    std::uint32_t first_time;
  } starts[] = {{"time from 2^31 - 100", 0x80000000U - 100U}, {"time up to 2^32 - 2", 0xfffffffeU - 256U}};
  for (const auto& start : starts) {
    job.first_time = start.first_time;
    table.add_fact(start.name, "the same film, bit for bit", same_image(run_chains(scene, job), home));
  }
  job.first_time = 1;
  job.mutations = 512;
  job.large_step = 0.2f;
  // Seeds and chain numbers around the ends of 32 and 64 bits are as good as any.
  for (const std::uint64_t seed : {std::uint64_t{0} - 1, std::uint64_t{0xfffffff0U}, kLast - 8}) {
    ChainJob seeded = job;
    seeded.seed = seed;
    add_floor_rows(table, "seeds from " + std::to_string(seed + 1), run_replicates(scene, seeded));
  }
  for (const std::uint64_t first : {std::uint64_t{0xfffffff8U}, kLast - 20}) {
    ChainJob numbered = job;
    numbered.first_chain = first;
    add_floor_rows(table, "chains from " + std::to_string(first), run_replicates(scene, numbered));
    table.add_fact("chains from " + std::to_string(first), "another film",
                   !same_image(run_chains(scene, numbered), run_chains(scene, job)));
  }
}

TEST_CASE("pitfalls 3 and 4: defects planted into real paths are rejected and counted") {
  const SceneDescription scene = parse_scene_text(lit_floor(), "floor");
  SweepTable table("defects planted into paths", "rate of each kind", kFloorBasis);
  for (const float rate : {1e-4f, 1e-2f}) {
    ChainJob job;
    job.defect_rate = rate;
    job.mutations = 1024;
    std::vector<RenderResult> replicates = run_replicates(scene, job);
    std::uint64_t nan = 0, infinite = 0, negative = 0, longest_run = 0;
    for (RenderResult& replicate : replicates) {
      nan += replicate.statistics.rejected_nan;
      infinite += replicate.statistics.rejected_infinite;
      negative += replicate.statistics.rejected_negative;
      longest_run = std::max(longest_run, replicate.statistics.longest_rejection_run);
      replicate.statistics.rejected_nan = 0;
      replicate.statistics.rejected_infinite = 0;
      replicate.statistics.rejected_negative = 0;
    }
    const std::string name = text_of(static_cast<double>(rate));
    table.add_fact(name,
                   "NaN " + std::to_string(nan) + ", infinite " + std::to_string(infinite) + ", negative " +
                       std::to_string(negative) + ", longest rejection run " + std::to_string(longest_run),
                   nan > 0 && infinite > 0 && negative > 0 && longest_run < job.mutations);
    // What a defect replaces is lost: three kinds, each as often as its rate.
    const double kept = 1 - 3 * static_cast<double>(rate);
    table.add(name + ", film", film_mean(replicates, kept * lit_floor_radiance(), 2e-6));
  }
}

}  // namespace mlt::test
