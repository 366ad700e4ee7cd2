// Against long double functions of the C library, whose error is below 2^-10 of a double's spacing.
#include "math/elementary_double.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "math/rng.hpp"

namespace mlt {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

double uniform(Rng& rng, double low, double high) {
  const double fine = static_cast<double>(rng.next_float()) + 0x1p-24 * static_cast<double>(rng.next_float());
  return low + (high - low) * fine / (1.0 + 0x1p-24);
}

/// Error in spacings of doubles at `exact`.
double ulps(double value, long double exact) {
  const double rounded = std::fabs(static_cast<double>(exact));
  const double spacing = std::fmax(std::nextafter(rounded, kInf) - rounded, 0x1p-1074);
  return static_cast<double>(std::fabs(static_cast<long double>(value) - exact)) / spacing;
}

TEST_CASE("double logarithm and exponential are right to 1.5 ulp") {
  Rng rng(1, StreamPurpose::kTest, 0);
  double worst_log = 0;
  double worst_exp = 0;
  double worst_cbrt = 0;
  for (int i = 0; i < 200000; ++i) {
    const double x = std::exp2(uniform(rng, -1074, 1023.9));
    const double near = uniform(rng, 0.5, 2);
    worst_log = std::fmax(worst_log, ulps(log_d(x), std::log(static_cast<long double>(x))));
    worst_log = std::fmax(worst_log, ulps(log_d(near), std::log(static_cast<long double>(near))));
    const double e = uniform(rng, -745, 709.7);
    worst_exp = std::fmax(worst_exp, ulps(exp_d(e), std::exp(static_cast<long double>(e))));
    worst_exp = std::fmax(worst_exp, ulps(exp_d(near - 1), std::exp(static_cast<long double>(near - 1))));
    const double c = std::exp2(uniform(rng, -1000, 1000));
    worst_cbrt = std::fmax(worst_cbrt, ulps(cbrt_d(c), std::cbrt(static_cast<long double>(c))));
  }
  CAPTURE(worst_log, worst_exp, worst_cbrt);
  CHECK(worst_log < 1.5);
  CHECK(worst_exp < 1.5);
  CHECK(worst_cbrt < 1.5);
}

TEST_CASE("double pow, log1p and expm1 keep their stated errors") {
  Rng rng(2, StreamPurpose::kTest, 0);
  for (int i = 0; i < 50000; ++i) {
    const double x = std::exp2(uniform(rng, -40, 20));
    const double y = uniform(rng, -3, 3);
    const long double exact = std::pow(static_cast<long double>(x), static_cast<long double>(y));
    const double bound = (2 + std::fabs(y * std::log(x))) * 0x1p-52;
    REQUIRE(std::fabs(static_cast<double>(pow_d(x, y) / exact - 1)) < bound);
    const double small = std::copysign(std::exp2(uniform(rng, -60, -0.1)), y);
    REQUIRE(std::fabs(static_cast<double>(log1p_d(small) / std::log1p(static_cast<long double>(small)) - 1)) <
            0x1p-50);
    REQUIRE(std::fabs(static_cast<double>(expm1_d(small) / std::expm1(static_cast<long double>(small)) - 1)) <
            0x1p-48);
  }
}

TEST_CASE("double functions at the ends of their ranges") {
  CHECK(log_d(1) == 0);
  CHECK(log_d(0) == -kInf);
  CHECK(log_d(kInf) == kInf);
  CHECK(std::isnan(log_d(-1)));
  CHECK(std::isnan(log_d(std::nan(""))));
  CHECK(exp_d(0) == 1);
  CHECK(exp_d(800) == kInf);
  CHECK(exp_d(kInf) == kInf);
  CHECK(exp_d(-800) == 0);
  CHECK(exp_d(-kInf) == 0);
  CHECK(std::isnan(exp_d(std::nan(""))));
  CHECK(pow_d(0, 0.7) == 0);
  CHECK(pow_d(0, 0) == 1);
  CHECK(cbrt_d(0) == 0);
  CHECK(cbrt_d(27) == 3);
  CHECK(expm1_d(0) == 0);
  CHECK(expm1_d(-800) == -1);
  CHECK(expm1_d(800) == kInf);
  CHECK(log1p_d(0) == 0);
}

}  // namespace
}  // namespace mlt
