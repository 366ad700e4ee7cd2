#include "geometry/geometry.hpp"

#include <algorithm>
#include <cstddef>
#include <new>
#include <string>

#include "base/error.hpp"
#include "geometry/bvh_workspace.hpp"
#include "shape_blocks.hpp"

namespace mlt {
namespace {

/// Quads, and triangles as quads after them.
struct PolygonList {
  std::span<const Quad> quads;
  TriangleList triangles;

  std::size_t size() const { return quads.size() + triangles.size(); }
  Quad operator[](std::size_t i) const {
    if (i < quads.size()) return quads[i];
    const Triangle t = triangles[i - quads.size()];
    return Quad{t.a, t.b, t.c, t.a};
  }
};

/// Asks for the memory of shape `i`.
template <class Shape>
void prefetch(std::span<const Shape> shapes, std::size_t i) {
  __builtin_prefetch(&shapes[i]);
}
void prefetch(const TriangleList& triangles, std::size_t i) {
  __builtin_prefetch(&triangles.corners[i]);
}
void prefetch(const PolygonList& polygons, std::size_t i) {
  if (i < polygons.quads.size()) prefetch(polygons.quads, i);
}

/// Shapes asked for ahead of those that are written.
constexpr std::size_t kPrefetched = 16;

/// The primitives of one kind while they are built. `first` is the primitive index of the first shape.
template <class Block, class Shapes>
struct KindBuild {
  std::span<Block> blocks;
  Shapes shapes;
  std::uint32_t first;

  void write_block(std::uint32_t index, std::span<const std::uint32_t> lanes) {
    MLT_CHECK_OP(index, <, blocks.size());
    for (int lane = 0; lane < kLanes; ++lane) {
      if (static_cast<std::size_t>(lane) >= lanes.size()) {
        clear_lane(blocks[index], lane);
        continue;
      }
      const std::uint32_t shape = lanes[static_cast<std::size_t>(lane)];
      set_lane(blocks[index], lane, shapes[shape], first + shape);
    }
  }

