#include "geometry/geometry.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "base/error.hpp"

namespace mlt {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

struct Bounds {
  Vec3 low{0, 0, 0}, high{0, 0, 0};
};

Bounds bounds_of(const Vec3& a, const Vec3& b) {
  return {Vec3{std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)},
          Vec3{std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}};
}

Bounds join(const Bounds& p, const Bounds& q) {
  return {bounds_of(p.low, q.low).low, bounds_of(p.high, q.high).high};
}

Bounds bounds_of(const Triangle& t) {
  return join(bounds_of(t.a, t.b), bounds_of(t.c, t.c));
}
Bounds bounds_of(const Quad& q) {
  return join(bounds_of(q.a, q.b), bounds_of(q.c, q.d));
}
/// With the same roundings as box_entry of sphere.hpp.
Bounds bounds_of(const Sphere& s) {
  const Vec3 radius{s.radius, s.radius, s.radius};
  return {s.center - radius, s.center + radius};
}

/// In double, where the differences and products of most floats are exact.
bool has_area(const Vec3& a, const Vec3& b, const Vec3& c) {
  return cross(DVec3{b} - DVec3{a}, DVec3{c} - DVec3{a}) != DVec3{0, 0, 0};
}
bool has_area(const Triangle& t) {
  return has_area(t.a, t.b, t.c);
}
bool has_area(const Quad& q) {
  return has_area(q.a, q.b, q.c);
}
bool has_area(const Sphere& s) {
  return s.radius > 0.0f;
}

void set_corner(LaneFloat* x, LaneFloat* y, LaneFloat* z, int lane, const Vec3& p) {
  (*x)[lane] = p.x;
  (*y)[lane] = p.y;
  (*z)[lane] = p.z;
}

template <int kVertices>
void set_corner(PolygonBlock<kVertices>& block, int vertex, int lane, const Vec3& p) {
  set_corner(&block.corners[0][vertex], &block.corners[1][vertex], &block.corners[2][vertex], lane, p);
}

void set_lane(PolygonBlock<3>& block, int lane, const Triangle& t) {
  set_corner(block, 0, lane, t.a);
  set_corner(block, 1, lane, t.b);
  set_corner(block, 2, lane, t.c);
}

void set_lane(PolygonBlock<4>& block, int lane, const Quad& q) {
  set_corner(block, 0, lane, q.a);
  set_corner(block, 1, lane, q.b);
  set_corner(block, 2, lane, q.c);
  set_corner(block, 3, lane, q.d);
  set_corner(&block.normals.axis[0], &block.normals.axis[1], &block.normals.axis[2], lane,
             unit_normal(q.a, q.b, q.c));
}

void set_lane(SphereBlock& block, int lane, const Sphere& s) {
  set_corner(&block.center[0], &block.center[1], &block.center[2], lane, s.center);
  block.radius[lane] = s.radius;
}

template <int kVertices>
void clear_lane(PolygonBlock<kVertices>& block, int lane) {
  for (int i = 0; i < kVertices; ++i) set_corner(block, i, lane, Vec3{kNaN, kNaN, kNaN});
  block.primitive[lane] = kNoPrimitive;
}

void clear_lane(SphereBlock& block, int lane) {
  set_lane(block, lane, Sphere{Vec3{kNaN, kNaN, kNaN}, kNaN});
  block.primitive[lane] = kNoPrimitive;
}

/// The primitives of one kind while they are built. `first` is the primitive index of the first shape.
template <class Block, class Shape>
struct KindBuild {
  std::span<Block> blocks;
  std::span<const Shape> shapes;
  std::uint32_t first;

  void write_block(std::uint32_t index, std::span<const BvhReference> references) {
    MLT_CHECK_OP(index, <, blocks.size());
    for (int lane = 0; lane < kLanes; ++lane) {
      if (static_cast<std::size_t>(lane) >= references.size()) {
        clear_lane(blocks[index], lane);
        continue;
      }
      const std::uint32_t shape = references[static_cast<std::size_t>(lane)].index;
      set_lane(blocks[index], lane, shapes[shape]);
      blocks[index].primitive[lane] = first + shape;
    }
  }
};

