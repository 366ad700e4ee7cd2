// The path tracer's samples: stratified within a pixel, uniform and independent across pixels and dimensions.
#include "integrator/pixel_sampler.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <set>
#include <vector>

#include "support/pixel_samples.hpp"
#include "support/statistics.hpp"

namespace mlt::test {
namespace {

constexpr double kSignificance = 1e-4;  // of one test case, by Sidak's correction

/// Which of 2^bits equal intervals of [0,1) a float primary sample lies in; exact, for bits <= 24.
std::uint32_t interval(float u, std::uint32_t bits) {
  return static_cast<std::uint32_t>(std::ldexp(u, static_cast<int>(bits)));
}

/// Does every elementary interval, of width 2^-a and height 2^(a-m), hold one of the 2^m points?
bool is_net(const std::vector<Vec2>& points, std::uint32_t m) {
  for (std::uint32_t a = 0; a <= m; ++a) {
    std::vector<bool> taken(points.size());
    for (const Vec2& point : points) {
      const std::uint32_t cell = (interval(point.x, a) << (m - a)) | interval(point.y, m - a);
      if (taken[cell]) return false;
      taken[cell] = true;
    }
  }
  return true;
}

/// The pairs of `count` samples of one pixel, after `skipped` dimensions.
std::vector<Vec2> pairs(PixelSampler& sampler, std::uint32_t x, std::uint32_t y, std::uint32_t count,
                        std::uint32_t skipped) {
  std::vector<Vec2> points;
  for (std::uint32_t i = 0; i < count; ++i) {
    start_sample(sampler, x, y, i);
    sampler.skip(skipped);
    points.push_back(sampler.next_2d());
  }
  return points;
}

TEST_CASE("each pair of dimensions is a (0,2)-net for every power of two, of a job's samples or fewer") {
  for (std::uint32_t m = 0; m <= 12; ++m) {
    const std::uint32_t count = 1U << m;
    // A power of two in all, just more, and many more.
    for (const std::uint64_t total :
         {std::uint64_t{count}, std::uint64_t{count} + 1, std::uint64_t{1} << 30}) {
      PixelSampler sampler(m, 100, 80, total);
      for (std::uint32_t dimension = 2; dimension < 40; dimension += 6) {
        INFO("2^" << m << " of " << total << " samples, dimension " << dimension);
        CHECK(is_net(pairs(sampler, dimension % 7, m, count, dimension), m));
      }
    }
  }
}

TEST_CASE("single dimensions are stratified") {
  for (std::uint32_t m = 0; m <= 10; ++m) {
    for (const std::uint64_t total : {std::uint64_t{1} << m, std::uint64_t{3} << m}) {
      PixelSampler sampler(m, 64, 64, total);
      std::set<std::uint32_t> strata;
      for (std::uint32_t i = 0; i < 1U << m; ++i) {
        start_sample(sampler, 3, 5, i);
        sampler.skip(2 + m);
        strata.insert(interval(sampler.next(), m));
      }
      CHECK(strata.size() == std::size_t{1} << m);
    }
  }
}

struct FilmSample {
  std::uint32_t x, y;
};

FilmSample film_sample(PixelSampler& sampler, std::uint32_t x, std::uint32_t y, std::uint32_t sample) {
  start_sample(sampler, x, y, sample);
  const std::uint32_t fixed_x = sampler.next_fixed();
  return {fixed_x, sampler.next_fixed()};
}

/// Where a camera finds the pixel: fixed-point product.
std::uint32_t pixel_of(std::uint32_t fixed, std::uint32_t side) {
  return static_cast<std::uint32_t>((std::uint64_t{fixed} * side) >> 32);
}

TEST_CASE("film coordinates map back to their pixel for all sides") {
  Rng rng(1, StreamPurpose::kTest, 0);
  std::vector<std::uint32_t> sides{4096, 32767, 65535, 65536};
  for (std::uint32_t side = 1; side <= 2000; ++side) sides.push_back(side);
  for (const std::uint32_t side : sides) {
    const std::uint32_t height = 1 + rng.next_fixed() % side;
    PixelSampler sampler(side, side, height, 16);
    for (std::uint32_t i = 0; i < 40; ++i) {
      const std::uint32_t x = i < 10 ? 0 : i < 20 ? side - 1 : rng.next_fixed() % side;
      const std::uint32_t y = i < 10 ? height - 1 : rng.next_fixed() % height;
      const FilmSample sample = film_sample(sampler, x, y, i % 16);
      REQUIRE(pixel_of(sample.x, side) == x);
      REQUIRE(pixel_of(sample.y, height) == y);
    }
  }
}

TEST_CASE("film coordinates map back to their pixel next to its border") {
  // The widest film leaves 2^16 positions to a pixel: of a million jitters some 15 round up to its end.
  for (const std::uint32_t side : {65536U, 65535U, 40001U}) {
    PixelSampler sampler(7, side, side, 1024);
    for (std::uint32_t i = 0; i < 300000; ++i) {
      const std::uint32_t x = i % 311 * 211;
      const std::uint32_t clamped = std::min(x, side - 1);
      const FilmSample sample = film_sample(sampler, clamped, side - 1, i % 1024);
      REQUIRE(pixel_of(sample.x, side) == clamped);
      REQUIRE(pixel_of(sample.y, side) == side - 1);
    }
  }
}

TEST_CASE("a pixel's film positions are a (0,2)-net within it") {
  constexpr std::uint32_t kBits = 8;
  PixelSampler sampler(5, 16, 8, 1U << kBits);
  std::vector<Vec2> points;
  for (std::uint32_t i = 0; i < 1U << kBits; ++i) {
    const FilmSample sample = film_sample(sampler, 11, 3, i);
    // Powers of two divide the film: what remains below the pixel's number is the place within it.
    points.push_back(Vec2{unit_float(sample.x << 4), unit_float(sample.y << 3)});
  }
  CHECK(is_net(points, kBits));
}

/// Cells of both dimensions' first 16ths, over pixels.
class Histogram2D {
 public:
  void add(float u, float v) { ++cells_[interval(u, 4) * 16 + interval(v, 4)]; }
  double p_value() const {
    double total = 0;
    for (const std::uint64_t count : cells_) total += static_cast<double>(count);
    return chi_square_test(cells_, std::vector<double>(256, total / 256)).p_value;
  }

