// The one polygon test: watertight ray against triangle or quad [Woop13]. triangle_block.hpp and
// quad_block.hpp do in float lanes what is here in double.
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

#include "geometry/ray_frame.hpp"

namespace mlt {

/// Where the ray meets one polygon: t, and the weights of the corners a, c and `middle`, which sum to 1.
struct PolygonCrossing {
  bool inside = false;
  int middle = 1;  ///< 1: triangle a, b, c; 3: triangle a, c, d
  double weight_middle = 0, weight_c = 0;
  double t = 0;

  /// t where it is one that a float can hold, else -1; the comparisons also reject NaN.
  float float_t() const { return inside && t > 0.0 && t < 3e38 ? static_cast<float>(t) : -1.0f; }
};

/// Twice the signed area of the triangle (origin, p, q). Swapping p and q changes the sign and no other bit.
template <class T>
MLT_INLINE T edge_function(T px, T py, T qx, T qy) {
  return px * qy - py * qx;
}

/// The test for one polygon in double, on the sheared float vertices; exact signs.
/// `corner(axis, vertex)` are the coordinates.
template <int kVertices, class CornerOf>
PolygonCrossing cross_polygon(const CornerOf& corner, const Ray& ray) {
  const RayShear shear(ray);
  double x[kVertices], y[kVertices], z[kVertices];
  for (int i = 0; i < kVertices; ++i) {
    // In float as in the vector test, so that both see the same sheared vertices.
    const float depth = corner(shear.axis_z, i) - shear.origin_z;
    x[i] = (corner(shear.axis_x, i) - shear.origin_x) - shear.shear_x * depth;
    y[i] = (corner(shear.axis_y, i) - shear.origin_y) - shear.shear_y * depth;
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

/// With Q = max|x| max|y| over the sheared corners, weights are at most 2Q and off by 4uQ, so the depth,
/// three products and two sums, is off by 34u Q max|t|. One that is larger than this part of Q max|t| has the
/// sign of the exact depth.
inline constexpr float kDepthError = 40 * 0x1p-24f;

}  // namespace mlt
