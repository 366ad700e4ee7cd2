// Builds a wide bounding volume hierarchy top down, in memory bounded by the number of primitives alone. A
// node's children come from repeatedly splitting the child of the largest surface; splits minimise the
// surface area heuristic over bins [Wald07], and exactly for few primitives. No recursion, no heap. Any
// number of threads builds the same bits: what is a unit of work, and where its results go, follows from the
// references alone.
#pragma once

#include <cstdint>
#include <span>

#include "base/unit_runner.hpp"
#include "geometry/bvh.hpp"

namespace mlt {

inline constexpr std::uint32_t kLeafSize = kLanes;
/// No split leaves a side with fewer primitives than this, and fewer than twice as many are split so that all
/// leaves but one are full. This bounds the number of leaves.
inline constexpr std::uint32_t kSmallestSide = 4 * kLeafSize;
inline constexpr std::uint32_t kMaxBvhPrimitives = 1U << 30;

/// What the builder knows of a primitive: its box and its index within its kind.
struct alignas(32) BvhReference {
  float low[3];
  std::uint32_t index;
  float minus_high[3];  ///< so that boxes are joined by minima alone
  std::uint32_t unused;
};

/// Leaves of a hierarchy over `count` primitives. Every sequence of splits ends in groups of s_i primitives,
/// kSmallestSide <= s_i (or there is one group), which become ceil(s_i / kLeafSize) leaves each; the sum is
/// at most count / kLeafSize plus one per group.
constexpr std::uint64_t max_bvh_leaves(std::uint64_t count) {
  return (count + kLeafSize - 1) / kLeafSize + count / kSmallestSide;
}

/// Nodes of a hierarchy with that many leaves. A node that is not full has only leaves as children, at least
/// two; with F full and P other nodes, leaves = (width - 1) F + P + 1 at least, and P <= (width - 1) F + 1,
/// so F + P is largest at P = leaves / 2, F = (leaves / 2 - 1) / (width - 1).
constexpr std::uint64_t max_bvh_nodes(std::uint64_t count) {
  const std::uint64_t half = (max_bvh_leaves(count) + 1) / 2;
  return half + half / (kNodeWidth - 1) + 1;
}

/// From so many references on, the tree is divided into subtrees that are units of work.
inline constexpr std::uint32_t kSharedCount = 8192;

/// Subtrees at most.
constexpr std::uint64_t max_bvh_subtrees(std::uint64_t count) {
  const std::uint64_t subtrees = count / 256;
  return count < kSharedCount ? 1 : subtrees < 512 ? subtrees : 512;
}

/// Nodes that a build needs room for. Each subtree has room for its own maximum, which is proportional to its
/// references but for at most 2.4 nodes; above S subtrees are less than S / (width - 1) + 1
/// nodes.
constexpr std::uint64_t bvh_node_capacity(std::uint64_t count) {
  return max_bvh_nodes(count) + (count < kSharedCount ? 0 : 3 * max_bvh_subtrees(count));
}

/// In an order of primitives: this one is the last of its leaf.
inline constexpr std::uint32_t kLastOfLeaf = 0x80000000U;

/// Receives runs of whole leaves, the first of which is leaf `first_block` and each of which has 1 to
/// kLeafSize primitives. Called once for each run, in any order and by several threads, when the references
/// are not needed any more.
struct LeafWriter {
  void (*write)(void* context, std::uint32_t first_block, std::span<const std::uint32_t> order) = nullptr;
  void* context = nullptr;
};

struct BvhSize {
  std::uint32_t nodes = 0;  ///< there may be unused ones between them
  std::uint32_t blocks = 0;
  int levels = 0;
};

struct BvhWorkspace;

struct BvhStorage {
  std::span<BvhReference> references;  ///< in any order, which changes
  std::span<std::uint32_t> order;      ///< as many
  std::span<BvhNode> nodes;  ///< bvh_node_capacity(references.size()); those not used stay as they are
  BvhWorkspace* workspace = nullptr;  ///< needed from kSharedCount references on
};

/// Orders the references into a hierarchy. Boxes must be finite. No primitives give a root without children.
BvhSize build_bvh(const BvhStorage& storage, const LeafWriter& leaves, const UnitRunner& runner);

}  // namespace mlt
