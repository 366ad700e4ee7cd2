// Builds a wide bounding volume hierarchy top down, in memory bounded by the number of primitives alone. A
// node's children come from repeatedly splitting the child of the largest surface; splits minimise the
// surface area heuristic over bins [Wald07], and exactly for few primitives. Deterministic, no recursion,
// no heap.
#pragma once

#include <cstdint>
#include <span>

#include "geometry/bvh.hpp"

namespace mlt {

inline constexpr std::uint32_t kLeafSize = kLanes;
/// No split leaves a side with fewer primitives than this, and fewer than twice as many are split so that all
/// leaves but one are full. This bounds the number of leaves.
inline constexpr std::uint32_t kSmallestSide = 4 * kLeafSize;
inline constexpr std::uint32_t kMaxBvhPrimitives = 1U << 30;

/// What the builder knows of a primitive: its box and its index within its kind. Two SIMD quadruples.
struct alignas(16) BvhReference {
  float low[3];
  std::uint32_t index;
  float high[3];
  std::uint32_t padding;
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

/// Receives leaf `block` with the primitives of `references` (1 to kLeafSize). Blocks are numbered in the
/// order of the calls, and each call has the references that follow those of the call before: behind the last
/// it may overwrite them.
struct LeafWriter {
  void (*write)(void* context, std::uint32_t block, std::span<const BvhReference> references) = nullptr;
  void* context = nullptr;
};

struct BvhSize {
  std::uint32_t nodes = 0;
  std::uint32_t blocks = 0;
  int levels = 0;
};

/// Orders `references` (changed) into a hierarchy in `nodes`, which holds max_bvh_nodes(references.size()).
/// Boxes must be finite. No primitives give a root without children.
BvhSize build_bvh(std::span<BvhReference> references, std::span<BvhNode> nodes, const LeafWriter& leaves);

}  // namespace mlt
