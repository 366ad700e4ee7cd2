// The one polygon test: watertight ray against triangle or quad [Woop13], in SIMD blocks.
//
// Vertices are moved into the ray's sheared frame, where the ray is the z axis, and edge functions there say
// on which side of each edge the ray passes. A vertex or edge shared by two polygons gives both the same
// bits, so no ray slips between them. A quad a, b, c, d is the union of the triangles a, b, c and a, c, d.
//
// A computed edge function ab - cd has the right sign, or is zero: rounding is monotone. So where all that
// matter are nonzero, inside and outside are exact. Where one is zero, the signs are taken in double, which
// holds the products of floats exactly; zero then means truly on the edge, and counts as inside.
//
// The hit distance is a mean of the vertices' distances, weighted by edge functions of one sign, so it lies
// among them. Where they lie before and behind the origin and the mean is smaller than its rounding error, it
// is computed in double, so that its sign is right for the sheared vertices. A ray that leaves a polygon from
// an origin as far off as SurfacePoint::offset_bound therefore never meets that polygon again.
//
// Last, t is raised to where the ray enters the polygon's own padded box, computed as for the boxes of a
// hierarchy: their entry distances are then <= t by monotonicity, whatever the rounding error of t, and a
// traversal that skips boxes entered beyond the best t finds what brute force finds.
#pragma once

#include <cstdint>

#include "geometry/ray_frame.hpp"

namespace mlt {

/// Unit normals of quads are stored: there are few, and hits on them are many. Triangles go without.
template <int kVertices>
struct BlockNormals {};
template <>
struct BlockNormals<4> {
  LaneFloat axis[3];
};

/// kLanes polygons of 3 or 4 vertices. An unused lane holds NaN, which no test accepts.
template <int kVertices>
struct alignas(sizeof(LaneFloat)) PolygonBlock {
  static_assert(kVertices == 3 || kVertices == 4);
  LaneFloat corners[3][kVertices];  ///< by axis and vertex
  [[no_unique_address]] BlockNormals<kVertices> normals;
  std::uint32_t primitive[kLanes];

  Vec3 corner(int vertex, int lane) const {
    return Vec3{corners[0][vertex][lane], corners[1][vertex][lane], corners[2][vertex][lane]};
  }
};

/// Where the ray meets one polygon: t, and the weights of the corners a, c and `middle`, which sum to 1.
struct PolygonCrossing {
  bool inside = false;
  int middle = 1;  ///< 1: triangle a, b, c; 3: triangle a, c, d
  double weight_middle = 0, weight_c = 0;
  double t = 0;
};

/// Twice the signed area of the triangle (origin, p, q). Swapping p and q changes the sign and no other bit.
template <class T>
MLT_INLINE T edge_function(T px, T py, T qx, T qy) {
  return px * qy - py * qx;
}

/// The test for one lane in double, on the sheared float vertices; exact signs.
template <int kVertices>
PolygonCrossing cross_polygon(const PolygonBlock<kVertices>& block, int lane, const Ray& ray) {
  const RayShear shear(ray);
  double x[kVertices], y[kVertices], z[kVertices];
  for (int i = 0; i < kVertices; ++i) {
    // In float as in the vector test, so that both see the same sheared vertices.
    const float depth = block.corners[shear.axis_z][i][lane] - shear.origin_z;
    x[i] = (block.corners[shear.axis_x][i][lane] - shear.origin_x) - shear.shear_x * depth;
    y[i] = (block.corners[shear.axis_y][i][lane] - shear.origin_y) - shear.shear_y * depth;
    z[i] = depth;
  }
  PolygonCrossing crossing;
  const double ca = edge_function(x[2], y[2], x[0], y[0]);
  for (int middle = 1; middle < kVertices; middle += 2) {
    const double sign = middle == 1 ? 1.0 : -1.0;
    const double weight_a = sign * edge_function(x[middle], y[middle], x[2], y[2]);
    const double weight_middle = sign * ca;
    const double weight_c = sign * edge_function(x[0], y[0], x[middle], y[middle]);
    const bool none_negative = weight_a >= 0 && weight_middle >= 0 && weight_c >= 0;
    const bool none_positive = weight_a <= 0 && weight_middle <= 0 && weight_c <= 0;
    const double sum = (weight_a + weight_middle) + weight_c;
    if (!(none_negative || none_positive) || sum == 0) continue;
    const double depth = (weight_a * z[0] + weight_middle * z[middle]) + weight_c * z[2];
    crossing.inside = true;
    crossing.middle = middle;
    crossing.weight_middle = weight_middle / sum;
    crossing.weight_c = weight_c / sum;
    crossing.t = depth / sum * static_cast<double>(shear.inverse_z);
    break;
  }
  return crossing;
}

/// The corners of a block in the ray's frame: sheared x and y, and the depth along the permuted z axis.
template <int kVertices>
struct ShearedBlock {
  LaneFloat x[kVertices], y[kVertices], z[kVertices];

