// The path tracer's film: every pixel has one owner, which sums its samples in double in their order. Samples
// are unbounded, so fixed point would not do; ownership alone makes the sums independent of scheduling.
//
// Every 16th pixel takes its samples twice, from two sequences: what they differ by tells how far one is from
// the truth (error_estimate.hpp).
#pragma once

#include <cstdint>
#include <span>

#include "math/vec.hpp"

namespace mlt {

/// Sequences of samples in pixel (x, y), each of as many samples as the job asks for: 1 or 2.
constexpr std::uint32_t sequences_in(std::uint32_t x, std::uint32_t y) {
  return x % 4 == 0 && y % 4 == 0 ? 2 : 1;
}

/// Samples of a film of width x height pixels, in units of those of one sequence.
constexpr std::uint64_t sequences_in_film(std::uint32_t width, std::uint32_t height) {
  return std::uint64_t{width} * height + std::uint64_t{(width + 3) / 4} * ((height + 3) / 4);
}

struct PixelSum {
  double channels[3] = {0, 0, 0};   ///< sum of radiance over the pixel's samples
  double halves[3] = {0, 0, 0};     ///< the first half of every sequence less the second
  double sequences[3] = {0, 0, 0};  ///< the first of two sequences less the second

  /// `half` is 1, -1, or 0 for a sample that belongs to no half, `sequence` is 1 or -1.
  void add(const Vec3& radiance, int half, int sequence) {
    for (int c = 0; c < 3; ++c) {
      const double value = radiance[c];
      channels[c] += value;
      halves[c] += half * value;
      sequences[c] += sequence * value;
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
