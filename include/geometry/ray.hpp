// Rays and hits, shared by every shape, acceleration structure and integrator.
#pragma once

#include <cstdint>

#include "math/vec.hpp"

namespace mlt {

inline constexpr std::uint32_t kNoPrimitive = 0xffffffffU;

/// Points origin + t * direction with 0 < t < t_max. Directions need not be unit vectors: t counts in lengths
/// of the direction, and a shadow segment is a ray with t_max 1.
struct Ray {
  Vec3 origin{0, 0, 0};
  Vec3 direction{0, 0, 1};
  float t_max = 0;
};

/// The closest hit is the lexicographic minimum of (t, primitive), whatever structure found it.
struct Hit {
  float t = 0;
  std::uint32_t primitive = kNoPrimitive;  ///< quads, then triangles, then spheres, each in scene order
  // Where the primitive is stored and where on it the hit lies; meaningful to Geometry::surface_point alone.
  std::uint32_t slot = 0;
  float weights[2] = {0, 0};

  bool found() const { return primitive != kNoPrimitive; }
};

/// A point on a surface. `normal` is the geometric unit normal of the front side. `offset_bound` bounds the
/// absolute rounding error of `position` along the normal; rays leave from position +- normal * offset_bound.
struct SurfacePoint {
  Vec3 position{0, 0, 0};
  Vec3 normal{0, 0, 1};
  float offset_bound = 0;

  /// Start of a ray that leaves towards `direction`, on its side of the surface.
  Vec3 origin_towards(const Vec3& direction) const {
    const float side = dot(direction, normal) >= 0.0f ? offset_bound : -offset_bound;
    return position + normal * side;
  }
};

}  // namespace mlt
