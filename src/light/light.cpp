#include "light/light.hpp"

#include <cmath>

#include "math/warp.hpp"

namespace mlt {

namespace {

/// Rounding of a point on a light: its own coordinates by half a unit in the last place each, and the corners
/// that both it and the intersection are computed from; 16 units cover the sum with a factor to spare.
constexpr float kOffsetPerCoordinate = 0x1p-20f;

float largest_coordinate(const Vec3& v) {
  return max_component(Vec3{std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
}

/// A parallelogram with `area_scale` 1, or half of it.
Light make_polygon_light(LightShape shape, const Vec3& a, const Vec3& b, const Vec3& last,
                         const Vec3& radiance) {
  Light light;
  light.shape = shape;
  light.origin = a;
  light.edge_u = b - a;
  light.edge_v = last - a;
  light.radiance = radiance;
  // In double, where the squared cross product of the shortest float edges does not underflow.
  const DVec3 perpendicular = cross(DVec3{b} - DVec3{a}, DVec3{last} - DVec3{a});
  const double parallelogram = length(perpendicular);
  if (parallelogram > 0.0 && std::isfinite(parallelogram)) light.normal = Vec3{perpendicular / parallelogram};
  light.area = static_cast<float>(shape == LightShape::kQuad ? parallelogram : 0.5 * parallelogram);
  const Vec3 opposite = shape == LightShape::kQuad ? b + light.edge_v : b;
  const Vec3 extent{largest_coordinate(a), largest_coordinate(opposite), largest_coordinate(b)};
  const float last_extent = largest_coordinate(last);
  const float largest = max_component(extent);
  light.offset_bound = kOffsetPerCoordinate * (largest > last_extent ? largest : last_extent);
  return light;
}

}  // namespace

Light make_quad_light(const Vec3& a, const Vec3& b, const Vec3& d, const Vec3& radiance) {
  return make_polygon_light(LightShape::kQuad, a, b, d, radiance);
}

Light make_triangle_light(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& radiance) {
  return make_polygon_light(LightShape::kTriangle, a, b, c, radiance);
}

Light make_sphere_light(const Vec3& center, float radius, const Vec3& radiance) {
  Light light;
  light.shape = LightShape::kSphere;
  light.origin = center;
  light.radius = radius;
  light.radiance = radiance;
  light.area = static_cast<float>(4.0 * kPi * (static_cast<double>(radius) * radius));
  light.offset_bound = kOffsetPerCoordinate * (largest_coordinate(center) + radius);
  return light;
}

}  // namespace mlt
