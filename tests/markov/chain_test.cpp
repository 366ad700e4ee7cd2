// What one chain does step by step: its streams, its weights, the replay of its start.
#include "markov/chain.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <set>
#include <vector>

#include "base/error.hpp"
#include "markov/toy_chains.hpp"
#include "markov/toy_integrators.hpp"
#include "support/child_process.hpp"
#include "support/statistics.hpp"

namespace mlt::test {
namespace {

using Kelemen = Mutation<MutationKind::kelemen>;

/// Notes the first primary sample of each evaluation; all paths have the same target.
struct RecordingToy {
  static constexpr std::uint32_t kCapacity = 1, kMaxSplats = 1;
  mutable std::vector<std::uint32_t> log;

  using Float = float;
  template <class Sampler, class Sink>
  void evaluate(Sampler& sampler, Sink&& sink, bool = true) const {
    log.push_back(sampler.next_fixed());
    sink(Splat{0, Vec3{1}});
  }
};

const SeedPath kConstantStart{0, luminance(Vec3{1})};

/// The states a chain proposes from the one start that all chains of these tests share.
std::vector<std::uint32_t> proposals(std::uint64_t seed, std::uint64_t chain, float large_step) {
  RecordingToy toy;
  ToyJob job;
  job.seed = seed;
  job.mutations = 4;
  job.large_step = large_step;
  DoubleFilm film(1);
  run_chain<Kelemen>(toy, job, 1, chain, kConstantStart, film);
  return toy.log;
}

/// Sum of products of two series of steps, in standard deviations; steps in [-1,1) around 0.
class Correlation {
 public:
  void add(double a, double b) {
    products_ += a * b;
    squares_a_ += a * a;
    squares_b_ += b * b;
    ++count_;
  }
  /// Under independence, sqrt(n) times the correlation is standard normal for many pairs.
  double p_value() const {
    return normal_p_value(products_ / std::sqrt(squares_a_ * squares_b_) * std::sqrt(count_));
  }

 private:
  double products_ = 0, squares_a_ = 0, squares_b_ = 0, count_ = 0;
};

double step_between(std::uint32_t from, std::uint32_t to) {
  return static_cast<std::int32_t>(to - from) * 0x1p-31;
}

TEST_CASE(
    "pitfall 10: chains forced onto one start move independently, from each other and from other seeds") {
  constexpr std::uint64_t kChains = 4000;
  for (const float large_step : {0.0f, 1.0f}) {
    Correlation of_neighbours, of_seeds;
    std::set<std::uint32_t> firsts;
    for (std::uint64_t chain = 0; chain < kChains; chain += 2) {
      const std::vector<std::uint32_t> a = proposals(1, chain, large_step);
      const std::vector<std::uint32_t> b = proposals(1, chain + 1, large_step);
      const std::vector<std::uint32_t> c = proposals(2, chain, large_step);
      REQUIRE(a[0] == b[0]);
      firsts.insert({a[1], b[1]});
      for (std::size_t step = 1; step < a.size(); ++step) {
        of_neighbours.add(step_between(a[step - 1], a[step]), step_between(b[step - 1], b[step]));
        of_seeds.add(step_between(a[step - 1], a[step]), step_between(c[step - 1], c[step]));
      }
    }
    const double threshold = sidak_threshold(1e-4, 4);
    CHECK(of_neighbours.p_value() > threshold);
    CHECK(of_seeds.p_value() > threshold);
    // Equal streams would repeat values; 4000 of 2^32, or of the 2^25 steps of a kind, rarely do.
    CHECK(firsts.size() > kChains - 10);
  }
}

TEST_CASE("pitfall 10: a chain shares no random numbers with the bootstrap path of its own index") {
  for (std::uint64_t chain = 1; chain < 1000; ++chain) {
    BootstrapSamplerOf<float> bootstrap = bootstrap_sampler(1, chain, 1000);
    std::set<std::uint32_t> values;
    for (int i = 0; i < 32; ++i) values.insert(bootstrap.next_fixed());
    const std::vector<std::uint32_t> own = proposals(1, chain, 1);
    for (std::size_t step = 1; step < own.size(); ++step) REQUIRE(values.count(own[step]) == 0);
  }
}

/// The start at pixel 0 with target 1; every proposal at pixel 1 with half of it.
struct HalvingToy {
  static constexpr std::uint32_t kCapacity = 1, kMaxSplats = 1;
  mutable bool started = false;

