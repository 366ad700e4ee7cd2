// The queries of class Geometry; included by geometry.hpp alone.
#pragma once

#include "geometry/geometry.hpp"
#include "geometry/surface.hpp"

namespace mlt {

template <class Block>
struct HitsOfBlock;
template <>
struct HitsOfBlock<TriangleBlock> {
  using Type = TriangleHits;
};
template <>
struct HitsOfBlock<SphereBlock> {
  using Type = SphereHits;
};
template <class Block>
using HitsOf = typename HitsOfBlock<Block>::Type;

MLT_INLINE Hit make_hit(const TriangleHits& hits, int lane, std::uint32_t primitive, std::uint32_t slot) {
  return {hits.t[lane], primitive, slot, {hits.weight_b[lane], hits.weight_c[lane]}};
}
MLT_INLINE Hit make_hit(const SphereHits& hits, int lane, std::uint32_t primitive, std::uint32_t slot) {
  return {hits.t[lane], primitive, slot, {0, 0}};
}

/// The best hit so far. `limit` admits t = limit only for primitives below `tie_below`, which is 0 until
/// there is a hit, as t_max itself is excluded.
struct BestHit {
  Hit hit;
  float limit;
  std::uint32_t tie_below = 0;

  MLT_INLINE explicit BestHit(float t_max) : limit(t_max) {}
  /// The best of what has been visited so far, if anything.
  MLT_INLINE BestHit(const Hit& so_far, float t_max)
      : hit(so_far),
        limit(so_far.found() ? so_far.t : t_max),
        tie_below(so_far.found() ? so_far.primitive : 0) {}

  template <class Block>
  MLT_INLINE void visit(const Block& block, std::uint32_t index, const RayFrame& ray) {
    HitsOf<Block> hits;
    unsigned bits = intersect_block(block, ray, broadcast(limit), hits);
    while (bits != 0) {
      const int lane = take_lowest(bits);
      const std::uint32_t primitive = block.primitive[lane];
      if (hits.t[lane] < limit || (hits.t[lane] == limit && primitive < tie_below)) {
        limit = hits.t[lane];
        tie_below = primitive;
        hit = make_hit(hits, lane, primitive, index * kLanes + static_cast<std::uint32_t>(lane));
      }
    }
  }

  /// Quads behind the best hit so far are passed over by their boxes' entries, which no t is below.
  MLT_INLINE void visit(const QuadBlock& block, std::uint32_t index, const RayFrame& ray) {
    LaneFloat entries;
    unsigned bits = entered_boxes(block.planes, ray, broadcast(limit), entries);
    while (bits != 0) {
      const int lane = take_lowest(bits);
      const float entry = entries[lane];
      QuadHit met;
      if (entry > limit || !cross_quad(block.quads[lane], *ray.ray, ray.shear, met)) continue;
      const float t = entry > met.t ? entry : met.t;
      const std::uint32_t primitive = block.quads[lane].primitive;
      if (t < limit || (t == limit && primitive < tie_below)) {
        limit = t;
        tie_below = primitive;
        const std::uint32_t slot = index * kLanes + static_cast<std::uint32_t>(lane);
        hit = {t, primitive, slot | (met.second ? kSecondTriangle : 0U), {met.weight_middle, met.weight_c}};
      }
    }
  }

  /// The test that defines hits, for one polygon of a flat list.
  MLT_INLINE void visit(const FlatPolygon& polygon, const Ray& ray, const RayShear& shear,
                        const RaySlabs& slabs) {
    QuadHit met;
    if (!cross_quad(polygon.quad, ray, shear, met)) return;
    const float entry = box_entry(polygon, slabs);
    const float t = entry > met.t ? entry : met.t;
    const std::uint32_t primitive = polygon.quad.primitive;
    if (t < limit || (t == limit && primitive < tie_below)) {
      limit = t;
      tie_below = primitive;
      const std::uint32_t slot = polygon.slot | (met.second ? kSecondTriangle : 0U);
      hit = {t, primitive, slot, {met.weight_middle, met.weight_c}};
    }
  }

  MLT_INLINE void visit_flat(const FlatList& list, const FlatRay& flat_ray, const Ray& ray,
                             const RayShear& shear, const RaySlabs& slabs) {
    visit_candidates(
        list, flat_ray, limit, [&](const FlatPolygon& polygon) __attribute__((always_inline)) {
          visit(polygon, ray, shear, slabs);
          return limit;
        });
  }

  template <class Block>
  MLT_INLINE void visit_blocks(const PrimitiveList<Block>& list, const RayFrame& ray) {
    for (std::uint32_t i = 0; i < list.block_count; ++i) visit(list.blocks[i], i, ray);
  }

  template <Fetch kFetch, class Block>
  MLT_INLINE bool step(ClosestWalk& walk, const PrimitiveList<Block>& list, const RayFrame& ray) {
    return walk.step<kFetch>(
        list.hierarchy(), ray, limit, [&](std::uint32_t block) __attribute__((always_inline)) {
          visit(list.blocks[block], block, ray);
          return limit;
        });
  }

