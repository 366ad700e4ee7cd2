// All shapes of a compiled scene behind two questions: what does a ray hit first, and is a segment blocked.
// Quads and triangles share one watertight formula [Woop13]; few primitives lie in flat SIMD lists, many
// triangles in a wide bounding volume hierarchy. Results do not depend on the structure or on the SIMD
// width: equal distances are resolved by primitive index.
#pragma once

#include <cstdint>
#include <span>

#include "base/memory.hpp"
#include "geometry/ray.hpp"

namespace mlt {

/// Input shapes in world space. A quad is a parallelogram a, b, c, d in order around it.
struct Quad {
  Vec3 a{0, 0, 0}, b{0, 0, 0}, c{0, 0, 0}, d{0, 0, 0};
};
struct Triangle {
  Vec3 a{0, 0, 0}, b{0, 0, 0}, c{0, 0, 0};
};
struct Sphere {
  Vec3 center{0, 0, 0};
  float radius = 0;
};

/// Counts fix the memory and the choice of structures; nothing else does.
struct GeometryCounts {
  std::uint32_t quads = 0;
  std::uint32_t triangles = 0;
  std::uint32_t spheres = 0;
};

struct GeometryInput {
  std::span<const Quad> quads;
  std::span<const Triangle> triangles;
  std::span<const Sphere> spheres;
};

// The class Geometry is defined by the module's author with:
//   struct GeometrySlots;                                  // slots of its plan lines
//   static GeometrySlots plan(MemoryPlan&, GeometryCounts) // upper bounds from counts alone
//   static Geometry build(Arena&, const GeometrySlots&, const GeometryInput&)
//   template <bool kGeneral> Hit intersect(const Ray&) const      // kGeneral=false: quads only, flat list
//   template <bool kGeneral> bool occluded(const Ray&) const
//   template <bool kGeneral> SurfacePoint surface_point(const Ray&, const Hit&) const

}  // namespace mlt