template <class Block, class Shape>
PrimitiveList<Block> build_flat(KindBuild<Block, Shape> build) {
  std::uint32_t count = 0;
  BvhReference block[kLanes];
  std::uint32_t filled = 0;
  for (std::uint32_t i = 0; i < build.shapes.size(); ++i) {
    if (has_area(build.shapes[i])) block[filled++].index = i;
    if (filled == kLanes || (i + 1 == build.shapes.size() && filled > 0)) {
      build.write_block(count++, {block, filled});
      filled = 0;
    }
  }
  return {build.blocks.data(), count, nullptr};
}

template <class Block, class Shape>
PrimitiveList<Block> build_tree(KindBuild<Block, Shape> build, std::span<BvhReference> references,
                                std::span<BvhNode> nodes) {
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < build.shapes.size(); ++i) {
    if (!has_area(build.shapes[i])) continue;
    const Bounds b = bounds_of(build.shapes[i]);
    references[count++] = {{b.low.x, b.low.y, b.low.z}, i, {b.high.x, b.high.y, b.high.z}, 0};
  }
  const auto write = [](void* context, std::uint32_t block, std::span<const BvhReference> leaf) {
    static_cast<KindBuild<Block, Shape>*>(context)->write_block(block, leaf);
  };
  const BvhSize size = build_bvh(references.first(count), nodes, LeafWriter{write, &build});
  return {build.blocks.data(), size.blocks, nodes.data()};
}

template <class Block, class Shape>
PrimitiveList<Block> build_kind(Arena& arena, const KindSlots<Block>& slots, std::span<const Shape> shapes,
                                std::uint32_t first, float& extent) {
  MLT_CHECK_OP(shapes.size(), ==, slots.count);
  for (const Shape& shape : shapes) {
    const Bounds b = bounds_of(shape);
    MLT_CHECK(is_finite(b.low) && is_finite(b.high));
    extent = std::max({extent, -b.low.x, -b.low.y, -b.low.z, b.high.x, b.high.y, b.high.z});
  }
  if (slots.count == 0) return {};
  const KindBuild<Block, Shape> build{arena.take(slots.blocks), shapes, first};
  if (slots.flat) return build_flat(build);
  return build_tree(build, arena.take(slots.references), arena.take(slots.nodes));
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
  slots.blocks = plan.add<Block>(name + ", leaves", Lifetime::kScene, max_bvh_leaves(count));
  slots.nodes = plan.add<BvhNode>(name + ", hierarchy", Lifetime::kScene, max_bvh_nodes(count));
  slots.references = plan.add<BvhReference>(name + ", build", Lifetime::kScratch, count);
  return slots;
}

}  // namespace

GeometrySlots Geometry::plan(MemoryPlan& plan, const GeometryCounts& counts, const FlatLimits& limits) {
  GeometrySlots slots;
  slots.quads = plan_kind<PolygonBlock<4>>(plan, "quads", counts.quads, limits.quads);
  slots.triangles = plan_kind<PolygonBlock<3>>(plan, "triangles", counts.triangles, limits.triangles);
  slots.spheres = plan_kind<SphereBlock>(plan, "spheres", counts.spheres, limits.spheres);
  return slots;
}

Geometry Geometry::build(Arena& arena, const GeometrySlots& slots, const GeometryInput& input) {
  Geometry geometry;
  geometry.first_triangle_ = slots.quads.count;
  geometry.first_sphere_ = slots.quads.count + slots.triangles.count;
  float extent = 0.0f;
  geometry.quads_ = build_kind(arena, slots.quads, input.quads, 0, extent);
  geometry.triangles_ = build_kind(arena, slots.triangles, input.triangles, geometry.first_triangle_, extent);
  geometry.spheres_ = build_kind(arena, slots.spheres, input.spheres, geometry.first_sphere_, extent);
  geometry.extent_ = extent;
  return geometry;
}

bool Geometry::is_general(const GeometryCounts& counts, const FlatLimits& limits) {
  return counts.triangles > 0 || counts.spheres > 0 || counts.quads > limits.quads;
}

}  // namespace mlt
