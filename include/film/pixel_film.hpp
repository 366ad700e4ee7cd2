// The path tracer's film: every pixel has one owner, which sums its samples in double in their order. Samples
// are unbounded, so fixed point would not do; ownership alone makes the sums independent of scheduling.
#pragma once

#include <cstdint>
#include <span>

#include "math/vec.hpp"

namespace mlt {

struct PixelSum {
  double channels[3] = {0, 0, 0};  ///< sum of radiance over the pixel's samples

  void add(const Vec3& radiance) {
    channels[0] += static_cast<double>(radiance.x);
    channels[1] += static_cast<double>(radiance.y);
    channels[2] += static_cast<double>(radiance.z);
  }
};

/// Mean over `samples` samples.
inline Vec3 develop_pixel(const PixelSum& sum, std::uint64_t samples) {
  const double scale = 1.0 / static_cast<double>(samples);
  return Vec3{static_cast<float>(sum.channels[0] * scale), static_cast<float>(sum.channels[1] * scale),
              static_cast<float>(sum.channels[2] * scale)};
}

}  // namespace mlt
