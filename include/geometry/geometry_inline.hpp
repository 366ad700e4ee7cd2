// The queries of class Geometry; included by geometry.hpp alone.
#pragma once

#include "geometry/geometry.hpp"
#include "geometry/surface.hpp"

namespace mlt {

inline constexpr std::uint32_t kSecondTriangle =
    0x80000000U;  ///< in Hit::slot: on triangle a, c, d of a quad

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
      if (entry > limit || !cross_quad(block.quads[lane], ray, met)) continue;
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

  template <class Block>
  MLT_INLINE void visit_flat(const PrimitiveList<Block>& list, const RayFrame& ray) {
    for (std::uint32_t i = 0; i < list.block_count; ++i) visit(list.blocks[i], i, ray);
  }

  template <class Block>
  MLT_INLINE void visit_list(const PrimitiveList<Block>& list, const RayFrame& ray) {
    if (list.nodes == nullptr) {
      visit_flat(list, ray);
      return;
    }
    traverse_closest(list.nodes, ray, limit, [&](std::uint32_t block) {
      visit(list.blocks[block], block, ray);
      return limit;
    });
  }
};

/// Whether any lane lies at t < limit; blocks admit t <= limit.
template <class Block>
MLT_INLINE bool blocks_ray(const Block& block, const RayFrame& ray, LaneFloat limit) {
  HitsOf<Block> hits;
  const unsigned bits = intersect_block(block, ray, limit, hits);
  return bits != 0 && (bits & lane_bits(hits.t < limit)) != 0;
}

MLT_INLINE bool blocks_ray(const QuadBlock& block, const RayFrame& ray, LaneFloat limit) {
  LaneFloat entries;
  unsigned bits = entered_boxes(block.planes, ray, limit, entries);
  while (bits != 0) {
    const int lane = take_lowest(bits);
    QuadHit met;
    if (cross_quad(block.quads[lane], ray, met) && met.t < limit[0] && entries[lane] < limit[0]) return true;
  }
  return false;
}

template <class Block>
MLT_INLINE bool flat_occluded(const PrimitiveList<Block>& list, const RayFrame& ray, LaneFloat limit) {
  for (std::uint32_t i = 0; i < list.block_count; ++i) {
    if (blocks_ray(list.blocks[i], ray, limit)) return true;
  }
  return false;
}

template <class Block>
MLT_INLINE bool list_occluded(const PrimitiveList<Block>& list, const RayFrame& ray, LaneFloat limit) {
  if (list.nodes == nullptr) return flat_occluded(list, ray, limit);
  return traverse_any(list.nodes, ray, limit[0],
                      [&](std::uint32_t block) { return blocks_ray(list.blocks[block], ray, limit); });
}

template <bool kGeneral>
[[gnu::noinline]] Hit Geometry::intersect(const Ray& ray) const {
  const RayFrame frame(ray, extent_);
  BestHit best(ray.t_max);
  if constexpr (kGeneral) {
    best.visit_list(quads_, frame);
    best.visit_list(spheres_, frame);
    best.visit_list(triangles_, frame);
  } else {
    best.visit_flat(quads_, frame);
  }
  return best.hit;
}

template <bool kGeneral>
[[gnu::noinline]] bool Geometry::occluded(const Ray& ray) const {
  const RayFrame frame(ray, extent_);
  const LaneFloat limit = broadcast(ray.t_max);
  if constexpr (kGeneral) {
    return list_occluded(quads_, frame, limit) || list_occluded(spheres_, frame, limit) ||
           list_occluded(triangles_, frame, limit);
  } else {
    return flat_occluded(quads_, frame, limit);
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
  return quad_point(quads_.blocks[block].quads[lane], (hit.slot & kSecondTriangle) != 0, hit);
}

}  // namespace mlt
