// A developed picture: linear radiance, Rec. 709 primaries, rows from top to bottom.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/assert.hpp"
#include "math/vec.hpp"

namespace mlt {

struct ImageView {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::span<const Vec3> pixels;  ///< width * height, pixel (x, y) at y * width + x
};

struct ImageBuffer {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<Vec3> pixels;

  ImageView view() const { return {width, height, pixels}; }
};

/// A picture of from_width x from_height pixels, pixel i of which is `pixel_at(i)`, in width x height of
/// them, not more than it has: the means of those that lie in each. Of the larger picture nothing need be in
/// memory.
template <class PixelAt>
ImageBuffer reduced_image(std::uint32_t from_width, std::uint32_t from_height, const PixelAt& pixel_at,
                          std::uint32_t width, std::uint32_t height) {
  MLT_CHECK(width >= 1 && width <= from_width && height >= 1 && height <= from_height);
  ImageBuffer result{width, height, {}};
  result.pixels.reserve(std::size_t{width} * height);
  struct Sum {
    double channels[3] = {0, 0, 0};
    double count = 0;
  };
  std::vector<Sum> row(width);
  for (std::uint32_t y = 0; y < from_height; ++y) {
    const auto row_of = [&](std::uint32_t at) { return std::size_t{at} * height / from_height; };
    for (std::uint32_t x = 0; x < from_width; ++x) {
      Sum& sum = row[std::size_t{x} * width / from_width];
      const Vec3 pixel = pixel_at(std::size_t{y} * from_width + x);
      for (int c = 0; c < 3; ++c) sum.channels[c] += pixel[c];
      sum.count += 1;
    }
    if (y + 1 < from_height && row_of(y + 1) == row_of(y)) continue;
    for (Sum& sum : row) {
      Vec3 mean;
      for (int c = 0; c < 3; ++c) mean[c] = static_cast<float>(sum.channels[c] / sum.count);
      result.pixels.push_back(mean);
      sum = {};
    }
  }
  return result;
}

}  // namespace mlt
