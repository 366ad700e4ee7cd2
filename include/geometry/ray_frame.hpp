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
// sphere.hpp). The padding used is 32uM = 2^-19 M [Ize13 pads the distances instead].
#pragma once

#include <cmath>

#include "geometry/ray.hpp"
#include "geometry/simd.hpp"

namespace mlt {

inline constexpr float kBoxPadding = 0x1p-19f;  ///< of M above
/// A direction component smaller than this part of the largest one counts as this part.
inline constexpr float kSmallestSlope = 0x1p-30f;

struct RayFrame {
  /// `extent` is the largest absolute coordinate of any primitive.
  RayFrame(const Ray& ray, float extent);

  // The ray's largest direction component is axis_z; permuted coordinates are (axis_x, axis_y, axis_z).
  int axis_x, axis_y, axis_z;
  LaneFloat origin_x, origin_y, origin_z;  ///< permuted
  LaneFloat shear_x, shear_y;              ///< direction x/z and y/z
  LaneFloat inverse_z;                     ///< 1 / direction z: depth times this is t

  LaneFloat natural_origin[3], direction[3];  ///< unpermuted, for spheres

  // Slabs by unpermuted axis: the distance to a plane that a box is entered by is (plane - near_origin) *
  // inverse.
  LaneFloat near_origin[3], far_origin[3], inverse[3];
  int near_side[3];  ///< 0 where the box is entered by its low plane, 1 by its high plane
};

MLT_INLINE RayFrame::RayFrame(const Ray& ray, float extent) {
  const float origin[3] = {ray.origin.x, ray.origin.y, ray.origin.z};
  const float along[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
  const float size[3] = {std::fabs(along[0]), std::fabs(along[1]), std::fabs(along[2])};
  axis_z = size[1] > size[0] ? 1 : 0;
  axis_z = size[2] > size[axis_z] ? 2 : axis_z;
  axis_x = axis_z == 2 ? 0 : axis_z + 1;
  axis_y = axis_x == 2 ? 0 : axis_x + 1;
  origin_x = broadcast(origin[axis_x]);
  origin_y = broadcast(origin[axis_y]);
  origin_z = broadcast(origin[axis_z]);
  shear_x = broadcast(along[axis_x] / along[axis_z]);
  shear_y = broadcast(along[axis_y] / along[axis_z]);
  inverse_z = broadcast(1.0f / along[axis_z]);

  float reach = std::fabs(origin[0]);
  reach = std::fabs(origin[1]) > reach ? std::fabs(origin[1]) : reach;
  reach = std::fabs(origin[2]) > reach ? std::fabs(origin[2]) : reach;
  const float padding = (reach + extent) * kBoxPadding;
  const float smallest = size[axis_z] * kSmallestSlope;
#pragma GCC unroll 4
  for (int axis = 0; axis < 3; ++axis) {
    natural_origin[axis] = broadcast(origin[axis]);
    direction[axis] = broadcast(along[axis]);
    const float slope = size[axis] > smallest ? size[axis] : smallest;
    const float signed_padding = std::copysign(padding, along[axis]);
    near_origin[axis] = broadcast(origin[axis] + signed_padding);
    far_origin[axis] = broadcast(origin[axis] - signed_padding);
    inverse[axis] = broadcast(1.0f / std::copysign(slope, along[axis]));
    near_side[axis] = std::signbit(along[axis]) ? 1 : 0;
  }
}

}  // namespace mlt
