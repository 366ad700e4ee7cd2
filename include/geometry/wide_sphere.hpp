// Many rays against the spheres of a flat list, one sphere after the other: the bits that one ray gets alone
// (sphere.hpp).
#pragma once

#include <cstddef>

#include "geometry/sphere.hpp"
#include "geometry/surface.hpp"
#include "geometry/wide_polygon.hpp"
#include "math/gather.hpp"

namespace mlt {

/// What all spheres need of the rays.
template <class F>
struct WideSphereRay {
  const RayOf<F>& ray;
  WideSlabs<F> slabs;
  F squared_length;

  MLT_INLINE WideSphereRay(const WideRayFrame<F>& frame, float extent)
      : ray(frame.ray), slabs(frame, extent), squared_length(squared(frame.ray.direction)) {}

  MLT_INLINE static F squared(const Vec3Of<F>& v) { return (v.x * v.x + v.y * v.y) + v.z * v.z; }
};

/// Where rays meet a sphere at 0 < t <= limit; as intersect_block.
template <class F>
MLT_INLINE MaskOf<F> cross_sphere(const Vec3& center, float radius, const WideSphereRay<F>& rays,
                                  const F& limit, F& t) {
  const Vec3Of<F>&o = rays.ray.origin, &d = rays.ray.direction;
  const Vec3Of<F> f{o.x - center.x, o.y - center.y, o.z - center.z};
  const F projection = -((f.x * d.x + f.y * d.y) + f.z * d.z);
  const F middle = projection / rays.squared_length;
  const Vec3Of<F> nearest{f.x + middle * d.x, f.y + middle * d.y, f.z + middle * d.z};
  const float squared_radius = radius * radius;
  const F discriminant = squared_radius - WideSphereRay<F>::squared(nearest);
  const MaskOf<F> met = discriminant >= 0.0f;
  if (!any(met)) return met;

  const F root = square_root(larger(rays.squared_length * discriminant, F{}));
  const F sum = projection + with_sign_of(root, projection);
  const F power = WideSphereRay<F>::squared(f) - squared_radius;
  const F first = power / sum;
  const F depth = select(first > 0.0f, first, sum / rays.squared_length);
  const F* const near_origin = rays.slabs.near_origin;
  const F* const inverse = rays.slabs.inverse;
  const float* const middle_of_box = &center.x;
  F entry{};
#pragma GCC unroll 3
  for (int axis = 0; axis < 3; ++axis) {
    const F low = (middle_of_box[axis] - radius) - near_origin[axis];
    const F high = (middle_of_box[axis] + radius) - near_origin[axis];
    entry = larger(entry, smaller(low * inverse[axis], high * inverse[axis]));
  }
  t = larger(entry, depth);
  return met & (depth > 0.0f) & (depth <= limit) & (t <= limit);
}

/// Calls visit(block, lane, slot) for all spheres of a flat list.
template <class Visit>
MLT_INLINE void for_spheres(const SphereBlock* blocks, std::uint32_t count, Visit&& visit) {
  for (std::uint32_t i = 0; i < count; ++i) {
    for (int lane = 0; lane < kLanes && blocks[i].primitive[lane] != kNoPrimitive; ++lane)
      visit(blocks[i], lane, i * kLanes + static_cast<std::uint32_t>(lane));
  }
}

MLT_INLINE Vec3 center_of(const SphereBlock& block, int lane) {
  return {block.center[0][lane], block.center[1][lane], block.center[2][lane]};
}

/// Replaces hits by those on spheres that are closer. All other primitives have lower indices, and so do
/// spheres that come first.
template <class F>
MLT_INLINE void intersect_spheres(const SphereBlock* blocks, std::uint32_t count, const RayOf<F>& ray,
                                  float extent, HitOf<F>& hit) {
  const WideRayFrame<F> frame(ray);
  const WideSphereRay<F> rays(frame, extent);
  F limit = select(hit.found(), hit.t, ray.t_max);
  for_spheres(
      blocks,
      count, [&](const SphereBlock& block, int lane, std::uint32_t slot) __attribute__((always_inline)) {
        F t{};
        MaskOf<F> closer = cross_sphere<F>(center_of(block, lane), block.radius[lane], rays, limit, t);
        closer &= t < limit;
        limit = select(closer, t, limit);
        hit.t = limit;
        hit.primitive = select(closer, broadcast_bits<UintOf<F>>(block.primitive[lane]), hit.primitive);
        hit.slot = select(closer, broadcast_bits<UintOf<F>>(slot), hit.slot);
        hit.weights[0] = select(closer, F{}, hit.weights[0]);
        hit.weights[1] = select(closer, F{}, hit.weights[1]);
      });
}

/// Which rays a sphere blocks; it can hide its own far side.
template <class F>
MLT_INLINE MaskOf<F> spheres_occlude(const SphereBlock* blocks, std::uint32_t count, const RayOf<F>& ray,
                                     float extent) {
  const WideRayFrame<F> frame(ray);
  const WideSphereRay<F> rays(frame, extent);
  MaskOf<F> blocked{};
  for_spheres(
      blocks, count, [&](const SphereBlock& block, int lane, std::uint32_t) __attribute__((always_inline)) {
        F t{};
        const MaskOf<F> met = cross_sphere<F>(center_of(block, lane), block.radius[lane], rays, ray.t_max, t);
        blocked |= met & (t < ray.t_max);
      });
  return blocked;
}

/// The points of hits on spheres; lanes outside `active` mean nothing.
template <class F>
MLT_INLINE SurfacePointOf<F> sphere_points(const SphereBlock* blocks, const RayOf<F>& ray,
                                           const HitOf<F>& hit, MaskOf<F> active) {
  static_assert(offsetof(SphereBlock, radius) == 3 * sizeof(LaneFloat));
  const UintOf<F> slot = select(active, hit.slot, UintOf<F>{});
  const UintOf<F> at =
      slot / static_cast<std::uint32_t>(kLanes) * static_cast<std::uint32_t>(sizeof(SphereBlock)) +
      (slot % static_cast<std::uint32_t>(kLanes)) * 4U;
  const auto row = [&](std::uint32_t index) {
    return gather_bytes<F>(reinterpret_cast<const float*>(blocks),
                           at + index * static_cast<std::uint32_t>(sizeof(LaneFloat)));
  };
  return sphere_point<F>(Vec3Of<F>{row(0), row(1), row(2)}, row(3), ray, hit.t);
}

}  // namespace mlt
