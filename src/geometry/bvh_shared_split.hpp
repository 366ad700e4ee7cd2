// Splits of many references by all threads together, over chunks that follow from the references alone.
#pragma once

#include "base/unit_runner.hpp"
#include "geometry/bvh_workspace.hpp"

namespace mlt {

class SharedSplitter {
 public:
  SharedSplitter(std::span<BvhReference> references, BvhWorkspace& work, const UnitRunner& runner)
      : references_(references), work_(work), runner_(runner) {}

  /// As measured() of bvh_range.hpp.
  Range measured(std::uint32_t begin, std::uint32_t end) const;

  /// As split_range, but for the order of references on each side.
  Pair split(const Range& range, int level) const;

 private:
  /// Fewer are split faster than threads meet.
  static constexpr std::uint32_t kFewest = 4 * Chunks::kSmallest;

  Partition partition_chunks(const Range& range, const Chunks& chunks, const Binning& binning,
                             const BinSplit& split) const;
  void exchange_misplaced(const Chunks& chunks, std::uint32_t middle) const;

  std::span<BvhReference> references_;
  BvhWorkspace& work_;
  const UnitRunner& runner_;
};

}  // namespace mlt
