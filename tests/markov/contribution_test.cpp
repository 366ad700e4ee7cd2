// What counts as a contribution, and that chains survive what does not.
#include "markov/contribution.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

#include "base/error.hpp"
#include "markov/replicates.hpp"
#include "markov/toy_chains.hpp"
#include "markov/toy_integrators.hpp"
#include "support/child_process.hpp"

namespace mlt::test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinite = std::numeric_limits<float>::infinity();
constexpr float kLargest = std::numeric_limits<float>::max();

struct Finished {
  float target = 0;
  std::size_t splats = 0;
  DefectCounts defects;
};

Finished finish(const std::vector<Vec3>& values) {
  std::array<Splat, 4> storage;
  ContributionOf<float> contribution(storage);
  for (const Vec3& value : values) contribution.add(Splat{0, value}, true);
  Finished finished;
  contribution.finish(true, [&](int) -> DefectCounts& { return finished.defects; });
  finished.target = contribution.target();
  finished.splats = contribution.splats().size();
  return finished;
}

bool is_rejected(const Finished& finished, std::uint64_t nan, std::uint64_t infinite,
                 std::uint64_t negative) {
  const DefectCounts& defects = finished.defects;
  return finished.target == 0.0f && defects.nan == nan && defects.infinite == infinite &&
         defects.negative == negative;
}

TEST_CASE("the target is the luminance of all splats; zero splats need no place") {
  const Finished two = finish({Vec3{1, 2, 3}, Vec3{0}, Vec3{-0.0f}, Vec3{0, 0, 1}});
  CHECK(two.splats == 2);
  CHECK(two.target == luminance(Vec3{1, 2, 3}) + luminance(Vec3{0, 0, 1}));
  CHECK(two.defects.nan + two.defects.infinite + two.defects.negative == 0);
  CHECK(is_rejected(finish({}), 0, 0, 0));
}

TEST_CASE("pitfall 3: a defective splat empties the contribution and is counted by kind") {
  const Vec3 good{1, 1, 1};
  CHECK(is_rejected(finish({good, Vec3{kNan, 1, 1}}), 1, 0, 0));
  CHECK(is_rejected(finish({Vec3{1, 1, kNan}, good}), 1, 0, 0));
  CHECK(is_rejected(finish({Vec3{-1, kInfinite, kNan}}), 1, 0, 0));
  CHECK(is_rejected(finish({Vec3{1, kInfinite, 1}}), 0, 1, 0));
  CHECK(is_rejected(finish({Vec3{-kInfinite, 1, 1}}), 0, 1, 0));
  CHECK(is_rejected(finish({Vec3{1, 1, -1e-30f}}), 0, 0, 1));
  CHECK(is_rejected(finish({Vec3{kNan}, Vec3{kInfinite}, Vec3{-1}}), 1, 0, 0));
}

TEST_CASE("finite splats whose luminance overflows count as infinite, too dim ones as black") {
  CHECK(is_rejected(finish({Vec3{kLargest}, Vec3{kLargest}}), 0, 1, 0));
  CHECK(is_rejected(finish({Vec3{std::numeric_limits<float>::denorm_min()}}), 0, 0, 0));
  CHECK(is_rejected(finish({Vec3{kMinTarget / 4}}), 0, 0, 0));
  const Finished dimmest = finish({Vec3{kMinTarget * 1.01f}});
  CHECK(dimmest.target >= kMinTarget);
  CHECK(std::isfinite(1.0f / dimmest.target));
}

TEST_CASE("more splats than the integrator stated are a bug, not a silent drop") {
  const ChildResult child = run_in_child([] { finish(std::vector<Vec3>(5, Vec3{1})); });
  CHECK(child.exit_code == static_cast<int>(ExitCode::kBug));
  CHECK_THAT(child.errors, Catch::Contains("count_ < splats_.size() (4 against 4)"));
}

