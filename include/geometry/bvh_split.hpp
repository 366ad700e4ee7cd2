// One split of a run of references in two: over bins where there are many [Wald07], and exactly for few.
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "geometry/bvh_range.hpp"

namespace mlt {

inline constexpr int kBins = 16;
/// Fewer than so many references are split exactly.
inline constexpr std::uint32_t kSmallCount = 2 * kSmallestSide;
static_assert(kSmallCount <= 64);

/// Assigns references to bins of equal width between the outermost centres, on each axis.
struct Binning {
  explicit Binning(const Range& range);

  /// In units of bins, from 0 to less than kBins. The bin is the integer below.
  MLT_INLINE Float4 position(const Box& box) const {
    return ((box.low() - box.minus_high()) - origin) * scale;
  }

  Float4 origin;
  Float4 scale{};
};

struct BinSplit {
  float cost = std::numeric_limits<float>::infinity();
  int axis = 0;
  int first_right = 0;  ///< bin
  Box left, right;

  bool exists() const { return cost < std::numeric_limits<float>::infinity(); }
};

/// Boxes and numbers of the references in each bin of each axis.
struct BinSet {
  void add(std::span<const BvhReference> references, const Binning& binning);
  void include(const BinSet& other);
  /// The cheapest split between bins that leaves kSmallestSide on both sides, if any.
  BinSplit cheapest_split() const;

  Box boxes[3][kBins];
  std::uint32_t counts[3][kBins] = {};
};

/// Where a run of references was divided, and the centres on both sides.
struct Partition {
  std::uint32_t left_count = 0;
  Box left_centers, right_centers;
};

/// Moves the references left of the split to the front of `run`.
Partition partition(std::span<BvhReference> run, const Binning& binning, const BinSplit& split);

/// The two sides of `range`, the first of which has `left_count` references.
inline Pair sides(const Range& range, const BinSplit& split, const Partition& partition) {
  const std::uint32_t middle = range.begin + partition.left_count;
  return {{range.begin, middle, split.left, partition.left_centers},
          {middle, range.end, split.right, partition.right_centers}};
}

/// Splits more than kLeafSize references in two, changing their order.
Pair split_range(std::span<BvhReference> references, const Range& range, int level);

/// In two halves, as they stand.
Pair split_in_halves(std::span<const BvhReference> references, const Range& range);

}  // namespace mlt
