// Triangles in SIMD blocks, the leaves of large meshes: the polygon test (polygon.hpp), one triangle a lane.
#pragma once

#include <cstdint>

#include "geometry/polygon.hpp"

namespace mlt {

/// kLanes triangles. An unused lane holds NaN, which no test accepts.
struct alignas(sizeof(LaneFloat)) TriangleBlock {
  LaneFloat corners[3][3];  ///< by axis and vertex
  std::uint32_t primitive[kLanes];

  Vec3 corner(int vertex, int lane) const {
    return Vec3{corners[0][vertex][lane], corners[1][vertex][lane], corners[2][vertex][lane]};
  }
};

/// The corners of a block in the ray's frame: sheared x and y, and the depth along the permuted z axis; the
/// edge functions there, and the corners' depths in units of t.
struct ShearedTriangles {
  LaneFloat x[3], y[3];
  LaneFloat ab, bc, ca;
  LaneFloat t_a, t_b, t_c;

  MLT_INLINE ShearedTriangles(const TriangleBlock& block, const RayShear& ray) {
    const LaneFloat* corner_x = block.corners[ray.axis_x];
    const LaneFloat* corner_y = block.corners[ray.axis_y];
    const LaneFloat* corner_z = block.corners[ray.axis_z];
    LaneFloat z[3];
#pragma GCC unroll 4
    for (int i = 0; i < 3; ++i) {
      z[i] = corner_z[i] - ray.origin_z;
      x[i] = (corner_x[i] - ray.origin_x) - ray.shear_x * z[i];
      y[i] = (corner_y[i] - ray.origin_y) - ray.shear_y * z[i];
    }
    ab = edge_function(x[0], y[0], x[1], y[1]);
    bc = edge_function(x[1], y[1], x[2], y[2]);
    ca = edge_function(x[2], y[2], x[0], y[0]);
    t_a = z[0] * ray.inverse_z;
    t_b = z[1] * ray.inverse_z;
    t_c = z[2] * ray.inverse_z;
  }

  MLT_INLINE LaneFloat smallest() const {
    return min_lanes(min_lanes(ab, bc), ca);
  }
  MLT_INLINE LaneFloat largest() const {
    return max_lanes(max_lanes(ab, bc), ca);
  }
};

/// Largest absolute value of three, per lane.
MLT_INLINE LaneFloat largest_magnitude(LaneFloat a, LaneFloat b, LaneFloat c) {
  return max_lanes(max_lanes(abs_lanes(a), abs_lanes(b)), abs_lanes(c));
}

/// Where the ray enters the padded bounding box of each triangle. The entry of the nearest corner is that of
/// the box, since rounding is monotone.
MLT_INLINE LaneFloat box_entry(const TriangleBlock& block, const RayFrame& ray) {
  LaneFloat entry{};
#pragma GCC unroll 4
  for (int axis = 0; axis < 3; ++axis) {
    LaneFloat nearest = (block.corners[axis][0] - ray.near_origin[axis]) * ray.inverse[axis];
#pragma GCC unroll 4
    for (int i = 1; i < 3; ++i) {
      nearest = min_lanes(nearest, (block.corners[axis][i] - ray.near_origin[axis]) * ray.inverse[axis]);
    }
    entry = max_lanes(entry, nearest);
  }
  return entry;
}

/// Where the ray meets the triangles of a block, by lane.
struct TriangleHits {
  LaneFloat t;
  LaneFloat weight_b, weight_c;  ///< that of a is the rest to 1
};

/// Replaces the lanes in `bits` by the result of cross_polygon; misses get a negative t.
[[gnu::noinline, gnu::cold]] inline void refine_lanes(const TriangleBlock& block, const Ray& ray,
                                                      unsigned bits, TriangleHits& hits) {
  while (bits != 0) {
    const int lane = take_lowest(bits);
    const PolygonCrossing crossing =
        cross_polygon<3>([&](int axis, int vertex) { return block.corners[axis][vertex][lane]; }, ray);
    hits.t[lane] = crossing.float_t();
    hits.weight_b[lane] = static_cast<float>(crossing.weight_middle);
    hits.weight_c[lane] = static_cast<float>(crossing.weight_c);
  }
}

/// Lanes whose distance the vector formula does not settle: an edge function is zero, or the corners lie on
/// both sides of the origin and the depth is smaller than its error.
MLT_INLINE LaneInt unsure_lanes(const ShearedTriangles& s, LaneInt inside, LaneFloat depth) {
  const LaneFloat zero{};
  const LaneInt sure = (s.smallest() > zero) | (s.largest() < zero);
  const LaneInt before = min_lanes(min_lanes(s.t_a, s.t_b), s.t_c) > zero;
  const LaneInt behind = max_lanes(max_lanes(s.t_a, s.t_b), s.t_c) <= zero;
  const LaneInt unsure = inside & ~(sure & (before | behind));
  if (lane_bits(unsure) == 0) return unsure;
  const LaneFloat error =
      (largest_magnitude(s.x[0], s.x[1], s.x[2]) * largest_magnitude(s.y[0], s.y[1], s.y[2])) *
      (largest_magnitude(s.t_a, s.t_b, s.t_c) * kDepthError);
  return unsure & ~(sure & (abs_lanes(depth) > error));
}

/// Lanes whose triangle the ray meets at 0 < t <= limit, as bits; `hits` is meaningful in those lanes.
MLT_INLINE unsigned intersect_block(const TriangleBlock& block, const RayFrame& ray, LaneFloat limit,
                                    TriangleHits& hits) {
  const LaneFloat zero{};
  // Looked up after a hit, from a cache line of their own.
  __builtin_prefetch(block.primitive);
  const ShearedTriangles s(block, ray.shear);
  // Zero edge functions count for either side here.
  const LaneInt inside = (s.smallest() >= zero) | (s.largest() <= zero);
  if (lane_bits(inside) == 0) return 0;

  const LaneFloat depth = (s.bc * s.t_a + s.ca * s.t_b) + s.ab * s.t_c;
  const LaneFloat scale = broadcast(1.0f) / ((s.bc + s.ca) + s.ab);
  hits = {depth * scale, s.ca * scale, s.ab * scale};
  if (const unsigned bits = lane_bits(unsure_lanes(s, inside, depth)); bits != 0) {
    TriangleHits refined = hits;
    refine_lanes(block, *ray.ray, bits, refined);
    hits = refined;
  }
  const LaneInt ahead = inside & (hits.t > zero) & (hits.t <= limit);
  if (lane_bits(ahead) == 0) return 0;
  // The order of the arguments keeps a t that is NaN.
  hits.t = max_lanes(box_entry(block, ray), hits.t);
  return lane_bits(ahead & (hits.t <= limit));
}

}  // namespace mlt