  template <class Block>
  MLT_INLINE void visit_list(const PrimitiveList<Block>& list, const RayFrame& ray) {
    if (list.nodes == nullptr) {
      visit_blocks(list, ray);
      return;
    }
    ClosestWalk walk;
    while (step<Fetch::when_read>(walk, list, ray)) {
    }
  }
};

/// Whether any lane but that of `target` lies at t < limit; blocks admit t <= limit.
template <class Block>
MLT_INLINE bool blocks_ray(const Block& block, const RayFrame& ray, LaneFloat limit, std::uint32_t target) {
  HitsOf<Block> hits;
  unsigned bits = intersect_block(block, ray, limit, hits);
  if (bits != 0) bits &= lane_bits(hits.t < limit);
  while (bits != 0) {
    if (block.primitive[take_lowest(bits)] != target) return true;
  }
  return false;
}

MLT_INLINE bool blocks_ray(const QuadBlock& block, const RayFrame& ray, LaneFloat limit,
                           std::uint32_t target) {
  LaneFloat entries;
  unsigned bits = entered_boxes(block.planes, ray, limit, entries);
  while (bits != 0) {
    const int lane = take_lowest(bits);
    QuadHit met;
    if (block.quads[lane].primitive != target && cross_quad(block.quads[lane], *ray.ray, ray.shear, met) &&
        met.t < limit[0] && entries[lane] < limit[0])
      return true;
  }
  return false;
}

MLT_INLINE bool flat_occluded(const FlatList& list, const FlatRay& flat_ray, const Ray& ray,
                              const RayLanes& lanes, float extent, std::uint32_t target) {
  const float limit = ray.t_max;
  return blocks_ray(list, flat_ray, broadcast(limit), target, [&](const FlatPolygon& polygon) {
    QuadHit met;
    return cross_quad(polygon.quad, ray, RayShear(ray, lanes), met) && met.t < limit &&
           box_entry(polygon, RaySlabs(lanes, extent)) < limit;
  });
}

template <class Block>
MLT_INLINE bool blocks_occluded(const PrimitiveList<Block>& list, const RayFrame& ray, LaneFloat limit,
                                std::uint32_t target) {
  for (std::uint32_t i = 0; i < list.block_count; ++i) {
    if (blocks_ray(list.blocks[i], ray, limit, target)) return true;
  }
  return false;
}

template <Fetch kFetch, class Block>
MLT_INLINE AnyWalk::Step step_to_any(AnyWalk& walk, const PrimitiveList<Block>& list, const RayFrame& ray,
                                     LaneFloat limit, std::uint32_t target) {
  return walk.step<kFetch>(
      list.hierarchy(), ray, limit, [&](std::uint32_t block) __attribute__((always_inline)) {
        return blocks_ray(list.blocks[block], ray, limit, target);
      });
}

template <class Block>
MLT_INLINE bool list_occluded(const PrimitiveList<Block>& list, const RayFrame& ray, LaneFloat limit,
                              std::uint32_t target) {
  if (list.nodes == nullptr) return blocks_occluded(list, ray, limit, target);
  AnyWalk walk;
  for (;;) {
    const AnyWalk::Step step = step_to_any<Fetch::when_read>(walk, list, ray, limit, target);
    if (step != AnyWalk::Step::goes_on) return step == AnyWalk::Step::found;
  }
}

template <bool kGeneral>
[[gnu::noinline]] Hit Geometry::intersect(const Ray& ray) const {
  const RayLanes lanes(ray);
  BestHit best(ray.t_max);
  if constexpr (kGeneral) {
    const RayFrame frame(ray, lanes, extent_);
    for (const FlatList& list : lists_for_one()) {
      best.visit_flat(list, FlatRay(ray, lanes, extent_), ray, frame.shear, frame.slabs);
    }
    best.visit_list(triangles_, frame);
    best.visit_list(spheres_, frame);
    best.visit_list(quads_, frame);
  } else if (flat_lists_.empty()) {
    best.visit_blocks(quads_, RayFrame(ray, lanes, extent_));
  } else {
    best.visit_flat(flat_lists_[0], FlatRay(ray, lanes, extent_), ray, RayShear(ray, lanes),
                    RaySlabs(lanes, extent_));
  }
  return best.hit;
}

template <bool kGeneral>
[[gnu::noinline]] bool Geometry::occluded(const Ray& ray, std::uint32_t target) const {
  const RayLanes lanes(ray);
  const LaneFloat limit = broadcast(ray.t_max);
  if constexpr (kGeneral) {
    for (const FlatList& list : lists_for_one()) {
      if (flat_occluded(list, FlatRay(ray, lanes, extent_), ray, lanes, extent_, target)) return true;
    }
    const RayFrame frame(ray, lanes, extent_);
    // A sphere can hide its own far side.
    return list_occluded(quads_, frame, limit, target) ||
           list_occluded(spheres_, frame, limit, kNoPrimitive) ||
           list_occluded(triangles_, frame, limit, target);
  } else {
    if (flat_lists_.empty()) return blocks_occluded(quads_, RayFrame(ray, lanes, extent_), limit, target);
    return flat_occluded(flat_lists_[0], FlatRay(ray, lanes, extent_), ray, lanes, extent_, target);
  }
}

template <bool kGeneral>
[[gnu::noinline]] SurfacePoint Geometry::surface_point(const Ray& ray, const Hit& hit) const {
  const std::uint32_t block = (hit.slot & ~kSecondTriangle) / kLanes;
  const int lane = static_cast<int>(hit.slot % kLanes);
  if constexpr (kGeneral) {
    if (hit.primitive >= first_sphere_) return sphere_point(spheres_.blocks[block], lane, ray, hit.t);
    if (hit.primitive >= first_in_triangles_) return triangle_point(triangles_.blocks[block], lane, hit);
  }
  const std::uint32_t slot = hit.slot & ~kSecondTriangle;
  const QuadRecord* quad = flat_lists_.empty()
                               ? &quads_.blocks[block].quads[lane]
                               : &flat_lists_[slot / kFlatSlots].polygons[slot % kFlatSlots].quad;
  return quad_point(*quad, (hit.slot & kSecondTriangle) != 0, hit);
}

}  // namespace mlt

#include "geometry/geometry_lanes.hpp"
