// The project's own elementary functions. libm's differ between versions and between processors with and
// without fused multiply-add; these consist of single IEEE operations in a fixed order, so they give the same
// bits everywhere, provided the compiler does not contract (-ffp-contract=off). Rare cases are selects, not
// branches, and there are no tables, so that a SIMD lane can run the same operations. Coefficients are
// minimax fits of this project, each rounded in turn with the rest fitted again. docs/MATH.md lists errors
// and speed, tests/math holds them. Angles in degrees, in double, are in math/degrees.hpp. All functions take
// every argument, the worst of which gives NaN; the sign and the payload of a NaN are not specified, being
// the one thing on which processors differ.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "math/degrees.hpp"
#include "math/wide.hpp"

namespace mlt {

namespace detail {

inline constexpr float kInfinity = std::numeric_limits<float>::infinity();
inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Adding 1.5 * 2^23 to a float below 2^22 in magnitude leaves no bits for a fraction: the sum is the nearest
// integer (ties to even), which stands in its low bits too. This needs no cast and so no range check.
inline constexpr float kRoundToInteger = 0x1.8p+23f;

/// `a` where `mask` has ones, `b` where it has zeros.
template <class F>
MLT_INLINE F blend(UintOf<F> mask, F a, F b) {
  return as_floats((as_bits(a) & mask) | (as_bits(b) & ~mask));
}

/// The integer that stands in the low bits of x + kRoundToInteger; |x| < 2^22.
inline std::int32_t rounded_integer(float shifted) {
  return static_cast<std::int32_t>(std::bit_cast<std::uint32_t>(shifted) -
                                   std::bit_cast<std::uint32_t>(kRoundToInteger));
}

/// 2^n for n in [-126, 127]; any other n gives some float, not a trap.
inline float power_of_two(std::int32_t n) {
  return std::bit_cast<float>((static_cast<std::uint32_t>(n) + 127U) << 23);
}

/// p * 2^n for n in [-151, 129] by two exact powers, so that only the last product can round or overflow.
inline float scale(float p, std::int32_t n) {
  const std::int32_t half = n >> 1;
  return (p * power_of_two(half)) * power_of_two(n - half);
}

}  // namespace detail

/// sin(2 pi u) and cos(2 pi u) for u in [0,1), error at most 1.18 ulp. Exact at multiples of 1/4, where a
/// zero may have either sign. Correct, too, for negative u and for |u| up to 2^20; beyond that, and for
/// infinity, the results mean nothing. NaN gives NaN.
template <class F>
inline void sincos_2pi(F u, F& s, F& c) {
  // u = q/4 + r with |r| <= 1/8, without rounding.
  const F shifted = 4.0f * u + detail::kRoundToInteger;
  const UintOf<F> quadrant = as_bits(shifted);
  const F r = u - 0.25f * (shifted - detail::kRoundToInteger);
  const F t = r * r;
  // sin(2 pi r) = 8 r - r (8 - 2 pi - r^2 S(r^2)): 8 r is exact, and what is taken from it is small. The
  // constant is the sum of two floats.
  const F sin_tail = (0x1.4abbbep+5f + t * (-0x1.465facp+6f + t * 0x1.2db5d6p+6f)) * t + 0x1.dde974p-25f;
  const F sin_r = 8.0f * r - r * (0x1.b7812ap+0f + sin_tail);
  // cos(2 pi r) = 1 - (16 r^2 + r^2 C(r^2)), for the same reason.
  const F cos_tail = (0x1.de9e64p+1f + t * -0x1.03c1dep+6f) + (t * t) * (0x1.55c5bp+6f + t * -0x1.d9b69ep+5f);
  const F cos_r = 1.0f - (16.0f * t + t * cos_tail);
  const UintOf<F> odd = 0U - (quadrant & 1U);
  const UintOf<F> sin_sign = (quadrant & 2U) << 30;
  const UintOf<F> cos_sign = ((quadrant + 1U) & 2U) << 30;
  s = as_floats(as_bits(detail::blend(odd, cos_r, sin_r)) ^ sin_sign);
  c = as_floats(as_bits(detail::blend(odd, sin_r, cos_r)) ^ cos_sign);
}

/// e^x, error at most 1.01 ulp (of a denormal's spacing where the result is denormal). exp_f(0) is 1, above
/// 88.7228 it is infinity, below -103.98 it is 0; NaN gives NaN.
inline float exp_f(float x) {
  float clamped = x < -104.0f ? -104.0f : x;
  clamped = clamped > 89.0f ? 89.0f : clamped;
  // x = n ln 2 + r; the high part of ln 2 has 15 bits, so its product with n is exact.
  const float shifted = clamped * 0x1.715476p+0f + detail::kRoundToInteger;
  const float n = shifted - detail::kRoundToInteger;
  const float r = (clamped - n * 0x1.62e4p-1f) - n * 0x1.7f7d1cp-20f;
  const float r2 = r * r;
  const float tail = (0x1.fffffcp-2f + r * 0x1.55549p-3f) +
                     r2 * ((0x1.55589ep-5f + r * 0x1.123ac6p-7f) + r2 * 0x1.6a623p-10f);
  return detail::scale(1.0f + (r + r2 * tail), detail::rounded_integer(shifted));
}

/// 2^x, error at most 0.9 ulp (of a denormal's spacing where the result is denormal), exact for whole x. From
/// 128 on it is infinity, below -150 it is 0; NaN gives NaN.
inline float exp2_f(float x) {
  float clamped = x < -151.0f ? -151.0f : x;
  clamped = clamped > 129.0f ? 129.0f : clamped;
  const float shifted = clamped + detail::kRoundToInteger;
  // 2^r = 1 + r/2 + r E(r), where r/2 is exact.
  const float r = clamped - (shifted - detail::kRoundToInteger);
  const float r2 = r * r;
  const float tail =
      (0x1.8b90cp-3f + r * 0x1.ebfbdcp-3f) +
      r2 * ((0x1.c6af7ap-5f + r * 0x1.3b2dd4p-7f) + r2 * (0x1.5f0952p-10f + r * 0x1.41787p-13f));
  return detail::scale(1.0f + (0.5f * r + r * tail), detail::rounded_integer(shifted));
}

/// Natural logarithm, error at most 0.94 ulp. Denormals are taken at their value. log_f(1) is 0, of either
/// zero -infinity, of infinity infinity, of a negative number or NaN NaN.
inline float log_f(float x) {
  constexpr std::uint32_t kRootHalf = 0x3f3504f3U;
  const bool tiny = x < 0x1p-126f;
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(tiny ? x * 0x1p+25f : x) - kRootHalf;
  // x = 2^k m with m in [sqrt(1/2), sqrt(2)) and m = 1 + f, without rounding.
  const float k = static_cast<float>((static_cast<std::int32_t>(bits) >> 23) - (tiny ? 25 : 0));
  const float f = std::bit_cast<float>((bits & 0x007fffffU) + kRootHalf) - 1.0f;
  // log(1 + f) = f - f^2/2 + f^3 L(f).
  const float f2 = f * f;
  const float low = (0x1.555554p-2f + f * -0x1.000228p-2f) + f2 * (0x1.99a022p-3f + f * -0x1.547218p-3f);
  const float high = (0x1.22d88cp-3f + f * -0x1.0d8598p-3f) + f2 * (0x1.056336p-3f + f * -0x1.38c268p-4f);
  const float tail = low + (f2 * f2) * high;
  const float small = (f * f2) * tail + (k * 0x1.7f7d1cp-20f - 0.5f * f2);
  float result = k * 0x1.62e4p-1f + (f + small);
  result = x < detail::kInfinity ? result : x;
  result = x == 0.0f ? -detail::kInfinity : result;
  return x < 0.0f ? detail::kNan : result;
}

namespace detail {

// Kernels in double for what needs more than float on the way. Relative errors: log2 2^-45, exp2 2^-34, far
// below the 2^-25 that one rounding to float costs.

/// log2(x) of a float x > 0; other arguments as log_f.
inline double log2_kernel(float x) {
  constexpr std::uint64_t kRootHalf = 0x3fe6a09e667f3bcdULL;
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(static_cast<double>(x)) - kRootHalf;
  const double k = static_cast<double>(static_cast<std::int32_t>(static_cast<std::int64_t>(bits) >> 52));
  const double m = std::bit_cast<double>((bits & 0x000fffffffffffffULL) + kRootHalf);
  // log2(m) = (2 / ln 2) artanh(s) with s = (m - 1) / (m + 1).
  const double s = (m - 1.0) / (m + 1.0);
  const double t = s * s;
  const double t2 = t * t;
  const double series = (0x1.71547652b8251p+1 + t * 0x1.ec709dc53c7c8p-1) +
                        t2 * ((0x1.2776c29323b7p-1 + t * 0x1.a61a2ee0bc0e9p-2) +
                              t2 * (0x1.47955245d0541p-2 + t * 0x1.21b12617f3d06p-2));
  double result = k + s * series;
  result = x < kInfinity ? result : static_cast<double>(x);
  result = x == 0.0f ? -std::numeric_limits<double>::infinity() : result;
  return x < 0.0f ? std::numeric_limits<double>::quiet_NaN() : result;
}

/// 2^x for x in [-1000, 1000]; NaN for NaN.
inline double exp2_kernel(double x) {
  constexpr double kRound = 0x1.8p+52;  // as kRoundToInteger
  const double shifted = x + kRound;
  const double r = x - (shifted - kRound);
  const double r2 = r * r;
  const double r4 = r2 * r2;
  const double p = ((0x1.ffffffffabbeap-1 + r * 0x1.62e42ff116746p-1) +
                    r2 * (0x1.ebfbe0a4bc79bp-3 + r * 0x1.c6b08aae94635p-5)) +
                   r4 * ((0x1.3b29dc42eee6ep-7 + r * 0x1.5d8a71394acb2p-10) +
                         r2 * (0x1.446a1e245db9fp-13 + r * 0x1.fe16a3324f8d6p-17));
  return p * std::bit_cast<double>((std::bit_cast<std::uint64_t>(shifted) + 1023U) << 52);
}

}  // namespace detail

/// Binary logarithm, error at most 0.51 ulp, exact for powers of two; edges as log_f.
inline float log2_f(float x) {
  return static_cast<float>(detail::log2_kernel(x));
}

/// x^y for x >= 0, error at most 0.51 ulp (of a denormal's spacing where the result is denormal). As in C, it
/// is 1 for y = 0 and for x = 1 even when the other is NaN; 0^y is 0 for y > 0 and infinity for y < 0.
/// Unlike C's, a negative x gives NaN for whole y also (and -0 is 0).
inline float pow_f(float x, float y) {
  double exponent = static_cast<double>(y) * detail::log2_kernel(x);
  // Far enough that float still rounds to 0 or infinity; a NaN stays.
  exponent = exponent < -200.0 ? -200.0 : exponent;
  exponent = exponent > 200.0 ? 200.0 : exponent;
  const float result = static_cast<float>(detail::exp2_kernel(exponent));
  return (y == 0.0f || x == 1.0f) ? 1.0f : result;
}

/// Arc cosine in [0, pi], error at most 1.2 ulp; acos_f(1) is 0. Outside [-1,1] and for NaN it is NaN.
inline float acos_f(float x) {
  constexpr float kHalfPiHigh = 0x1.921fb6p+0f;
  constexpr float kHalfPiLow = -0x1.777a5cp-25f;
  const float magnitude = std::fabs(x);
  const bool inner = magnitude <= 0.5f;
  // asin(s) = s + s^3 A(s^2) for |s| <= 1/2; further out acos(x) = 2 asin(sqrt((1 - x) / 2)).
  const float z = inner ? x * x : 0.5f * (1.0f - magnitude);
  const float s = inner ? x : std::sqrt(z);
  const float series = (0x1.5555c8p-3f + z * 0x1.330202p-4f) +
                       (z * z) * ((0x1.747c0cp-5f + z * 0x1.8c3a12p-6f) + (z * z) * 0x1.5960aep-5f);
  const float tail = (s * z) * series;
  const float from_half_pi = kHalfPiHigh - (s + (tail - kHalfPiLow));
  const float outer = x > 0.0f ? 2.0f * (s + tail) : 2.0f * from_half_pi;
  return inner ? from_half_pi : outer;
}

/// Angle of the point (x, y) in [-pi, pi], error at most 0.51 ulp, with the conventions of C: the result has
/// y's sign (zeros included), (0, +0) is 0, (0, -0) pi, and infinities count as equal and beyond everything.
inline float atan2_f(float y, float x) {
  constexpr double kBeyondFloat = 0x1p+400;  // stands for infinity, so that a quotient of two is 1
  double ax = static_cast<double>(std::fabs(x));
  double ay = static_cast<double>(std::fabs(y));
  ax = ax > kBeyondFloat ? kBeyondFloat : ax;
  ay = ay > kBeyondFloat ? kBeyondFloat : ay;
  const bool steep = ay > ax;
  const double small = steep ? ax : ay;
  const double large = steep ? ay : ax;
  // atan(q) = pi/4 + atan((q - 1) / (q + 1)) brings the argument below tan(pi/8).
  const bool upper = small > 0x1.a8279ap-2 * large;
  const double numerator = upper ? small - large : small;
  const double denominator = upper ? small + large : large;
  const double z = numerator / (denominator == 0.0 ? 1.0 : denominator);
  const double t = z * z;
  const double t2 = t * t;
  const double series =
      ((0x1.ffffffffd279fp-1 + t * -0x1.5555548777a1cp-2) +
       t2 * (0x1.9999011a80bbap-3 + t * -0x1.247cfbbf30397p-3)) +
      (t2 * t2) * ((0x1.c43f3e999d6dfp-4 + t * -0x1.5a836bfe3247p-4) + t2 * 0x1.8232bf6ce348bp-5);
  double angle = z * series + (upper ? 0x1.921fb54442d18p-1 : 0.0);
  angle = steep ? 0x1.921fb54442d18p+0 - angle : angle;
  angle = std::signbit(x) ? 0x1.921fb54442d18p+1 - angle : angle;
  return std::copysign(static_cast<float>(angle), y);
}

}  // namespace mlt
