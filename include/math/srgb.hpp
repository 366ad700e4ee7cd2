// The transfer function of sRGB [IEC 61966-2-1], by which linear radiance becomes display values.
#pragma once

#include "math/elementary.hpp"
#include "math/elementary_double.hpp"

namespace mlt {

/// Linear value to sRGB's non-linear one, both in [0,1]; error at most 0.51 ulp of the standard's formula,
/// and monotone. Values from 1 on give 1; 0, negative values and NaN give 0.
inline float srgb_encode(float linear) {
  if (!(linear > 0.0f)) return 0.0f;
  if (linear >= 1.0f) return 1.0f;
  if (linear <= 0.0031308f) return static_cast<float>(12.92 * static_cast<double>(linear));
  const double root = detail::exp2_kernel(detail::log2_kernel(linear) * (1.0 / 2.4));
  return static_cast<float>(1.055 * root - 0.055);
}

/// sRGB's non-linear value in [0,1] to the linear one, the standard's formula to some units of double's last
/// place.
inline double srgb_decode(double encoded) {
  if (encoded <= 0.04045) return encoded / 12.92;
  return pow_d((encoded + 0.055) / 1.055, 2.4);
}

}  // namespace mlt