  MLT_INLINE ShearedBlock(const PolygonBlock<kVertices>& block, const RayFrame& ray) {
    const LaneFloat* corner_x = block.corners[ray.axis_x];
    const LaneFloat* corner_y = block.corners[ray.axis_y];
    const LaneFloat* corner_z = block.corners[ray.axis_z];
#pragma GCC unroll 4
    for (int i = 0; i < kVertices; ++i) {
      z[i] = corner_z[i] - ray.origin_z;
      x[i] = (corner_x[i] - ray.origin_x) - ray.shear_x * z[i];
      y[i] = (corner_y[i] - ray.origin_y) - ray.shear_y * z[i];
    }
  }

  MLT_INLINE LaneFloat edge(int p, int q) const {
    return edge_function(x[p], y[p], x[q], y[q]);
  }
};

/// Edge functions of one block, and the lanes that they do not exclude.
template <int kVertices>
struct BlockEdges;

template <>
struct BlockEdges<3> {
  LaneFloat ab, bc, ca;

  MLT_INLINE explicit BlockEdges(const ShearedBlock<3>& s)
      : ab(s.edge(0, 1)), bc(s.edge(1, 2)), ca(s.edge(2, 0)) {}

  /// Zero edge functions count for either side here.
  MLT_INLINE LaneInt maybe_inside() const {
    const LaneFloat zero{};
    return (smallest() >= zero) | (largest() <= zero);
  }
  MLT_INLINE LaneInt surely_inside() const {
    const LaneFloat zero{};
    return (smallest() > zero) | (largest() < zero);
  }
  MLT_INLINE LaneFloat smallest() const { return min_lanes(min_lanes(ab, bc), ca); }
  MLT_INLINE LaneFloat largest() const { return max_lanes(max_lanes(ab, bc), ca); }
};

template <>
struct BlockEdges<4> {
  LaneFloat ab, bc, ca, cd, da;

  MLT_INLINE explicit BlockEdges(const ShearedBlock<4>& s)
      : ab(s.edge(0, 1)), bc(s.edge(1, 2)), ca(s.edge(2, 0)), cd(s.edge(2, 3)), da(s.edge(3, 0)) {}

