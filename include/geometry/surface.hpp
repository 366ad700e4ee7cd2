// Points on surfaces: where a ray met a primitive, to within a bound on the error along the normal.
#pragma once

#include <cmath>

#include "geometry/quad_block.hpp"
#include "geometry/sphere.hpp"
#include "geometry/triangle_block.hpp"

namespace mlt {

inline constexpr float kUnitRoundoff = 0x1p-24f;

/// Unit normal of a triangle by its edges from one corner. In double, since for needles the product of float
/// edges is mostly rounding error.
inline Vec3 unit_normal(const Vec3& a, const Vec3& b, const Vec3& c) {
  const DVec3 from{a};
  return Vec3{normalize(cross(DVec3{b} - from, DVec3{c} - from))};
}

/// The point a + v (m - a) + w (c - a), m being the corner `middle`, b or d.
///
/// Rounding: with u = 2^-24 and E the sum of the absolute edges, each coordinate is off by u|p| + 4uE, and by
/// another u|p| after the offset is added. The polygon test of a ray that leaves from there sees corners
/// moved by up to 7uE (ray_frame.hpp), along a normal whose components sum to at most sqrt(3). The bound is
/// their sum with a little to spare.
template <class F>
MLT_INLINE SurfacePointOf<F> polygon_point(const Vec3Of<F>& a, const Vec3Of<F>& middle, const Vec3Of<F>& c,
                                           const Vec3Of<F>& normal, const HitOf<F>& hit) {
  const Vec3Of<F> to_middle = middle - a;
  const Vec3Of<F> to_c = c - a;
  SurfacePointOf<F> point;
  point.position = a + (to_middle * hit.weights[0] + to_c * hit.weights[1]);
  point.normal = normal;
  const Vec3Of<F> along{magnitude(point.position.x * point.normal.x),
                        magnitude(point.position.y * point.normal.y),
                        magnitude(point.position.z * point.normal.z)};
  const Vec3Of<F> edges{magnitude(to_middle.x) + magnitude(to_c.x),
                        magnitude(to_middle.y) + magnitude(to_c.y),
                        magnitude(to_middle.z) + magnitude(to_c.z)};
  point.offset_bound =
      kUnitRoundoff * (4.0f * ((along.x + along.y) + along.z) + 24.0f * max_component<F>(edges));
  return point;
}

MLT_INLINE SurfacePoint triangle_point(const TriangleBlock& block, int lane, const Hit& hit) {
  const Vec3 a = block.corner(0, lane);
  const Vec3 b = block.corner(1, lane);
  const Vec3 c = block.corner(2, lane);
  return polygon_point<float>(a, b, c, unit_normal(a, b, c), hit);
}

MLT_INLINE SurfacePoint quad_point(const QuadRecord& quad, bool second, const Hit& hit) {
  return polygon_point<float>(quad.corner(0), quad.corner(second ? 3 : 1), quad.corner(2),
                              Vec3{quad.normal[0], quad.normal[1], quad.normal[2]}, hit);
}

/// The point is moved along its radius onto the sphere, off by 5u radius + u|p|. A ray that leaves from there
/// must find its origin outside (or inside) by a difference of squares that is off by 7u radius^2.
template <class F>
MLT_INLINE SurfacePointOf<F> sphere_point(const Vec3Of<F>& center, const F& radius, const RayOf<F>& ray,
                                          const F& t) {
  SurfacePointOf<F> point;
  point.normal = normalize((ray.origin + ray.direction * t) - center);
  point.position = center + point.normal * radius;
  const F reach = (magnitude(point.position.x) + magnitude(point.position.y)) + magnitude(point.position.z);
  point.offset_bound = kUnitRoundoff * (4.0f * reach + 16.0f * radius);
  return point;
}

MLT_INLINE SurfacePoint sphere_point(const SphereBlock& block, int lane, const Ray& ray, float t) {
  const Vec3 center{block.center[0][lane], block.center[1][lane], block.center[2][lane]};
  return sphere_point<float>(center, block.radius[lane], ray, t);
}

}  // namespace mlt
