// Quads with their boxes, in blocks: lanes test the boxes, as those of a hierarchy, and the few quads whose
// boxes the ray enters are tested one by one, with a lane for each corner. A triangle a, b, c fits in as the
// quad a, b, c, a: its second half has no area, and the first gives the same bits as triangle_block.hpp.
#pragma once

#include <cstdint>

#include "geometry/bvh.hpp"
#include "geometry/polygon.hpp"

namespace mlt {

struct alignas(64) QuadRecord {
  float corners[3][4];  ///< by axis and vertex
  float normal[3];      ///< unit normal of the front
  std::uint32_t primitive;

  Vec3 corner(int vertex) const { return Vec3{corners[0][vertex], corners[1][vertex], corners[2][vertex]}; }
};

/// kLanes quads. An unused lane has a box of NaN, which no ray enters.
struct alignas(64) QuadBlock {
  LaneFloat planes[3][2];  ///< boxes by axis and side (0 low, 1 high)
  QuadRecord quads[kLanes];
};

struct QuadHit {
  float t;
  float weight_middle, weight_c;  ///< of the corners b or d, and c; that of a is the rest to 1
  bool second;                    ///< on triangle a, c, d
};

/// The result of cross_polygon; whether it lies at t > 0.
[[gnu::noinline, gnu::cold]] inline bool refine_quad(const QuadRecord& quad, const Ray& ray, QuadHit& hit) {
  const PolygonCrossing crossing =
      cross_polygon<4>([&](int axis, int vertex) { return quad.corners[axis][vertex]; }, ray);
  hit = {crossing.float_t(), static_cast<float>(crossing.weight_middle),
         static_cast<float>(crossing.weight_c), crossing.middle == 3};
  return hit.t > 0.0f;
}

/// Largest absolute value of four.
MLT_INLINE float largest_magnitude(Float4 v) {
  const float low = std::fabs(v[0]) > std::fabs(v[1]) ? std::fabs(v[0]) : std::fabs(v[1]);
  const float high = std::fabs(v[2]) > std::fabs(v[3]) ? std::fabs(v[2]) : std::fabs(v[3]);
  return low > high ? low : high;
}

/// Whether the ray meets the quad at t > 0, before t is raised to where it enters the quad's box.
MLT_INLINE bool cross_quad(const QuadRecord& quad, const Ray& ray, const RayShear& shear, QuadHit& hit) {
  const Float4 z = load_float4(quad.corners[shear.axis_z]) - shear.origin_z;
  const Float4 x = (load_float4(quad.corners[shear.axis_x]) - shear.origin_x) - shear.shear_x * z;
  const Float4 y = (load_float4(quad.corners[shear.axis_y]) - shear.origin_y) - shear.shear_y * z;
  // ab, bc, cd, da.
  const Float4 edges = edge_function(x, y, __builtin_shufflevector(x, x, 1, 2, 3, 0),
                                     __builtin_shufflevector(y, y, 1, 2, 3, 0));
  // In lane 2 the function of ca, in lane 0 that of ac, and so on.
  const Float4 diagonals = edge_function(x, y, __builtin_shufflevector(x, x, 2, 3, 0, 1),
                                         __builtin_shufflevector(y, y, 2, 3, 0, 1));
  const float ca = diagonals[2];
  // With the sign of ca divided out, a point of triangle a, b, c has positive functions of ab and bc, a point
  // of triangle a, c, d negative ones of cd and da. Where ca is zero, its sign says nothing.
  constexpr std::int32_t kSign = static_cast<std::int32_t>(0x80000000U);
  const Int4 sign = std::bit_cast<Int4>(__builtin_shufflevector(diagonals, diagonals, 2, 2, 2, 2)) & kSign;
  const Float4 turned = std::bit_cast<Float4>(std::bit_cast<Int4>(edges) ^ sign);
  const Int4 above = turned > Float4{};
  const unsigned positive = lane_bits4(above);
  const unsigned negative = lane_bits4(turned < Float4{});
  const bool inclined = ca > 0.0f || ca < 0.0f;
  if (inclined && (negative & 3U) != 0 && (positive & 12U) != 0) return false;
  const bool first = (positive & 3U) == 3U;
  if (!inclined || !(first || (negative & 12U) == 12U)) return refine_quad(quad, ray, hit);

  // Lanes a, middle, c; which half it is cannot be predicted.
  const Int4 halves =
      __builtin_shufflevector(above, above, 0, 0, 0, 0) & __builtin_shufflevector(above, above, 1, 1, 1, 1);
  const Float4 distances = z * shear.inverse_z;
  const Float4 weights = select4(halves, __builtin_shufflevector(edges, diagonals, 1, 6, 0, 0),
                                 __builtin_shufflevector(edges, diagonals, 2, 4, 3, 3));
  const Float4 t = select4(halves, __builtin_shufflevector(distances, distances, 0, 1, 2, 2),
                           __builtin_shufflevector(distances, distances, 0, 3, 2, 2));
  const Float4 depths = weights * t;
  const float depth = (depths[0] + depths[1]) + depths[2];
  if (lane_bits4(t > Float4{}) != 15U) {
    if (lane_bits4(t <= Float4{}) == 15U) return false;
    const float error = (largest_magnitude(x) * largest_magnitude(y)) * (largest_magnitude(t) * kDepthError);
    if (!(std::fabs(depth) > error)) return refine_quad(quad, ray, hit);
  }
  const float scale = 1.0f / ((weights[0] + weights[1]) + weights[2]);
  const Float4 scaled = weights * scale;
  hit = {depth * scale, scaled[1], scaled[2], !first};
  return hit.t > 0.0f;
}

}  // namespace mlt
