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

TEST_CASE("the halves of a sequence are consecutive and equal in number") {
  for (const std::uint64_t count : {1U, 2U, 3U, 4U, 7U, 64U, 101U}) {
    std::uint64_t members[3] = {0, 0, 0};
    int last = 1;
    for (std::uint64_t i = 0; i < count; ++i) {
      const int half = half_of_sequence(i, count);
      if (half != 0) REQUIRE(half <= last);
      last = half;
      ++members[half + 1];
    }
    CHECK(members[2] == count / 2);
    CHECK(members[0] == count / 2);
    CHECK(members[1] == count % 2);
  }
}

TEST_CASE("every 16th pixel has two sequences") {
  for (const auto& [width, height] : {std::pair{1U, 1U}, {4U, 4U}, {5U, 9U}, {1U, 17U}, {64U, 48U}}) {
    std::uint64_t sequences = 0;
    for (std::uint32_t y = 0; y < height; ++y) {
      for (std::uint32_t x = 0; x < width; ++x) sequences += sequences_in(x, y);
    }
    CHECK(sequences == sequences_in_film(width, height));
  }
  CHECK(sequences_in_film(64, 64) == 64 * 64 + 16 * 16);
}

TEST_CASE("differences of a pixel's sums, by hand") {
  PixelSum sum;
  const float values[8] = {1, 2, 4, 8, 16, 32, 64, 128};
  for (std::uint64_t i = 0; i < 8; ++i) {
    sum.add(Vec3{values[i], 0, 1}, half_of_sequence(i % 4, 4), i < 4 ? 1 : -1);
  }
  CHECK(sum.channels[0] == 255);
  const PixelDifferences differences = pixel_differences(sum, 1.0 / 4, 2);
  CHECK(differences.has_sequences);
  CHECK(differences.halves[0] == Approx(std::pow((3.0 - 12.0 + 48.0 - 192.0) / 8, 2)));
  CHECK(differences.sequences[0] == Approx(std::pow((15.0 - 240.0) / 8, 2)));
  CHECK(differences.halves[1] == 0);
  CHECK(differences.halves[2] == 0);
  CHECK(differences.sequences[2] == 0);
  CHECK(pixel_differences(sum, 1.0 / 8, 1).halves[0] == differences.halves[0]);
  CHECK(pixel_differences(sum, 1.0 / 8, 1).sequences[0] == 0);
  FilmPixel pixel;
  pixel.difference[1] = -6;
  CHECK(pixel_differences(pixel, 0.5).halves[1] == 9);
  CHECK_FALSE(pixel_differences(pixel, 0.5).has_sequences);
}

/// An image of radiance 1 of which each pixel is the mean of `count` samples with independent noise of
/// variance 0.04. A second half of a sequence shares the share `echo` of the first's noise with opposite
/// sign, as samples that complement each other do.
ErrorEstimate estimate_of_noise(std::uint64_t count, float echo, double& true_rel_mse) {
  constexpr std::uint32_t kSide = 64;
  std::vector<PixelSum> sums(kSide * kSide);
  std::vector<Vec3> pixels(sums.size());
  Rng rng(31, StreamPurpose::kTest, count);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const std::uint32_t sequences = sequences_in(i % kSide, i / kSide);
    for (std::uint32_t sequence = 0; sequence < sequences; ++sequence) {
      std::vector<float> noise(count);
      for (std::uint64_t s = 0; s < count; ++s) {
        // Uniform in [-0.5, 0.5) has variance 1/12.
        noise[s] = (rng.next_float() - 0.5f) * std::sqrt(12.0f * 0.04f);
        if (s >= count / 2) noise[s] -= echo * noise[s - count / 2];
        sums[i].add(Vec3{1 + noise[s]}, half_of_sequence(s, count), sequence == 0 ? 1 : -1);
      }
    }
    pixels[i] = develop_pixel(sums[i], sequences * count);
    const double error = static_cast<double>(pixels[i].x) - 1;
    true_rel_mse += error * error / 1.01 / static_cast<double>(sums.size());
  }
  const ImageView image{kSide, kSide, pixels};
  std::vector<ErrorSums> blocks(16);
  for (std::uint32_t i = 0; i < sums.size(); ++i) {
    const std::uint32_t x = i % kSide, y = i / kSide;
    blocks[i / 256].add(relative_differences(
        image, x, y, pixel_differences(sums[i], 1.0 / static_cast<double>(count), sequences_in(x, y))));
  }
  return estimate_error(blocks, sums.size());
}

TEST_CASE("the estimate is the noise's variance, whether samples are independent or complement each other") {
  for (const float echo : {0.0f, 0.5f, 0.9f}) {
    for (const std::uint64_t count : {2U, 16U, 64U}) {
      double true_rel_mse = 0;
      const ErrorEstimate estimate = estimate_of_noise(count, echo, true_rel_mse);
      REQUIRE(estimate.known);
      // The sum over both halves of x + (y - echo x), of which sequences in 256 of 4096 pixels count half.
      const double sums = 0.5 * (1 + (1 - echo) * (1 - echo)) * (1 - 1 / 32.0);
      const double expected = 0.04 / static_cast<double>(count) / 1.01 * sums;
      INFO("echo " << echo << ", count " << count);
      // Squares of 256 normal numbers have a mean that is off by sqrt(2/256) = 8.8 %, and the quotient of two
      // means, less correlated the more the halves complement each other, by 12.5 % at the most: three times
      // it.
      CHECK(estimate.rel_mse == Approx(expected).epsilon(0.375));
      // The standard error is known to 18 % from 16 blocks, whose own is at least that of the factor's
      // numerator.
      CHECK(estimate.standard_error < 2 * 0.125 * expected);
      CHECK(true_rel_mse == Approx(expected).epsilon(0.12));
    }
  }
}

TEST_CASE("the factor is what two sequences differ by, over what their halves do") {
  const ErrorSums block{8.0, 2.0, 0.5};
  const ErrorEstimate estimate = estimate_error(std::vector<ErrorSums>(4, block), 16);
  CHECK(estimate.factor == Approx(0.25));
  CHECK(estimate.rel_mse == Approx(0.25 * 32 / 16));
  CHECK(estimate.standard_error == Approx(0.0).margin(1e-12));
  CHECK_FALSE(estimate_error({}, 0).known);
  // Without pairs, as for chains, the halves are the whole truth.
  const ErrorEstimate chains = estimate_error(std::vector<ErrorSums>(1, ErrorSums{2.0, 0.0, 0.0}), 1);
  CHECK(chains.factor == 1);
  CHECK(chains.standard_error == 2);
}

TEST_CASE("an outlier is measured by its neighbours") {
  std::vector<Vec3> pixels(25, Vec3{1, 1, 1});
  pixels[12] = Vec3{1000, 1000, 1000};
  const ImageView image{5, 5, pixels};
  PixelDifferences differences;
  for (int c = 0; c < 3; ++c) differences.halves[c] = 1e6;
  CHECK(relative_differences(image, 2, 2, differences).halves == Approx(1e6 / 1.01));
  const std::vector<PixelDifferences> all(25, differences);
  for (const Vec3& error : smooth_standard_errors(all, 0.25, 5, 5)) CHECK(error.y == Approx(500));
}

}  // namespace
}  // namespace mlt::test
