// The hypothesis tests themselves: against closed forms and published tables, and shown to accept what is
// true at the right rate and to reject what is false.
#include "support/statistics.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "math/rng.hpp"

using namespace mlt;
using namespace mlt::test;

namespace {

constexpr double kPiDouble = 3.14159265358979323846;

/// P(|T| >= t) by Simpson's rule over the density, with x = tan(a) so that the range is finite.
double student_by_quadrature(double t, double dof) {
  const double front =
      std::exp(std::lgamma(0.5 * (dof + 1)) - std::lgamma(0.5 * dof)) / std::sqrt(dof * kPiDouble);
  const auto density = [&](double a) {
    const double x = std::tan(a);
    return front * std::pow(1 + x * x / dof, -0.5 * (dof + 1)) * (1 + x * x);
  };
  const int n = 20000;
  const double low = std::atan(std::fabs(t));
  const double high = std::atan(1e9);
  const double h = (high - low) / n;
  double sum = density(low) + density(high);
  for (int i = 1; i < n; ++i) sum += (i % 2 == 1 ? 4 : 2) * density(low + i * h);
  return 2 * sum * h / 3;
}

}  // namespace

TEST_CASE("chi-square p-values match tables and closed forms") {
  // 5 % and 0.1 % points of the tables [Abramowitz64, table 26.8].
  CHECK(chi_square_p_value(3.841458820694124, 1) == Approx(0.05).epsilon(1e-12));
  CHECK(chi_square_p_value(18.307038053275146, 10) == Approx(0.05).epsilon(1e-12));
  CHECK(chi_square_p_value(124.3421134, 100) == Approx(0.05).epsilon(1e-7));
  CHECK(chi_square_p_value(10.828, 1) == Approx(0.001).epsilon(1e-3));
  CHECK(chi_square_p_value(0, 5) == 1.0);
  for (const double x : {0.1, 1.0, 2.0, 7.0, 30.0, 300.0}) {
    CHECK(chi_square_p_value(x, 2) == Approx(std::exp(-x / 2)).epsilon(1e-12).margin(0));
    CHECK(chi_square_p_value(x, 4) == Approx(std::exp(-x / 2) * (1 + x / 2)).epsilon(1e-12).margin(0));
    CHECK(chi_square_p_value(x, 1) == Approx(std::erfc(std::sqrt(x / 2))).epsilon(1e-12).margin(0));
  }
  // For many degrees of freedom by the cube-root transform [Wilson31], good to 1e-4 here.
  const double z = (std::cbrt(1.02) - (1 - 2.0 / 90000)) / std::sqrt(2.0 / 90000);
  CHECK(chi_square_p_value(10200, 10000) == Approx(0.5 * std::erfc(z / std::sqrt(2.0))).epsilon(1e-3));
}

TEST_CASE("normal and Student p-values match tables and closed forms") {
  CHECK(normal_p_value(1.959963984540054) == Approx(0.05).epsilon(1e-12));
  CHECK(normal_p_value(-2.5758293035489004) == Approx(0.01).epsilon(1e-12));
  CHECK(normal_p_value(3) == Approx(0.0026997960632601866).epsilon(1e-12));
  CHECK(normal_p_value(0) == 1.0);
  CHECK(student_p_value(12.706204736432095, 1) == Approx(0.05).epsilon(1e-10));
  CHECK(student_p_value(-2.2281388519649385, 10) == Approx(0.05).epsilon(1e-10));
  CHECK(student_p_value(2.0422724563012373, 30) == Approx(0.05).epsilon(1e-10));
  CHECK(student_p_value(0, 7) == Approx(1.0).epsilon(1e-12));
  CHECK(student_p_value(std::numeric_limits<double>::infinity(), 7) == 0.0);
  for (const double t : {0.3, 1.0, 2.5, 8.0, 1000.0}) {
    CHECK(student_p_value(t, 1) == Approx(2 / kPiDouble * std::atan(1 / t)).epsilon(1e-10).margin(0));
    // 1 - t / sqrt(t^2 + 2), without its cancellation.
    const double root = std::sqrt(t * t + 2);
    CHECK(student_p_value(t, 2) == Approx(2 / (root * (root + t))).epsilon(1e-10).margin(0));
  }
  CHECK(incomplete_beta(2, 3, 0.4) == Approx(0.5248).epsilon(1e-12));  // 6 x^2 - 8 x^3 + 3 x^4
  CHECK(incomplete_beta(2, 3, 0.9) == Approx(0.9963).epsilon(1e-12));
}

