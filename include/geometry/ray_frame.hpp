// What a ray needs besides its origin and direction, computed once before it meets any primitive: the shear
// that lays it along an axis, for polygons [Woop13], and the padded slabs, for boxes.
//
// Conservative boxes. Let u = 2^-24 and M = extent + max |origin|, which bounds every |vertex - origin|.
// Polygons are tested with vertices whose sheared coordinates are off by at most 6uM: u|A_x| for the
// difference, 3u|A_z| for slope and product, u(|A_x| + |A_z|) for the last difference. That test is otherwise
// exact, so an accepted ray passes within 6uM of a point of the true polygon, at the depth t of that point.
// The slab test in turn errs by uM in the padded origin, uM in the difference, uM each in reciprocal and
// product, and 2^-29 M where a direction component is replaced by a larger one. A padding of 12uM therefore
// lets every box of an accepted polygon pass, at an entry distance <= t. Spheres err by at most 26uM (see
// sphere.hpp). The padding used is 32uM = 2^-19 M ([Ize13] pads distances instead).
#pragma once

#include <cmath>
#include <limits>

#include "geometry/ray.hpp"
#include "math/simd.hpp"

namespace mlt {

inline constexpr float kBoxPadding = 0x1p-19f;  ///< of M above
/// A direction component smaller than this part of the largest one counts as this part.
inline constexpr float kSmallestSlope = 0x1p-30f;

/// The sheared frame of a ray in scalars.
struct RayShear {
  explicit RayShear(const Ray& ray);

  int axis_x, axis_y, axis_z;          ///< z: the direction's largest component; x and y follow it cyclically
  float origin_x, origin_y, origin_z;  ///< in this order of axes
  float shear_x, shear_y;              ///< direction x/z and y/z
  float inverse_z;                     ///< 1 / direction z: depth times this is t
};

MLT_INLINE RayShear::RayShear(const Ray& ray) {
  const float origin[3] = {ray.origin.x, ray.origin.y, ray.origin.z};
  const float direction[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
  const Vec3 size{std::fabs(direction[0]), std::fabs(direction[1]), std::fabs(direction[2])};
  // The first of the largest components, looked up by three comparisons: two bits for each outcome. Rays
  // differ too much in it for a branch to be predicted.
  const unsigned order =
      (size.y > size.x ? 1U : 0U) | (size.z > size.x ? 2U : 0U) | (size.z > size.y ? 4U : 0U);
  constexpr unsigned kLargest =
      0U << 0 | 1U << 2 | 2U << 4 | 1U << 6 | 0U << 8 | 2U << 10 | 2U << 12 | 2U << 14;
  axis_z = static_cast<int>(kLargest >> (2U * order) & 3U);
  axis_x = axis_z == 2 ? 0 : axis_z + 1;
  axis_y = axis_x == 2 ? 0 : axis_x + 1;
  origin_x = origin[axis_x];
  origin_y = origin[axis_y];
  origin_z = origin[axis_z];
  // One division of lanes. A direction of 0 makes the shear NaN, which no test accepts; for scalars that
  // division would be undefined behaviour.
  const Float4 quotients =
      Float4{direction[axis_x], direction[axis_y], 1.0f, 1.0f} / broadcast4(direction[axis_z]);
  shear_x = quotients[0];
  shear_y = quotients[1];
  inverse_z = quotients[2];
}

/// All of a ray in lanes. Functions that take one are inlined, so that members without use cost nothing.
struct RayFrame {
  /// `extent` is the largest absolute coordinate of any primitive. `ray` must outlive the frame.
  RayFrame(const Ray& ray, float extent);

  const Ray* ray;
  RayShear shear;

  LaneFloat origin[3], direction[3];  ///< for spheres

  // Slabs: the distance to a plane that a box is entered by is (plane - near_origin) * inverse.
  LaneFloat near_origin[3], far_origin[3], inverse[3];
  int near_side[3];  ///< 0 where a box is entered by its low plane, 1 by its high plane
};

MLT_INLINE RayFrame::RayFrame(const Ray& r, float extent) : ray(&r), shear(r) {
  constexpr std::int32_t kSign = static_cast<std::int32_t>(0x80000000U);
  const Float4 at{r.origin.x, r.origin.y, r.origin.z, 0.0f};
  const Float4 along{r.direction.x, r.direction.y, r.direction.z, 1.0f};
  const Vec3 sizes{std::fabs(along[0]), std::fabs(along[1]), std::fabs(along[2])};
  const Vec3 distances{std::fabs(at[0]), std::fabs(at[1]), std::fabs(at[2])};
  const float padding = (max_component(distances) + extent) * kBoxPadding;
  // The smallest normal number keeps reciprocals finite, even for a direction of 0.
  const float smallest = max_component(sizes) * kSmallestSlope + std::numeric_limits<float>::min();
  const Int4 signs = std::bit_cast<Int4>(along) & kSign;
  const unsigned backwards = lane_bits4(signs);
  const Float4 slope = max4(std::bit_cast<Float4>(std::bit_cast<Int4>(along) & ~kSign), broadcast4(smallest));
  const Float4 reciprocal = 1.0f / std::bit_cast<Float4>(std::bit_cast<Int4>(slope) | signs);
  const Float4 signed_padding = std::bit_cast<Float4>(std::bit_cast<Int4>(broadcast4(padding)) | signs);
  const Float4 near_at = at + signed_padding;
  const Float4 far_at = at - signed_padding;
#pragma GCC unroll 4
  for (int axis = 0; axis < 3; ++axis) {
    origin[axis] = broadcast(at[axis]);
    direction[axis] = broadcast(along[axis]);
    near_origin[axis] = broadcast(near_at[axis]);
    far_origin[axis] = broadcast(far_at[axis]);
    inverse[axis] = broadcast(reciprocal[axis]);
    near_side[axis] = static_cast<int>(backwards >> axis & 1U);
  }
}

}  // namespace mlt
