// Shapes as lanes of the blocks that rays meet, their boxes, and whether they have an area.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "geometry/quad_block.hpp"
#include "geometry/shapes.hpp"
#include "geometry/sphere.hpp"
#include "geometry/surface.hpp"
#include "geometry/triangle_block.hpp"

namespace mlt {

inline constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

struct Bounds {
  Vec3 low{0, 0, 0}, high{0, 0, 0};
};

MLT_INLINE Bounds bounds_of(const Vec3& a, const Vec3& b) {
  return {Vec3{std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)},
          Vec3{std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}};
}

MLT_INLINE Bounds join(const Bounds& p, const Bounds& q) {
  return {bounds_of(p.low, q.low).low, bounds_of(p.high, q.high).high};
}

MLT_INLINE Bounds bounds_of(const Triangle& t) {
  return join(bounds_of(t.a, t.b), bounds_of(t.c, t.c));
}
inline Bounds bounds_of(const Quad& q) {
  return join(bounds_of(q.a, q.b), bounds_of(q.c, q.d));
}
/// With the same roundings as box_entry of sphere.hpp.
inline Bounds bounds_of(const Sphere& s) {
  const Vec3 radius{s.radius, s.radius, s.radius};
  return {s.center - radius, s.center + radius};
}

/// In double, where the differences and products of most floats are exact.
inline bool has_area(const Vec3& a, const Vec3& b, const Vec3& c) {
  return cross(DVec3{b} - DVec3{a}, DVec3{c} - DVec3{a}) != DVec3{0, 0, 0};
}
inline bool has_area(const Triangle& t) {
  return has_area(t.a, t.b, t.c);
}
inline bool has_area(const Quad& q) {
  return has_area(q.a, q.b, q.c);
}
inline bool has_area(const Sphere& s) {
  return s.radius > 0.0f;
}

inline void set_corner(LaneFloat* x, LaneFloat* y, LaneFloat* z, int lane, const Vec3& p) {
  (*x)[lane] = p.x;
  (*y)[lane] = p.y;
  (*z)[lane] = p.z;
}

inline void set_corner(TriangleBlock& block, int vertex, int lane, const Vec3& p) {
  set_corner(&block.corners[0][vertex], &block.corners[1][vertex], &block.corners[2][vertex], lane, p);
}

inline void set_lane(TriangleBlock& block, int lane, const Triangle& t, std::uint32_t primitive) {
  set_corner(block, 0, lane, t.a);
  set_corner(block, 1, lane, t.b);
  set_corner(block, 2, lane, t.c);
  block.primitive[lane] = primitive;
}

inline void set_box(QuadBlock& block, int lane, const Bounds& b) {
  set_corner(&block.planes[0][0], &block.planes[1][0], &block.planes[2][0], lane, b.low);
  set_corner(&block.planes[0][1], &block.planes[1][1], &block.planes[2][1], lane, b.high);
}

inline void set_record(QuadRecord& record, const Quad& q, std::uint32_t primitive) {
  const Vec3 corners[4] = {q.a, q.b, q.c, q.d};
  const Vec3 normal = unit_normal(q.a, q.b, q.c);
  for (int axis = 0; axis < 3; ++axis) {
    for (int vertex = 0; vertex < 4; ++vertex) record.corners[axis][vertex] = corners[vertex][axis];
    record.normal[axis] = normal[axis];
  }
  record.primitive = primitive;
}

inline void set_lane(QuadBlock& block, int lane, const Quad& q, std::uint32_t primitive) {
  set_box(block, lane, bounds_of(q));
  set_record(block.quads[lane], q, primitive);
}

inline void set_lane(SphereBlock& block, int lane, const Sphere& s, std::uint32_t primitive) {
  set_corner(&block.center[0], &block.center[1], &block.center[2], lane, s.center);
  block.radius[lane] = s.radius;
  block.primitive[lane] = primitive;
}

inline void clear_lane(TriangleBlock& block, int lane) {
  const Vec3 nowhere{kNaN, kNaN, kNaN};
  set_lane(block, lane, Triangle{nowhere, nowhere, nowhere}, kNoPrimitive);
}
inline void clear_lane(QuadBlock& block, int lane) {
  set_box(block, lane, Bounds{Vec3{kNaN, kNaN, kNaN}, Vec3{kNaN, kNaN, kNaN}});
  block.quads[lane] = QuadRecord{};
}
inline void clear_lane(SphereBlock& block, int lane) {
  set_lane(block, lane, Sphere{Vec3{kNaN, kNaN, kNaN}, kNaN}, kNoPrimitive);
}

}  // namespace mlt
