// All shapes of a compiled scene behind two questions: what does a ray hit first, and is a segment blocked.
// Quads and triangles share one watertight formula (polygon.hpp); few primitives lie in a flat list of SIMD
// blocks, many in a wide bounding volume hierarchy (bvh.hpp). Results do not depend on the structure
// or on the SIMD width: a hit is a property of ray and primitive, and equal distances are resolved by
// primitive index. Memory belongs to the arena; a Geometry is a view of it, immutable after build.
#pragma once

#include <cstdint>
#include <span>

#include "base/memory.hpp"
#include "geometry/bvh.hpp"
#include "geometry/bvh_builder.hpp"
#include "geometry/flat_list.hpp"
#include "geometry/quad_block.hpp"
#include "geometry/ray.hpp"
#include "geometry/shapes.hpp"
#include "geometry/sphere.hpp"
#include "geometry/triangle_block.hpp"
#include "geometry/turns.hpp"

namespace mlt {

/// Counts fix the memory and the choice of structures; nothing else does.
struct GeometryCounts {
  std::uint32_t quads = 0;
  std::uint32_t triangles = 0;
  std::uint32_t spheres = 0;
};

/// Up to so many primitives lie in a flat list. The same for every SIMD width, so that the features of a
/// scene are. Where a bounce and a shadow ray of groups together cost the same as in a tree, with eight
/// lanes; with four that is at half as many, unless they are walls and blocks (tests/bench/ray_bench.cpp).
struct FlatLimits {
  std::uint32_t polygons = 112;  ///< quads and triangles together
  std::uint32_t triangles = 64;
  std::uint32_t spheres = 64;
  // Few polygons, or few quads beside a hierarchy of triangles, lie in a FlatList up to these, else in
  // QuadBlocks: with four lanes always where there are triangles, which the fast test sees as twice their
  // size.
  std::uint32_t bounded_quads = 112;
  std::uint32_t bounded_triangles = kLanes >= 8 ? 64 : 0;
};
static_assert(FlatLimits{}.polygons <= kFlatPolygons);

struct GeometryInput {
  std::span<const Quad> quads;
  TriangleList triangles;
  std::span<const Sphere> spheres;
};

/// Plan lines of one kind of primitive. A flat list has no nodes.
template <class Block>
struct KindSlots {
  std::uint32_t count = 0;
  bool flat = true;
  Slot<Block> blocks;
  Slot<BvhNode> nodes;
  Slot<std::uint32_t> order;
  Slot<BvhWorkspace> workspace;  ///< from kSharedCount primitives on
};

struct FlatSlots {
  std::uint32_t count = 0;
  Slot<FlatList> lists;
  /// Beside a hierarchy also, in the same slots of one list, for rays one by one: what they then meet faster.
  bool has_boxes = false;
  Slot<QuadBlock> boxes;
};

struct GeometrySlots {
  FlatSlots flat;              ///< quads where there are few, and the triangles when there are few of both
  KindSlots<QuadBlock> quads;  ///< or here
  KindSlots<TriangleBlock> triangles;
  KindSlots<SphereBlock> spheres;
};

/// Primitives of one kind. Without nodes, the `block_count` blocks are a flat list.
template <class Block>
struct PrimitiveList {
  const Block* blocks = nullptr;
  std::uint32_t block_count = 0;
  const BvhNode* nodes = nullptr;

  Bvh<Block> hierarchy() const { return {nodes, blocks}; }
};

class Geometry {
 public:
  /// Adds upper bounds of all blocks; about 77 bytes per triangle in a hierarchy. Throws
  /// ResourceError when a kind has more than kMaxBvhPrimitives.
  static GeometrySlots plan(MemoryPlan& plan, const GeometryCounts& counts, const FlatLimits& limits = {});

  /// `input` has the counts of the plan; all coordinates are finite, radii too. Primitives without area are
  /// never hit.
  static Geometry build(Arena& arena, const GeometrySlots& slots, const GeometryInput& input,
                        const UnitRunner& runner = {});

  /// Whether intersect<true> and occluded<true> are needed: whether there is more than a flat list of
  /// polygons.
  static bool is_general(const GeometryCounts& counts, const FlatLimits& limits = {});

  /// The closest hit at 0 < t < ray.t_max, by (t, primitive). A ray whose direction is 0 or not finite, or
  /// whose longest component lies outside [2^-60, 2^60], hits nothing or anything. kGeneral = false compiles
  /// code for one flat list of polygons alone.
  template <bool kGeneral>
  Hit intersect(const Ray& ray) const;

  /// Whether intersect would find a hit, on another polygon than `target`.
  template <bool kGeneral>
  bool occluded(const Ray& ray, std::uint32_t target = kNoPrimitive) const;

  /// The point of a hit that intersect found with the same ray.
  template <bool kGeneral>
  SurfacePoint surface_point(const Ray& ray, const Hit& hit) const;

  /// The same for each lane of `active`; nothing is known of other lanes. `leaves`, and that of `ends`, are
  /// the primitives that rays leave from origin_towards(), or kNoPrimitive. Where rays take turns, the
  /// `records` of primitives hit, if there are any, are asked for while other rays are on their way.
  template <bool kGeneral, class F, class Record = std::byte>
  HitOf<F> intersect_lanes(const RayOf<F>& ray, const UintOf<F>& leaves, const MaskOf<F>& active,
                           const Record* records = nullptr) const;
  template <bool kGeneral, class F>
  MaskOf<F> occluded_lanes(const RayOf<F>& ray, const SegmentEnds<F>& ends, const MaskOf<F>& active) const;
  template <bool kGeneral, class F>
  SurfacePointOf<F> surface_points(const RayOf<F>& ray, const HitOf<F>& hits, const MaskOf<F>& active) const;

  /// Largest absolute coordinate of any primitive.
  float extent() const { return extent_; }

 private:
  bool takes_turns() const {
    return triangles_.nodes != nullptr && first_sphere_ - first_in_triangles_ >= kLeastForTurns;
  }
  /// Whether rays in lanes meet all there is together but a hierarchy of triangles: one flat list of polygons
  /// at most, and if kGeneral, a flat list of spheres.
  template <bool kGeneral>
  bool has_lanes() const {
    if constexpr (!kGeneral) return !flat_lists_.empty();
    return flat_lists_.size() <= 1 && (!flat_lists_.empty() || quads_.block_count == 0) &&
           spheres_.nodes == nullptr && (triangles_.block_count == 0 || triangles_.nodes != nullptr);
  }
  std::span<const FlatList> lists_for_one() const {
    return quads_.block_count == 0 ? flat_lists_ : std::span<const FlatList>{};
  }
  template <class F, class Record>
  void intersect_triangles(const LaneRays<F>& rays, const MaskOf<F>& active, const Record* records,
                           HitOf<F>& hits) const;
  template <class F>
  MaskOf<F> triangles_occlude(const LaneRays<F>& rays, const UintOf<F>& targets,
                              const MaskOf<F>& active) const;

  // One of the two, or the same polygons in both.
  std::span<const FlatList> flat_lists_;
  PrimitiveList<QuadBlock> quads_;
  PrimitiveList<TriangleBlock> triangles_;
  PrimitiveList<SphereBlock> spheres_;
  std::uint32_t first_in_triangles_ = 0;  ///< first primitive index that is stored in triangles_
  std::uint32_t first_sphere_ = 0;
  float extent_ = 0;
};

}  // namespace mlt

#include "geometry/geometry_inline.hpp"
