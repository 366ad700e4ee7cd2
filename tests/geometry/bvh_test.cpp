// The builder: every primitive in exactly one leaf, boxes that enclose, and the bounds on memory and depth
// that planning and traversal rely on, for friendly and hostile inputs.
#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <memory>

#include "geometry/bvh_workspace.hpp"
#include "scene_fixture.hpp"
#include "support/threads.hpp"

namespace mlt::test {
namespace {

struct Inspection {
  std::vector<int> leaves_of;  ///< per primitive
  std::uint32_t leaves = 0;
  std::uint32_t partial_leaves = 0;
  int outside = 0;  ///< references that stick out of a box above them
};

/// Descends from the root, each node with the box that its parent gives it.
Inspection inspect(const std::vector<BvhNode>& nodes, const std::vector<std::vector<BvhReference>>& leaves,
                   std::size_t primitives) {
  struct Pending {
    std::uint32_t child;
    Vec3 low, high;
  };
  Inspection result;
  result.leaves_of.resize(primitives);
  const float inf = std::numeric_limits<float>::infinity();
  std::vector<Pending> pending{{0, Vec3{-inf, -inf, -inf}, Vec3{inf, inf, inf}}};
  while (!pending.empty()) {
    const Pending p = pending.back();
    pending.pop_back();
    if ((p.child & kLeafBit) != 0) {
      const std::vector<BvhReference>& leaf = leaves.at(p.child & ~kLeafBit);
      result.leaves += 1;
      result.partial_leaves += leaf.size() < kLeafSize;
      for (const BvhReference& r : leaf) {
        result.leaves_of.at(r.index) += 1;
        for (int k = 0; k < 3; ++k) result.outside += r.low[k] < p.low[k] || -r.minus_high[k] > p.high[k];
      }
      continue;
    }
    const BvhNode& node = nodes.at(p.child);
    for (int lane = 0; lane < kNodeWidth; ++lane) {
      Pending next{node.children[lane], Vec3{0, 0, 0}, Vec3{0, 0, 0}};
      for (int k = 0; k < 3; ++k) {
        next.low[k] = node.planes[k][0][lane];
        next.high[k] = node.planes[k][1][lane];
      }
      if (!(next.low.x <= next.high.x)) continue;
      for (int k = 0; k < 3; ++k) result.outside += next.low[k] < p.low[k] || next.high[k] > p.high[k];
      pending.push_back(next);
    }
  }
  return result;
}

/// A hierarchy with all that it was built in.
struct Built {
  explicit Built(std::vector<BvhReference> input, const UnitRunner& runner = {})
      : references(std::move(input)),
        order(references.size()),
        nodes(bvh_node_capacity(references.size())),
        workspace(std::make_unique<BvhWorkspace>()),
        block_of(references.size(), kNobody) {
    const LeafWriter writer{&Built::write, this};
    size = build_bvh({references, order, nodes, workspace.get()}, writer, runner);
  }

  static constexpr std::uint32_t kNobody = ~0U;

  /// Leaves may come at the same time, but never the same place of the order twice.
  static void write(void* context, std::uint32_t block, std::span<const std::uint32_t> run) {
    Built& self = *static_cast<Built*>(context);
    for (const std::uint32_t& entry : run) {
      const std::ptrdiff_t place = &entry - self.order.data();
      std::uint32_t& own = self.block_of.at(static_cast<std::size_t>(place));
      if (own != kNobody) self.overlaps.fetch_add(1);
      own = block;
      if ((entry & kLastOfLeaf) != 0) ++block;
    }
  }

