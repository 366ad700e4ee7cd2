// A flat list of polygons against as many rays as there are lanes: the fast test goes polygon by polygon
// over all rays (flat_list.hpp), then each ray meets the test that defines hits (wide_polygon.hpp) with the
// polygon that seems nearest to it. Rays on which that leaves doubt, few of them, are told by a mask; they
// are to be asked one by one. All others get the bits that one ray gets.
#pragma once

#include "geometry/flat_list.hpp"
#include "geometry/surface.hpp"
#include "geometry/wide_cell.hpp"
#include "geometry/wide_polygon.hpp"

namespace mlt {

/// Of a key: the slot of a polygon, and kOfCell.
inline constexpr std::uint32_t kKeyBits = 2 * kFlatSlots - 1;
static_assert(kOfCell == kFlatSlots && (1U << kPrimitiveShift) == kKeyBits + 1);

/// As key_limit.
template <class F>
MLT_INLINE F key_limits(F limit) {
  constexpr float kFarthest = 0x1p125f;
  return as_floats(as_bits(smaller(limit, broadcast_to<F>(kFarthest))) + (kKeyBits + 1));
}

/// Calls visit(block, lane, axes, crossing) for each polygon of a list that lies in no cell, with where the
/// rays cross its plane.
template <class F, class Visit>
MLT_INLINE void for_crossings(const FlatList& list, const FlatRayOf<F>& ray, Visit&& visit) {
  for (std::uint32_t i = 0; i < list.loose_count; ++i) {
    const FlatBlock& block = list.loose[i];
    const FlatAxes<F> axes(ray, block.axis);
    const auto used = static_cast<int>(block.used), aligned = static_cast<int>(block.aligned);
    int lane = 0;
    if (aligned > 0) {
      const PlaneSlope<F> slope(axes.direction[0], ray.error);
      for (; lane < aligned; ++lane) {
        const PolygonCoefficients<F> of{block, lane};
        visit(block, lane, axes, PlaneCrossing<F>::aligned(of, axes, slope));
      }
    }
    for (; lane < used; ++lane) {
      const PolygonCoefficients<F> of{block, lane};
      visit(block, lane, axes, PlaneCrossing<F>::inclined(of, axes));
    }
  }
}

/// The least two of the keys seen so far, each a first distance with kKeyBits in its lowest bits.
template <class F>
struct LeastKeys {
  static constexpr float kNever = 0x1p126f;

  F keys[kFlatSlots];
  int count = 0;
  F least = broadcast_to<F>(kNever), next = least;

  /// Rays that might hit a polygon, at `first` or behind, but those that `rejected` tells.
  MLT_INLINE void add(const F& first, const UintOf<F>& polygon, MaskOf<F> rejected) {
    const UintOf<F> key = (as_bits(first) & ~kKeyBits) | polygon;
    keys[count] = as_floats(key | mask_bits(rejected));
    rank(keys[count++]);
  }
  /// Passes over the least.
  MLT_INLINE void drop_least() {
    const F nearest = least;
    least = next = broadcast_to<F>(kNever);
    for (int i = 0; i < count; ++i) rank(as_floats(as_bits(keys[i]) | mask_bits(keys[i] <= nearest)));
  }

  MLT_INLINE UintOf<F> slot(MaskOf<F> active) const {
    return select(active, as_bits(least) & (kOfCell - 1U), UintOf<F>{});
  }
  MLT_INLINE MaskOf<F> of_cell() const { return (as_bits(least) & kOfCell) != 0U; }

 private:
  /// The order of arguments passes over NaN.
  MLT_INLINE void rank(F key) {
    next = smaller(larger(least, key), next);
    least = smaller(key, least);
  }
};

/// The best hits so far, as BestHit.
template <class F>
struct WideBestHit {
  HitOf<F> hit;
  F limit;
  UintOf<F> tie_below{};

  MLT_INLINE explicit WideBestHit(F t_max) : limit(t_max) {}