  /// With the sign of ca divided out, a point of triangle a, b, c has positive functions of ab and bc, a
  /// point of triangle a, c, d negative ones of cd and da. Where ca is zero, its sign says nothing.
  MLT_INLINE LaneInt maybe_inside() const {
    const LaneFloat zero{};
    const LaneInt sign = sign_of_ca();
    const LaneFloat first = min_lanes(floats_of(bits_of(ab) ^ sign), floats_of(bits_of(bc) ^ sign));
    const LaneFloat second = max_lanes(floats_of(bits_of(cd) ^ sign), floats_of(bits_of(da) ^ sign));
    return (first >= zero) | (second <= zero) | (ca == zero);
  }
  /// Strictly inside triangle a, b, c.
  MLT_INLINE LaneInt surely_in_first() const {
    const LaneInt sign = sign_of_ca();
    const LaneFloat zero{};
    return (min_lanes(floats_of(bits_of(ab) ^ sign), floats_of(bits_of(bc) ^ sign)) > zero) & (ca != zero);
  }
  /// Strictly inside triangle a, c, d.
  MLT_INLINE LaneInt surely_in_second() const {
    const LaneInt sign = sign_of_ca();
    const LaneFloat zero{};
    return (max_lanes(floats_of(bits_of(cd) ^ sign), floats_of(bits_of(da) ^ sign)) < zero) & (ca != zero);
  }
  MLT_INLINE LaneInt sign_of_ca() const { return bits_of(ca) & static_cast<std::int32_t>(0x80000000U); }
};

/// The triangle of each lane that the ray meets: depths in units of t, sheared corners, weights.
struct MetTriangles {
  LaneFloat t_a, t_middle, t_c;
  LaneFloat weight_a, weight_middle, weight_c;
  LaneInt second;  ///< lanes where it is the triangle a, c, d
  LaneInt sure;    ///< lanes strictly inside
};

MLT_INLINE MetTriangles met_triangles(const ShearedBlock<3>& s, const BlockEdges<3>& edges,
                                      const RayFrame& ray) {
  return {s.z[0] * ray.inverse_z,
          s.z[1] * ray.inverse_z,
          s.z[2] * ray.inverse_z,
          edges.bc,
          edges.ca,
          edges.ab,
          LaneInt{},
          edges.surely_inside()};
}

MLT_INLINE MetTriangles met_triangles(const ShearedBlock<4>& s, const BlockEdges<4>& edges,
                                      const RayFrame& ray) {
  const LaneInt first = edges.surely_in_first();
  return {s.z[0] * ray.inverse_z,
          select(first, s.z[1], s.z[3]) * ray.inverse_z,
          s.z[2] * ray.inverse_z,
          select(first, edges.bc, edges.cd),
          select(first, edges.ca, -edges.ca),
          select(first, edges.ab, edges.da),
          ~first,
          first | edges.surely_in_second()};
}

/// Largest absolute value among the corners, per lane.
template <int kVertices>
MLT_INLINE LaneFloat largest_magnitude(const LaneFloat (&values)[kVertices]) {
  LaneFloat largest = abs_lanes(values[0]);
#pragma GCC unroll 4
  for (int i = 1; i < kVertices; ++i) largest = max_lanes(largest, abs_lanes(values[i]));
  return largest;
}

/// Where the ray enters the padded bounding box of each polygon. The entry of the nearest corner is that of
/// the box, since rounding is monotone.
template <int kVertices>
MLT_INLINE LaneFloat box_entry(const PolygonBlock<kVertices>& block, const RayFrame& ray) {
  LaneFloat entry{};
#pragma GCC unroll 4
  for (int axis = 0; axis < 3; ++axis) {
    LaneFloat nearest = (block.corners[axis][0] - ray.near_origin[axis]) * ray.inverse[axis];
#pragma GCC unroll 4
    for (int i = 1; i < kVertices; ++i) {
      nearest = min_lanes(nearest, (block.corners[axis][i] - ray.near_origin[axis]) * ray.inverse[axis]);
    }
    entry = max_lanes(entry, nearest);
  }
  return entry;
}

/// Where the ray meets the polygons of a block, by lane.
struct PolygonHits {
  LaneFloat t;
  LaneFloat weight_middle, weight_c;  ///< of the corners b or d, and c; that of a is the rest to 1
  LaneInt second;                     ///< lanes that lie in triangle a, c, d
};

/// Replaces the lanes in `bits` by the result of cross_polygon; misses get a negative t.
template <int kVertices>
[[gnu::noinline, gnu::cold]] void refine_lanes(const PolygonBlock<kVertices>& block, const Ray& ray,
                                               unsigned bits, PolygonHits& hits) {
  while (bits != 0) {
    const int lane = take_lowest(bits);
    const PolygonCrossing crossing = cross_polygon(block, lane, ray);
    // Only distances that a float can hold; the comparisons also reject NaN.
    const bool representable = crossing.inside && crossing.t > 0.0 && crossing.t < 3e38;
    hits.t[lane] = representable ? static_cast<float>(crossing.t) : -1.0f;
    hits.weight_middle[lane] = static_cast<float>(crossing.weight_middle);
    hits.weight_c[lane] = static_cast<float>(crossing.weight_c);
    hits.second[lane] = crossing.middle == 3 ? -1 : 0;
  }
}

/// Lanes whose distance the vector formula does not settle: an edge function is zero, or the corners lie on
/// both sides of the origin and the depth is smaller than its error.
template <int kVertices>
MLT_INLINE LaneInt unsure_lanes(const ShearedBlock<kVertices>& sheared, const MetTriangles& met,
                                LaneInt inside, LaneFloat depth) {
  const LaneFloat zero{};
  const LaneInt before = min_lanes(min_lanes(met.t_a, met.t_middle), met.t_c) > zero;
  const LaneInt behind = max_lanes(max_lanes(met.t_a, met.t_middle), met.t_c) <= zero;
  const LaneInt unsure = inside & ~(met.sure & (before | behind));
  if (lane_bits(unsure) == 0) return unsure;
  // With Q = max|x| max|y|, weights are at most 2Q and off by 4uQ, so three products and two sums are off by
  // 34u Q max|t|; an exact depth has the same sign when it is larger.
  const LaneFloat reach =
      max_lanes(max_lanes(abs_lanes(met.t_a), abs_lanes(met.t_middle)), abs_lanes(met.t_c));
  const LaneFloat error =
      (largest_magnitude(sheared.x) * largest_magnitude(sheared.y)) * (reach * (40 * 0x1p-24f));
  return unsure & ~(met.sure & (abs_lanes(depth) > error));
}

/// Lanes whose polygon the ray meets at 0 < t <= limit, as bits; `hits` is meaningful in those lanes.
template <int kVertices>
MLT_INLINE unsigned intersect_block(const PolygonBlock<kVertices>& block, const RayFrame& ray,
                                    LaneFloat limit, PolygonHits& hits) {
  const ShearedBlock<kVertices> sheared(block, ray);
  const BlockEdges<kVertices> edges(sheared);
  const LaneInt inside = edges.maybe_inside();
  if (lane_bits(inside) == 0) return 0;

  const MetTriangles met = met_triangles(sheared, edges, ray);
  const LaneFloat depth =
      (met.weight_a * met.t_a + met.weight_middle * met.t_middle) + met.weight_c * met.t_c;
  const LaneFloat scale = broadcast(1.0f) / ((met.weight_a + met.weight_middle) + met.weight_c);
  hits = {depth * scale, met.weight_middle * scale, met.weight_c * scale, met.second};
  if (const unsigned bits = lane_bits(unsure_lanes(sheared, met, inside, depth)); bits != 0) {
    PolygonHits refined = hits;
    refine_lanes(block, *ray.ray, bits, refined);
    hits = refined;
  }
  const LaneInt ahead = inside & (hits.t > LaneFloat{}) & (hits.t <= limit);
  if (lane_bits(ahead) == 0) return 0;
  // The order of the arguments keeps a t that is NaN.
  hits.t = max_lanes(box_entry(block, ray), hits.t);
  return lane_bits(ahead & (hits.t <= limit));
}

}  // namespace mlt
