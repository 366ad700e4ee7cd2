// The strata of the bootstrap's paths: where they lie, against a curve walked bit by bit and divisions of
// 128 bits; that all paths together are uniform; and what that does to the mean and to the estimate of its
// error.
#include "markov/bootstrap_sampler.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <vector>

#include "markov/bootstrap.hpp"
#include "markov/toy_chains.hpp"
#include "support/statistics.hpp"

namespace mlt::test {
namespace {

__extension__ using Wide = unsigned __int128;

/// Place of a film point on the curve, 64 bits, of which the place within the stratum decides the first 56.
std::uint64_t on_curve(FilmPlace place) {
  std::uint64_t bits = 0;
  for (int bit = 31; bit >= 0; --bit) {
    bits = bits << 1 | (place.y >> bit & 1U);
    bits = bits << 1 | (place.x >> bit & 1U);
  }
  return bits;
}

TEST_CASE("a path lies in its stratum, at its own place in it") {
  Rng rng(31, StreamPurpose::kTest, 0);
  for (const std::uint64_t paths :
       {std::uint64_t{1}, std::uint64_t{2}, std::uint64_t{3}, std::uint64_t{1000}, std::uint64_t{16384},
        std::uint64_t{99999999}, (std::uint64_t{1} << 36) - 1, std::uint64_t{1} << 36}) {
    for (int i = 0; i < 2000; ++i) {
      std::uint64_t index = i < 2 ? static_cast<std::uint64_t>(i) * (paths - 1) : rng.next_key() % paths;
      const FilmPlace within{i % 3 == 0 ? 0 : rng.next_fixed(), i % 5 == 0 ? ~0U : rng.next_fixed()};
      const FilmPlace shift{rng.next_fixed(), rng.next_fixed()};
      const FilmPlace place = stratified_place(within, index, paths, shift);
      const std::uint64_t fraction = std::uint64_t{within.x >> 4} << 28 | within.y >> 4;
      const auto expected = static_cast<std::uint64_t>((Wide{index} << 56 | fraction) / Wide{paths});
      const std::uint64_t found = on_curve({place.x ^ shift.x, place.y ^ shift.y});
      REQUIRE(found >> 8 == expected);
      REQUIRE(((place.x ^ shift.x) & 15U) == (within.x & 15U));
      REQUIRE(((place.y ^ shift.y) & 15U) == (within.y & 15U));
    }
  }
}

TEST_CASE("with a power of four, each square cell holds one path") {
  for (const std::uint32_t side : {1U, 2U, 16U, 64U}) {
    const std::uint64_t paths = std::uint64_t{side} * side;
    std::vector<int> cells(paths);
    for (std::uint64_t i = 0; i < paths; ++i) {
      BootstrapSamplerOf<float> sampler = bootstrap_sampler(7, i, paths);
      const std::uint64_t x = std::uint64_t{sampler.next_fixed()} * side >> 32;
      const std::uint64_t y = std::uint64_t{sampler.next_fixed()} * side >> 32;
      cells[y * side + x] += 1;
    }
    for (const int count : cells) REQUIRE(count == 1);
  }
}

TEST_CASE("all paths together are uniform on the film, whatever their number") {
  constexpr std::size_t kCells = 12;  // a side; not a power of two, so that cells cut the curve's squares
  for (const std::uint64_t paths : {1U, 3U, 5U, 37U}) {
    std::vector<std::uint64_t> counts(kCells * kCells);
    std::vector<double> expected(kCells * kCells);
    const std::uint64_t seeds = 40000 / paths;
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
      for (std::uint64_t i = 0; i < paths; ++i) {
        BootstrapSamplerOf<float> sampler = bootstrap_sampler(seed, i, paths);
        const Vec2 film = sampler.next_2d();
        counts[static_cast<std::size_t>(film.y * kCells) * kCells +
               static_cast<std::size_t>(film.x * kCells)] += 1;
      }
    }
    // Points of one seed avoid each other, which only lowers the statistic.
    for (double& cell : expected) cell = static_cast<double>(seeds * paths) / (kCells * kCells);
    INFO(paths << " paths");
    CHECK(chi_square_test(counts, expected).p_value > sidak_threshold(1e-4, 4));
  }
}

TEST_CASE("samples behind the film's are the path's stream, and lanes are paths") {
  constexpr std::uint64_t kPaths = 100;
  BootstrapSamplerOf<WideFloat> wide;
  for (int lane = 0; lane < kLaneCount<WideFloat>; ++lane)
    wide.set_lane(lane, BootstrapStreams(3, kPaths), static_cast<std::uint64_t>(5 * lane));
  std::vector<UintOf<WideFloat>> values(8);
  for (auto& value : values) value = wide.next_fixed();
  for (int lane = 0; lane < kLaneCount<WideFloat>; ++lane) {
    const auto index = static_cast<std::uint64_t>(5 * lane);
    BootstrapSamplerOf<float> alone = bootstrap_sampler(3, index, kPaths);
    Rng stream(3, StreamPurpose::kBootstrap, index);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::uint32_t expected = alone.next_fixed();
      const std::uint32_t independent = stream.next_fixed();
      REQUIRE(lane_of(values[i], lane) == expected);
      if (i >= 2) REQUIRE(expected == independent);
    }
  }
}