  /// The test that defines hits, for one polygon of each ray in `active`. Returns where it is to be done one
  /// by one, among others where a ray misses what it `must` meet.
  MLT_INLINE MaskOf<F> visit(const FlatList& list, UintOf<F> slot, const WideRayFrame<F>& frame, float extent,
                             MaskOf<F> active, MaskOf<F> must = MaskOf<F>{}) {
    const PolygonRef<F> polygon(list, slot);
    const WideQuadHit<F> quad = cross_quads<F>(ShearedCorners<F>(polygon, frame));
    const Rows<F> low = polygon.low_row();
    const F entry = box_entries<F>(low, polygon.high_row(), WideSlabs<F>(frame, extent));
    const F t = select(entry > quad.t, entry, quad.t);
    const UintOf<F> primitive = as_bits(polygon.normal_row().column[3]);
    const MaskOf<F> better = active & quad.met & ((t < limit) | ((t == limit) & (primitive < tie_below)));
    limit = select(better, t, limit);
    tie_below = select(better, primitive, tie_below);
    hit.t = limit;
    hit.primitive = select(better, primitive, hit.primitive);
    hit.slot = select(better, as_bits(low.column[3]) | (mask_bits(quad.second) & kSecondTriangle), hit.slot);
    hit.weights[0] = select(better, quad.weight_middle, hit.weights[0]);
    hit.weights[1] = select(better, quad.weight_c, hit.weights[1]);
    return active & (quad.in_doubt | (must & not_in(quad.met)));
  }
};

/// Adds the face of each cell that rays might hit first. Returns which rays might hit others.
template <class F>
MLT_INLINE MaskOf<F> add_cells(const FlatList& list, const FlatRayOf<F>& ray, UintOf<F> leaves,
                               LeastKeys<F>& found) {
  const AxisSlopes<F> slopes(list, ray);
  MaskOf<F> in_doubt{};
  for (std::uint32_t i = 0; i < list.cell_count; ++i) {
    const CellCrossing<F> crossing(list.cells[i], ray, slopes);
    const MaskOf<F> met = crossing.met();
    if (!any(met)) continue;
    const CellFaces<F> faces(list.cells[i], crossing);
    in_doubt |= met & not_in(faces.clear);
    const MaskOf<F> enters = (crossing.enters_before() > 0.0f) & is_another<F>(faces.entry, leaves);
    const MaskOf<F> hit = met & (enters | is_another<F>(faces.exit, leaves));
    const F first = select(enters, crossing.enters, crossing.leaves) - crossing.error;
    found.add(larger(first, F{}), select(enters, faces.entry, faces.exit) & kKeyBits, not_in(hit));
  }
  return in_doubt;
}

/// The closest hits. `leaves` are the primitives that rays start from, which they do not meet again
/// (polygon.hpp): the fast test alone could not tell. Nothing is known of rays outside `active` or, on
/// return, in `in_doubt`.
template <class F>
MLT_INLINE HitOf<F> intersect_flat(const FlatList& list, const RayOf<F>& ray, float extent, UintOf<F> leaves,
                                   MaskOf<F> active, MaskOf<F>& in_doubt) {
  const WideRayFrame<F> frame(ray);
  const FlatRayOf<F> flat(ray, frame.longest, frame.distance, extent);
  LeastKeys<F> found;
  in_doubt = active & add_cells<F>(list, flat, leaves, found);
  for_crossings<F>(
      list, flat,
      [&](const FlatBlock& block, int lane, const FlatAxes<F>& axes, const PlaneCrossing<F>& plane)
          __attribute__((always_inline)) {
            const auto bounds = bound_hits<F>(PolygonCoefficients<F>{block, lane}, axes, plane);
            const auto slot = static_cast<std::uint32_t>(block.slot[lane]);
            found.add(bounds.first, broadcast_bits<UintOf<F>>(slot),
                      bounds.rejected | (leaves == block.primitive[lane]));
          });

  WideBestHit<F> best(ray.t_max);
  MaskOf<F> open = active & not_in(in_doubt) & (found.least <= key_limits(best.limit));
  while (any(open)) {
    in_doubt |= best.visit(list, found.slot(open), frame, extent, open, found.of_cell());
    // Few rays have another polygon that they might meet as early.
    open = open & (found.next <= key_limits(best.limit)) & not_in(in_doubt);
    if (!any(open)) [[likely]]
      break;
    found.drop_least();
    open = open & (found.least <= key_limits(best.limit));
  }
  return best.hit;
}

/// What blocks rays, as far as the fast test can tell.
template <class F>
struct WideBlockers {
  MaskOf<F> blocked{};
  MaskOf<F> doubted{}, doubted_twice{};
  UintOf<F> doubtful{};  ///< a polygon on which there is doubt, the last one