TEST_CASE("t-tests follow a worked example") {
  const Moments a = moments(std::vector<double>{1, 2, 3, 4});
  const Moments b = moments(std::vector<double>{2, 4, 6, 8, 10});
  CHECK(a.mean == 2.5);
  CHECK(a.variance == Approx(5.0 / 3).epsilon(1e-14));
  CHECK(b.standard_error() == Approx(std::sqrt(2.0)).epsilon(1e-14));
  // Variances of the means 5/12 and 2, so t = -3.5 / sqrt(29/12), dof = (29/12)^2 / ((5/12)^2 / 3 + 2^2 / 4).
  const TTestResult welch = welch_t_test(a, b);
  CHECK(welch.t == Approx(-3.5 / std::sqrt(29.0 / 12)).epsilon(1e-14));
  CHECK(welch.dof == Approx((841.0 / 144) / (25.0 / 432 + 1)).epsilon(1e-14));
  CHECK(welch.p_value == Approx(student_by_quadrature(welch.t, welch.dof)).epsilon(1e-8));
  const TTestResult one = student_t_test(a, 1.0);
  CHECK(one.dof == 3);
  CHECK(one.t == Approx(1.5 / std::sqrt(5.0 / 12)).epsilon(1e-14));
  CHECK(one.p_value == Approx(student_by_quadrature(one.t, 3)).epsilon(1e-8));

  const Moments constant = moments(std::vector<double>{3, 3, 3});
  CHECK(student_t_test(constant, 3).p_value == 1.0);
  CHECK(student_t_test(constant, 3.5).p_value == 0.0);
  CHECK(welch_t_test(constant, constant).p_value == 1.0);
  CHECK_THROWS(student_t_test(moments(std::vector<double>{1}), 1));
}

TEST_CASE("Kolmogorov-Smirnov p-values match the tables of the exact distribution") {
  // 5 % points of D for n values [Miller56]. Values at i/n + d put the largest gap, d, at every step.
  struct Row {
    int n;
    double d;
  };
  for (const Row row : {Row{5, 0.56328}, Row{10, 0.40925}, Row{20, 0.29408}, Row{50, 0.18841}}) {
    std::vector<double> values;
    for (int i = 0; i < row.n; ++i) values.push_back(std::fmin(1.0, static_cast<double>(i) / row.n + row.d));
    const KolmogorovResult result = ks_uniform_test(values);
    CHECK(result.distance == Approx(row.d).epsilon(1e-12));
    CHECK(result.p_value == Approx(0.05).epsilon(0.02));
  }
  CHECK(ks_uniform_test(std::vector<double>{0.5}).distance == 0.5);
  CHECK_THROWS(ks_uniform_test(std::vector<double>{0.5, std::nan("")}));
  CHECK_THROWS(ks_uniform_test(std::vector<double>{1.5}));
}

TEST_CASE("Sidak's threshold gives the family its significance") {
  CHECK(sidak_threshold(0.05, 1) == Approx(0.05).epsilon(1e-12));
  CHECK(sidak_threshold(0.05, 10) == Approx(0.005116196891823743).epsilon(1e-12));
  CHECK(1 - std::pow(1 - sidak_threshold(0.01, 1000), 1000) == Approx(0.01).epsilon(1e-9));
  CHECK_THROWS(sidak_threshold(0.05, 0));
}

TEST_CASE("chi_square_test pools small cells and refuses the impossible") {
  // 88 throws of a die: the sum of o^2 / e, less the number of throws.
  const std::vector<std::uint64_t> die{16, 18, 16, 14, 12, 12};
  const std::vector<double> fair(6, 88.0 / 6);
  const ChiSquareResult plain = chi_square_test(die, fair);
  CHECK(plain.dof == 5);
  CHECK(plain.statistic == Approx((2 * 256 + 324 + 196 + 2 * 144) * 6 / 88.0 - 88).epsilon(1e-12));
  CHECK(plain.pooled_cells == 0);

  // Expectations 1, 2, 3 make one pool of 6, 40 stays alone.
  const ChiSquareResult pooled =
      chi_square_test(std::vector<std::uint64_t>{40, 3, 0, 3}, std::vector<double>{40, 1, 2, 3});
  CHECK(pooled.pooled_cells == 3);
  CHECK(pooled.dof == 1);
  CHECK(pooled.statistic == 0.0);
  // Expectation 0: fine when nothing was seen, otherwise impossible.
  CHECK(chi_square_test(std::vector<std::uint64_t>{10, 10, 0}, std::vector<double>{10, 10, 0}).p_value ==
        1.0);
  CHECK(chi_square_test(std::vector<std::uint64_t>{10, 10, 1}, std::vector<double>{10, 10, 0}).p_value ==
        0.0);
  CHECK_THROWS(chi_square_test(std::vector<std::uint64_t>{1}, std::vector<double>{1, 2}));
  CHECK_THROWS(chi_square_test(std::vector<std::uint64_t>{1}, std::vector<double>{std::nan("")}));
}

