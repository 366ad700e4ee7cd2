#include "compare/replicates.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "compare/statistics.hpp"
#include "math/rng.hpp"
#include "support/statistics.hpp"

namespace mlt {
namespace {

TEST_CASE("the product's distributions agree with those of the tests, which use the C library") {
  for (const double x : {0.01, 0.5, 1.0, 1.5, 2.0, 7.3, 14.999, 15.0, 120.5, 9999.0}) {
    CAPTURE(x);
    CHECK(log_gamma(x) == Approx(std::lgamma(x)).epsilon(1e-14).margin(1e-14));
  }
  for (const double a : {0.5, 1.0, 3.7, 40.0, 5000.0}) {
    for (const double b : {0.5, 2.0, 33.3}) {
      for (const double x : {0.0, 1e-6, 0.1, 0.5, 0.93, 0.999999, 1.0}) {
        CAPTURE(a, b, x);
        CHECK(regularised_beta(a, b, x) ==
              Approx(test::incomplete_beta(a, b, x)).epsilon(1e-10).margin(1e-300));
      }
    }
  }
  for (const double t : {0.0, 0.3, -1.0, 2.5, 8.0, 1e6}) {
    for (const double dof : {1.0, 2.0, 3.4, 30.0, 1e4}) {
      CAPTURE(t, dof);
      CHECK(student_tail(t, dof) == Approx(test::student_p_value(t, dof)).epsilon(1e-9).margin(1e-300));
    }
    // Closed form for one degree of freedom.
    if (t > 0) CHECK(student_tail(t, 1) == Approx(2 / M_PI * std::atan(1 / t)).epsilon(1e-10));
  }
  CHECK(student_tail(std::numeric_limits<double>::infinity(), 3) == 0);
  for (const std::size_t tests : {1U, 7U, 100000U}) {
    const double level = sidak_level(0.01, tests);
    CHECK(level == Approx(test::sidak_threshold(0.01, tests)).epsilon(1e-11));
    CHECK(sidak_p_value(level, tests) == Approx(0.01).epsilon(1e-11));
  }
  CHECK(sidak_p_value(1, 10) == 1);
  CHECK(sidak_p_value(0, 10) == 0);
}

TEST_CASE("Welch's test agrees with that of the tests and treats what does not vary exactly") {
  const std::vector<double> a{1, 2, 3, 4};
  const std::vector<double> b{2, 4, 6, 8, 10};
  const WelchResult result = welch_test(sample_moments(a), sample_moments(b));
  const test::TTestResult expected = test::welch_t_test(test::moments(a), test::moments(b));
  CHECK(result.t == Approx(expected.t).epsilon(1e-14));
  CHECK(result.dof == Approx(expected.dof).epsilon(1e-14));
  CHECK(result.p_value == Approx(expected.p_value).epsilon(1e-10));
  // Three times a number that has no exact third.
  const SampleMoments constant = sample_moments(std::vector<double>{0.1, 0.1, 0.1});
  CHECK(constant.mean == 0.1);
  CHECK(constant.variance == 0);
  CHECK(welch_test(constant, constant).p_value == 1);
  CHECK(welch_test(constant, sample_moments(std::vector<double>{0.2, 0.2})).p_value == 0);
}

TEST_CASE("the one-sided Kolmogorov-Smirnov test sees small p-values and passes large ones") {
  // 10 % points of the one-sided test for n values: half of the two-sided table's [Miller56]; values at i/n
  // less the gap put it at every step.
  struct Row {
    int n;
    double distance;
  };
  for (const Row row : {Row{10, 0.32260}, Row{20, 0.23156}, Row{50, 0.14840}}) {
    std::vector<double> values;
    for (int i = 1; i <= row.n; ++i) values.push_back(std::fmax(0.0, i / double(row.n) - row.distance));
    const UniformResult result = ks_small_test(values);
    CHECK(result.distance == Approx(row.distance).epsilon(1e-12));
    CHECK(result.p_value == Approx(0.1).epsilon(0.03));
  }
  CHECK(ks_small_test(std::vector<double>(100, 1.0)).p_value == 1);
  CHECK(ks_small_test(std::vector<double>(100, 0.2)).p_value < 1e-20);
  CHECK(ks_small_test({}).p_value == 1);
}

/// Noise around a slope in the shape of a rendered replicate: skewed, some pixels black.
std::vector<ImageBuffer> replicates(std::uint64_t seed, std::size_t count, float bias, std::uint32_t biased) {
  std::vector<ImageBuffer> images;
  for (std::size_t k = 0; k < count; ++k) {
    Rng rng(seed * 1000 + k, StreamPurpose::kTest, 5);
    ImageBuffer image{37, 30, {}};
    for (std::uint32_t y = 0; y < 30; ++y) {
      for (std::uint32_t x = 0; x < 37; ++x) {
        const float u = rng.next_float();
        const float value = (0.5f + static_cast<float>(x) / 37.0f) * 3.0f * u * u;
        const bool inside = x / 8 < biased;
        Vec3 pixel{value, 0.5f * value, u};
        if (inside) pixel.z *= 1.0f + bias;
        if (y < 3) pixel = Vec3(0.25f);  // does not vary
        image.pixels.push_back(pixel);
      }
    }
    images.push_back(std::move(image));
  }
  return images;
}

std::vector<ImageView> views(const std::vector<ImageBuffer>& images) {
  std::vector<ImageView> result;
  for (const ImageBuffer& image : images) result.push_back(image.view());
  return result;
}

ReplicateTestResult run(const std::vector<ImageBuffer>& a, const std::vector<ImageBuffer>& b, double alpha) {
  return test_replicates(views(a), views(b), {8, alpha});
}

TEST_CASE("replicates of the same picture are rejected no more often than alpha says") {
  constexpr int kRuns = 100;
  constexpr double kAlpha = 0.1;
  int rejected = 0;
  std::vector<double> sidak;
  for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
    const ReplicateTestResult result =
        run(replicates(2 * seed + 1, 5, 0, 0), replicates(2 * seed + 2, 4, 0, 0), kAlpha);
    rejected += result.rejected;
    sidak.push_back(result.sidak_p_value);
  }
  // 10 of 100 expected if the tests were exact; the channels of a tile depend on each other, which makes them
  // cautious. 20 and more of a binomial have probability 0.002.
  CHECK(rejected <= 19);
  CHECK(rejected >= 1);
  CHECK(ks_small_test(sidak).p_value > 0.001);
}

TEST_CASE("a strong error in one tile and a weak one everywhere are found") {
  const ReplicateTestResult strong = run(replicates(1, 6, 0, 0), replicates(2, 6, 0.5f, 1), 0.01);
  CHECK(strong.rejected);
  CHECK(strong.sidak_p_value < 1e-3);
  CHECK(strong.smallest_x == 0);
  // 6 % more light everywhere, and up to 30 % moved from left to right: little against the noise of a tile.
  const std::vector<ImageBuffer> a = replicates(3, 8, 0, 0);
  std::vector<ImageBuffer> brighter = replicates(4, 8, 0, 0);
  for (ImageBuffer& image : brighter) {
    for (Vec3& pixel : image.pixels) pixel *= 1.06f;
  }
  CHECK(run(a, brighter, 0.01).rejected);
  CHECK(run(a, brighter, 0.01).mean_p_value < 1e-3);
  CHECK(run(a, brighter, 0.01).ks_p_value > 0.01);
  std::vector<ImageBuffer> shifted = replicates(5, 8, 0, 0);
  for (ImageBuffer& image : shifted) {
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
      if (i >= 3 * 37) image.pixels[i] *= 0.7f + 0.6f * static_cast<float>(i % 37) / 36.0f;
    }
  }
  CHECK(run(a, shifted, 0.01).ks_p_value <= 0.003);
  CHECK(run(a, shifted, 0.01).relabellings == 1000);
}