  MLT_INLINE void add(MaskOf<F> possible, MaskOf<F> sure, const UintOf<F>& polygon) {
    blocked |= sure;
    doubted_twice |= doubted & possible;
    doubted |= possible;
    doubtful = select(possible, polygon, doubtful);
  }
};

/// Whether faces of cells block rays before `limit`.
template <class F>
MLT_INLINE void add_cells(const FlatList& list, const FlatRayOf<F>& ray, F limit, const SegmentEnds<F>& ends,
                          WideBlockers<F>& blockers) {
  using M = MaskOf<F>;
  const AxisSlopes<F> slopes(list, ray);
  for (std::uint32_t i = 0; i < list.cell_count; ++i) {
    const CellCrossing<F> crossing(list.cells[i], ray, slopes);
    const M met = crossing.met() & not_in(M(crossing.enters_after() >= limit));
    if (!any(met)) continue;
    const CellFaces<F> faces(list.cells[i], crossing);
    const auto is_free = [&](const UintOf<F>& face) __attribute__((always_inline)) {
      return is_another<F>(face, ends.leaves) & is_another<F>(face, ends.target);
    };
    const M unclear = met & not_in(faces.clear);
    blockers.doubted |= unclear;
    blockers.doubted_twice |= unclear;
    const M enters = met & (crossing.enters_before() > 0.0f) & is_free(faces.entry);
    const M leaves = met & (crossing.leaves_after() < limit) & is_free(faces.exit);
    const M enters_surely = (crossing.enters_after() > 0.0f) & (crossing.enters_before() < limit);
    const M leaves_surely = (crossing.leaves_after() > 0.0f) & (crossing.leaves_before() < limit);
    blockers.add(enters, enters & faces.clear & enters_surely, faces.entry);
    blockers.add(leaves, leaves & faces.clear & leaves_surely, faces.exit);
  }
}

/// Which rays the list blocks, but for their targets. Nothing is known of rays outside `active` or, on
/// return, in `in_doubt`.
template <class F>
MLT_INLINE MaskOf<F> flat_occludes(const FlatList& list, const RayOf<F>& ray, float extent,
                                   const SegmentEnds<F>& ends, MaskOf<F> active, MaskOf<F>& in_doubt) {
  using U = UintOf<F>;
  const WideRayFrame<F> frame(ray);
  const FlatRayOf<F> flat(ray, frame.longest, frame.distance, extent);
  WideBlockers<F> blockers;
  add_cells<F>(list, flat, ray.t_max, ends, blockers);
  for_crossings<F>(
      list, flat,
      [&](const FlatBlock& block, int lane, const FlatAxes<F>& axes, const PlaneCrossing<F>& plane)
          __attribute__((always_inline)) {
            const std::uint32_t primitive = block.primitive[lane];
            const MaskOf<F> is_end = (ends.leaves == primitive) | (ends.target == primitive);
            const auto bounds =
                bound_hits<F>(PolygonCoefficients<F>{block, lane}, axes, plane, ray.t_max, is_end);
            blockers.add(not_in(bounds.rejected), bounds.sure,
                         broadcast_bits<U>(static_cast<std::uint32_t>(block.slot[lane])));
          });
  MaskOf<F> blocked = blockers.blocked;
  MaskOf<F> doubted = active & blockers.doubted & not_in(blocked);
  in_doubt = doubted & blockers.doubted_twice;
  doubted = doubted & not_in(in_doubt);
  if (any(doubted)) {
    WideBestHit<F> met(ray.t_max);
    const U slot = select(doubted, blockers.doubtful & (kOfCell - 1U), U{});
    in_doubt |= met.visit(list, slot, frame, extent, doubted);
    blocked |= doubted & not_in(in_doubt) & met.hit.found();
  }
  return blocked;
}

/// The points of hits on a list of polygons.
template <class F>
MLT_INLINE SurfacePointOf<F> flat_points(const FlatList& list, const HitOf<F>& hit) {
  using V = Vec3Of<F>;
  const PolygonRef<F> polygon(list, hit.slot & (kFlatSlots - 1U));
  const Rows<F> x = polygon.corners(0U), y = polygon.corners(1U), z = polygon.corners(2U);
  const Rows<F> normal = polygon.normal_row();
  const MaskOf<F> second = (hit.slot & kSecondTriangle) != 0U;
  const V middle{select(second, x.column[3], x.column[1]), select(second, y.column[3], y.column[1]),
                 select(second, z.column[3], z.column[1])};
  return polygon_point<F>(V{x.column[0], y.column[0], z.column[0]}, middle,
                          V{x.column[2], y.column[2], z.column[2]},
                          V{normal.column[0], normal.column[1], normal.column[2]}, hit);
}

}  // namespace mlt