  void write_leaves(std::uint32_t block, std::span<const std::uint32_t> order) {
    std::uint32_t lanes[kLanes];
    std::size_t filled = 0;
    for (std::size_t i = 0; i < order.size(); ++i) {
      if (i + kPrefetched < order.size()) prefetch(shapes, order[i + kPrefetched] & ~kLastOfLeaf);
      lanes[filled++] = order[i] & ~kLastOfLeaf;
      if ((order[i] & kLastOfLeaf) == 0) continue;
      write_block(block++, {lanes, filled});
      filled = 0;
    }
  }
};

/// Blocks whose storage holds the leaves of `count` primitives, and before them the references of the build.
template <class Block>
constexpr std::uint64_t leaf_blocks(std::uint64_t count) {
  return std::max(max_bvh_leaves(count), (count * sizeof(BvhReference) + sizeof(Block) - 1) / sizeof(Block));
}

/// What one part of the shapes left in its part of the references.
struct PlacedChunk {
  std::uint32_t count = 0;
  float extent = 0;
};

float largest_coordinate(const Bounds& b, float extent) {
  MLT_CHECK(is_finite(b.low) && is_finite(b.high));
  return std::max({extent, -b.low.x, -b.low.y, -b.low.z, b.high.x, b.high.y, b.high.z});
}

/// The primitives that have an area, in the leaves' storage.
template <class Block, class Shapes>
std::span<BvhReference> place_references(const KindBuild<Block, Shapes>& build, float& extent,
                                         const UnitRunner& runner) {
  const auto count = static_cast<std::uint32_t>(build.shapes.size());
  auto* const all = reinterpret_cast<BvhReference*>(build.blocks.data());
  const Chunks chunks(0, count);
  PlacedChunk placed[Chunks::kMax];
  runner.run(chunks.count, [&](std::uint64_t c) {
    BvhReference* next = all + chunks.begin(c);
    PlacedChunk own;
    for (std::uint32_t i = chunks.begin(c); i < chunks.end(c); ++i) {
      const auto shape = build.shapes[i];
      const Bounds b = bounds_of(shape);
      own.extent = largest_coordinate(b, own.extent);
      if (!has_area(shape)) continue;
      ::new (next++) BvhReference{{b.low.x, b.low.y, b.low.z}, i, {-b.high.x, -b.high.y, -b.high.z}, 0};
    }
    own.count = static_cast<std::uint32_t>(next - (all + chunks.begin(c)));
    placed[c] = own;
  });
  BvhReference* end = all;
  for (std::uint32_t c = 0; c < chunks.count; ++c) {
    extent = std::max(extent, placed[c].extent);
    const BvhReference* const begin = all + chunks.begin(c);
    end = begin == end ? end + placed[c].count : std::copy_n(begin, placed[c].count, end);
  }
  return {all, end};
}

template <class Block, class Shapes>
PrimitiveList<Block> build_flat(KindBuild<Block, Shapes> build) {
  std::uint32_t count = 0;
  std::uint32_t block[kLanes];
  std::uint32_t filled = 0;
  for (std::uint32_t i = 0; i < build.shapes.size(); ++i) {
    if (has_area(build.shapes[i])) block[filled++] = i;
    if (filled == kLanes || (i + 1 == build.shapes.size() && filled > 0)) {
      build.write_block(count++, {block, filled});
      filled = 0;
    }
  }
  return {build.blocks.data(), count, nullptr};
}

template <class Shapes>
void include_extent(const Shapes& shapes, float& extent) {
  for (std::size_t i = 0; i < shapes.size(); ++i) extent = largest_coordinate(bounds_of(shapes[i]), extent);
}

template <class Block, class Shapes>
PrimitiveList<Block> build_tree(Arena& arena, const KindSlots<Block>& slots, KindBuild<Block, Shapes> build,
                                float& extent, const UnitRunner& runner) {
  const auto write = [](void* context, std::uint32_t block, std::span<const std::uint32_t> order) {
    static_cast<KindBuild<Block, Shapes>*>(context)->write_leaves(block, order);
  };
  const std::span<BvhReference> references = place_references(build, extent, runner);
  const std::span<BvhNode> nodes = arena.raw(slots.nodes);
  BvhStorage storage{references, arena.raw(slots.order).first(references.size()), nodes, nullptr};
  if (slots.count >= kSharedCount) storage.workspace = arena.take(slots.workspace).data();
  const BvhSize size = build_bvh(storage, LeafWriter{write, &build}, runner);
  return {build.blocks.data(), size.blocks, nodes.data()};
}

template <class Block, class Shapes>
PrimitiveList<Block> build_kind(Arena& arena, const KindSlots<Block>& slots, const Shapes& shapes,
                                std::uint32_t first, float& extent, const UnitRunner& runner) {
  MLT_CHECK_OP(shapes.size(), ==, slots.count);
  if (slots.count == 0) return {};
  const KindBuild<Block, Shapes> build{arena.raw(slots.blocks), shapes, first};
  if (!slots.flat) return build_tree(arena, slots, build, extent, runner);
  include_extent(shapes, extent);
  return build_flat(build);
}

FlatSlots plan_flat(MemoryPlan& plan, const std::string& name, std::uint32_t count, bool beside_tree) {
  FlatSlots slots;
  slots.count = count;
  if (count == 0) return slots;
  slots.lists = plan.add<FlatList>(name + ", flat list", Lifetime::kScene, (count - 1) / kFlatPolygons + 1);
  slots.has_boxes = beside_tree && count <= kFlatPolygons;
  // Each axis may leave a block that is not full.
  if (slots.has_boxes)
    slots.boxes = plan.add<QuadBlock>(name + ", boxes", Lifetime::kScene, count / kLanes + 3);
  return slots;
}

FlatPolygon make_polygon(const Quad& q, std::uint32_t primitive) {
  FlatPolygon polygon{};
  set_record(polygon.quad, q, primitive);
  const Bounds b = bounds_of(q);
  for (int axis = 0; axis < 3; ++axis) {
    polygon.low[axis] = b.low[axis];
    polygon.high[axis] = b.high[axis];
  }
  return polygon;
}

std::span<const FlatList> build_flat_lists(Arena& arena, const FlatSlots& slots, const PolygonList& shapes,
                                           float& extent) {
  MLT_CHECK_OP(shapes.size(), ==, slots.count);
  include_extent(shapes, extent);
  if (slots.count == 0) return {};
  const std::span<FlatList> lists = arena.take(slots.lists);
  for (std::uint32_t list = 0; list < lists.size(); ++list) {
    const std::uint32_t begin = list * kFlatPolygons;
    const std::uint32_t end = std::min(begin + kFlatPolygons, slots.count);
    FlatListBuilder builder(lists[list], list * kFlatSlots, extent);
    // All aligned polygons of an axis, then the others of it, and so on.
    for (int part = 0; part < 6; ++part) {
      const int axis = part / 2;
      const bool aligned = part % 2 == 0;
      for (std::uint32_t i = begin; i < end; ++i) {
        const Quad q = shapes[i];
        if (has_area(q) && FlatListBuilder::axis_of(q) == axis && FlatListBuilder::is_aligned(q) == aligned)
          builder.add(axis, q, make_polygon(q, i));
      }
    }
    builder.finish();
  }
  return lists;
}

/// The polygons of a list in the same slots.
PrimitiveList<QuadBlock> build_boxes(Arena& arena, const FlatSlots& slots, const FlatList& list,
                                     const PolygonList& shapes) {
  const std::span<QuadBlock> blocks = arena.take(slots.boxes);
  MLT_CHECK_OP(list.block_count, <=, blocks.size());
  for (std::uint32_t i = 0; i < list.block_count; ++i) {
    for (int lane = 0; lane < kLanes; ++lane) {
      const std::uint32_t primitive = list.blocks[i].primitive[lane];
      if (static_cast<std::uint32_t>(lane) < list.blocks[i].used) {
        set_lane(blocks[i], lane, shapes[primitive], primitive);
      } else {
        clear_lane(blocks[i], lane);
      }
    }
  }
  return {blocks.data(), list.block_count, nullptr};
}

bool has_many_polygons(const GeometryCounts& counts, const FlatLimits& limits) {
  return std::uint64_t{counts.quads} + counts.triangles > limits.polygons ||
         counts.triangles > limits.triangles;
}

template <class Block>
KindSlots<Block> plan_kind(MemoryPlan& plan, const std::string& name, std::uint32_t count,
                           std::uint32_t flat_limit) {
  if (count > kMaxBvhPrimitives) {
    throw ResourceError(name + ": " + std::to_string(count) + " are too many, the most allowed are " +
                        std::to_string(kMaxBvhPrimitives));
  }
  KindSlots<Block> slots;
  slots.count = count;
  slots.flat = count <= flat_limit;
  if (count == 0) return slots;
  if (slots.flat) {
    slots.blocks = plan.add<Block>(name + ", flat list", Lifetime::kScene, (count + kLanes - 1) / kLanes);
    return slots;
  }
  slots.blocks = plan.add<Block>(name + ", leaves", Lifetime::kScene, leaf_blocks<Block>(count));
  slots.nodes = plan.add<BvhNode>(name + ", hierarchy", Lifetime::kScene, bvh_node_capacity(count));
  slots.order = plan.add<std::uint32_t>(name + ", order", Lifetime::kScratch, count);
  if (count < kSharedCount) return slots;
  slots.workspace = plan.add<BvhWorkspace>(name + ", build of the hierarchy", Lifetime::kScratch, 1);
  return slots;
}

}  // namespace

GeometrySlots Geometry::plan(MemoryPlan& plan, const GeometryCounts& counts, const FlatLimits& limits) {
  const bool few = !has_many_polygons(counts, limits);
  GeometrySlots slots;
  const std::uint32_t count = few ? counts.quads + counts.triangles : counts.quads;
  const std::string name = few ? "polygons" : "quads";
  if (counts.spheres <= limits.spheres && counts.quads <= limits.bounded_quads &&
      (!few || counts.triangles <= limits.bounded_triangles)) {
    slots.flat = plan_flat(plan, name, count, !few);
  } else {
    slots.quads = plan_kind<QuadBlock>(plan, name, count, limits.polygons);
  }
  slots.triangles = plan_kind<TriangleBlock>(plan, "triangles", few ? 0 : counts.triangles, 0);
  slots.spheres = plan_kind<SphereBlock>(plan, "spheres", counts.spheres, limits.spheres);
  return slots;
}

Geometry Geometry::build(Arena& arena, const GeometrySlots& slots, const GeometryInput& input,
                         const UnitRunner& runner) {
  Geometry geometry;
  const auto quads = static_cast<std::uint32_t>(input.quads.size());
  const bool few = slots.triangles.count == 0;
  geometry.first_in_triangles_ = few ? quads + static_cast<std::uint32_t>(input.triangles.size()) : quads;
  geometry.first_sphere_ = geometry.first_in_triangles_ + slots.triangles.count;
  float extent = 0.0f;
  const PolygonList polygons{input.quads, few ? input.triangles : TriangleList{}};
  if (slots.quads.count > 0) {
    geometry.quads_ = build_kind(arena, slots.quads, polygons, 0, extent, runner);
  } else {
    geometry.flat_lists_ = build_flat_lists(arena, slots.flat, polygons, extent);
    if (slots.flat.has_boxes) {
      geometry.quads_ = build_boxes(arena, slots.flat, geometry.flat_lists_[0], polygons);
    }
  }
  geometry.triangles_ = build_kind(arena, slots.triangles, few ? TriangleList{} : input.triangles,
                                   geometry.first_in_triangles_, extent, runner);
  geometry.spheres_ = build_kind(arena, slots.spheres, input.spheres, geometry.first_sphere_, extent, runner);
  geometry.extent_ = extent;
  return geometry;
}

bool Geometry::is_general(const GeometryCounts& counts, const FlatLimits& limits) {
  return counts.spheres > 0 || has_many_polygons(counts, limits);
}

}  // namespace mlt