 private:
  std::vector<std::uint64_t> cells_ = std::vector<std::uint64_t>(256);
};

TEST_CASE("one sample of each pixel is uniform, and independent between dimensions and between pixels") {
  Histogram2D film, pair, between_pairs, between_singles, between_pixels, between_samples;
  PixelSampler sampler(3, 256, 256, 4);
  float previous = 0;
  for (std::uint32_t y = 0; y < 256; ++y) {
    for (std::uint32_t x = 0; x < 256; ++x) {
      start_sample(sampler, x, y, 2);
      const std::uint32_t fixed_x = sampler.next_fixed();
      film.add(unit_float(fixed_x << 8), unit_float(sampler.next_fixed() << 8));
      const Vec2 first = sampler.next_2d();
      const Vec2 second = sampler.next_2d();
      const float third = sampler.next();
      pair.add(first.x, first.y);
      between_pairs.add(first.x, second.x);
      between_singles.add(second.y, third);
      if (x % 2 == 1) between_pixels.add(previous, first.x);
      previous = first.x;
      // Pixels above each other, and two samples of one pixel that no net ties together: of different pairs.
      start_sample(sampler, x, y, 1);
      sampler.skip(2);
      between_samples.add(second.x, sampler.next_2d().x);
    }
  }
  const double threshold = sidak_threshold(kSignificance, 6);
  CHECK(film.p_value() > threshold);
  CHECK(pair.p_value() > threshold);
  CHECK(between_pairs.p_value() > threshold);
  CHECK(between_singles.p_value() > threshold);
  CHECK(between_pixels.p_value() > threshold);
  CHECK(between_samples.p_value() > threshold);
}

/// Mean product of two dimensions' deviations over a pixel's samples; 0 in expectation when the dimensions'
/// nets are shuffled and scrambled independently.
double covariance(const std::vector<Vec2>& a, const std::vector<Vec2>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i].x - 0.5) * (b[i].x - 0.5);
  return sum / static_cast<double>(a.size());
}

TEST_CASE("a pixel's samples are uncorrelated between pairs of dimensions and between pixels") {
  const double threshold = sidak_threshold(kSignificance, 2 * 4);
  for (const std::uint32_t count : {2U, 4U, 16U, 64U}) {
    PixelSampler sampler(count, 64, 64, count);
    std::vector<double> dimensions, pixels;
    for (std::uint32_t i = 0; i < 1000; ++i) {
      const std::uint32_t x = i % 50;
      const std::uint32_t y = i / 50;
      const std::vector<Vec2> first = pairs(sampler, x, y, count, 2);
      dimensions.push_back(covariance(first, pairs(sampler, x, y, count, 4)));
      pixels.push_back(covariance(first, pairs(sampler, x + 1, y, count, 2)));
    }
    INFO(count << " samples");
    CHECK(student_t_test(moments(dimensions), 0).p_value > threshold);
    CHECK(student_t_test(moments(pixels), 0).p_value > threshold);
  }
}

/// How many of the samples lie in the lower half of two dimensions.
std::uint32_t lower_quadrant(const std::vector<Vec2>& a, const std::vector<Vec2>& b) {
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) count += a[i].x < 0.5f && b[i].x < 0.5f ? 1U : 0U;
  return count;
}

