// A developed picture: linear radiance, Rec. 709 primaries, rows from top to bottom.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

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

}  // namespace mlt
