// The test that defines hits, for as many rays as there are lanes, each with a polygon of its own out of a
// flat list: the bits that one ray gets alone (quad_block.hpp). Where it needs more precision it leaves
// doubt.
#pragma once

#include <cstddef>
#include <limits>

#include "geometry/flat_list.hpp"
#include "math/gather.hpp"

namespace mlt {

/// RayLanes, RayShear and RaySlabs (ray_frame.hpp) of many rays.
template <class F>
struct WideRayFrame {
  const RayOf<F>& ray;
  Vec3Of<F> size;  ///< |direction|
  F longest;       ///< its largest component
  F distance;      ///< largest component of |origin|

  MLT_INLINE explicit WideRayFrame(const RayOf<F>& r)
      : ray(r),
        size(magnitudes(r.direction)),
        longest(largest(size)),
        distance(largest(magnitudes(r.origin))) {}

  MLT_INLINE static Vec3Of<F> magnitudes(const Vec3Of<F>& v) {
    return {magnitude(v.x), magnitude(v.y), magnitude(v.z)};
  }
  MLT_INLINE static F largest(const Vec3Of<F>& v) { return larger(larger(v.x, v.y), v.z); }
};

/// A vector's components in the order of a ray's sheared axes.
template <class F>
struct AxisOrder {
  MaskOf<F> is_x, is_y;  ///< the direction's first largest component; z where neither

  MLT_INLINE explicit AxisOrder(const WideRayFrame<F>& frame)
      : is_x(frame.size.x == frame.longest), is_y(not_in(is_x) & (frame.size.y == frame.longest)) {}

  template <class T>
  MLT_INLINE T first(const T& x, const T& y, const T& z) const {
    return select(is_x, y, select(is_y, z, x));
  }
  template <class T>
  MLT_INLINE T second(const T& x, const T& y, const T& z) const {
    return select(is_x, z, select(is_y, x, y));
  }
  template <class T>
  MLT_INLINE T last(const T& x, const T& y, const T& z) const {
    return select(is_x, x, select(is_y, y, z));
  }
};

/// Where each ray meets its polygon; as QuadHit.
template <class F>
struct WideQuadHit {
  F t;
  F weight_middle, weight_c;
  MaskOf<F> second;
  MaskOf<F> met;
  MaskOf<F> in_doubt;
};

/// Polygon slot[i] of `list` for lane i.
template <class F>
class PolygonRef {
 public:
  MLT_INLINE PolygonRef(const FlatList& list, UintOf<F> slot)
      : list_(list), slot_(slot), in_tables_(kHasTables<F> && list.slot_count() <= kTableSlots) {}

  /// The corners' coordinates along x, y and z.
  MLT_INLINE Rows<F> corners(std::uint32_t axis) const { return row(axis); }
  /// The unit normal, and the primitive's bits.
  MLT_INLINE Rows<F> normal_row() const { return row(3); }
  /// The box's low corner and the slot's bits, and the high corner.
  MLT_INLINE Rows<F> low_row() const { return row(4); }
  MLT_INLINE Rows<F> high_row() const { return row(5); }

  /// The corners' coordinates in a ray's order of axes.
  MLT_INLINE void corners(const AxisOrder<F>& order, Rows<F>& first, Rows<F>& second, Rows<F>& last) const {
    if (in_tables_) {
      const Rows<F> x = row(0), y = row(1), z = row(2);
#pragma GCC unroll 4
      for (int i = 0; i < 4; ++i) {
        first.column[i] = order.first(x.column[i], y.column[i], z.column[i]);
        second.column[i] = order.second(x.column[i], y.column[i], z.column[i]);
        last.column[i] = order.last(x.column[i], y.column[i], z.column[i]);
      }
      return;
    }
    using U = UintOf<F>;
    const U zero{}, one = broadcast_bits<U>(1), two = broadcast_bits<U>(2);
    first = loaded_row(order.first(zero, one, two));
    second = loaded_row(order.second(zero, one, two));
    last = loaded_row(order.last(zero, one, two));
  }

 private:
  static_assert(offsetof(FlatPolygon, quad.corners) == 0);
  static_assert(offsetof(FlatPolygon, quad.normal) == 3 * 16);
  static_assert(offsetof(FlatPolygon, quad.primitive) == offsetof(FlatPolygon, quad.normal) + 12);
  static_assert(offsetof(FlatPolygon, low) == 4 * 16);
  static_assert(offsetof(FlatPolygon, slot) == offsetof(FlatPolygon, low) + 12);
  static_assert(offsetof(FlatPolygon, high) == 5 * 16);

  MLT_INLINE Rows<F> row(std::uint32_t index) const {
    if (in_tables_) return list_.columns.row<F>(index, slot_, list_.slot_count() > 32);
    return loaded_row(broadcast_bits<UintOf<F>>(index));
  }
  MLT_INLINE Rows<F> loaded_row(UintOf<F> index) const {
    return gather_rows<F>(&list_.polygons[0].quad.corners[0][0],
                          slot_ * static_cast<std::uint32_t>(sizeof(FlatPolygon)) + index * 16U);
  }

  const FlatList& list_;
  UintOf<F> slot_;
  bool in_tables_;
};

/// Largest absolute value of four.
template <class F>
MLT_INLINE F largest_magnitude(const F (&v)[4]) {
  const F low = larger(magnitude(v[0]), magnitude(v[1]));
  const F high = larger(magnitude(v[2]), magnitude(v[3]));
  return larger(low, high);
}

/// The corners of each ray's polygon in its sheared frame.
template <class F>
struct ShearedCorners {
  F x[4], y[4], z[4];
  F inverse_z;

