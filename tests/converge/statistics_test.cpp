// The statistics against closed forms, libm and the coverage that an interval promises.
#include "converge/statistics.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "math/rng.hpp"

namespace mlt {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A standard normal number by Box and Muller, with libm, from 24-bit uniform ones.
double normal(Rng& rng) {
  const double u = 1.0 - static_cast<double>(rng.next_float());
  const double v = static_cast<double>(rng.next_float());
  return std::sqrt(-2 * std::log(u)) * std::cos(6.283185307179586 * v);
}

TEST_CASE("the decimal logarithm and power agree with libm") {
  // The bounds are those that the header states.
  Rng rng(1, StreamPurpose::kTest, 0);
  double worst_log = 0, worst_power = 0;
  for (int i = 0; i < 100000; ++i) {
    const double x = (static_cast<double>(rng.next_fixed()) + 1) *
                     std::pow(10.0, 590.0 * static_cast<double>(rng.next_float()) - 300);
    const double expected = std::log10(x);
    worst_log = std::max(worst_log, std::fabs(log10_of(x) - expected) / std::max(1.0, std::fabs(expected)));
    const double y = 600.0 * static_cast<double>(rng.next_float()) - 300;
    const long double power = std::pow(10.0L, static_cast<long double>(y));
    worst_power = std::max(worst_power, static_cast<double>(std::fabs(power_of_10(y) / power - 1)));
  }
  CHECK(worst_log < 1e-13);
  CHECK(worst_power < 1e-9);
  CHECK(log10_of(1) == 0);
  CHECK(log10_of(1e-310) == Approx(-310).epsilon(1e-13));
  CHECK(power_of_10(0) == Approx(1).epsilon(1e-9));
}

TEST_CASE("quantiles follow definition 7") {
  // position = share * (n - 1), linear between neighbours: worked by hand.
  const std::vector<double> values{40, 10, 30, 20};
  CHECK(quantile(values, 0) == 10);
  CHECK(quantile(values, 1) == 40);
  CHECK(median(values) == 25);
  CHECK(quantile(values, 0.95) == Approx(38.5).epsilon(1e-15));
  CHECK(quantile(values, 0.1) == Approx(13).epsilon(1e-15));
  CHECK(quantile({7}, 0.95) == 7);
  CHECK(median({1, 5, 3}) == 3);
  CHECK(quantile({1, kInfinity}, 0.5) == kInfinity);
  CHECK(quantile({0, kInfinity, kInfinity}, 0.75) == kInfinity);
}

TEST_CASE("the mean's standard error is the sample deviation over the root of n") {
  // Squared deviations from 3 sum to 10; 10 / 4 / 5 = 1/2.
  const std::vector<double> values{1, 2, 3, 4, 5};
  CHECK(mean_of(values).mean == 3);
  CHECK(mean_of(values).standard_error == Approx(std::sqrt(0.5)).epsilon(1e-15));
  CHECK(std::isnan(mean_of(std::vector<double>{4}).standard_error));
}

TEST_CASE("the exponent of a power law is found, with its error") {
  std::vector<double> x, y;
  for (int i = 0; i < 12; ++i) {
    x.push_back(0.01 * std::pow(2.0, i));
    y.push_back(3.5 * std::pow(x.back(), -1.25));
  }
  const auto exact = fit_power_law(x, y);
  REQUIRE(exact);
  CHECK(exact->exponent == Approx(-1.25).epsilon(1e-10));
  CHECK(std::pow(10.0, exact->log10_factor) == Approx(3.5).epsilon(1e-9));
  CHECK(exact->exponent_error < 1e-10);

  // log10 y off by +-d at the ends of three points one decade apart: slope unchanged by +d, -2d, +d, whose
  // squares sum to 6 d^2 on one degree of freedom, over sum of squares 2 of log10 x.
  const double d = 0.01;
  const auto noisy =
      fit_power_law(std::vector<double>{1, 10, 100},
                    std::vector<double>{std::pow(10, d), std::pow(10, -1 - 2 * d), std::pow(10, -2 + d)});
  REQUIRE(noisy);
  CHECK(noisy->exponent == Approx(-1).epsilon(1e-10));
  CHECK(noisy->exponent_error == Approx(std::sqrt(6 * d * d / 2)).epsilon(1e-9));

  CHECK_FALSE(fit_power_law(std::vector<double>{2, 2}, std::vector<double>{1, 3}));
  CHECK_FALSE(fit_power_law(std::vector<double>{2}, std::vector<double>{1}));
  const auto two = fit_power_law(std::vector<double>{1, 10}, std::vector<double>{1, 0.1});
  REQUIRE(two);
  CHECK(std::isnan(two->exponent_error));
}

TEST_CASE("the standard error of the exponent is that of repeated fits") {
  // 400 fits of noise 0.2 in log10; the sample deviation of 400 values is known to 3.5 %, so 15 % is four
  // standard errors.
  Rng rng(2, StreamPurpose::kTest, 0);
  std::vector<double> exponents, errors;
  for (int trial = 0; trial < 400; ++trial) {
    std::vector<double> x, y;
    for (int i = 0; i < 40; ++i) {
      x.push_back(std::pow(10.0, 0.1 * i));
      y.push_back(std::pow(10.0, -0.1 * i + 0.2 * normal(rng)));
    }
    const auto law = fit_power_law(x, y);
    REQUIRE(law);
    exponents.push_back(law->exponent);
    errors.push_back(law->exponent_error);
  }
  const MeanEstimate found = mean_of(exponents);
  CHECK(std::fabs(found.mean + 1) < 4 * found.standard_error);
  CHECK(mean_of(errors).mean == Approx(found.standard_error * 20).epsilon(0.15));
}

TEST_CASE("a target is interpolated along the power law between two points") {
  const std::vector<double> x{1, 4, 16, 64};
  std::vector<double> y;
  for (const double at : x) y.push_back(2 / at);
  const Crossing between = find_crossing(x, y, 2 / 7.0);
  CHECK(between.reach == Reach::kReached);
  CHECK(between.x == Approx(7).epsilon(1e-9));
  CHECK(find_crossing(x, y, 0.5).x == Approx(4).epsilon(1e-9));
  CHECK(find_crossing(x, y, 2).reach == Reach::kBeforeFirst);
  CHECK(find_crossing(x, y, 5).x == 0);
  CHECK(find_crossing(x, y, 1e-3).reach == Reach::kNever);
  CHECK(find_crossing(x, y, 1e-3).x == kInfinity);
  // The first time counts, and an error below the reference's own has no logarithm.
  CHECK(find_crossing(x, std::vector<double>{2, 0.1, 2, 0.1}, 0.1).x == Approx(4).epsilon(1e-9));
  CHECK(find_crossing(x, std::vector<double>{2, 1, -0.1, -0.2}, 0.1).x == 16);
}

TEST_CASE("bootstrap intervals of a mean cover it about as often as promised") {
  // 300 samples of 16 normal numbers. The percentile interval of a mean is the normal one with the biased
  // deviation: half width 1.96 sqrt(15/16) s / 4, which Student's t with 15 degrees covers with 0.922. Four
  // standard errors of 300 trials at that rate are 0.062.
  Rng rng(3, StreamPurpose::kTest, 0);
  int covered = 0;
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<double> values;
    for (int i = 0; i < 16; ++i) values.push_back(5 + normal(rng));
    const Interval interval = bootstrap_interval(16, [&values](std::span<const std::uint32_t> chosen) {
      double sum = 0;
      for (const std::uint32_t index : chosen) sum += values[index];
      return sum / static_cast<double>(chosen.size());
    });
    covered += interval.low <= 5 && 5 <= interval.high ? 1 : 0;
  }
  CHECK(std::fabs(covered / 300.0 - 0.922) < 0.062);
}

TEST_CASE("bootstrap intervals repeat, and carry infinities and NaN") {
  const auto first_index = [](std::span<const std::uint32_t> chosen) {
    return static_cast<double>(chosen[0]);
  };
  const Interval a = bootstrap_interval(100, first_index);
  const Interval b = bootstrap_interval(100, first_index);
  CHECK((a.low == b.low && a.high == b.high));
  // A uniform index of 0 to 99: quantiles 2.5 and 97.5; 2000 draws know them to 4 * 100 *
  // sqrt(0.025*0.975/2000).
  CHECK(std::fabs(a.low - 2) < 1.6);
  CHECK(std::fabs(a.high - 97) < 1.6);
  const Interval open = bootstrap_interval(
      2, [](std::span<const std::uint32_t> chosen) { return chosen[0] == 0 ? 1.0 : kInfinity; });
  CHECK((open.low == 1 && open.high == kInfinity));
  CHECK(std::isnan(bootstrap_interval(2, [](auto) { return std::nan(""); }).low));
}

}  // namespace
}  // namespace mlt
