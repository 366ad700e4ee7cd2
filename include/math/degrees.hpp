// Sine, cosine and tangent of angles in degrees, in double, for scene transforms and the camera. These run
// once per statement of a scene file, so they are written for accuracy rather than for speed.
// Bit-reproducible as math/elementary.hpp is.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace mlt {

struct DSinCos {
  double sin = 0;
  double cos = 1;
};

namespace detail {

/// |degrees| modulo 360 for a finite value of at least 2^52, which is a whole number: m 2^e with the exponent
/// worked off by doubling (at most 971 times).
inline double large_degrees_modulo_360(double degrees) {
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(degrees);
  const std::uint64_t mantissa = (bits & 0x000fffffffffffffULL) | 0x0010000000000000ULL;
  const int exponent = static_cast<int>((bits >> 52) & 0x7ffU) - 1075;
  std::uint64_t rest = mantissa % 360U;
  for (int i = 0; i < exponent; ++i) rest = rest * 2U % 360U;
  return static_cast<double>(rest);
}

/// The rounding error of the product a * b, exactly [Dekker71], where nothing over- or underflows.
inline double product_error(double a, double b, double product) {
  constexpr double kSplit = 0x1p+27 + 1.0;
  const double a_scaled = a * kSplit;
  const double a_high = a_scaled - (a_scaled - a);
  const double a_low = a - a_high;
  const double b_scaled = b * kSplit;
  const double b_high = b_scaled - (b_scaled - b);
  const double b_low = b - b_high;
  return ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
}

/// Sine and cosine of r degrees for |r| <= 45, by Taylor series of the angle in radians as the sum of two
/// doubles; terms are taken until the first one dropped is below 2^-57 of the result.
inline DSinCos sincos_octant(double r) {
  constexpr double kRootHalf = 0x1.6a09e667f3bcdp-1;
  // The two must agree here for tan(45) to be 1.
  if (std::fabs(r) == 45.0) return {std::copysign(kRootHalf, r), kRootHalf};
  constexpr double kRadianHigh = 0x1.1df46a2529d39p-6;
  constexpr double kRadianLow = 0x1.5c1d8becdd291p-62;
  const double x = r * kRadianHigh;
  const double x_low = product_error(r, kRadianHigh, x) + r * kRadianLow;
  const double t = x * x;
  double sin_tail = 1.0 / 355687428096000.0;
  constexpr double kSinCoefficients[] = {
      -1.0 / 1307674368000.0, 1.0 / 6227020800.0, -1.0 / 39916800.0, 1.0 / 362880.0,
      -1.0 / 5040.0,          1.0 / 120.0,        -1.0 / 6.0};
  for (const double coefficient : kSinCoefficients) sin_tail = coefficient + t * sin_tail;
  double cos_tail = -1.0 / 6402373705728000.0;
  constexpr double kCosCoefficients[] = {
      1.0 / 20922789888000.0, -1.0 / 87178291200.0, 1.0 / 479001600.0, -1.0 / 3628800.0,
      1.0 / 40320.0,          -1.0 / 720.0,         1.0 / 24.0};
  for (const double coefficient : kCosCoefficients) cos_tail = coefficient + t * cos_tail;
  const double half = 0.5 * t;
  const double near_cos = 1.0 - half;
  // What 1 - half lost to rounding is (1 - near_cos) - half, exactly.
  const double rest = ((1.0 - near_cos) - half) + (t * t * cos_tail - x * x_low);
  return {x + (x * t * sin_tail + x_low * near_cos), near_cos + rest};
}

/// Quadrant and remainder of an angle: degrees = 90 (4 k + quadrant) + remainder, |remainder| <= 45, exactly.
struct QuarterTurns {
  unsigned quadrant = 0;
  double remainder = 0;
};

inline QuarterTurns reduce_degrees(double degrees) {
  const double magnitude = std::fabs(degrees);
  const double angle = magnitude < 0x1p+52 ? magnitude : large_degrees_modulo_360(magnitude);
  // Below 2^52 both the quotient (in an int64) and 90 times it, a multiple of 2, are exact.
  const double quotient = std::floor(angle / 90.0 + 0.5);
  const unsigned quadrant = static_cast<unsigned>(static_cast<std::int64_t>(quotient) & 3);
  const double remainder = angle - 90.0 * quotient;
  if (degrees < 0) return {(4U - quadrant) & 3U, -remainder};
  return {quadrant, remainder};
}

}  // namespace detail

/// Sine and cosine of an angle in degrees, error below 0.8 ulp for every finite argument, exact where the
/// value is 0 (always +0), 1/2 or 1. NaN for infinity and NaN.
inline DSinCos sincos_degrees(double degrees) {
  if (!std::isfinite(degrees)) {
    return {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
  }
  const detail::QuarterTurns turns = detail::reduce_degrees(degrees);
  const DSinCos r = detail::sincos_octant(turns.remainder);
  DSinCos result;
  switch (turns.quadrant) {
    case 0:
      result = {r.sin, r.cos};
      break;
    case 1:
      result = {r.cos, -r.sin};
      break;
    case 2:
      result = {-r.sin, -r.cos};
      break;
    default:
      result = {-r.cos, r.sin};
      break;
  }
  // -0 + 0 is +0; everything else stays as it is.
  return {result.sin + 0.0, result.cos + 0.0};
}

/// Tangent of an angle in degrees, error below 2.2 ulp, exact at multiples of 45; at odd multiples of 90 it
/// is infinity with the sign of the sine. NaN for infinity and NaN.
inline double tan_degrees(double degrees) {
  const DSinCos angle = sincos_degrees(degrees);
  if (angle.cos == 0.0) return std::copysign(std::numeric_limits<double>::infinity(), angle.sin);
  return angle.sin / angle.cos;
}

}  // namespace mlt