  using Float = float;
  template <class Sampler, class Sink>
  void evaluate(Sampler& sampler, Sink&& sink, bool = true) const {
    sampler.next_fixed();
    sink(started ? Splat{1, Vec3{0.5f}} : Splat{0, Vec3{1}});
    started = true;
  }
};

/// Keeps the splats in their order.
struct SplatLog {
  struct Entry {
    std::uint32_t pixel;
    Vec3 value;
    double metropolis_weight, uniform_weight;
  };
  std::vector<Entry> entries;
  void prefetch(std::uint32_t) const {}
  void splat(std::uint32_t pixel, const Vec3& value, double metropolis_weight, double uniform_weight) {
    entries.push_back({pixel, value, metropolis_weight, uniform_weight});
  }
};

/// Whether the chain accepts a proposal of acceptance probability 1/2: then the start is splatted first.
bool accepts_half(std::uint64_t seed, std::uint64_t chain) {
  const HalvingToy toy;
  ToyJob job;
  job.seed = seed;
  job.mutations = 1;
  job.large_step = 0;
  SplatLog log;
  run_chain<Kelemen>(toy, job, 1, chain, kConstantStart, log);
  REQUIRE(log.entries.size() == 2);
  return log.entries[0].pixel == 0;
}

TEST_CASE("pitfall 10: acceptance happens with its probability and differs between seeds and chains") {
  constexpr int kChains = 10000;
  int accepted = 0;
  Correlation of_seeds, of_neighbours;
  double previous = 0;
  for (int chain = 0; chain < kChains; ++chain) {
    const auto index = static_cast<std::uint64_t>(chain);
    const bool first = accepts_half(1, index);
    accepted += first ? 1 : 0;
    const double signed_first = first ? 1 : -1;
    of_seeds.add(signed_first, accepts_half(2, index) ? 1 : -1);
    if (chain > 0) of_neighbours.add(signed_first, previous);
    previous = signed_first;
  }
  const double threshold = sidak_threshold(1e-4, 3);
  CHECK(normal_p_value((accepted - kChains / 2) / std::sqrt(kChains / 4.0)) > threshold);
  CHECK(of_seeds.p_value() > threshold);
  CHECK(of_neighbours.p_value() > threshold);
}

TEST_CASE("pitfall 10: two seeds give different films, one seed the same film") {
  const SmoothToy<> toy;
  const auto film_of = [&](std::uint64_t seed) {
    ToyJob job;
    job.seed = seed;
    const ToyBootstrap bootstrap = run_bootstrap(toy, seed, job.bootstrap);
    DoubleFilm film(toy.kPixels);
    run_chains<Kelemen>(toy, job, bootstrap, film);
    return film;
  };
  CHECK(film_of(1) == film_of(1));
  CHECK_FALSE(film_of(1) == film_of(2));
  CHECK_FALSE(film_of(0) == film_of(std::uint64_t{1} << 63));
}

TEST_CASE("each mutation adds one to the Metropolis weights, each large step one to the uniform weights") {
  ToyJob job;
  job.mutations = 500;
  const ConstantToy<> constant{2};
  SplatLog log;
  const SeedPath start{0, luminance(Vec3{2})};
  const ChainStatistics statistics = run_chain<Kelemen>(constant, job, 3, 0, start, log);
  double metropolis = 0;
  double uniform = 0;
  for (const SplatLog::Entry& entry : log.entries) {
    metropolis += entry.metropolis_weight;
    uniform += entry.uniform_weight;
    // F / (I + p w)
    CHECK(entry.value.x == 2.0f * (1.0f / (start.target + job.large_step * 3.0f)));
  }
  CHECK(metropolis == 500);
  CHECK(uniform == static_cast<double>(statistics.large_steps.count));
  CHECK(statistics.acceptance_large == uniform);
  CHECK(statistics.acceptance_small == static_cast<double>(statistics.small_steps));
  CHECK(statistics.mutations == 500);
  CHECK(log.entries.size() == 500);
  // Binomial, 0.3 of 500.
  CHECK(normal_p_value((uniform - 150) / std::sqrt(500 * 0.3 * 0.7)) > 1e-4);
}

TEST_CASE("the start is splatted when it is left, and the last state with the same formula") {
  const HalvingToy toy;
  ToyJob job;
  job.mutations = 1;
  job.large_step = 0;
  SplatLog log;
  run_chain<Kelemen>(toy, job, 7, 3, kConstantStart, log);
  REQUIRE(log.entries.size() == 2);
  for (const SplatLog::Entry& entry : log.entries) {
    CHECK(entry.metropolis_weight == 0.5);
    CHECK(entry.uniform_weight == 0.0);
    // Without large steps F / I, which is 1 for grey of luminance 1, within the rounding of three products.
    CHECK(std::fabs(luminance(entry.value) - 1.0f) < 4 * 0x1p-24f);
  }
}

/// Breaks the replay: the evaluation number `drifting_call` is brighter by a few ulp.
struct DriftingToy {
  static constexpr std::uint32_t kCapacity = 1, kMaxSplats = 1;
  int drifting_call;
  mutable int calls = 0;

