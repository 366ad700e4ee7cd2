// What integrators hand to films and chains.
#pragma once

#include <cstdint>

#include "math/vec.hpp"

namespace mlt {

/// A contribution to one pixel of the film.
template <class F>
struct SplatOf {
  UintOf<F> pixel{};               ///< y * width + x
  Vec3Of<F> value{F{}, F{}, F{}};  ///< radiance estimate, linear RGB
};
using Splat = SplatOf<float>;

}  // namespace mlt
