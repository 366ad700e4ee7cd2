// Integrators over a few primary samples whose image is known in closed form.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "integrator/splat.hpp"
#include "math/vec.hpp"

namespace mlt::test {

/// Which of `count` equal parts of [0,1) a primary sample lies in.
inline std::uint32_t part_of(std::uint32_t fixed, std::uint32_t count) {
  return static_cast<std::uint32_t>((std::uint64_t{fixed} * count) >> 32);
}

/// A smooth image of 6 x 4 pixels with what makes real integrators difficult: paths that end early, a number
/// of primary samples that depends on the path, black paths, and several splats at different pixels.
///
/// Samples x, y choose the pixel and base(x, y) = (1 + 0.8 sin 2 pi x) (1 + 0.5 cos 2 pi y). z ends the path:
/// black below 0.25, one grey splat from 0.9 on. Otherwise a factor of one or of three samples, 2u each (mean
/// 1), and w, which colours the value by (2w, 1, 2 - 2w): it is splatted at the pixel, with weight 0.3 and
/// reversed channels at the opposite pixel, and for w < 1/2 with weight 0.2 at kFixedPixel.
/// With kEager, samples that the path does not need are drawn instead of skipped.
template <bool kEager = false>
class SmoothToy {
 public:
  static constexpr std::uint32_t kWidth = 6, kHeight = 4, kPixels = kWidth * kHeight, kFixedPixel = 7;
  static constexpr std::uint32_t kCapacity = 8;
  static constexpr std::uint32_t kMaxSplats = 3;

  using Float = float;
  template <class Sampler, class Sink>
  void evaluate(Sampler& sampler, Sink&& sink, bool = true) const {
    const std::uint32_t fixed_x = sampler.next_fixed();
    const std::uint32_t fixed_y = sampler.next_fixed();
    const std::uint32_t pixel = part_of(fixed_y, kHeight) * kWidth + part_of(fixed_x, kWidth);
    const double base =
        (1 + 0.8 * std::sin(kTwoPi * fixed_x * 0x1p-32)) * (1 + 0.5 * std::cos(kTwoPi * fixed_y * 0x1p-32));
    const float z = sampler.next();
    if (z < 0.25f || z >= 0.9f) {
      omit(sampler, 5);
      sink(Splat{pixel, Vec3{z < 0.25f ? 0.0f : static_cast<float>(base)}});
      return;
    }
    float factor = 1;
    const bool three = sampler.next() >= 0.5f;
    for (int i = 0; i < (three ? 3 : 1); ++i) factor *= 2.0f * sampler.next();
    if (!three) omit(sampler, 2);
    const float w = sampler.next();
    const Vec3 value = Vec3{2.0f * w, 1.0f, 2.0f - 2.0f * w} * (factor * static_cast<float>(base));
    sink(Splat{pixel, value});
    sink(Splat{kPixels - 1 - pixel, Vec3{value.z, value.y, value.x} * 0.3f});
    if (w < 0.5f) sink(Splat{kFixedPixel, value * 0.2f});
  }

  /// Three channels a pixel.
  static std::vector<double> expected() {
    // Integrals over w in [0, 1/2) of 2w, 1 and 2 - 2w.
    constexpr double kLowerHalf[3] = {0.25, 0.5, 0.75};
    std::vector<double> image(3 * kPixels);
    for (std::uint32_t pixel = 0; pixel < kPixels; ++pixel) {
      const double coloured = 0.65 * (base_integral(pixel) + 0.3 * base_integral(kPixels - 1 - pixel));
      for (std::uint32_t c = 0; c < 3; ++c) {
        image[3 * pixel + c] = kPixels * (coloured + 0.1 * base_integral(pixel));
        // The integral of base over the whole square is 1.
        if (pixel == kFixedPixel) image[3 * pixel + c] += kPixels * 0.2 * 0.65 * kLowerHalf[c];
      }
    }
    return image;
  }

  /// The target's integral.
  static double expected_b() {
    const std::vector<double> image = expected();
    double sum = 0;
    for (std::size_t i = 0; i < image.size(); i += 3) {
      sum += 0.2126 * image[i] + 0.7152 * image[i + 1] + 0.0722 * image[i + 2];
    }
    return sum / kPixels;
  }

 private:
  static constexpr double kTwoPi = 6.283185307179586477;

  template <class Sampler>
  static void omit(Sampler& sampler, std::uint32_t count) {
    if constexpr (kEager) {
      for (std::uint32_t i = 0; i < count; ++i) sampler.next_fixed();
    } else {
      sampler.skip(count);
    }
  }

  static double base_integral(std::uint32_t pixel) {
    const double x0 = static_cast<double>(pixel % kWidth) / kWidth;
    const double y0 = static_cast<double>(pixel / kWidth) / kHeight;
    const double x1 = x0 + 1.0 / kWidth;
    const double y1 = y0 + 1.0 / kHeight;
    const double over_x = x1 - x0 - 0.8 * (std::cos(kTwoPi * x1) - std::cos(kTwoPi * x0)) / kTwoPi;
    const double over_y = y1 - y0 + 0.5 * (std::sin(kTwoPi * y1) - std::sin(kTwoPi * y0)) / kTwoPi;
    return over_x * over_y;
  }
};

/// The same grey value at the same pixel for every path of `kSamples` samples: b is `value`, and every
/// proposal is accepted.
template <std::uint32_t kSamples = 2>
struct ConstantToy {
  static constexpr std::uint32_t kPixels = 1, kCapacity = kSamples, kMaxSplats = 1;
  float value = 1;

  using Float = float;
  template <class Sampler, class Sink>
  void evaluate(Sampler& sampler, Sink&& sink, bool = true) const {
    for (std::uint32_t i = 0; i < kSamples; ++i) sampler.next_fixed();
    sink(Splat{0, Vec3{value}});
  }
};

}  // namespace mlt::test
