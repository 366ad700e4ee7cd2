// The bootstrap's sums against direct formulas, and which path a position selects against a linear search.
#include "markov/bootstrap.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <vector>

#include "markov/toy_chains.hpp"

namespace mlt::test {
namespace {

/// Luminances of many orders of magnitude; three of four paths are black.
struct UnevenToy {
  static constexpr std::uint32_t kMaxSplats = 1;

  using Float = float;
  template <class Sampler, class Sink>
  void evaluate(Sampler& sampler, Sink&& sink, bool = true) const {
    const float u = sampler.next();
    const float v = sampler.next();
    if (u < 0.25f) sink(Splat{0, Vec3{0.01f + std::pow(v, 12.0f) * 100.0f}});
  }
};

std::vector<double> all_targets(std::uint64_t seed, std::uint64_t paths) {
  std::vector<double> targets;
  const UnevenToy toy;
  std::array<Splat, 1> splats;
  ContributionOf<float> contribution(splats);
  DefectCounts defects;
  for (std::uint64_t i = 0; i < paths; ++i) {
    BootstrapSamplerOf<float> sampler = bootstrap_sampler(seed, i, paths);
    evaluate_into(toy, sampler, true, contribution, [&](int) -> DefectCounts& { return defects; });
    targets.push_back(contribution.target());
  }
  return targets;
}

TEST_CASE("the bootstrap's sum is that of all its paths, whatever remains for the last chunk") {
  for (const std::uint64_t paths : {1U, 2U, 63U, 64U, 65U, 1000U}) {
    const ToyBootstrap bootstrap = run_bootstrap(UnevenToy{}, 5, paths);
    long double sum = 0;
    for (const double target : all_targets(5, paths)) sum += target;
    const long double mean = sum / paths;
    INFO(paths << " paths");
    CHECK(bootstrap.luminance.count == paths);
    // At most 1000 additions, each of relative error 2^-53.
    CHECK(std::fabs(bootstrap.luminance.mean() - static_cast<double>(mean)) <=
          1e-12 * static_cast<double>(mean));
  }
}

TEST_CASE("moments of nothing, one value and equal values have no error, and parts add up") {
  LuminanceMoments moments;
  CHECK(moments.mean() == 0);
  CHECK(moments.standard_error() == 0);
  moments.add(3);
  CHECK(moments.mean() == 3);
  CHECK(moments.standard_error() == 0);
  LuminanceMoments equal;
  for (int i = 0; i < 7; ++i) equal.add(0.1);
  // Cancellation may leave a tiny variance of either sign; it must not become NaN.
  CHECK(equal.standard_error() >= 0);
  CHECK(equal.standard_error() < 1e-8);
  LuminanceMoments both;
  both.add(1);
  both.add(2);
  both.add(moments);
  CHECK(both.count == 3);
  CHECK(both.mean() == 2);
  CHECK(both.standard_error() == Approx(1 / std::sqrt(3.0)).epsilon(1e-14));
}

/// Chunks with these sums.
std::vector<BootstrapChunk> chunks_of(const std::vector<double>& sums) {
  std::vector<BootstrapChunk> chunks(sums.size());
  for (std::size_t i = 0; i < sums.size(); ++i) chunks[i].sum = sums[i];
  accumulate_bootstrap(chunks, sums.size() * kBootstrapChunk);
  return chunks;
}

TEST_CASE("a position falls into the chunk that covers it") {
  const std::vector<BootstrapChunk> chunks = chunks_of({0, 0, 2, 0, 3, 1, 0, 0});
  CHECK(chunks[4].cumulative == 2);
  CHECK(find_bootstrap_chunk(chunks, 0) == 2);
  CHECK(find_bootstrap_chunk(chunks, 1.999) == 2);
  CHECK(find_bootstrap_chunk(chunks, 2) == 4);
  CHECK(find_bootstrap_chunk(chunks, 4.999) == 4);
  CHECK(find_bootstrap_chunk(chunks, 5) == 5);
  CHECK(find_bootstrap_chunk(chunks, 5.999) == 5);
  // Rounding can put a position at the total; then the last light is meant.
  CHECK(find_bootstrap_chunk(chunks, 6) == 5);
  CHECK(find_bootstrap_chunk(chunks, 7) == 5);
}

TEST_CASE("one chunk, and light in the first or last chunk only") {
  CHECK(find_bootstrap_chunk(chunks_of({4}), 0) == 0);
  CHECK(find_bootstrap_chunk(chunks_of({4}), 4) == 0);
  CHECK(find_bootstrap_chunk(chunks_of({4, 0, 0}), 0) == 0);
  CHECK(find_bootstrap_chunk(chunks_of({4, 0, 0}), 4) == 0);
  CHECK(find_bootstrap_chunk(chunks_of({0, 0, 4}), 0) == 2);
  CHECK(find_bootstrap_chunk(chunks_of({0, 0, 4}), 4) == 2);
  // A sum below the rounding of what came before is passed over, never chosen in another's place.
  CHECK(find_bootstrap_chunk(chunks_of({1e20, 1, 1e20}), 1e20) == 2);
}

SeedPath seed_path_at(const ToyBootstrap& bootstrap, std::uint64_t seed, std::uint64_t paths,
                      double position) {
  std::array<Splat, 1> splats;
  return find_seed_path(UnevenToy{}, seed, paths, bootstrap.chunks, position, splats);
}

TEST_CASE("position 0 is the first path that carries light, the total the last") {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const ToyBootstrap bootstrap = run_bootstrap(UnevenToy{}, seed, 130);
    const std::vector<double> targets = all_targets(seed, 130);
    std::uint64_t first = 0;
    while (!(targets[first] > 0)) ++first;
    std::uint64_t last = 129;
    while (!(targets[last] > 0)) --last;
    const SeedPath at_zero = seed_path_at(bootstrap, seed, 130, 0);
    CHECK(at_zero.index == first);
    CHECK(static_cast<double>(at_zero.target) == targets[first]);
    CHECK(seed_path_at(bootstrap, seed, 130, bootstrap.luminance.sum).index == last);
  }
}

TEST_CASE("every position selects the path that a linear search finds") {
  constexpr std::uint64_t kPaths = 1000;
  const ToyBootstrap bootstrap = run_bootstrap(UnevenToy{}, 9, kPaths);
  const std::vector<double> targets = all_targets(9, kPaths);
  Rng rng(1, StreamPurpose::kTest, 0);
  for (int i = 0; i < 3000; ++i) {
    const double position = rng.next_float() * bootstrap.luminance.sum;
    std::uint64_t index = 0;
    double sum = 0;
    double cumulative = 0;
    for (; index < kPaths; ++index) {
      if (index % kBootstrapChunk == 0) {
        cumulative += sum;
        sum = 0;
      }
      sum += targets[index];
      if (cumulative + sum > position) break;
    }
    REQUIRE(seed_path_at(bootstrap, 9, kPaths, position).index == index);
  }
}

TEST_CASE("systematic starts take each path as often as its luminance demands, within one") {
  for (const std::uint64_t chains : {1U, 7U, 1000U, 20000U}) {
    constexpr std::uint64_t kPaths = 500;
    const ToyBootstrap bootstrap = run_bootstrap(UnevenToy{}, 11, kPaths);
    const std::vector<double> targets = all_targets(11, kPaths);
    std::vector<double> counts(kPaths);
    for (std::uint64_t chain = 0; chain < chains; ++chain) {
      const double position = seed_position(11, 0, chain, chains, bootstrap.luminance.sum);
      REQUIRE(position >= 0);
      REQUIRE(position < bootstrap.luminance.sum);
      const SeedPath path = seed_path_at(bootstrap, 11, kPaths, position);
      REQUIRE(static_cast<double>(path.target) == targets[path.index]);
      counts[path.index] += 1;
    }
    for (std::uint64_t i = 0; i < kPaths; ++i) {
      const double expected = static_cast<double>(chains) * targets[i] / bootstrap.luminance.sum;
      // The tolerance is the rounding of positions.
      REQUIRE(std::fabs(counts[i] - expected) < 1 + 1e-9);
    }
  }
}

TEST_CASE("the offset of all starts differs between seeds and is uniform in its stratum") {
  double sum = 0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const double position = seed_position(seed, 0, 3, 8, 16);
    REQUIRE(position >= 6);
    REQUIRE(position < 8);
    REQUIRE(seed_position(seed, 0, 4, 8, 16) == Approx(position + 2).epsilon(1e-15));
    sum += position;
  }
  // Mean 7, standard error 2 / sqrt(12 * 1000), at 4 of which p is 6e-5.
  CHECK(std::fabs(sum / 1000 - 7) < 4 * 2 / std::sqrt(12000.0));
}

}  // namespace
}  // namespace mlt::test
