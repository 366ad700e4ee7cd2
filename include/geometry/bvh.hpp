// A bounding volume hierarchy with kLanes children per node and one block of primitives per leaf, and its two
// traversals. Built by bvh_builder.hpp. Boxes are exact; the ray carries the padding that makes the test
// conservative (ray_frame.hpp).
#pragma once

#include <bit>
#include <cstdint>
#include <span>

#include "base/assert.hpp"
#include "geometry/ray_frame.hpp"

namespace mlt {

inline constexpr int kNodeWidth = kLanes;
inline constexpr std::uint32_t kLeafBit = 0x80000000U;

/// Levels of nodes up to this one are split by surface area, then by halves, of which 31 bits of count need
/// at most 31 / log2(width) more.
inline constexpr int kSurfaceAreaLevels = 32;
inline constexpr int kMaxLevels = kSurfaceAreaLevels + (kNodeWidth == 8 ? 11 : 16);
/// A node on the way down leaves at most width - 1 siblings behind.
inline constexpr int kTraversalStack = kMaxLevels * (kNodeWidth - 1) + 1;

/// Children's boxes by axis and side (0 low, 1 high). An absent child has an empty box, low above high.
struct alignas(64) BvhNode {
  LaneFloat planes[3][2];
  std::uint32_t children[kNodeWidth];  ///< index of a node, or kLeafBit | index of a block
};

template <class Block>
struct Bvh {
  const BvhNode* nodes = nullptr;  ///< the first is the root
  const Block* blocks = nullptr;
};

/// The boxes, by axis and side, that the ray enters before it leaves them, at a distance <= limit.
MLT_INLINE unsigned entered_boxes(const LaneFloat (&planes)[3][2], const RayFrame& ray, LaneFloat limit,
                                  LaneFloat& entry) {
  LaneFloat exit = limit;
  entry = LaneFloat{};
#pragma GCC unroll 4
  for (int axis = 0; axis < 3; ++axis) {
    const int near_side = ray.near_side[axis];
    const LaneFloat near_plane = planes[axis][near_side];
    const LaneFloat far_plane = planes[axis][1 - near_side];
    entry = max_lanes(entry, (near_plane - ray.near_origin[axis]) * ray.inverse[axis]);
    exit = min_lanes(exit, (far_plane - ray.far_origin[axis]) * ray.inverse[axis]);
  }
  return lane_bits(entry <= exit);
}

/// Calls visit(block index) -> new limit for the leaves near enough, roughly from near to far. `limit` is the
/// distance beyond which hits do not matter; boxes entered exactly there are still visited.
template <class Visit>
MLT_INLINE void traverse_closest(const BvhNode* nodes, const RayFrame& ray, float limit, Visit&& visit) {
  struct Entry {
    std::uint32_t child;
    float distance;
  };
  Entry stack[kTraversalStack];
  int size = 0;
  std::uint32_t child = 0;
  for (;;) {
    if ((child & kLeafBit) != 0) {
      limit = visit(child & ~kLeafBit);
    } else {
      LaneFloat entry;
      const std::uint32_t* children = nodes[child].children;
      // Needed once it is known which boxes are entered; its cache line can come at the same time as theirs.
      __builtin_prefetch(children);
      unsigned bits = entered_boxes(nodes[child].planes, ray, broadcast(limit), entry);
      if (bits != 0) {
        if ((bits & (bits - 1)) == 0) {  // most often
          child = children[std::countr_zero(bits)];
          continue;
        }
        const int base = size;
        do {
          const int lane = take_lowest(bits);
          // Insertion keeps the children of this node sorted, the nearest on top.
          const Entry added{children[lane], entry[lane]};
          int place = size++;
          for (; place > base && stack[place - 1].distance < added.distance; --place) {
            stack[place] = stack[place - 1];
          }
          stack[place] = added;
        } while (bits != 0);
      }
    }
    do {
      if (size == 0) return;
      --size;
    } while (stack[size].distance > limit);
    child = stack[size].child;
  }
}

/// Calls visit(block index) -> bool for the leaves within reach, in no particular order, until one says true;
/// returns whether one did.
template <class Visit>
MLT_INLINE bool traverse_any(const BvhNode* nodes, const RayFrame& ray, float limit, Visit&& visit) {
  std::uint32_t stack[kTraversalStack];
  int size = 0;
  const LaneFloat limits = broadcast(limit);
  std::uint32_t child = 0;
  for (;;) {
    if ((child & kLeafBit) != 0) {
      if (visit(child & ~kLeafBit)) return true;
    } else {
      LaneFloat entry;
      const std::uint32_t* children = nodes[child].children;
      __builtin_prefetch(children);
      unsigned bits = entered_boxes(nodes[child].planes, ray, limits, entry);
      if (bits != 0) {
        // The last one need not pass through memory.
        while ((bits & (bits - 1)) != 0) stack[size++] = children[take_lowest(bits)];
        child = children[std::countr_zero(bits)];
        continue;
      }
    }
    if (size == 0) return false;
    child = stack[--size];
  }
}

}  // namespace mlt
