// Errors in units in the last place, for the accuracy tests of math/.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace mlt::test {

/// Spacing of floats in the binade of `reference`; 2^-149 for denormal and smaller values.
inline double float_spacing(double reference) {
  const double magnitude = std::fabs(reference);
  if (magnitude < 0x1p-126) return 0x1p-149;
  int exponent = 0;
  std::frexp(magnitude, &exponent);
  return std::ldexp(1.0, exponent - 24);
}

/// Spacing of doubles in the binade of a normal `reference`.
inline double double_spacing(double reference) {
  int exponent = 0;
  std::frexp(reference, &exponent);
  return std::ldexp(1.0, exponent - 53);
}

/// Largest double that rounds to a finite float.
inline constexpr double kFloatLimit = 0x1.ffffffp+127;

/// |value - reference| in spacings of floats; 0 when both are NaN or both lie beyond the largest float with
/// the same sign, infinity when only one does.
inline double ulp_error(float value, double reference) {
  if (std::isnan(value) || std::isnan(reference)) {
    return std::isnan(value) && std::isnan(reference) ? 0.0 : HUGE_VAL;
  }
  const bool beyond = std::fabs(reference) >= kFloatLimit;
  if (beyond || std::isinf(value)) {
    return beyond && std::isinf(value) && std::signbit(value) == std::signbit(reference) ? 0.0 : HUGE_VAL;
  }
  return std::fabs(static_cast<double>(value) - reference) / float_spacing(reference);
}

struct WorstError {
  double ulp = 0;
  float argument = 0;
};

/// Largest ulp_error(f(x), reference(x)) over every `stride`-th float of [low, high] in the order of their
/// bit patterns, both ends included.
template <class F, class R>
WorstError worst_error(float low, float high, std::uint32_t stride, F f, R reference) {
  WorstError worst;
  const auto visit = [&](float x) {
    const double error = ulp_error(f(x), reference(x));
    if (error > worst.ulp) worst = {error, x};
  };
  const auto sweep = [&](float sign, float from, float to) {
    const std::uint64_t last = std::bit_cast<std::uint32_t>(to);
    for (std::uint64_t bits = std::bit_cast<std::uint32_t>(from); bits <= last; bits += stride) {
      visit(sign * std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    }
    visit(sign * to);
  };
  if (low < 0.0f) sweep(-1.0f, high < 0.0f ? -high : 0.0f, -low);
  if (high > 0.0f) sweep(1.0f, low > 0.0f ? low : 0.0f, high);
  return worst;
}

}  // namespace mlt::test