/// Luminance 6 x^2 y, 1 on average, of which the film decides everything; with kNoise times a uniform number
/// of mean 1, which it does not decide.
template <bool kNoise>
struct SlopeToy {
  static constexpr std::uint32_t kMaxSplats = 1;
  using Float = float;
  template <class Sampler, class Sink>
  void evaluate(Sampler& sampler, Sink&& sink, bool = true) const {
    const float x = sampler.next();
    const float y = sampler.next();
    const float noise = kNoise ? 2 * sampler.next() : 1.0f;
    sink(Splat{0, Vec3{6 * x * x * y * noise}});
  }
};

struct Spread {
  Moments mean;            ///< of b over seeds
  double told = 0;         ///< mean of the estimated variance of b
  double independent = 0;  ///< variance of as many independent paths
};

template <bool kNoise>
Spread spread_of_b(std::uint64_t paths) {
  std::vector<double> means;
  Spread spread;
  constexpr int kSeeds = 400;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const ToyBootstrap bootstrap = run_bootstrap(SlopeToy<kNoise>{}, static_cast<std::uint64_t>(seed), paths);
    means.push_back(bootstrap.luminance.mean());
    const double error = bootstrap.luminance.standard_error();
    spread.told += error * error / kSeeds;
  }
  spread.mean = moments(means);
  // E (6 x^2 y)^2 = 36/15, times E noise^2 = 4/3.
  spread.independent = (2.4 * (kNoise ? 4.0 / 3.0 : 1.0) - 1) / static_cast<double>(paths);
  return spread;
}

TEST_CASE("b has no bias and less variance than of independent paths, and its error is not understated") {
  for (const std::uint64_t paths : {2U, 7U, 64U, 100U, 1000U}) {
    INFO(paths << " paths");
    const Spread smooth = spread_of_b<false>(paths);
    const Spread noisy = spread_of_b<true>(paths);
    // 4 standard errors over 400 seeds: p is 6e-5.
    CHECK(std::fabs(smooth.mean.mean - 1) < 4 * smooth.mean.standard_error());
    CHECK(std::fabs(noisy.mean.mean - 1) < 4 * noisy.mean.standard_error());
    // The relative standard error of a variance over 400 seeds is about sqrt(2/400) = 0.07 or, for the few
    // heavy-tailed sums of small numbers of paths, at most 0.15.
    CHECK(smooth.mean.variance < smooth.told * 1.3);
    CHECK(noisy.mean.variance < noisy.told * 1.3);
    if (paths < 64) continue;
    // Strata of 1/64 of the film remove all but some hundredths of the smooth part of the variance.
    CHECK(smooth.mean.variance < 0.1 * smooth.independent);
    // What the film does not explain remains: E (6 x^2 y)^2 / 3 = 0.8 of 2.2.
    CHECK(noisy.mean.variance < 0.6 * noisy.independent);
    CHECK(noisy.told < 0.6 * noisy.independent);
  }
}

TEST_CASE("differences of neighbours estimate the variance of a sum, and count a lone value as error") {
  NeighbourDifferences of_nothing;
  CHECK(of_nothing.sum_variance() == 0);
  NeighbourDifferences of_one;
  of_one.add(3);
  CHECK(of_one.sum_variance() == 9);
  NeighbourDifferences of_two;
  for (const double value : {1.0, 4.0}) of_two.add(value);
  CHECK(of_two.sum_variance() == 9);
  NeighbourDifferences of_three;
  for (const double value : {1.0, 4.0, 2.0}) of_three.add(value);
  CHECK(of_three.sum_variance() == (9.0 + 4.0 + 1.0) / 2);
}

TEST_CASE("a sum of luminance adds independent moments") {
  LuminanceSum sum{6, 2, 3};
  CHECK(sum.mean() == 2);
  CHECK(sum.standard_error() == Approx(std::sqrt(2.0) / 3).epsilon(1e-15));
  LuminanceMoments more;
  for (const double value : {1.0, 3.0}) more.add(value);
  sum.add(more);
  CHECK(sum.count == 5);
  CHECK(sum.mean() == 2);
  // The sum of two values of sample variance 2 has variance 4.
  CHECK(sum.sum_variance == Approx(6).epsilon(1e-14));
  CHECK(LuminanceSum{}.mean() == 0);
  CHECK(LuminanceSum{}.standard_error() == 0);
}

}  // namespace
}  // namespace mlt::test