TEST_CASE("grids assign every point of the closed rectangle to one cell") {
  const Grid2D grid{-1, 1, 4, 0, 3, 3};
  CHECK(grid.cell_of(-1, 0) == 0U);
  CHECK(grid.cell_of(1, 3) == 11U);
  CHECK(grid.cell_of(0, 1) == 6U);
  CHECK_FALSE(grid.cell_of(1.001, 1));
  CHECK_FALSE(grid.cell_of(0, -1e-9));
  CHECK_FALSE(grid.cell_of(std::nan(""), 1));
}

TEST_CASE("quadrature meets closed forms, smooth, peaked and discontinuous") {
  CHECK(integrate([](double u, double v) { return std::exp(u) * std::cos(v); }, 0, 1, 0, 2) ==
        Approx((std::exp(1.0) - 1) * std::sin(2.0)).epsilon(1e-10));
  // A peak of width 0.01; erf closed form.
  const double width = 0.01;
  const double half = std::sqrt(kPiDouble) * width * 0.5 * (std::erf(0.3 / width) + std::erf(0.7 / width));
  CHECK(integrate([&](double u, double) { return std::exp(-(u - 0.3) * (u - 0.3) / (width * width)); }, 0, 1,
                  0, 1) == Approx(half).epsilon(1e-6));
  CHECK(integrate([](double u, double v) { return u + v < 1.0 ? 2.0 : 0.0; }, 0, 1, 0, 1) ==
        Approx(1.0).epsilon(1e-3));
  double sum = 0;
  for (const double cell : integrate_cells(direction_grid(8, 8), [](double, double) { return 1.0; }))
    sum += cell;
  CHECK(sum == Approx(4 * kPiDouble).epsilon(1e-12));
}

TEST_CASE("chi_square_2d accepts a true density at the stated rate and rejects a false one") {
  std::vector<double> p_values;
  std::vector<double> p_values_of_false;
  for (std::uint64_t repeat = 0; repeat < 100; ++repeat) {
    Rng rng(repeat, StreamPurpose::kTest, 1);
    // u has density 2u; a fifth of the draws is dropped.
    const auto draw = [&]() -> std::optional<Point2> {
      const Point2 point{std::sqrt(static_cast<double>(rng.next_float())), rng.next_float()};
      return rng.next_float() < 0.2f ? std::nullopt : std::optional<Point2>(point);
    };
    p_values.push_back(
        chi_square_2d(unit_grid(6, 6), 4000, draw, [](double u, double) { return 1.6 * u; }).p_value);
    p_values_of_false.push_back(
        chi_square_2d(unit_grid(6, 6), 4000, draw, [](double u, double) { return 1.5 * u + 0.05; }).p_value);
  }
  CHECK(ks_uniform_test(p_values).p_value > 0.01);
  CHECK(ks_uniform_test(p_values_of_false).p_value < 1e-6);
  // A density whose integral exceeds 1 fails whatever was drawn.
  Rng rng(0, StreamPurpose::kTest, 2);
  const auto uniform = [&]() -> std::optional<Point2> { return Point2{rng.next_float(), rng.next_float()}; };
  CHECK(chi_square_2d(unit_grid(4, 4), 1000, uniform, [](double, double) { return 1.01; }).p_value == 0.0);
}

TEST_CASE("t-tests of true and of false means") {
  std::vector<double> p_values;
  int rejected = 0;
  for (std::uint64_t repeat = 0; repeat < 200; ++repeat) {
    Rng rng(repeat, StreamPurpose::kTest, 3);
    std::vector<double> a(20);
    std::vector<double> b(40);
    for (double& x : a) x = rng.next_float();
    for (double& x : b) x = 0.5 + 3.0 * (rng.next_float() - 0.5);
    p_values.push_back(welch_t_test(moments(a), moments(b)).p_value);
    for (double& x : b) x += 1.0;
    if (welch_t_test(moments(a), moments(b)).p_value < 0.01) ++rejected;
  }
  CHECK(ks_uniform_test(p_values).p_value > 0.01);
  CHECK(rejected > 195);
}
