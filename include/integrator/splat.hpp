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

template <class F>
MLT_INLINE SplatOf<F> select(MaskOf<F> mask, const SplatOf<F>& a, const SplatOf<F>& b) {
  return {select(mask, a.pixel, b.pixel), select(mask, a.value, b.value)};
}

}  // namespace mlt