/// Frequencies of counts against a binomial distribution with probability 1/2.
double binomial_p_value(const std::vector<std::uint64_t>& observed) {
  const double trials = static_cast<double>(observed.size() - 1);
  double total = 0;
  for (const std::uint64_t count : observed) total += static_cast<double>(count);
  std::vector<double> expected;
  for (double k = 0; k <= trials; k += 1) {
    const double log_ways = std::lgamma(trials + 1) - std::lgamma(k + 1) - std::lgamma(trials - k + 1);
    expected.push_back(total * std::exp(log_ways - trials * std::log(2.0)));
  }
  return chi_square_test(observed, expected).p_value;
}

TEST_CASE("a pixel's samples are shuffled anew for each pair of dimensions and each pixel") {
  // Samples 2j and 2j + 1 lie in different halves of every dimension, and a nested uniform shuffle decides
  // for each such couple alone which is where: the number in the lower half of two dimensions is binomial.
  // Without the shuffle all couples would decide alike, whatever the scrambles.
  const double threshold = sidak_threshold(kSignificance, 2 * 4);
  for (const std::uint32_t count : {2U, 4U, 16U, 64U}) {
    PixelSampler sampler(count, 100, 100, count);
    std::vector<std::uint64_t> dimensions(count / 2 + 1), pixels(count / 2 + 1);
    for (std::uint32_t i = 0; i < 4000; ++i) {
      const std::uint32_t x = i % 80;
      const std::uint32_t y = i / 80;
      const std::vector<Vec2> first = pairs(sampler, x, y, count, 2);
      ++dimensions[lower_quadrant(first, pairs(sampler, x, y, count, 4))];
      ++pixels[lower_quadrant(first, pairs(sampler, x + 1, y, count, 2))];
    }
    INFO(count << " samples");
    CHECK(binomial_p_value(dimensions) > threshold);
    CHECK(binomial_p_value(pixels) > threshold);
  }
}

TEST_CASE("a sample is a function of seed, pixel, index and dimension; skipping keeps later dimensions") {
  PixelSampler sampler(1, 50, 40, 16);
  start_sample(sampler, 7, 9, 3);
  std::vector<float> values;
  for (int i = 0; i < 10; ++i) values.push_back(sampler.next());
  start_sample(sampler, 8, 9, 3);
  CHECK(sampler.next() != values[0]);
  for (std::uint32_t skipped = 0; skipped < 10; ++skipped) {
    start_sample(sampler, 7, 9, 3);
    sampler.skip(skipped);
    CHECK(sampler.next() == values[skipped]);
  }
  // The place of a pair is its first dimension, whatever was asked for before.
  start_sample(sampler, 7, 9, 3);
  sampler.skip(6);
  const Vec2 pair = sampler.next_2d();
  start_sample(sampler, 7, 9, 3);
  for (int i = 0; i < 4; ++i) sampler.next();
  sampler.next_2d();
  CHECK(sampler.next_2d() == pair);
  PixelSampler other_seed(2, 50, 40, 16);
  start_sample(other_seed, 7, 9, 3);
  other_seed.skip(2);
  CHECK(other_seed.next() != values[2]);
}

TEST_CASE("a sample is a function of pixel, index and dimension alone, whatever was asked for before") {
  // Far apart, where numbers of a block share a place, too; in an order that no path has.
  constexpr std::uint32_t kLast = 300;
  PixelSampler used(9, 8, 8, 32);
  for (const std::uint32_t sample : {0U, 9U, 3U, 31U, 8U}) {
    used.clear();
    used.place({2, 5, 1, sample / 8 * 8}, 8);
    for (std::uint32_t dimension = 2; dimension + 2 <= kLast; dimension += 3) {
      PixelSampler fresh(9, 8, 8, 32);
      start_sample(fresh, 2, 5, sample, 1);
      fresh.skip(dimension);
      used.start(sample % 8);
      used.skip(dimension);
      REQUIRE(used.next_2d() == fresh.next_2d());
      REQUIRE(used.next_fixed() == fresh.next_fixed());
      REQUIRE(used.dimension() == dimension + 3);
      // As a single, what was one of a pair, and the reverse.
      used.start(sample % 8);
      used.skip(dimension);
      const std::uint32_t single = used.next_fixed();
      start_sample(fresh, 2, 5, sample, 1);
      fresh.skip(dimension);
      REQUIRE(single == fresh.next_fixed());
    }
  }
  // And no two of them are the same.
  std::vector<std::uint32_t> values;
  start_sample(used, 2, 5, 7);
  for (std::uint32_t dimension = 0; dimension < kLast; ++dimension) values.push_back(used.next_fixed());
  std::sort(values.begin(), values.end());
  CHECK(std::adjacent_find(values.begin(), values.end()) == values.end());
}

}  // namespace
}  // namespace mlt::test