TEST_CASE("each lane's contribution is what it would be alone, and is exchanged alone") {
  using F = WideFloat;
  constexpr float kValues[] = {0, 1, 2.5f, kMinTarget / 4, kLargest, kNan, kInfinite, -1};
  Rng rng(5, StreamPurpose::kTest, 0);
  const auto any_value = [&] {
    // Half of the values zero, and most others sound.
    const std::uint32_t draw = rng.next_fixed() >> 27;
    return draw < 16 ? 0.0f : kValues[draw < 28 ? draw % 3 : draw % 8];
  };
  for (int i = 0; i < 3000; ++i) {
    std::array<SplatOf<F>, 3> storage[2];
    ContributionOf<F> contributions[2] = {ContributionOf<F>(storage[0]), ContributionOf<F>(storage[1])};
    Finished alone[2][kLaneCount<F>];
    for (int state = 0; state < 2; ++state) {
      std::vector<Vec3> values[kLaneCount<F>];
      contributions[state].clear();
      for (int k = 0; k < i % 4; ++k) {
        SplatOf<F> splat;
        const MaskOf<F> lanes = mask_of<F>(rng.next_fixed() >> (32 - kLaneCount<F>));
        for_lanes(not_in(MaskOf<F>{}), [&](int lane) {
          const Vec3 value{any_value(), 1, any_value()};
          set_lane_of(splat.value, lane, value);
          if ((lanes_of(lanes) >> lane & 1U) != 0) values[lane].push_back(value);
        });
        contributions[state].add(splat, lanes);
      }
      DefectCounts defects[kLaneCount<F>];
      contributions[state].finish(not_in(MaskOf<F>{}),
                                  [&](int lane) -> DefectCounts& { return defects[lane]; });
      for (int lane = 0; lane < kLaneCount<F>; ++lane) {
        alone[state][lane] = finish(values[lane]);
        const DefectCounts& expected = alone[state][lane].defects;
        REQUIRE(defects[lane].nan == expected.nan);
        REQUIRE(defects[lane].infinite == expected.infinite);
        REQUIRE(defects[lane].negative == expected.negative);
        REQUIRE(lane_of(contributions[state].target(), lane) == alone[state][lane].target);
      }
    }
    const unsigned exchanged = rng.next_fixed() >> (32 - kLaneCount<F>);
    contributions[0].exchange(contributions[1], mask_of<F>(exchanged));
    for (int state = 0; state < 2; ++state) {
      for (int lane = 0; lane < kLaneCount<F>; ++lane) {
        const Finished& expected = alone[(exchanged >> lane & 1U) != 0 ? 1 - state : state][lane];
        REQUIRE(lane_of(contributions[state].target(), lane) == expected.target);
        float sum = 0;
        for (const SplatOf<F>& splat : contributions[state].splats())
          sum += luminance(lane_of(splat.value, lane));
        if (expected.target > 0.0f) REQUIRE(sum == expected.target);
      }
    }
  }
}

/// SmoothToy behind a fault: one more primary sample, at first, decides whether one of the path's splats is
/// spoilt. The decision hashes the sample, so that a small step decides anew.
class FaultyToy {
 public:
  static constexpr std::uint32_t kPixels = SmoothToy<>::kPixels, kCapacity = SmoothToy<>::kCapacity + 1;
  static constexpr std::uint32_t kMaxSplats = SmoothToy<>::kMaxSplats + 1;
  static constexpr double kRate = 1e-4;  ///< of each of the five kinds
  enum Kind : std::size_t { kNanFault, kPositiveInfinity, kNegativeInfinity, kNegative, kZero };
  static constexpr std::size_t kKinds = 5;
  mutable std::array<std::uint64_t, kKinds> injected{};

  using Float = float;
  template <class Sampler, class Sink>
  void evaluate(Sampler& sampler, Sink&& sink, bool = true) const {
    const double chance = static_cast<double>(mix64(sampler.next_fixed()) >> 32) * 0x1p-32;
    const auto kind = static_cast<std::size_t>(std::min(chance / kRate, static_cast<double>(kKinds)));
    if (kind == kKinds) {
      toy_.evaluate(sampler, sink);
      return;
    }
    ++injected[kind];
    if (kind == kZero) return;
    constexpr float kValues[] = {kNan, kInfinite, -kInfinite, -1.0f};
    // Between good splats, which must be dropped with it.
    toy_.evaluate(sampler, sink);
    sink(Splat{0, Vec3{1, kValues[kind], 1}});
  }

 private:
  SmoothToy<> toy_;
};

std::uint64_t total(const DefectCounts& defects) {
  return defects.nan + defects.infinite + defects.negative;
}

