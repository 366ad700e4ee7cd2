// Ray against spheres, in SIMD blocks. The discriminant is taken from the vector between the centre and the
// ray's nearest point, and the roots from the sum without cancellation [Haines19].
//
// With f = origin - centre the computed nearest point is off by at most 12u|f|: 4u|f| each for the dot
// product and the squared length of the direction, u|f| each for quotient, product, difference and sum.
// Comparing squares adds 3u radius. An accepted ray therefore passes within 26uM of the sphere (|f| <=
// sqrt(3) M, M as in ray_frame.hpp), which the padding of boxes covers together with the 6uM of their own
// test.
#pragma once

#include <cstdint>

#include "geometry/ray_frame.hpp"

namespace mlt {

/// kLanes spheres. An unused lane holds NaN, which no test accepts.
struct alignas(sizeof(LaneFloat)) SphereBlock {
  LaneFloat center[3];
  LaneFloat radius;
  std::uint32_t primitive[kLanes];
};

/// Where the ray enters the padded bounding box of each sphere.
MLT_INLINE LaneFloat box_entry(const SphereBlock& block, const RayFrame& ray) {
  LaneFloat entry{};
#pragma GCC unroll 4
  for (int axis = 0; axis < 3; ++axis) {
    const LaneFloat low = (block.center[axis] - block.radius) - ray.near_origin[axis];
    const LaneFloat high = (block.center[axis] + block.radius) - ray.near_origin[axis];
    entry = max_lanes(entry, min_lanes(low * ray.inverse[axis], high * ray.inverse[axis]));
  }
  return entry;
}

struct SphereHits {
  LaneFloat t;
};

/// Lanes whose sphere the ray meets at 0 < t <= limit, as bits; `hits` is meaningful in those lanes. The
/// entry point counts, or the exit point for a ray that starts inside.
MLT_INLINE unsigned intersect_block(const SphereBlock& block, const RayFrame& ray, LaneFloat limit,
                                    SphereHits& hits) {
  const LaneFloat zero{};
  const LaneFloat fx = ray.origin[0] - block.center[0];
  const LaneFloat fy = ray.origin[1] - block.center[1];
  const LaneFloat fz = ray.origin[2] - block.center[2];
  const LaneFloat* d = ray.direction;
  const LaneFloat squared_length = (d[0] * d[0] + d[1] * d[1]) + d[2] * d[2];
  const LaneFloat projection = -((fx * d[0] + fy * d[1]) + fz * d[2]);
  const LaneFloat middle = projection / squared_length;
  const LaneFloat nx = fx + middle * d[0];
  const LaneFloat ny = fy + middle * d[1];
  const LaneFloat nz = fz + middle * d[2];
  const LaneFloat squared_radius = block.radius * block.radius;
  const LaneFloat discriminant = squared_radius - ((nx * nx + ny * ny) + nz * nz);
  const LaneInt met = discriminant >= zero;
  if (lane_bits(met) == 0) return 0;

  const LaneFloat root = sqrt_lanes(max_lanes(squared_length * discriminant, zero));
  const LaneFloat signed_root =
      floats_of(bits_of(root) | (bits_of(projection) & static_cast<std::int32_t>(0x80000000U)));
  const LaneFloat sum = projection + signed_root;
  const LaneFloat power = ((fx * fx + fy * fy) + fz * fz) - squared_radius;  // negative inside the sphere
  const LaneFloat first = power / sum;
  const LaneFloat t = select(first > zero, first, sum / squared_length);
  const LaneInt ahead = met & (t > zero) & (t <= limit);
  if (lane_bits(ahead) == 0) return 0;
  hits.t = max_lanes(box_entry(block, ray), t);
  return lane_bits(ahead & (hits.t <= limit));
}

}  // namespace mlt
