// What a build that is divided among threads keeps beside the tree.
#pragma once

#include <algorithm>
#include <cstdint>

#include "geometry/bvh_split.hpp"

namespace mlt {

/// A run of references in parts of equal size, whose number follows from that of the references.
struct Chunks {
  static constexpr std::uint32_t kMax = 64;
  static constexpr std::uint32_t kSmallest = 4096;

  Chunks(std::uint32_t run_begin, std::uint32_t run_end)
      : first(run_begin),
        last(run_end),
        size(std::max(kSmallest, (run_end - run_begin + kMax - 1) / kMax)),
        count((run_end - run_begin + size - 1) / size) {}

  std::uint32_t begin(std::uint64_t chunk) const { return first + static_cast<std::uint32_t>(chunk) * size; }
  std::uint32_t end(std::uint64_t chunk) const {
    return last - begin(chunk) > size ? begin(chunk) + size : last;
  }

  std::uint32_t first, last, size, count;
};

/// A part of the tree that one thread builds.
struct Subtree {
  Range range;
  std::uint32_t parent = 0;
  int lane = 0;
  int level = 0;  ///< 0: the root, which has no parent
  std::uint32_t first_node = 0;
  std::uint32_t first_block = 0;
  BvhSize size;
};

struct OpenedNode {
  Range children[kNodeWidth];
  int count = 0;
};

struct BvhWorkspace {
  static constexpr std::uint32_t kMaxSubtrees = 512;
  static constexpr std::uint32_t kMaxOpened = 64;

  BinSet bins[Chunks::kMax];
  Partition partitions[Chunks::kMax];
  Range ranges[Chunks::kMax];
  Subtree subtrees[kMaxSubtrees];
  OpenedNode opened[kMaxOpened];
};

}  // namespace mlt