TEST_CASE("pitfall 3 and 4: injected defects are counted, rejected and leave the mean as it was") {
  const FaultyToy toy;
  const double kept = 1 - FaultyToy::kKinds * FaultyToy::kRate;
  std::vector<double> expected = SmoothToy<>::expected();
  for (double& value : expected) value *= kept;
  Replicates images(expected);
  ToyJob job;
  job.weight_b = static_cast<float>(SmoothToy<>::expected_b());
  DefectCounts counted;
  std::array<std::uint64_t, FaultyToy::kKinds> injected{};
  std::uint64_t longest_run = 0;
  for (std::uint64_t seed = 3000; seed < 3200; ++seed) {
    job.seed = seed;
    toy.injected = {};
    const ToyBootstrap bootstrap = run_bootstrap(toy, seed, job.bootstrap);
    const DefectCounts& of_bootstrap = bootstrap.defects;
    REQUIRE(of_bootstrap.nan == toy.injected[FaultyToy::kNanFault]);
    REQUIRE(total(of_bootstrap) + toy.injected[FaultyToy::kZero] ==
            std::accumulate(toy.injected.begin(), toy.injected.end(), std::uint64_t{0}));
    DoubleFilm film(toy.kPixels);
    for (std::uint64_t chain = 0; chain < job.chains; ++chain) {
      const SeedPath start = seed_path_of_chain(toy, job, bootstrap, chain);
      // Starts replay bootstrap paths, whose defects are counted already.
      toy.injected = {};
      const ChainStatistics statistics =
          run_chain<Mutation<MutationKind::kelemen>>(toy, job, job.weight_b, chain, start, film);
      counted.add(statistics.defects);
      for (std::size_t k = 0; k < injected.size(); ++k) injected[k] += toy.injected[k];
      longest_run = std::max(longest_run, statistics.longest_rejection_run);
    }
    const std::vector<double> image = film.develop(bootstrap.luminance.mean(), job.weight_b, 32 * 64);
    for (const double value : image) REQUIRE((std::isfinite(value) && value >= 0));
    images.add(image);
  }
  CHECK(counted.nan == injected[FaultyToy::kNanFault]);
  CHECK(counted.infinite == injected[FaultyToy::kPositiveInfinity] + injected[FaultyToy::kNegativeInfinity]);
  CHECK(counted.negative == injected[FaultyToy::kNegative]);
  for (const std::uint64_t count : injected) CHECK(count > 0);
  CHECK(images.smallest_p_value() > sidak_threshold(1e-4, expected.size()));
  // An accepted infinity would end all acceptance: 64 mutations of the chain would be one run.
  CHECK(longest_run < 64);
  CHECK(longest_run > 0);
}

/// Scripted targets: the n-th evaluation has the n-th value, the last one for ever.
struct ScriptedToy {
  static constexpr std::uint32_t kCapacity = 1, kMaxSplats = 1;
  std::vector<float> values;
  mutable std::size_t next = 0;

  using Float = float;
  template <class Sampler, class Sink>
  void evaluate(Sampler& sampler, Sink&& sink, bool = true) const {
    sampler.next_fixed();
    sink(Splat{0, Vec3{values[std::min(next++, values.size() - 1)]}});
  }
};

TEST_CASE(
    "pitfall 4: the longest rejection run of a chain is recorded, and it recovers from non-finite "
    "proposals") {
  // Start, 3 rejected, 1 accepted, 5 rejected of each kind, then accepted for ever.
  const ScriptedToy toy{{1, 0, kNan, kInfinite, 1, kInfinite, -kInfinite, kNan, -1, 0, 1}};
  ToyJob job;
  job.mutations = 100;
  DoubleFilm film(1);
  const SeedPath start{0, luminance(Vec3{1})};
  const ChainStatistics statistics = run_chain<Mutation<MutationKind::kelemen>>(toy, job, 1, 0, start, film);
  CHECK(statistics.longest_rejection_run == 5);
  CHECK(statistics.defects.nan == 2);
  CHECK(statistics.defects.infinite == 3);
  CHECK(statistics.defects.negative == 1);
  CHECK(statistics.acceptance_large + statistics.acceptance_small == 100 - 8);
  ChainStatistics other;
  other.longest_rejection_run = 4;
  other.add(statistics);
  CHECK(other.longest_rejection_run == 5);
}

}  // namespace
}  // namespace mlt::test
