// What integrators hand to films and chains.
#pragma once

#include <cstdint>

#include "math/vec.hpp"

namespace mlt {

/// A contribution to one pixel of the film.
struct Splat {
  std::uint32_t pixel = 0;  ///< y * width + x
  Vec3 value{0, 0, 0};      ///< radiance estimate, linear RGB
};

}  // namespace mlt
