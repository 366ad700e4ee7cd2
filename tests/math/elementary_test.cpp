// Accuracy and edges of math/elementary.hpp and math/srgb.hpp. References are the C library's double
// functions, whose own error (under 1 ulp of double, 2^-29 ulp of float) does not show. Bounds are those that
// the headers state; docs/MATH.md lists what was measured, and over how many arguments.
#include "math/elementary.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <limits>

#include "math/srgb.hpp"
#include "ulp.hpp"

using namespace mlt;
using mlt::test::worst_error;
using mlt::test::WorstError;

namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();
constexpr float kMax = std::numeric_limits<float>::max();
constexpr float kDenormal = std::numeric_limits<float>::denorm_min();
constexpr double kTwoPiDouble = 6.283185307179586476925;

// A prime, so that all low bits of the pattern occur; 2^32 / 1021 is 4 million arguments for each sign.
constexpr std::uint32_t kStride = 1021;

struct Angle {
  double sin, cos;
};

/// Reference for sincos_2pi(): the argument is reduced exactly before libm sees it.
Angle reference_2pi(float u) {
  const double quarter_turns = std::floor(4.0 * u + 0.5);
  const double x = kTwoPiDouble * (u - 0.25 * quarter_turns);
  switch (static_cast<long>(quarter_turns) & 3) {
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

float sin_part(float u) {
  float s, c;
  sincos_2pi(u, s, c);
  return s;
}

float cos_part(float u) {
  float s, c;
  sincos_2pi(u, s, c);
  return c;
}

void require_within(const char* name, const WorstError& worst, double limit) {
  std::printf("  %-28s max %.4f ulp at %a\n", name, worst.ulp, static_cast<double>(worst.argument));
  std::fflush(stdout);  // the exhaustive sweeps take minutes each
  INFO(name << " at " << worst.argument);
  CHECK(worst.ulp <= limit);
}

// Ranges end where a function has become constant or undefined; what lies beyond is for the tests of edges.
void check_accuracy(std::uint32_t stride) {
  require_within(
      "sin of sincos_2pi",
      worst_error(0.0f, 0x1.fffffep-1f, stride, sin_part, [](float u) { return reference_2pi(u).sin; }),
      1.18);
  require_within(
      "cos of sincos_2pi",
      worst_error(0.0f, 0x1.fffffep-1f, stride, cos_part, [](float u) { return reference_2pi(u).cos; }),
      1.18);
  require_within(
      "exp_f",
      worst_error(-110.0f, 90.0f, stride, exp_f, [](float x) { return std::exp(static_cast<double>(x)); }),
      1.01);
  require_within(
      "exp2_f",
      worst_error(-160.0f, 130.0f, stride, exp2_f, [](float x) { return std::exp2(static_cast<double>(x)); }),
      0.9);
  require_within(
      "log_f",
      worst_error(0.0f, kMax, stride, log_f, [](float x) { return std::log(static_cast<double>(x)); }), 0.94);
  require_within(
      "log2_f",
      worst_error(0.0f, kMax, stride, log2_f, [](float x) { return std::log2(static_cast<double>(x)); }),
      0.501);
  require_within(
      "acos_f",
      worst_error(-1.0f, 1.0f, stride, acos_f, [](float x) { return std::acos(static_cast<double>(x)); }),
      1.2);
  require_within("srgb_encode",
                 worst_error(0.0f, 1.0f, stride, srgb_encode,
                             [](float x) {
                               const double linear = x;
                               return x <= 0.0031308f ? 12.92 * linear
                                                      : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
                             }),
                 0.51);
}

void check_accuracy_of_two_arguments(std::uint32_t stride) {
  for (const float y : {1.0f / 2.4f, 0.5f, 2.2f, -0.5f, 5.0f, 100.0f, -37.3f, 1e-6f, 1e6f}) {
    char name[32];
    std::snprintf(name, sizeof name, "pow_f(x, %g)", static_cast<double>(y));
    require_within(name,
                   worst_error(
                       0.0f, kMax, stride, [y](float x) { return pow_f(x, y); },
                       [y](float x) { return std::pow(static_cast<double>(x), static_cast<double>(y)); }),
                   0.51);
  }
  for (const float x : {1.0f, -1.0f, 0.3f, -1e-20f, 1e30f, kDenormal}) {
    char name[32];
    std::snprintf(name, sizeof name, "atan2_f(y, %g)", static_cast<double>(x));
    require_within(name,
                   worst_error(
                       -kMax, kMax, stride, [x](float y) { return atan2_f(y, x); },
                       [x](float y) { return std::atan2(static_cast<double>(y), static_cast<double>(x)); }),
                   0.501);
  }
}

}  // namespace

TEST_CASE("elementary functions keep their error bounds on a dense subset of all floats") {
  check_accuracy(kStride);
  check_accuracy_of_two_arguments(16 * kStride + 1);
}

TEST_CASE("elementary functions keep their error bounds on all floats", "[.slow]") {
  check_accuracy(1);
  check_accuracy_of_two_arguments(17);
}

TEST_CASE("sincos_2pi is exact at quarters and right beyond one turn") {
  const float expected[4][2] = {{0, 1}, {1, 0}, {0, -1}, {-1, 0}};
  for (int turns = -3; turns <= 3; ++turns) {
    for (int q = 0; q < 4; ++q) {
      const float u = static_cast<float>(turns) + 0.25f * static_cast<float>(q);
      CHECK(sin_part(u) == expected[q][0]);
      CHECK(cos_part(u) == expected[q][1]);
    }
  }
  CHECK(std::isnan(sin_part(kNotANumber)));
  CHECK(std::isnan(cos_part(kNotANumber)));
  for (float u = -0x1p+20f; u <= 0x1p+20f; u += 1237.3177f) {
    CHECK(test::ulp_error(sin_part(u), reference_2pi(u).sin) <= 1.18);
    CHECK(test::ulp_error(cos_part(u), reference_2pi(u).cos) <= 1.18);
  }
}

TEST_CASE("sincos_2pi gives a point of the unit circle") {
  // Each part is off by at most 1.18 ulp, an absolute 1.18 * 2^-24, so s^2 + c^2 is off by at most
  // 2 * (|s| + |c|) * 1.18 * 2^-24 < 2e-7.
  for (std::uint32_t i = 0; i < (1U << 24); i += 97) {
    float s, c;
    sincos_2pi(static_cast<float>(i) * 0x1p-24f, s, c);
    const double square = static_cast<double>(s) * s + static_cast<double>(c) * c;
    if (std::fabs(square - 1.0) > 2.1e-7) FAIL("at " << i << ": " << square);
  }
}

TEST_CASE("exp_f and exp2_f at their edges") {
  CHECK(exp_f(0.0f) == 1.0f);
  CHECK(exp_f(-0.0f) == 1.0f);
  CHECK(exp_f(kInf) == kInf);
  CHECK(exp_f(-kInf) == 0.0f);
  CHECK(exp_f(kMax) == kInf);
  CHECK(exp_f(-kMax) == 0.0f);
  CHECK(std::isfinite(exp_f(88.7228f)));
  CHECK(exp_f(88.7229f) == kInf);
  CHECK(exp_f(-103.97f) == kDenormal);
  CHECK(exp_f(-103.98f) == 0.0f);
  CHECK(exp_f(kDenormal) == 1.0f);
  CHECK(std::isnan(exp_f(kNotANumber)));

  for (int n = -149; n < 128; ++n) CHECK(exp2_f(static_cast<float>(n)) == std::ldexp(1.0f, n));
  CHECK(exp2_f(128.0f) == kInf);
  CHECK(exp2_f(-150.0f) == 0.0f);
  CHECK(exp2_f(std::nextafter(-150.0f, 0.0f)) == kDenormal);
  CHECK(exp2_f(kInf) == kInf);
  CHECK(exp2_f(-kInf) == 0.0f);
  CHECK(std::isnan(exp2_f(kNotANumber)));
}

TEST_CASE("pitfall 2: log_f of 0, of denormals and of the largest primary sample is defined") {
  CHECK(log_f(1.0f) == 0.0f);
  CHECK(log_f(0.0f) == -kInf);
  CHECK(log_f(-0.0f) == -kInf);
  CHECK(log_f(kInf) == kInf);
  CHECK(std::isnan(log_f(-kDenormal)));
  CHECK(std::isnan(log_f(-1.0f)));
  CHECK(std::isnan(log_f(-kInf)));
  CHECK(std::isnan(log_f(kNotANumber)));
  CHECK(log_f(kDenormal) == Approx(-149.0 * std::log(2.0)).epsilon(1e-7));
  CHECK(log_f(0x1.fffffep-1f) == -0x1p-24f);

  for (int n = -149; n < 128; ++n) CHECK(log2_f(std::ldexp(1.0f, n)) == static_cast<float>(n));
  CHECK(log2_f(0.0f) == -kInf);
  CHECK(log2_f(kInf) == kInf);
  CHECK(std::isnan(log2_f(-1.0f)));
  CHECK(std::isnan(log2_f(kNotANumber)));
}

TEST_CASE("pow_f at its edges") {
  for (const float y : {0.0f, -0.0f}) {
    for (const float x : {0.0f, 1.0f, 3.0f, kInf, kNotANumber}) CHECK(pow_f(x, y) == 1.0f);
  }
  for (const float y : {2.5f, -7.0f, kInf, -kInf, kNotANumber}) CHECK(pow_f(1.0f, y) == 1.0f);
  CHECK(pow_f(0.0f, 2.0f) == 0.0f);
  CHECK(pow_f(-0.0f, 3.0f) == 0.0f);
  CHECK(pow_f(0.0f, -2.0f) == kInf);
  CHECK(pow_f(kInf, 0.5f) == kInf);
  CHECK(pow_f(kInf, -0.5f) == 0.0f);
  CHECK(pow_f(2.0f, kInf) == kInf);
  CHECK(pow_f(0.5f, kInf) == 0.0f);
  CHECK(pow_f(0.5f, -kInf) == kInf);
  CHECK(pow_f(2.0f, 10.0f) == 1024.0f);
  CHECK(pow_f(10.0f, 39.0f) == kInf);
  CHECK(pow_f(10.0f, -46.0f) == 0.0f);
  CHECK(pow_f(2.0f, -149.0f) == kDenormal);
  CHECK(std::isnan(pow_f(-2.0f, 2.0f)));
  CHECK(std::isnan(pow_f(kNotANumber, 2.0f)));
  CHECK(std::isnan(pow_f(2.0f, kNotANumber)));
}

TEST_CASE("acos_f at its edges") {
  CHECK(acos_f(1.0f) == 0.0f);
  CHECK(acos_f(-1.0f) == 0x1.921fb6p+1f);
  CHECK(acos_f(0.0f) == 0x1.921fb6p+0f);
  CHECK(acos_f(kDenormal) == 0x1.921fb6p+0f);
  CHECK(acos_f(0x1.fffffep-1f) == Approx(std::sqrt(0x1p-23)).epsilon(1e-6));
  for (const float x : {std::nextafter(1.0f, 2.0f), std::nextafter(-1.0f, -2.0f), kInf, -kInf, kNotANumber}) {
    CHECK(std::isnan(acos_f(x)));
  }
}

TEST_CASE("atan2_f has C's conventions at zeros and infinities") {
  for (const float y : {0.0f, -0.0f, kDenormal, -1.0f, 1.0f, kMax, kInf, -kInf}) {
    for (const float x : {0.0f, -0.0f, kDenormal, -kDenormal, 1.0f, -1.0f, kMax, kInf, -kInf}) {
      const float reference = static_cast<float>(std::atan2(static_cast<double>(y), static_cast<double>(x)));
      INFO("atan2_f(" << y << ", " << x << ")");
      CHECK(atan2_f(y, x) == reference);
      CHECK(std::signbit(atan2_f(y, x)) == std::signbit(reference));
    }
  }
  CHECK(std::isnan(atan2_f(kNotANumber, 1.0f)));
  CHECK(std::isnan(atan2_f(1.0f, kNotANumber)));
}

TEST_CASE("srgb_encode meets published values, is monotone off the standard's joint, and clamps") {
  CHECK(srgb_encode(0.0f) == 0.0f);
  CHECK(srgb_encode(1.0f) == 1.0f);
  CHECK(srgb_encode(-0.5f) == 0.0f);
  CHECK(srgb_encode(7.0f) == 1.0f);
  CHECK(srgb_encode(kInf) == 1.0f);
  CHECK(srgb_encode(kNotANumber) == 0.0f);
  // Linear 0.214041 is the middle code value 0.5.
  CHECK(srgb_encode(0.21404114f) == Approx(0.5).epsilon(1e-6));
  CHECK(srgb_encode(0.5f) == Approx(0.735356983).epsilon(1e-7));
  float previous = 0.0f;
  for (std::uint32_t bits = 0; bits <= 0x3f800000U; bits += 509) {
    const float linear = std::bit_cast<float>(bits);
    const float encoded = srgb_encode(linear);
    const bool at_joint = linear > 0.0031307f && linear < 0.0031309f;
    if (encoded < previous && !at_joint) FAIL("at " << linear);
    previous = encoded;
  }
}