  using Float = float;
  template <class Sampler, class Sink>
  void evaluate(Sampler& sampler, Sink&& sink, bool = true) const {
    const float value = 1.0f + sampler.next();
    sink(Splat{0, Vec3{calls++ == drifting_call ? value * (1 + 0x1p-20f) : value}});
  }
};

/// One chunk of bootstrap, then one chain: 64 evaluations, 64 to find the start, then the chain's start.
ChildResult run_drifting(int drifting_call) {
  return run_in_child([&] {
    set_replay_command("mlt render scene.txt --seed 77");
    replay_context().stage = "chain";
    const DriftingToy toy{drifting_call};
    ToyJob job;
    job.seed = 77;
    job.bootstrap = 64;
    job.chains = 5;
    const ToyBootstrap bootstrap = run_bootstrap(toy, job.seed, job.bootstrap);
    const SeedPath start = seed_path_of_chain(toy, job, bootstrap, 3);
    DoubleFilm film(1);
    run_chain<Kelemen>(toy, job, 1, 3, start, film);
  });
}

/// A start of target 1; every proposal has 2^-26 of it.
struct CliffToy {
  static constexpr std::uint32_t kCapacity = 1, kMaxSplats = 1;
  mutable bool started = false;

  using Float = float;
  template <class Sampler, class Sink>
  void evaluate(Sampler& sampler, Sink&& sink, bool = true) const {
    sampler.next_fixed();
    sink(Splat{0, Vec3{started ? 0x1p-26f : 1.0f}});
    started = true;
  }
};

TEST_CASE("a chain leaves a state 2^26 times brighter as rarely as it must", "[.slow]") {
  ToyJob job;
  job.mutations = std::uint64_t{1} << 22;
  job.large_step = 0;
  constexpr int kChains = 64;
  int left = 0;
  for (int chain = 0; chain < kChains; ++chain) {
    DoubleFilm film(1);
    const ChainStatistics statistics =
        run_chain<Kelemen>(CliffToy{}, job, 1, static_cast<std::uint64_t>(chain), kConstantStart, film);
    left += statistics.longest_rejection_run < job.mutations ? 1 : 0;
  }
  // Each stays with probability (1 - 2^-26)^(2^22); 24-bit decisions would leave 22 % of the chains' starts
  // instead of 6 %.
  const double leaving = 1 - std::exp(-0x1p-4);
  const double deviation = std::sqrt(kChains * leaving * (1 - leaving));
  CHECK(normal_p_value((left - kChains * leaving) / deviation) > 1e-4);
}

TEST_CASE("pitfall 11: a start replays bit for bit, in every build") {
  const ChildResult child = run_drifting(-1);
  CHECK(child.exit_code == 0);
  CHECK(child.errors.empty());
}

TEST_CASE(
    "pitfall 11: a start that another evaluation does not reproduce ends with exit code 70 and its context") {
  const ChildResult child = run_drifting(128);
  CHECK(child.exit_code == static_cast<int>(ExitCode::kBug));
  CHECK_THAT(child.errors, Catch::Contains("== tasks_[i].start.target"));
  CHECK_THAT(child.errors, Catch::Contains("while: chain, seed 77, unit 3, step 0"));
  CHECK_THAT(child.errors, Catch::Contains("replay: mlt render scene.txt --seed 77"));
}

TEST_CASE("pitfall 11: a bootstrap chunk that another evaluation does not reproduce ends with exit code 70") {
  const ChildResult child = run_drifting(100);
  CHECK(child.exit_code == static_cast<int>(ExitCode::kBug));
  CHECK_THAT(child.errors, Catch::Contains("check failed: sum == chunk.sum"));
  CHECK_THAT(child.errors, Catch::Contains("seed 77, unit 0"));
}

}  // namespace
}  // namespace mlt::test
