// Area lights as the world stores them. One record per emitting primitive; sampling is in
// light/light_table.hpp. Lights emit the same radiance in all directions of their front side.
#pragma once

#include <cstdint>

#include "math/vec.hpp"

namespace mlt {

struct Quad;
struct Triangle;
struct Sphere;

inline constexpr std::uint32_t kNoLight = 0xffffffffU;

enum class LightShape : std::uint8_t { kQuad, kTriangle, kSphere };

struct Light {
  LightShape shape = LightShape::kQuad;
  Vec3 origin{0, 0, 0};  ///< corner a, or the sphere's centre
  Vec3 edge_u{0, 0, 0};  ///< b - a
  Vec3 edge_v{0, 0, 0};  ///< quad: d - a; triangle: c - a
  Vec3 normal{0, 0, 1};  ///< front side, unit; unused for a sphere, whose front is its outside
  Vec3 radiance{0, 0, 0};
  float radius = 0;
  float area = 0;
  float choice_probability = 0;  ///< exactly the length of its interval in LightTable::cdf
  float offset_bound = 0;  ///< distance along the normal that keeps shadow segments off the light's surface
};

/// A point on a light as seen from a reference point.
struct LightSample {
  Vec3 position{0, 0, 0};     ///< already offset off the light's surface, towards the reference point
  Vec3 direction{0, 0, 1};    ///< unit, reference to light
  Vec3 radiance{0, 0, 0};     ///< 0 when the reference point sees the back
  float pdf_solid_angle = 0;  ///< including the choice of the light; 0 means: no sample
  std::uint32_t light = kNoLight;
};

/// Lights from world space shapes, without a choice probability, which build_light_table sets. A shape of
/// area 0 gives a light of area 0, which is never chosen.
Light make_quad_light(const Quad& quad, const Vec3& radiance);
Light make_triangle_light(const Triangle& triangle, const Vec3& radiance);
Light make_sphere_light(const Sphere& sphere, const Vec3& radiance);

/// Radiance that the point of a light whose surface normal there is `normal` sends against `direction` (from
/// the receiver towards the light): nothing from the back side.
inline Vec3 emitted_radiance(const Light& light, const Vec3& normal, const Vec3& direction) {
  return dot(normal, direction) < 0.0f ? light.radiance : Vec3{0, 0, 0};
}

}  // namespace mlt
