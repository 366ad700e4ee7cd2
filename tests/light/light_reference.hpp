// What the light tests compare with: intersections, solid angles and irradiances in double, by closed forms
// that share nothing with the samplers.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "geometry/geometry.hpp"
#include "light/light_table.hpp"
#include "math/rng.hpp"

namespace mlt::test {

inline constexpr double kPiDouble = 3.141592653589793;

inline Vec2 random_pair(Rng& rng) {
  const float first = rng.next_float();
  const float second = rng.next_float();
  return Vec2{first, second};
}

/// A table of one light, which owns what it points to.
struct SingleLight {
  Light light;
  float cdf = 0;
  LightTable table;

  explicit SingleLight(const Light& made) : light(made) { table = build_light_table({&light, 1}, {&cdf, 1}); }
  SingleLight(const SingleLight&) = delete;
  SingleLight& operator=(const SingleLight&) = delete;
};

/// Position along the edges of a polygon light where the ray meets its plane, whether inside or not.
inline std::optional<std::array<double, 2>> plane_coordinates(const Light& light, const DVec3& from,
                                                              const DVec3& direction) {
  const DVec3 u{light.edge_u};
  const DVec3 v{light.edge_v};
  const DVec3 normal = cross(u, v);
  const double t = dot(normal, DVec3{light.origin} - from) / dot(normal, direction);
  if (!(t > 0)) return std::nullopt;
  const DVec3 p = from + direction * t - DVec3{light.origin};
  const double square = dot(normal, normal);
  return std::array<double, 2>{dot(cross(p, v), normal) / square, dot(cross(u, p), normal) / square};
}

/// Does the ray meet the light, and where? The nearest point, in double.
inline std::optional<DVec3> meet_light(const Light& light, const DVec3& from, const DVec3& direction) {
  if (light.shape == LightShape::kSphere) {
    const DVec3 to_center = DVec3{light.origin} - from;
    const double along = dot(to_center, direction);
    const DVec3 across = to_center - direction * along;
    const double half_squared = static_cast<double>(light.radius) * light.radius - dot(across, across);
    if (half_squared < 0) return std::nullopt;
    const double half = std::sqrt(half_squared);
    const double t = along - half > 0 ? along - half : along + half;
    if (!(t > 0)) return std::nullopt;
    return from + direction * t;
  }
  const auto place = plane_coordinates(light, from, direction);
  if (!place) return std::nullopt;
  const auto [a, b] = *place;
  const bool inside = a >= 0 && b >= 0 && (light.shape == LightShape::kQuad ? a <= 1 && b <= 1 : a + b <= 1);
  if (!inside) return std::nullopt;
  return DVec3{light.origin} + DVec3{light.edge_u} * a + DVec3{light.edge_v} * b;
}

inline std::vector<DVec3> corners_of(const Light& light) {
  const DVec3 a{light.origin};
  const DVec3 u{light.edge_u};
  const DVec3 v{light.edge_v};
  if (light.shape == LightShape::kQuad) return {a, a + u, a + u + v, a + v};
  return {a, a + u, a + v};
}

/// Solid angle of a triangle in steradian, without sign [VanOosterom83 eq. 8].
inline double triangle_solid_angle(const DVec3& from, const DVec3& a, const DVec3& b, const DVec3& c) {
  const DVec3 x = a - from;
  const DVec3 y = b - from;
  const DVec3 z = c - from;
  const double numerator = std::fabs(dot(x, cross(y, z)));
  const double denominator = length(x) * length(y) * length(z) + dot(x, y) * length(z) +
                             dot(x, z) * length(y) + dot(y, z) * length(x);
  return 2 * std::atan2(numerator, denominator);
}

inline double solid_angle(const Light& light, const DVec3& from) {
  if (light.shape == LightShape::kSphere) {
    const double distance = length(DVec3{light.origin} - from);
    if (distance <= light.radius) return 4 * kPiDouble;
    const double sine = light.radius / distance;
    return 2 * kPiDouble * sine * sine / (1 + std::sqrt(1 - sine * sine));
  }
  const std::vector<DVec3> corners = corners_of(light);
  double sum = triangle_solid_angle(from, corners[0], corners[1], corners[2]);
  if (corners.size() == 4) sum += triangle_solid_angle(from, corners[0], corners[2], corners[3]);
  return sum;
}

/// Irradiance at `from` (surface normal `normal`) over radiance from a polygon wholly above the surface:
/// half the sum over edges of the angle they subtend times the cosine of their plane [Lambert1760].
inline double polygon_irradiance_factor(const Light& light, const DVec3& from, const DVec3& normal) {
  const std::vector<DVec3> corners = corners_of(light);
  double sum = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const DVec3 a = corners[i] - from;
    const DVec3 b = corners[(i + 1) % corners.size()] - from;
    const DVec3 across = cross(a, b);
    sum += std::atan2(length(across), dot(a, b)) * dot(across / length(across), normal);
  }
  return std::fabs(sum) / 2;
}

}  // namespace mlt::test
