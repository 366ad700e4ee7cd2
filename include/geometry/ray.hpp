// Rays and hits, shared by every shape, acceleration structure and integrator.
#pragma once

#include <cstdint>

#include "math/vec.hpp"

namespace mlt {

inline constexpr std::uint32_t kNoPrimitive = 0xffffffffU;
/// In Hit::slot: on triangle a, c, d of a quad.
inline constexpr std::uint32_t kSecondTriangle = 0x80000000U;

/// Points origin + t * direction with 0 < t < t_max. Directions need not be unit vectors: t counts in lengths
/// of the direction, and a shadow segment is a ray with t_max 1.
template <class F>
struct RayOf {
  Vec3Of<F> origin{F{}, F{}, F{}};
  Vec3Of<F> direction{F{}, F{}, broadcast_to<F>(1)};
  F t_max{};
};
using Ray = RayOf<float>;

/// The ray of lane i.
template <class F>
MLT_INLINE Ray lane_of(const RayOf<F>& ray, int lane) {
  return {lane_of(ray.origin, lane), lane_of(ray.direction, lane), lane_of(ray.t_max, lane)};
}

/// The closest hit is the lexicographic minimum of (t, primitive), whatever structure found it.
template <class F>
struct HitOf {
  F t{};
  /// Quads, then triangles, then spheres, each in scene order.
  UintOf<F> primitive = broadcast_bits<UintOf<F>>(kNoPrimitive);
  // Where the primitive is stored and where on it the hit lies; meaningful to Geometry::surface_point alone.
  UintOf<F> slot{};
  F weights[2] = {F{}, F{}};

  MLT_INLINE MaskOf<F> found() const { return primitive != kNoPrimitive; }
};
using Hit = HitOf<float>;

template <class F>
MLT_INLINE Hit lane_of(const HitOf<F>& hits, int lane) {
  return {lane_of(hits.t, lane),
          lane_of(hits.primitive, lane),
          lane_of(hits.slot, lane),
          {lane_of(hits.weights[0], lane), lane_of(hits.weights[1], lane)}};
}
template <class F>
MLT_INLINE void set_lane_of(HitOf<F>& hits, int lane, const Hit& hit) {
  set_lane_of(hits.t, lane, hit.t);
  set_lane_of(hits.primitive, lane, hit.primitive);
  set_lane_of(hits.slot, lane, hit.slot);
  set_lane_of(hits.weights[0], lane, hit.weights[0]);
  set_lane_of(hits.weights[1], lane, hit.weights[1]);
}

/// Primitives at the ends of a shadow segment, kNoPrimitive where there is none. The one it starts from it
/// does not meet again; the target, a light, is no obstacle if it is a polygon.
template <class F>
struct SegmentEnds {
  UintOf<F> leaves = broadcast_bits<UintOf<F>>(kNoPrimitive);
  UintOf<F> target = broadcast_bits<UintOf<F>>(kNoPrimitive);
};

/// A point on a surface. `normal` is the geometric unit normal of the front side. `offset_bound` bounds the
/// absolute rounding error of `position` along the normal; rays leave from position +- normal * offset_bound.
template <class F>
struct SurfacePointOf {
  Vec3Of<F> position{F{}, F{}, F{}};
  Vec3Of<F> normal{F{}, F{}, broadcast_to<F>(1)};
  F offset_bound{};

  /// Start of a ray that leaves towards `direction`, on its side of the surface.
  MLT_INLINE Vec3Of<F> origin_towards(const Vec3Of<F>& direction) const {
    return position + normal * select(dot(direction, normal) >= 0.0f, offset_bound, -offset_bound);
  }
};
using SurfacePoint = SurfacePointOf<float>;

}  // namespace mlt
