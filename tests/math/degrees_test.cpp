// Accuracy of math/degrees.hpp. The reference computes in long double; where that is no wider than double the
// accuracy test leaves itself out, and bits_test.cpp still compares with the machines where it ran.
#include "math/degrees.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "math/rng.hpp"
#include "ulp.hpp"

using namespace mlt;

namespace {

constexpr long double kRadian = 0.017453292519943295769236907684886127L;

struct LongAngle {
  long double sin, cos;
};

LongAngle reference(double degrees) {
  const long double angle = std::fmod(static_cast<long double>(degrees), 360.0L);
  const long double quarter_turns = std::floor(angle / 90.0L + 0.5L);
  const long double x = (angle - 90.0L * quarter_turns) * kRadian;
  switch (static_cast<int>(quarter_turns) & 3) {
    case 0:
      return {std::sin(x), std::cos(x)};
    case 1:
      return {std::cos(x), -std::sin(x)};
    case 2:
      return {-std::sin(x), -std::cos(x)};
    default:
      return {-std::cos(x), std::sin(x)};
  }
}

double error(double value, long double expected) {
  if (expected == 0.0L) return value == 0.0 ? 0.0 : HUGE_VAL;
  const double spacing = test::double_spacing(static_cast<double>(expected));
  return static_cast<double>(std::fabs(static_cast<long double>(value) - expected)) / spacing;
}

}  // namespace

TEST_CASE("sincos_degrees and tan_degrees keep their error bounds") {
  if (std::numeric_limits<long double>::digits < 64) return;
  Rng rng(1, StreamPurpose::kTest, 0);
  double worst_sin = 0;
  double worst_cos = 0;
  double worst_tan = 0;
  for (int i = 0; i < 200000; ++i) {
    const double high = rng.next_fixed();
    const double fraction = (high + rng.next_fixed() * 0x1p-32) * 0x1p-32;
    // Half of the angles within one turn, half with any exponent up to 2^400.
    const double degrees = i % 2 == 0 ? 720.0 * fraction - 360.0
                                      : std::ldexp(fraction, static_cast<int>(rng.next_fixed() % 500) - 100);
    const LongAngle expected = reference(degrees);
    const DSinCos angle = sincos_degrees(degrees);
    worst_sin = std::fmax(worst_sin, error(angle.sin, expected.sin));
    worst_cos = std::fmax(worst_cos, error(angle.cos, expected.cos));
    if (expected.cos != 0.0L) {
      worst_tan = std::fmax(worst_tan, error(tan_degrees(degrees), expected.sin / expected.cos));
    }
  }
  std::printf("  sincos_degrees max %.4f and %.4f ulp, tan_degrees %.4f ulp of double\n", worst_sin,
              worst_cos, worst_tan);
  // Measured over 3 million angles: 0.786 and 2.13.
  CHECK(worst_sin <= 0.8);
  CHECK(worst_cos <= 0.8);
  CHECK(worst_tan <= 2.2);
}

TEST_CASE("sincos_degrees is exact where the value is 0, 1/2 or 1") {
  struct Row {
    double degrees, sin, cos;
  };
  const double half_root_3 = std::sqrt(3.0) / 2.0;
  const double root_half = std::sqrt(0.5);
  const Row rows[] = {{0, 0, 1},
                      {90, 1, 0},
                      {180, 0, -1},
                      {270, -1, 0},
                      {360, 0, 1},
                      {-90, -1, 0},
                      {-180, 0, -1},
                      {450, 1, 0},
                      {36000, 0, 1},
                      {3.6e17, 0, 1},
                      {-0.0, 0, 1},
                      {30, 0.5, half_root_3},
                      {60, half_root_3, 0.5},
                      {-30, -0.5, half_root_3},
                      {150, 0.5, -half_root_3},
                      {240, -half_root_3, -0.5},
                      {45, root_half, root_half},
                      {135, root_half, -root_half},
                      {-45, -root_half, root_half}};
  for (const Row& row : rows) {
    INFO(row.degrees << " degrees");
    const DSinCos angle = sincos_degrees(row.degrees);
    CHECK(angle.sin == row.sin);
    CHECK(angle.cos == row.cos);
    if (row.sin == 0.0) CHECK_FALSE(std::signbit(angle.sin));
    if (row.cos == 0.0) CHECK_FALSE(std::signbit(angle.cos));
  }
}

TEST_CASE("tan_degrees is exact at multiples of 45") {
  CHECK(tan_degrees(0) == 0.0);
  CHECK(tan_degrees(45) == 1.0);
  CHECK(tan_degrees(-45) == -1.0);
  CHECK(tan_degrees(135) == -1.0);
  CHECK(tan_degrees(225) == 1.0);
  CHECK(tan_degrees(180) == 0.0);
  CHECK(tan_degrees(90) == HUGE_VAL);
  CHECK(tan_degrees(-90) == -HUGE_VAL);
}

TEST_CASE("degrees beyond every double's fraction are reduced exactly, the rest is NaN") {
  // 2^60 = 16 modulo 360: 2^12 = 4096 = 136, 2^24 = 136^2 = 136, so 2^60 = 2^12 * 136 * 136 = 136 * 136 =
  // 136.
  CHECK(sincos_degrees(0x1p+60).sin == sincos_degrees(136).sin);
  CHECK(sincos_degrees(-0x1p+60).sin == sincos_degrees(-136).sin);
  CHECK(sincos_degrees(0x1p+60).cos == sincos_degrees(136).cos);
  const DSinCos largest = sincos_degrees(std::numeric_limits<double>::max());
  CHECK(largest.sin * largest.sin + largest.cos * largest.cos == Approx(1.0).epsilon(1e-15));
  for (const double bad : {HUGE_VAL, -HUGE_VAL, std::numeric_limits<double>::quiet_NaN()}) {
    CHECK(std::isnan(sincos_degrees(bad).sin));
    CHECK(std::isnan(sincos_degrees(bad).cos));
    CHECK(std::isnan(tan_degrees(bad)));
  }
}
