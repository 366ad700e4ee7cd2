// Exponential, logarithm, power and cube root in double, for figures about images (compare), which are
// printed with more digits than a float has. Bit-reproducible as math/elementary.hpp is; plain Taylor series,
// since nothing here runs inside a render.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace mlt {

namespace detail {

// ln 2 as a sum: the first part has 32 bits, so that its product with an exponent is exact.
inline constexpr double kLn2High = 0x1.62e42feep-1;
inline constexpr double kLn2Low = 0x1.a39ef35793c76p-33;

}  // namespace detail

inline constexpr double kLn2 = 0x1.62e42fefa39efp-1;
inline constexpr double kLn10 = 0x1.26bb1bbb55516p+1;
inline constexpr double kPiDouble = 0x1.921fb54442d18p+1;

/// Natural logarithm, error below 1.5 ulp. log(1) is 0, of zero -infinity, of infinity infinity, of a
/// negative number or NaN NaN.
inline double log_d(double x) {
  if (!(x > 0))
    return x == 0 ? -std::numeric_limits<double>::infinity() : std::numeric_limits<double>::quiet_NaN();
  if (!(x <= std::numeric_limits<double>::max())) return x;
  constexpr std::uint64_t kRootHalf = 0x3fe6a09e667f3bcdULL;
  const bool denormal = x < 0x1p-1022;
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(denormal ? x * 0x1p+54 : x) - kRootHalf;
  // x = 2^k (1 + f) with 1 + f in [sqrt(1/2), sqrt(2)), without rounding.
  const double k = static_cast<double>(static_cast<std::int64_t>(bits) >> 52) - (denormal ? 54.0 : 0.0);
  const double f = std::bit_cast<double>((bits & 0x000fffffffffffffULL) + kRootHalf) - 1.0;
  // log(1 + f) = 2 artanh(s), s = f / (2 + f); 2 s = f - s f leaves the leading term exact.
  const double s = f / (2.0 + f);
  const double z = s * s;
  constexpr double kCoefficients[] = {2.0 / 21, 2.0 / 19, 2.0 / 17, 2.0 / 15, 2.0 / 13,
                                      2.0 / 11, 2.0 / 9,  2.0 / 7,  2.0 / 5,  2.0 / 3};
  double series = 2.0 / 23;
  for (const double coefficient : kCoefficients) series = coefficient + z * series;
  const double half_square = 0.5 * f * f;
  const double tail = s * (half_square + z * series) + k * detail::kLn2Low;
  return k * detail::kLn2High - ((half_square - tail) - f);
}

/// e^x, error below 1.5 ulp (of a denormal's spacing where the result is denormal). exp(0) is 1; above 709.79
/// it is infinity, below -745.14 it is 0; NaN gives NaN.
inline double exp_d(double x) {
  double clamped = x < -746.0 ? -746.0 : x;
  clamped = clamped > 710.0 ? 710.0 : clamped;
  constexpr double kRound = 0x1.8p+52;  // leaves no bits for a fraction
  const double shifted = clamped * (1.0 / kLn2) + kRound;
  const double n = shifted - kRound;
  const double r = (clamped - n * detail::kLn2High) - n * detail::kLn2Low;
  constexpr double kCoefficients[] = {
      1.0 / 6227020800.0, 1.0 / 479001600.0, 1.0 / 39916800.0, 1.0 / 3628800.0, 1.0 / 362880.0, 1.0 / 40320.0,
      1.0 / 5040.0,       1.0 / 720.0,       1.0 / 120.0,      1.0 / 24.0,      1.0 / 6.0,      0.5};
  double series = 1.0 / 87178291200.0;
  for (const double coefficient : kCoefficients) series = coefficient + r * series;
  const double p = 1.0 + (r + r * r * series);
  // Two powers of two, each a normal number, so that only the last product can round or overflow.
  const std::uint64_t exponent = std::bit_cast<std::uint64_t>(shifted) - std::bit_cast<std::uint64_t>(kRound);
  const std::int64_t whole = static_cast<std::int64_t>(exponent);
  const std::int64_t half = whole >> 1;
  const auto power_of_two = [](std::int64_t e) {
    return std::bit_cast<double>(static_cast<std::uint64_t>(e + 1023) << 52);
  };
  return (p * power_of_two(half)) * power_of_two(whole - half);
}

/// x^y for x >= 0, relative error below (2 + |y ln x|) 2^-52. 1 for y = 0; 0^y is 0 for y > 0.
inline double pow_d(double x, double y) {
  return y == 0 ? 1.0 : exp_d(y * log_d(x));
}

/// Cube root of a normal x > 0 or 0, error below 1.5 ulp.
inline double cbrt_d(double x) {
  if (!(x > 0)) return x == 0 ? 0.0 : std::numeric_limits<double>::quiet_NaN();
  // A third of the exponent, right to 6 %; each step of Halley's method triples the digits.
  double root = std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) / 3 + 0x2a9f84fe36d22425ULL);
  for (int i = 0; i < 3; ++i) {
    const double cube = root * root * root;
    root = root - root * ((cube - x) / (cube + (cube + x)));
  }
  return root;
}

/// log(1 + x) for x > -1, relative error below 2^-50: the rounding of 1 + x is divided out [Goldberg91, th.
/// 4].
inline double log1p_d(double x) {
  const double sum = 1.0 + x;
  return sum == 1.0 ? x : log_d(sum) * (x / (sum - 1.0));
}

/// e^x - 1, relative error below 2^-48, by the same means.
inline double expm1_d(double x) {
  const double power = exp_d(x);
  if (power == 1.0) return x;
  if (power - 1.0 == -1.0 || !(power <= std::numeric_limits<double>::max())) return power - 1.0;
  return (power - 1.0) * (x / log_d(power));
}

}  // namespace mlt