  std::vector<BvhReference> references;
  std::vector<std::uint32_t> order;
  std::vector<BvhNode> nodes;
  std::unique_ptr<BvhWorkspace> workspace;
  std::vector<std::uint32_t> block_of;  ///< by place in the order
  std::atomic<int> overlaps{0};
  BvhSize size;
};

void check_build(std::vector<BvhReference> references, const UnitRunner& runner = {}) {
  const std::size_t count = references.size();
  for (std::size_t i = 0; i < count; ++i) references[i].index = static_cast<std::uint32_t>(i);
  const Built built(references, runner);
  CHECK(built.overlaps == 0);
  CHECK(built.size.levels <= kMaxLevels);
  CHECK(built.size.blocks <= max_bvh_leaves(count));
  CHECK(built.size.nodes <= bvh_node_capacity(count));
  std::vector<std::vector<BvhReference>> leaves(built.size.blocks);
  for (std::size_t i = 0; i < count; ++i) {
    leaves.at(built.block_of[i]).push_back(references.at(built.order[i] & ~kLastOfLeaf));
  }
  for (const std::vector<BvhReference>& leaf : leaves) {
    REQUIRE((leaf.size() >= 1 && leaf.size() <= kLeafSize));
  }
  const Inspection tree = inspect(built.nodes, leaves, count);
  CHECK(tree.leaves == built.size.blocks);
  CHECK(tree.outside == 0);
  CHECK(tree.partial_leaves <= count / kSmallestSide + 1);
  CHECK(std::count(tree.leaves_of.begin(), tree.leaves_of.end(), 1) == static_cast<std::ptrdiff_t>(count));
}

BvhReference reference_at(const Vec3& p, float size) {
  return {{p.x - size, p.y - size, p.z - size}, 0, {-(p.x + size), -(p.y + size), -(p.z + size)}, 0};
}

TEST_CASE("every number of primitives builds a tree within its bounds") {
  Rng rng(1, StreamPurpose::kTest, 20);
  for (std::size_t count = 0; count < 300; ++count) {
    std::vector<BvhReference> references;
    for (std::size_t i = 0; i < count; ++i) references.push_back(reference_at(point_in_cube(rng), 0.01f));
    check_build(references);
  }
  for (const std::size_t count : {1000, 5000, 20000}) {
    std::vector<BvhReference> references;
    for (std::size_t i = 0; i < count; ++i) {
      const float size = std::ldexp(1.0f, -static_cast<int>(below(rng, 20)));
      references.push_back(reference_at(point_in_cube(rng), size));
    }
    check_build(references);
  }
}

TEST_CASE("hostile inputs stay within the bounds on memory and depth") {
  constexpr std::size_t kCount = 20000;
  std::vector<BvhReference> same, line, shrinking, denormal, nested, pairs;
  for (std::size_t i = 0; i < kCount; ++i) {
    const float f = static_cast<float>(i);
    same.push_back(reference_at(Vec3{0.5f, 0.5f, 0.5f}, 0.1f));
    line.push_back(reference_at(Vec3{f / kCount, 0, 0}, 0.0f));
    // Ever smaller distances to the origin: equal bins split off a few at a time, as deep as possible.
    shrinking.push_back(reference_at(Vec3{std::ldexp(1.0f, -static_cast<int>(i % 140)), 0, 0}, 0.0f));
    denormal.push_back(reference_at(Vec3{std::ldexp(f, -149), 0, 0}, 0.0f));
    nested.push_back(reference_at(Vec3{0, 0, 0}, std::ldexp(1.0f, -static_cast<int>(i % 120))));
    pairs.push_back(reference_at(Vec3{i % 2 == 0 ? -1.0f : 1.0f, 0, 0}, 0.0f));
  }
  check_build(same);
  check_build(line);
  check_build(shrinking);
  check_build(denormal);
  check_build(nested);
  check_build(pairs);
}

TEST_CASE("a sequence that loses few primitives per level ends in halving before the stack is exhausted") {
  // Groups of just kSmallestSide at distances that shrink by 32 per group, more than the bins resolve, so
  // that each split takes one group off.
  std::vector<BvhReference> references;
  for (int group = 0; group < 28; ++group) {
    for (std::uint32_t i = 0; i < kSmallestSide; ++i) {
      references.push_back(reference_at(Vec3{std::ldexp(1.0f, 5 * (group - 20)), 0, 0}, 0.0f));
    }
  }
  const std::size_t cluster = 200000;
  for (std::size_t i = 0; i < cluster; ++i) references.push_back(reference_at(Vec3{0, 0, 0}, 0.0f));
  check_build(references);
}

bool same_bytes(const Built& a, const Built& b) {
  return a.size.nodes == b.size.nodes && a.size.blocks == b.size.blocks && a.order == b.order &&
         a.block_of == b.block_of &&
         std::memcmp(a.nodes.data(), b.nodes.data(), a.nodes.size() * sizeof(BvhNode)) == 0;
}

TEST_CASE("any number of threads builds the same tree, bit by bit") {
  Rng rng(3, StreamPurpose::kTest, 22);
  // Even, crowded in a corner, and all in one place; of sizes around those at which the work is divided anew.
  for (const std::size_t count :
       {std::size_t{kSharedCount - 1}, std::size_t{kSharedCount}, std::size_t{70000}}) {
    for (int kind = 0; kind < 3; ++kind) {
      std::vector<BvhReference> references;
      for (std::size_t i = 0; i < count; ++i) {
        const Vec3 p = point_in_cube(rng);
        const Vec3 moved = kind == 0 ? p : kind == 1 ? p * (p * p) * (p * p) : Vec3{0.25f, 0, 0};
        references.push_back(reference_at(moved, std::ldexp(1.0f, -static_cast<int>(below(rng, 12)) - 4)));
        references.back().index = static_cast<std::uint32_t>(i);
      }
      const Built serial(references);
      check_build(references);
      for (const unsigned count_of_threads : {1U, 2U, 3U, 7U}) {
        Threads threads(count_of_threads);
        INFO(count << " references of kind " << kind << ", threads: " << count_of_threads);
        CHECK(same_bytes(serial, Built(references, threads.runner())));
      }
    }
  }
}

/// The blocks and nodes of a mesh's hierarchy.
std::vector<std::byte> mesh_bytes(const std::vector<Triangle>& triangles, const UnitRunner& runner) {
  MemoryPlan plan;
  const GeometrySlots slots =
      Geometry::plan(plan, GeometryCounts{0, static_cast<std::uint32_t>(triangles.size()), 0});
  Arena arena(plan);
  const TriangleSoup soup(triangles);
  static_cast<void>(Geometry::build(arena, slots, {{}, soup.list(), {}}, runner));
  std::vector<std::byte> bytes(plan.bytes(Lifetime::kScene));
  // Scene blocks stand at the start of the arena, in the order of their lines: the leaves are the first.
  const auto blocks = arena.raw(slots.triangles.blocks);
  std::memcpy(bytes.data(), blocks.data(), bytes.size());
  return bytes;
}

TEST_CASE("any number of threads leaves the same bytes of a mesh in the arena") {
  std::vector<Triangle> triangles = tessellated_sphere(100, 101, 0.8f);
  // Triangles without area leave gaps between the references of different parts.
  for (std::size_t i = 0; i < triangles.size(); i += 97) triangles[i].b = triangles[i].a;
  const std::vector<std::byte> serial = mesh_bytes(triangles, {});
  for (const unsigned count : {1U, 2U, 3U, 7U}) {
    Threads threads(count);
    INFO("threads: " << count);
    CHECK(mesh_bytes(triangles, threads.runner()) == serial);
  }
}

TEST_CASE("memory of a mesh: at most 80 bytes a triangle, and 32 of scratch") {
  const std::uint32_t count = 100000;
  MemoryPlan plan;
  static_cast<void>(Geometry::plan(plan, GeometryCounts{0, count, 0}));
  CHECK(plan.bytes(Lifetime::kScene) <= std::size_t{80} * count);
  CHECK(plan.bytes(Lifetime::kScratch) <= std::size_t{32} * count + kPage);
  CHECK(Geometry::is_general(GeometryCounts{0, 0, 1}));
  CHECK(Geometry::is_general(GeometryCounts{FlatLimits{}.polygons, 1, 0}));
  CHECK_FALSE(Geometry::is_general(GeometryCounts{FlatLimits{}.polygons - 1, 1, 0}));
  CHECK(Geometry::is_general(GeometryCounts{0, FlatLimits{}.triangles + 1, 0}));
  CHECK_FALSE(Geometry::is_general(GeometryCounts{0, FlatLimits{}.triangles, 0}));
  MemoryPlan none;
  static_cast<void>(Geometry::plan(none, GeometryCounts{}));
  CHECK(none.lines().empty());
}

}  // namespace
}  // namespace mlt::test
