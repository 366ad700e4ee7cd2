// A bounding volume hierarchy with kLanes children per node and one block of primitives per leaf, and two
// ways through it. Built by bvh_builder.hpp. Boxes are exact; the ray carries the padding that makes the test
// conservative (ray_frame.hpp).
#pragma once

#include <bit>
#include <cstddef>
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

/// Whether a way through a hierarchy asks for memory before the step that reads it, which helps where other
/// rays take their turns in between.
enum class Fetch : bool { when_read, ahead };

/// A node or a leaf that is to be visited next.
template <class Block>
MLT_INLINE void fetch(const Bvh<Block>& bvh, std::uint32_t child) {
  const void* place = (child & kLeafBit) != 0 ? static_cast<const void*>(bvh.blocks + (child & ~kLeafBit))
                                              : static_cast<const void*>(bvh.nodes + child);
  constexpr std::size_t kLine = 64;
  for (std::size_t at = 0; at < sizeof(BvhNode); at += kLine)
    __builtin_prefetch(static_cast<const std::byte*>(place) + at);
}

/// A ray's way to its closest hit, from the root on, in steps.
class ClosestWalk {
 public:
  /// Leaves the stack's places as they are, which {} alone would clear.
  MLT_INLINE ClosestWalk() {}

  /// Visits a node or a leaf, the latter by visit(block index) -> new limit, roughly from near to far; false
  /// after the last. `limit` is the distance beyond which hits do not matter; boxes entered exactly there are
  /// still visited.
  template <Fetch kFetch, class Block, class Visit>
  MLT_INLINE bool step(const Bvh<Block>& bvh, const RayFrame& ray, float limit, Visit&& visit) {
    if ((child_ & kLeafBit) != 0) {
      limit = visit(child_ & ~kLeafBit);
    } else {
      LaneFloat entry;
      const BvhNode& node = bvh.nodes[child_];
      // Needed once it is known which boxes are entered; its cache line can come at the same time as theirs.
      if constexpr (kFetch == Fetch::when_read) __builtin_prefetch(node.children);
      const unsigned bits = entered_boxes(node.planes, ray, broadcast(limit), entry);
      if (bits != 0) {
        if ((bits & (bits - 1)) == 0) {  // most often
          child_ = node.children[std::countr_zero(bits)];
          if constexpr (kFetch == Fetch::ahead) fetch(bvh, child_);
          return true;
        }
        push(node.children, entry, bits);
      }
    }
    do {
      if (size_ == 0) return false;
      --size_;
    } while (stack_[size_].distance > limit);
    child_ = stack_[size_].child;
    if constexpr (kFetch == Fetch::ahead) fetch(bvh, child_);
    return true;
  }

 private:
  struct Entry {
    std::uint32_t child;
    float distance;
  };

  MLT_INLINE void push(const std::uint32_t* children, const LaneFloat& entry, unsigned bits) {
    const int base = size_;
    do {
      const int lane = take_lowest(bits);
      // Insertion keeps the children of this node sorted, the nearest on top.
      const Entry added{children[lane], entry[lane]};
      int place = size_++;
      for (; place > base && stack_[place - 1].distance < added.distance; --place) {
        stack_[place] = stack_[place - 1];
      }
      stack_[place] = added;
    } while (bits != 0);
  }

  std::uint32_t child_ = 0;
  int size_ = 0;
  Entry stack_[kTraversalStack];
};

/// A ray's way to anything that blocks it, from the root on, in steps.
class AnyWalk {
 public:
  /// As that of ClosestWalk.
  MLT_INLINE AnyWalk() {}

  enum class Step : std::uint8_t { goes_on, found, ended };

  /// Visits a node or a leaf within reach, the latter by visit(block index) -> whether it blocks the ray, in
  /// no particular order.
  template <Fetch kFetch, class Block, class Visit>
  MLT_INLINE Step step(const Bvh<Block>& bvh, const RayFrame& ray, LaneFloat limit, Visit&& visit) {
    if ((child_ & kLeafBit) != 0) {
      if (visit(child_ & ~kLeafBit)) return Step::found;
    } else {
      LaneFloat entry;
      const std::uint32_t* children = bvh.nodes[child_].children;
      if constexpr (kFetch == Fetch::when_read) __builtin_prefetch(children);
      unsigned bits = entered_boxes(bvh.nodes[child_].planes, ray, limit, entry);
      if (bits != 0) {
        // The last one need not pass through memory.
        while ((bits & (bits - 1)) != 0) stack_[size_++] = children[take_lowest(bits)];
        child_ = children[std::countr_zero(bits)];
        if constexpr (kFetch == Fetch::ahead) fetch(bvh, child_);
        return Step::goes_on;
      }
    }
    if (size_ == 0) return Step::ended;
    child_ = stack_[--size_];
    if constexpr (kFetch == Fetch::ahead) fetch(bvh, child_);
    return Step::goes_on;
  }

 private:
  std::uint32_t child_ = 0;
  int size_ = 0;
  std::uint32_t stack_[kTraversalStack];
};

}  // namespace mlt
