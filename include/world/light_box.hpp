// A box around all lights of a world. A path's last edge brings radiance only if it ends on a light, so the
// edges that pass the box need not be traced at all: with one lamp in a room that is nearly all of them.
#pragma once

#include <limits>
#include <span>

#include "geometry/ray.hpp"
#include "light/light.hpp"

namespace mlt {

/// Of world space, padded.
struct LightBox {
  Vec3 low{kInfinity, kInfinity, kInfinity};
  Vec3 high{-kInfinity, -kInfinity, -kInfinity};
  float longest = -1;  ///< no ray to a light is longer; negative where there is none

  /// Whether the rays may meet a light; none that does is told that it may not. Rays leave points of the
  /// world in unit directions.
  template <class F>
  MLT_INLINE MaskOf<F> may_be_met_by(const RayOf<F>& ray) const {
    const F* const origin = &ray.origin.x;
    const F* const direction = &ray.direction.x;
    const float* const low_side = &low.x;
    const float* const high_side = &high.x;
    F entry{}, exit = broadcast_to<F>(longest);
#pragma GCC unroll 3
    for (int axis = 0; axis < 3; ++axis) {
      const F size = larger(magnitude(direction[axis]), broadcast_to<F>(kSmallestComponent));
      const F inverse = 1.0f / with_sign_of(size, direction[axis]);
      const F to_low = (low_side[axis] - origin[axis]) * inverse;
      const F to_high = (high_side[axis] - origin[axis]) * inverse;
      entry = larger(smaller(to_low, to_high), entry);
      exit = smaller(larger(to_low, to_high), exit);
    }
    return entry <= exit;
  }

 private:
  static constexpr float kInfinity = std::numeric_limits<float>::infinity();
  /// Moves a ray by less than 2^-27 within the world.
  static constexpr float kSmallestComponent = 0x1p-30f;
};

/// The coordinates of a world are less than 2, so rounding takes accepted rays past their polygons or
/// spheres, and this test past its slabs, by less than 2^-16 (ray_frame.hpp); quads may miss being
/// parallelograms by 1e-6 of their size. The padding is more than ten times all of that, and still small
/// beside a lamp.
inline constexpr float kLightBoxPadding = 0x1p-11f;

LightBox box_around(std::span<const Light> lights);

}  // namespace mlt
