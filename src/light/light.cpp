#include "light/light.hpp"

#include <cmath>
#include <initializer_list>

#include "geometry/shapes.hpp"

namespace mlt {

namespace {

/// Rounding of a point on a light: its own coordinates by half a unit in the last place each, and the corners
/// that both it and the intersection are computed from; 16 units cover the sum with a factor to spare.
constexpr float kOffsetPerCoordinate = 0x1p-20f;

float offset_bound(std::initializer_list<Vec3> corners) {
  float largest = 0;
  for (const Vec3& corner : corners) {
    const float extent = max_component(Vec3{std::fabs(corner.x), std::fabs(corner.y), std::fabs(corner.z)});
    if (extent > largest) largest = extent;
  }
  return kOffsetPerCoordinate * largest;
}

/// Everything but the area, of which this returns what the parallelogram over both edges has. In double,
/// where the squared cross product of the shortest float edges does not underflow.
double set_polygon(Light& light, const Vec3& a, const Vec3& b, const Vec3& last, const Vec3& radiance) {
  // Of the corners of a triangle, none is farther from the middle than two thirds of both edges together; of
  // a parallelogram, than half of them.
  const double edges = length(DVec3{b} - DVec3{a}) + length(DVec3{last} - DVec3{a});
  light.radius = static_cast<float>((light.shape == LightShape::kQuad ? 0.5 : 2.0 / 3.0) * edges);
  light.origin = a;
  light.edge_u = b - a;
  light.edge_v = last - a;
  light.radiance = radiance;
  const DVec3 perpendicular = cross(DVec3{b} - DVec3{a}, DVec3{last} - DVec3{a});
  const double area = length(perpendicular);
  if (area > 0.0) light.normal = Vec3{perpendicular / area};
  return area;
}

}  // namespace

Light make_quad_light(const Quad& quad, const Vec3& radiance) {
  Light light;
  light.shape = LightShape::kQuad;
  light.area = static_cast<float>(set_polygon(light, quad.a, quad.b, quad.d, radiance));
  light.offset_bound = offset_bound({quad.a, quad.b, quad.c, quad.d});
  return light;
}

Light make_triangle_light(const Triangle& triangle, const Vec3& radiance) {
  Light light;
  light.shape = LightShape::kTriangle;
  light.area = static_cast<float>(0.5 * set_polygon(light, triangle.a, triangle.b, triangle.c, radiance));
  light.offset_bound = offset_bound({triangle.a, triangle.b, triangle.c});
  return light;
}

Light make_sphere_light(const Sphere& sphere, const Vec3& radiance) {
  Light light;
  light.shape = LightShape::kSphere;
  light.origin = sphere.center;
  light.radius = sphere.radius;
  light.radiance = radiance;
  light.area = static_cast<float>(12.5663706143591730 * (static_cast<double>(sphere.radius) * sphere.radius));
  const Vec3 extent{sphere.radius, sphere.radius, sphere.radius};
  light.offset_bound = offset_bound({sphere.center - extent, sphere.center + extent});
  return light;
}

}  // namespace mlt
