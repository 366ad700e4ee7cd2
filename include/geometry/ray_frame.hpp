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

#include <bit>
#include <cstddef>
#include <cstring>
#include <limits>

#include "geometry/ray.hpp"
#include "math/simd.hpp"

namespace mlt {

inline constexpr float kBoxPadding = 0x1p-19f;  ///< of M above
/// A direction component smaller than this part of the largest one counts as this part.
inline constexpr float kSmallestSlope = 0x1p-30f;

/// Origin and direction in lanes, and their sizes. Fourth lanes mean nothing.
struct RayLanes {
  Float4 origin, direction;
  Float4 size;     ///< |direction|
  Float4 longest;  ///< its largest component
  float distance;  ///< largest component of |origin|

  MLT_INLINE explicit RayLanes(const Ray& ray) {
    static_assert(offsetof(Ray, direction) + sizeof(Float4) <= sizeof(Ray));
    const auto* bytes = reinterpret_cast<const std::byte*>(&ray);
    std::memcpy(&origin, bytes + offsetof(Ray, origin), sizeof(Float4));
    std::memcpy(&direction, bytes + offsetof(Ray, direction), sizeof(Float4));
    constexpr std::int32_t kMagnitude = 0x7fffffff;
    size = std::bit_cast<Float4>(std::bit_cast<Int4>(direction) & kMagnitude);
    longest = largest_of_3(size);
    distance = largest_of_3(std::bit_cast<Float4>(std::bit_cast<Int4>(origin) & kMagnitude))[0];
  }

  /// In lanes 0 to 2.
  MLT_INLINE static Float4 largest_of_3(Float4 v) {
    return max4(max4(v, __builtin_shufflevector(v, v, 1, 2, 0, 3)),
                __builtin_shufflevector(v, v, 2, 0, 1, 3));
  }
};

/// The sheared frame of a ray in scalars.
struct RayShear {
  MLT_INLINE explicit RayShear(const Ray& ray) : RayShear(ray, RayLanes(ray)) {}
  MLT_INLINE RayShear(const Ray& ray, const RayLanes& lanes);

  int axis_x, axis_y, axis_z;          ///< z: the direction's largest component; x and y follow it cyclically
  float origin_x, origin_y, origin_z;  ///< in this order of axes
  float shear_x, shear_y;              ///< direction x/z and y/z
  float inverse_z;                     ///< 1 / direction z: depth times this is t
};

MLT_INLINE RayShear::RayShear(const Ray& ray, const RayLanes& lanes) {
  // The first of the largest components, without branches, as rays differ too much in it for one to be
  // predicted. The last where there is none, for NaN.
  axis_z = std::countr_zero(lane_bits4(lanes.size == lanes.longest) | 4U);
  axis_x = 0b001001 >> (2 * axis_z) & 3;
  axis_y = 0b010010 >> (2 * axis_z) & 3;
  const float* const origin = &ray.origin.x;
  const float* const direction = &ray.direction.x;
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

/// Slabs: the distance to a plane that a box is entered by is (plane - near_origin) * inverse.
struct RaySlabs {
  Float4 near_origin, far_origin, inverse;
  Int4 backwards;  ///< all ones where a box is entered by its high plane

  MLT_INLINE RaySlabs(const RayLanes& ray, float extent) {
    constexpr std::int32_t kSign = static_cast<std::int32_t>(0x80000000U);
    const Float4 padding = broadcast4((ray.distance + extent) * kBoxPadding);
    // The smallest normal number keeps reciprocals finite, even for a direction of 0.
    const Float4 smallest = ray.longest * kSmallestSlope + std::numeric_limits<float>::min();
    const Int4 signs = std::bit_cast<Int4>(ray.direction) & kSign;
    inverse = 1.0f / std::bit_cast<Float4>(std::bit_cast<Int4>(max4(ray.size, smallest)) | signs);
    const Float4 signed_padding = std::bit_cast<Float4>(std::bit_cast<Int4>(padding) | signs);
    near_origin = ray.origin + signed_padding;
    far_origin = ray.origin - signed_padding;
    backwards = signs >> 31;
  }
};

/// All of a ray in lanes. Functions that take one are inlined, so that members without use cost nothing.
struct RayFrame {
  /// `extent` is the largest absolute coordinate of any primitive. `ray` must outlive the frame.
  MLT_INLINE RayFrame(const Ray& r, float extent) : RayFrame(r, RayLanes(r), extent) {}
  MLT_INLINE RayFrame(const Ray& ray, const RayLanes& lanes, float extent);

  const Ray* ray;
  RayShear shear;
  RaySlabs slabs;

  LaneFloat origin[3], direction[3];  ///< for spheres

  LaneFloat near_origin[3], far_origin[3], inverse[3];  ///< the slabs
  int near_side[3];  ///< 0 where a box is entered by its low plane, 1 by its high plane
};

MLT_INLINE RayFrame::RayFrame(const Ray& r, const RayLanes& lanes, float extent)
    : ray(&r), shear(r, lanes), slabs(lanes, extent) {
  const unsigned backwards = lane_bits4(slabs.backwards);
#pragma GCC unroll 4
  for (int axis = 0; axis < 3; ++axis) {
    origin[axis] = broadcast((&r.origin.x)[axis]);
    direction[axis] = broadcast((&r.direction.x)[axis]);
    near_origin[axis] = broadcast(slabs.near_origin[axis]);
    far_origin[axis] = broadcast(slabs.far_origin[axis]);
    inverse[axis] = broadcast(slabs.inverse[axis]);
    near_side[axis] = static_cast<int>(backwards >> axis & 1U);
  }
}

}  // namespace mlt