  MLT_INLINE ShearedCorners(const PolygonRef<F>& polygon, const WideRayFrame<F>& frame) {
    const AxisOrder<F> order(frame);
    const Vec3Of<F>&o = frame.ray.origin, &d = frame.ray.direction;
    const F direction_z = order.last(d.x, d.y, d.z);
    const F shear_x = order.first(d.x, d.y, d.z) / direction_z;
    const F shear_y = order.second(d.x, d.y, d.z) / direction_z;
    inverse_z = 1.0f / direction_z;
    const F origin_x = order.first(o.x, o.y, o.z), origin_y = order.second(o.x, o.y, o.z);
    const F origin_z = order.last(o.x, o.y, o.z);
    Rows<F> row_x, row_y, row_z;
    polygon.corners(order, row_x, row_y, row_z);
#pragma GCC unroll 4
    for (int i = 0; i < 4; ++i) {
      z[i] = row_z.column[i] - origin_z;
      x[i] = (row_x.column[i] - origin_x) - shear_x * z[i];
      y[i] = (row_y.column[i] - origin_y) - shear_y * z[i];
    }
  }
};

/// cross_quad for as many rays as there are lanes, each with a polygon of its own.
template <class F>
MLT_INLINE WideQuadHit<F> cross_quads(const ShearedCorners<F>& corners) {
  using M = MaskOf<F>;
  using U = UintOf<F>;
  const F(&x)[4] = corners.x, (&y)[4] = corners.y, (&z)[4] = corners.z;
  F edges[4];
#pragma GCC unroll 4
  for (int i = 0; i < 4; ++i) edges[i] = edge_function(x[i], y[i], x[(i + 1) % 4], y[(i + 1) % 4]);
  const F ca = edge_function(x[2], y[2], x[0], y[0]);
  const F ac = edge_function(x[0], y[0], x[2], y[2]);

  // As in cross_quad: the sign of ca divided out.
  const U sign = as_bits(ca) & 0x80000000U;
  F turned[4];
#pragma GCC unroll 4
  for (int i = 0; i < 4; ++i) turned[i] = as_floats(as_bits(edges[i]) ^ sign);
  const M inclined = (ca > 0.0f) | (ca < 0.0f);
  const M missed =
      inclined & ((turned[0] < 0.0f) | (turned[1] < 0.0f)) & ((turned[2] > 0.0f) | (turned[3] > 0.0f));
  const M in_first = (turned[0] > 0.0f) & (turned[1] > 0.0f);
  const M in_second = (turned[2] < 0.0f) & (turned[3] < 0.0f);
  WideQuadHit<F> hit;
  hit.in_doubt = not_in(missed) & not_in(M(inclined & (in_first | in_second)));

  const F t_a = z[0] * corners.inverse_z, t_c = z[2] * corners.inverse_z;
  const F t_middle = select(in_first, z[1], z[3]) * corners.inverse_z;
  const F weight_a = select(in_first, edges[1], edges[2]);
  const F weight_middle = select(in_first, ca, ac);
  const F weight_c = select(in_first, edges[0], edges[3]);
  const F depth = (weight_a * t_a + weight_middle * t_middle) + weight_c * t_c;
  const M before = (t_a > 0.0f) & (t_middle > 0.0f) & (t_c > 0.0f);
  const M behind = (t_a <= 0.0f) & (t_middle <= 0.0f) & (t_c <= 0.0f);
  const M straddles = not_in(M(before | behind));
  if (any(straddles)) {
    const F reach_x = largest_magnitude(x), reach_y = largest_magnitude(y);
    const F t[4] = {t_a, t_middle, t_c, t_c};
    const F error = (reach_x * reach_y) * (largest_magnitude(t) * kDepthError);
    hit.in_doubt |= not_in(missed) & straddles & not_in(M(magnitude(depth) > error));
  }
  const F scale = 1.0f / ((weight_a + weight_middle) + weight_c);
  hit.t = depth * scale;
  hit.weight_middle = weight_middle * scale;
  hit.weight_c = weight_c * scale;
  hit.second = not_in(in_first);
  hit.met = not_in(M(missed | behind)) & (hit.t > 0.0f);
  return hit;
}

/// Slabs of many rays; as RaySlabs.
template <class F>
struct WideSlabs {
  F near_origin[3], inverse[3];

  MLT_INLINE WideSlabs(const WideRayFrame<F>& frame, float extent) {
    const F padding = (frame.distance + extent) * kBoxPadding;
    const F smallest = frame.longest * kSmallestSlope + std::numeric_limits<float>::min();
    const F* const origin = &frame.ray.origin.x;
    const F* const direction = &frame.ray.direction.x;
    const F* const size = &frame.size.x;
#pragma GCC unroll 3
    for (int axis = 0; axis < 3; ++axis) {
      inverse[axis] = 1.0f / with_sign_of(larger(size[axis], smallest), direction[axis]);
      near_origin[axis] = origin[axis] + with_sign_of(padding, direction[axis]);
    }
  }
};

/// Where the rays enter the padded boxes of their polygons; as box_entry.
template <class F>
MLT_INLINE F box_entries(const Rows<F>& low, const Rows<F>& high, const WideSlabs<F>& slabs) {
  F most{};
#pragma GCC unroll 3
  for (int axis = 0; axis < 3; ++axis) {
    const MaskOf<F> backwards = (as_bits(slabs.inverse[axis]) & 0x80000000U) != 0U;
    const F plane = select(backwards, high.column[axis], low.column[axis]);
    most = larger((plane - slabs.near_origin[axis]) * slabs.inverse[axis], most);
  }
  return most;
}

}  // namespace mlt
