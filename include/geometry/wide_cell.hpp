// Many rays against a cell of a flat list (flat_cell.hpp): between what depths each is inside, and through
// which faces it comes and goes.
#pragma once

#include "geometry/flat_list.hpp"
#include "geometry/ray.hpp"
#include "math/gather.hpp"

namespace mlt {

/// Slopes of the planes across the axes, of those that cells of a list have.
template <class F>
struct AxisSlopes {
  F inverse[3], error[3];

  MLT_INLINE AxisSlopes(const FlatList& list, const FlatRayOf<F>& ray) {
    for (std::uint32_t axis = 0; list.cell_axes != 0 && axis < 3; ++axis) {
      if ((list.cell_axes >> axis & 1U) == 0) continue;
      const PlaneSlope<F> slope(ray.direction[axis], ray.error);
      inverse[axis] = slope.inverse;
      error[axis] = slope.error;
    }
  }
};

/// What the lanes of a coefficient all hold.
template <class F>
MLT_INLINE F coefficient(const LaneFloat& lanes) {
  if constexpr (std::is_same_v<F, LaneFloat>) return lanes;
  return broadcast_to<F>(lanes[0]);
}

/// Where rays cross the planes of a slab.
template <class F>
struct SlabCrossing {
  F enters, leaves, error;
  UintOf<F> near;  ///< the face where a ray enters, of the two

  MLT_INLINE SlabCrossing(const CellSlab& slab, const FlatRayOf<F>& ray, const AxisSlopes<F>& slopes) {
    const F* const o = ray.origin + slab.axis;
    const F* const d = ray.direction + slab.axis;
    if (slab.aligned) {
      set(slab, o[0], slopes.inverse[slab.axis], slopes.error[slab.axis]);
      return;
    }
    const F normal_i = coefficient<F>(slab.normal_i), normal_j = coefficient<F>(slab.normal_j);
    const F height = mul_add_bound(normal_j, o[2], mul_add_bound(normal_i, o[1], o[0]));
    const F det = mul_add_bound(normal_j, d[2], mul_add_bound(normal_i, d[1], d[0]));
    const PlaneSlope<F> slope(det, ray.error);
    set(slab, height, slope.inverse, slope.error);
  }

 private:
  MLT_INLINE void set(const CellSlab& slab, const F& height, const F& inverse, const F& unit) {
    const F to_high = (height - coefficient<F>(slab.high)) * inverse;
    const F to_low = (height - coefficient<F>(slab.low)) * inverse;
    enters = smaller(to_high, to_low);
    leaves = larger(to_high, to_low);
    error = unit * coefficient<F>(slab.error);
    // -1 / det is negative where a ray goes from the low plane to the high one.
    near = as_bits(inverse) >> 31U;
  }
};

/// Between what depths rays are inside a cell. Only where a ray runs along a slab's planes are there
/// infinities and NaN, and the error is one.
template <class F>
struct CellCrossing {
  SlabCrossing<F> slabs[3];
  F enters, leaves;
  F error;  ///< of all depths: the slabs' together, as mostly all are small

  MLT_INLINE CellCrossing(const FlatCell& cell, const FlatRayOf<F>& ray, const AxisSlopes<F>& slopes)
      : slabs{{cell.slabs[0], ray, slopes}, {cell.slabs[1], ray, slopes}, {cell.slabs[2], ray, slopes}},
        enters(larger(larger(slabs[0].enters, slabs[1].enters), slabs[2].enters)),
        leaves(smaller(smaller(slabs[0].leaves, slabs[1].leaves), slabs[2].leaves)),
        error((slabs[0].error + slabs[1].error) + slabs[2].error) {}

  // Hits on the face where rays enter, and on the one where they leave, lie between these.
  MLT_INLINE F enters_after() const { return enters - error; }
  MLT_INLINE F enters_before() const { return enters + error; }
  MLT_INLINE F leaves_after() const { return leaves - error; }
  MLT_INLINE F leaves_before() const { return leaves + error; }

  /// Whether there may be hits ahead of the origin.
  MLT_INLINE MaskOf<F> met() const {
    return not_in(MaskOf<F>(enters_after() > leaves_before())) & not_in(MaskOf<F>(leaves_before() <= 0.0f));
  }
};

/// Through which faces rays come into a cell and go out of it.
template <class F>
struct CellFaces {
  UintOf<F> entry, exit;  ///< words of faces
  /// No other face can be hit, and where both are, the entry is before the exit.
  MaskOf<F> clear;

  MLT_INLINE CellFaces(const FlatCell& cell, const CellCrossing<F>& crossing) {
    const SlabCrossing<F>(&slab)[3] = crossing.slabs;
    const UintOf<F> near[3] = {slab[0].near, slab[1].near | 2U, slab[2].near | 4U};

    const F first_entry = smaller(slab[0].enters, slab[1].enters);
    const F later_entry = larger(slab[0].enters, slab[1].enters);
    const F next_entry = larger(smaller(later_entry, slab[2].enters), first_entry);
    entry =
        small_table_entries<F>(cell.faces, select(slab[2].enters > later_entry, near[2],
                                                  select(slab[1].enters > slab[0].enters, near[1], near[0])));

    const F last_exit = larger(slab[0].leaves, slab[1].leaves);
    const F earlier_exit = smaller(slab[0].leaves, slab[1].leaves);
    const F next_exit = smaller(larger(earlier_exit, slab[2].leaves), last_exit);
    exit =
        small_table_entries<F>(cell.faces, select(slab[2].leaves < earlier_exit, near[2],
                                                  select(slab[1].leaves < slab[0].leaves, near[1], near[0])) ^
                                               1U);

    const F gap = smaller(smaller(crossing.enters - next_entry, next_exit - crossing.leaves),
                          crossing.leaves - crossing.enters);
    clear = gap > crossing.error + crossing.error;
  }
};

/// Whether a face is a polygon other than the one whose primitive is given.
template <class F>
MLT_INLINE MaskOf<F> is_another(UintOf<F> face, UintOf<F> primitive) {
  return not_in(MaskOf<F>(((face >> kPrimitiveShift) == primitive) | (face == kOpenFace)));
}

}  // namespace mlt