TEST_CASE("a common factor of each replicate, as Metropolis renders have, is no difference") {
  int rejected = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    std::vector<ImageBuffer> sets[2] = {replicates(500 + 2 * seed, 4, 0, 0),
                                        replicates(501 + 2 * seed, 4, 0, 0)};
    Rng rng(seed, StreamPurpose::kTest, 6);
    for (std::vector<ImageBuffer>& set : sets) {
      for (ImageBuffer& image : set) {
        const float factor = 0.7f + 0.6f * rng.next_float();
        for (Vec3& pixel : image.pixels) pixel *= factor;
      }
    }
    rejected += run(sets[0], sets[1], 0.1).rejected;
  }
  // 10 of 100 expected; 20 and more of a binomial have probability 0.002.
  CHECK(rejected <= 19);
}

TEST_CASE("tiles cover the picture, and what does not vary is told exactly") {
  const std::vector<ImageBuffer> a = replicates(1, 3, 0, 0);
  const ReplicateTestResult same = run(a, a, 0.01);
  CHECK(same.tiles_x == 5);
  CHECK(same.tiles_y == 4);
  CHECK(same.p_values.size() == 20);
  CHECK(same.tests == 60);
  CHECK(same.relabellings == 20);
  CHECK_FALSE(same.rejected);
  CHECK(same.smallest_p_value == 1);

  const ImageBuffer flat{4, 4, std::vector<Vec3>(16, Vec3(0.5f))};
  const ReplicateTestResult nothing = run({flat, flat}, {flat, flat}, 0.01);
  CHECK(nothing.tests == 0);
  CHECK_FALSE(nothing.rejected);
  ImageBuffer other = flat;
  other.pixels[15].y += 1e-6f;
  const ReplicateTestResult differs = run({flat, flat}, {other, other}, 0.01);
  CHECK(differs.tests == 1);
  CHECK(differs.rejected);
  CHECK(differs.p_values.front() == 0);
  const Picture picture = draw_p_values(differs, 4, 4, 8);
  CHECK(picture.bytes.size() == std::size_t{3} * picture.width * picture.height);
}

}  // namespace
}  // namespace mlt
