#include "bvh_shared_split.hpp"

#include <algorithm>

#include "base/assert.hpp"

namespace mlt {
namespace {

/// Up to one run of references from each chunk, numbered through.
class Runs {
 public:
  struct Run {
    std::uint32_t begin, end;
  };

  void add(std::uint32_t begin, std::uint32_t end) {
    if (begin >= end) return;
    runs_[count_++] = {begin, end};
    total_ += end - begin;
  }
  std::uint32_t total() const { return total_; }

  /// Walks through the numbered references from a given one on.
  class Walk {
   public:
    Walk(const Runs& runs, std::uint32_t number) : run_(runs.runs_) {
      for (; number >= run_->end - run_->begin; ++run_) number -= run_->end - run_->begin;
      at_ = run_->begin + number;
    }
    /// The present one; there must be one.
    std::uint32_t take() {
      if (at_ == run_->end) at_ = (++run_)->begin;
      return at_++;
    }

   private:
    const Run* run_;
    std::uint32_t at_ = 0;
  };

 private:
  Run runs_[Chunks::kMax];
  std::uint32_t count_ = 0;
  std::uint32_t total_ = 0;
};

}  // namespace

Range SharedSplitter::measured(std::uint32_t begin, std::uint32_t end) const {
  const Chunks chunks(begin, end);
  runner_.run(chunks.count, [&](std::uint64_t c) {
    work_.ranges[c] = mlt::measured(references_, chunks.begin(c), chunks.end(c));
  });
  Range all;
  all.begin = begin;
  all.end = end;
  for (std::uint32_t c = 0; c < chunks.count; ++c) {
    all.box.include(work_.ranges[c].box);
    all.centers.include(work_.ranges[c].centers);
  }
  return all;
}

Pair SharedSplitter::split(const Range& range, int level) const {
  if (range.count() < kFewest || level >= kSurfaceAreaLevels) return split_range(references_, range, level);
  const Chunks chunks(range.begin, range.end);
  const Binning binning(range);
  runner_.run(chunks.count, [&](std::uint64_t c) {
    work_.bins[c] = BinSet{};
    work_.bins[c].add(references_.subspan(chunks.begin(c), chunks.end(c) - chunks.begin(c)), binning);
  });
  for (std::uint32_t c = 1; c < chunks.count; ++c) work_.bins[0].include(work_.bins[c]);
  const BinSplit best = work_.bins[0].cheapest_split();
  if (!best.exists()) return split_in_halves(references_, range);
  return sides(range, best, partition_chunks(range, chunks, binning, best));
}

Partition SharedSplitter::partition_chunks(const Range& range, const Chunks& chunks, const Binning& binning,
                                           const BinSplit& split) const {
  runner_.run(chunks.count, [&](std::uint64_t c) {
    const std::span<BvhReference> chunk =
        references_.subspan(chunks.begin(c), chunks.end(c) - chunks.begin(c));
    work_.partitions[c] = partition(chunk, binning, split);
  });
  Partition all;
  for (std::uint32_t c = 0; c < chunks.count; ++c) {
    all.left_count += work_.partitions[c].left_count;
    all.left_centers.include(work_.partitions[c].left_centers);
    all.right_centers.include(work_.partitions[c].right_centers);
  }
  exchange_misplaced(chunks, range.begin + all.left_count);
  return all;
}

void SharedSplitter::exchange_misplaced(const Chunks& chunks, std::uint32_t middle) const {
  Runs left_behind, right_before;
  for (std::uint32_t c = 0; c < chunks.count; ++c) {
    const std::uint32_t border = chunks.begin(c) + work_.partitions[c].left_count;
    left_behind.add(std::max(chunks.begin(c), middle), border);
    right_before.add(border, std::min(chunks.end(c), middle));
  }
  MLT_CHECK_OP(left_behind.total(), ==, right_before.total());
  if (left_behind.total() == 0) return;
  const Chunks parts(0, left_behind.total());
  runner_.run(parts.count, [&](std::uint64_t p) {
    Runs::Walk a(left_behind, parts.begin(p));
    Runs::Walk b(right_before, parts.begin(p));
    for (std::uint32_t i = parts.begin(p); i < parts.end(p); ++i) {
      std::swap(references_[a.take()], references_[b.take()]);
    }
  });
}

}  // namespace mlt
