// The path tracer's film: every pixel has one owner, which sums its samples in double in their order. Samples
// are unbounded, so fixed point would not do; ownership alone makes the sums independent of scheduling.
#pragma once

#include <cstdint>
#include <span>

#include "math/vec.hpp"

namespace mlt {

struct PixelSum {
  double channels[3] = {0, 0, 0};  ///< sum of radiance over the pixel's samples
  // Of the quarters of every sequence of samples (error_estimate.hpp): (1 + 2) - (3 + 4), 1 - 2 and 3 - 4.
  double halves[3] = {0, 0, 0};
  double first_quarters[3] = {0, 0, 0};
  double last_quarters[3] = {0, 0, 0};

  /// `quarter` is 0 to 3, or 4 for a sample that belongs to none.
  void add(const Vec3& radiance, std::uint64_t quarter) {
    constexpr double kHalf[5] = {1, 1, -1, -1, 0};
    constexpr double kFirst[5] = {1, -1, 0, 0, 0};
    constexpr double kLast[5] = {0, 0, 1, -1, 0};
    for (int c = 0; c < 3; ++c) {
      const double value = radiance[c];
      channels[c] += value;
      halves[c] += kHalf[quarter] * value;
      first_quarters[c] += kFirst[quarter] * value;
      last_quarters[c] += kLast[quarter] * value;
    }
  }
};

/// Mean over `samples` samples.
inline Vec3 develop_pixel(const PixelSum& sum, std::uint64_t samples) {
  const double scale = 1.0 / static_cast<double>(samples);
  return Vec3{static_cast<float>(sum.channels[0] * scale), static_cast<float>(sum.channels[1] * scale),
              static_cast<float>(sum.channels[2] * scale)};
}

}  // namespace mlt
