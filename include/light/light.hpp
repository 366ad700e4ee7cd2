// Area lights. One record per emitting primitive; chosen in proportion to emitted power, by a single primary
// sample that is used again for nothing else.
#pragma once

#include <cstdint>
#include <span>

#include "geometry/ray.hpp"
#include "math/vec.hpp"

namespace mlt {

inline constexpr std::uint32_t kNoLight = 0xffffffffU;

enum class LightShape : std::uint8_t { kQuad, kTriangle, kSphere };

struct Light {
  LightShape shape = LightShape::kQuad;
  Vec3 origin{0, 0, 0};   ///< corner a, or the sphere's centre
  Vec3 edge_u{0, 0, 0};   ///< b - a
  Vec3 edge_v{0, 0, 0};   ///< quad: d - a; triangle: c - a
  Vec3 normal{0, 0, 1};   ///< front side, unit
  Vec3 radiance{0, 0, 0};
  float radius = 0;
  float area = 0;
  float choice_probability = 0;
  float offset_bound = 0;  ///< distance along the normal that keeps shadow segments off the light's surface
};

/// A point on a light as seen from a reference point.
struct LightSample {
  Vec3 position{0, 0, 0};       ///< already offset off the light's surface, towards the reference point
  Vec3 direction{0, 0, 1};      ///< unit, reference to light
  Vec3 radiance{0, 0, 0};       ///< 0 when the reference point sees the back
  float pdf_solid_angle = 0;    ///< including the choice of the light; 0 means: no sample
};

}  // namespace mlt
