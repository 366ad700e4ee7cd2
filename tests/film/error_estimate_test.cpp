// The error known without a reference: exact on numbers made by hand, unbiased on independent noise, and
// right for a noise of which a known part is removed by stratification.
#include "film/error_estimate.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "math/rng.hpp"

namespace mlt::test {
namespace {

TEST_CASE("halves are equal in number, and the last of an odd number belongs to none") {
  for (const std::uint64_t count : {1U, 2U, 3U, 8U, 255U}) {
    int sum = 0, used = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
      sum += half_of(i, count);
      used += half_of(i, count) != 0;
    }
    CHECK(sum == 0);
    CHECK(static_cast<std::uint64_t>(used) == count / 2 * 2);
  }
}

TEST_CASE("quarters are consecutive and equal in number") {
  for (const std::uint64_t count : {1U, 3U, 4U, 7U, 64U, 101U}) {
    std::uint64_t members[5] = {0, 0, 0, 0, 0};
    std::uint64_t last = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::uint64_t quarter = quarter_of(i, count);
      REQUIRE(quarter >= last);
      REQUIRE(quarter <= 4);
      last = quarter;
      ++members[quarter];
    }
    for (int q = 0; q < 4; ++q) CHECK(members[q] == count / 4);
    CHECK(members[4] == count % 4);
  }
}

TEST_CASE("differences of a pixel's sums, by hand") {
  PixelSum sum;
  const float values[8] = {1, 2, 4, 8, 16, 32, 64, 128};
  for (std::uint64_t i = 0; i < 8; ++i) sum.add(Vec3{values[i], 0, 1}, quarter_of(i, 8));
  CHECK(sum.channels[0] == 255);
  const PixelDifferences differences = pixel_differences(sum, 1.0 / 8);
  CHECK(differences.halves[0] == Approx(std::pow((15.0 - 240.0) / 8, 2)));
  CHECK(differences.quarters[0] ==
        Approx(2 * (std::pow((3.0 - 12.0) / 8, 2) + std::pow((48.0 - 192.0) / 8, 2))));
  CHECK(differences.halves[1] == 0);
  CHECK(differences.halves[2] == 0);
  FilmPixel pixel;
  pixel.difference[1] = -6;
  CHECK(pixel_differences(pixel, 0.5).halves[1] == 9);
  CHECK(pixel_differences(pixel, 0.5).quarters[1] == 9);
}

/// An image of radiance 1 of which each pixel is the mean of `count` samples with independent noise of
/// variance 0.04.
ErrorEstimate estimate_of_noise(std::uint64_t count, double& true_rel_mse) {
  constexpr std::uint32_t kSide = 64;
  std::vector<PixelSum> sums(kSide * kSide);
  std::vector<Vec3> pixels(sums.size());
  Rng rng(31, StreamPurpose::kTest, count);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    for (std::uint64_t s = 0; s < count; ++s) {
      // Uniform in [-0.5, 0.5) has variance 1/12.
      const float noise = (rng.next_float() - 0.5f) * std::sqrt(12.0f * 0.04f);
      sums[i].add(Vec3{1 + noise, 1 + noise, 1 + noise}, quarter_of(s, count));
    }
    pixels[i] = develop_pixel(sums[i], count);
    const double error = static_cast<double>(pixels[i].x) - 1;
    true_rel_mse += error * error / 1.01 / static_cast<double>(sums.size());
  }
  const ImageView image{kSide, kSide, pixels};
  std::vector<ErrorSums> blocks(16);
  for (std::uint32_t i = 0; i < sums.size(); ++i) {
    const ErrorSums added = relative_differences(
        image, i % kSide, i / kSide, pixel_differences(sums[i], 1.0 / static_cast<double>(count)));
    blocks[i / 256].halves += added.halves;
    blocks[i / 256].quarters += added.quarters;
  }
  return estimate_error(blocks, sums.size(), true);
}

TEST_CASE("the estimate of independent noise is its variance, with a fair standard error") {
  for (const std::uint64_t count : {4U, 16U, 64U}) {
    double true_rel_mse = 0;
    const ErrorEstimate estimate = estimate_of_noise(count, true_rel_mse);
    REQUIRE(estimate.known);
    const double expected = 0.04 / static_cast<double>(count) / 1.01;
    // Squares of 4096 normal numbers have a mean that is off by sqrt(2/4096) = 2.2 %, and the factor, found
    // from these and as many again, by 1.8 %: five times both. The standard error is known to 18 % from 16
    // blocks.
    CHECK(estimate.rel_mse == Approx(expected).epsilon(0.14));
    CHECK(estimate.standard_error < 2 * 0.022 * expected);
    CHECK(estimate.standard_error > 0.5 * 0.022 * expected);
    CHECK(true_rel_mse == Approx(expected).epsilon(0.12));
    CHECK(estimate.factor > 0.9);
  }
}

TEST_CASE("the factor follows from V(n) = a/n + b/n^2 and is bounded") {
  const auto factor = [](double a, double b) {
    // V(1), V(1/2) and V(1/4) of a sequence with n = 1 as unit.
    const double whole = a + b, half = 2 * a + 4 * b, quarter = 4 * a + 16 * b;
    std::vector<ErrorSums> blocks(4, ErrorSums{half - whole, quarter - half});
    const ErrorEstimate estimate = estimate_error(blocks, 4, true);
    return estimate.rel_mse / whole;
  };
  CHECK(factor(1, 0) == Approx(1));
  CHECK(factor(1, 0.2) == Approx(1));
  CHECK(factor(1, 0.4) == Approx(1));
  // Without a part of independent noise, the bound overstates: 3 b times 1/2 instead of b.
  CHECK(factor(0, 1) == Approx(1.5));
  CHECK_FALSE(estimate_error({}, 0, true).known);
  CHECK(estimate_error(std::vector<ErrorSums>(1, ErrorSums{2, 4}), 1, true).standard_error == 2);
}

TEST_CASE("an outlier is measured by its neighbours") {
  std::vector<Vec3> pixels(25, Vec3{1, 1, 1});
  pixels[12] = Vec3{1000, 1000, 1000};
  const ImageView image{5, 5, pixels};
  PixelDifferences differences;
  for (int c = 0; c < 3; ++c) differences.halves[c] = differences.quarters[c] = 1e6;
  CHECK(relative_differences(image, 2, 2, differences).halves == Approx(1e6 / 1.01));
  const std::vector<PixelDifferences> all(25, differences);
  for (const Vec3& error : smooth_standard_errors(all, 0.25, 5, 5)) CHECK(error.y == Approx(500));
}

}  // namespace
}  // namespace mlt::test
