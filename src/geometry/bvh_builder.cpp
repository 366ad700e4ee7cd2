#include "geometry/bvh_builder.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>

#include "base/assert.hpp"

namespace mlt {
namespace {

/// x, y, z and one unused lane.
using Quadruple __attribute__((vector_size(16))) = float;
using IntQuadruple __attribute__((vector_size(16))) = std::int32_t;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr int kBins = 16;
constexpr std::uint32_t kSmallCount = 2 * kSmallestSide;
static_assert(kSmallCount <= 64);

#if defined(__SSE2__)
Quadruple min_of(Quadruple a, Quadruple b) {
  return std::bit_cast<Quadruple>(_mm_min_ps(std::bit_cast<__m128>(a), std::bit_cast<__m128>(b)));
}
Quadruple max_of(Quadruple a, Quadruple b) {
  return std::bit_cast<Quadruple>(_mm_max_ps(std::bit_cast<__m128>(a), std::bit_cast<__m128>(b)));
}
#else
Quadruple choose(IntQuadruple mask, Quadruple a, Quadruple b) {
  return std::bit_cast<Quadruple>((mask & std::bit_cast<IntQuadruple>(a)) |
                                  (~mask & std::bit_cast<IntQuadruple>(b)));
}
Quadruple min_of(Quadruple a, Quadruple b) {
  return choose(a < b, a, b);
}
Quadruple max_of(Quadruple a, Quadruple b) {
  return choose(a > b, a, b);
}
#endif

Quadruple low_of(const BvhReference& r) {
  return Quadruple{r.low[0], r.low[1], r.low[2], 0.0f};
}
Quadruple high_of(const BvhReference& r) {
  return Quadruple{r.high[0], r.high[1], r.high[2], 0.0f};
}

struct Box {
  Quadruple low{kInfinity, kInfinity, kInfinity, 0.0f};
  Quadruple high{-kInfinity, -kInfinity, -kInfinity, 0.0f};

  void include(Quadruple other_low, Quadruple other_high) {
    low = min_of(low, other_low);
    high = max_of(high, other_high);
  }
  /// Half the surface; the box must not be empty.
  float half_area() const {
    const Quadruple d = high - low;
    return (d[0] * d[1] + d[1] * d[2]) + d[2] * d[0];
  }
};

/// A run of references with their box and the box of their centres, the latter scaled by 2.
struct Range {
  std::uint32_t begin = 0, end = 0;
  Box box, centers;

  std::uint32_t count() const { return end - begin; }
  void include(const BvhReference& reference) {
    const Quadruple low = low_of(reference);
    const Quadruple high = high_of(reference);
    box.include(low, high);
    centers.include(low + high, low + high);
  }
};

struct Pair {
  Range left, right;
};

Range measured(std::span<const BvhReference> references, std::uint32_t begin, std::uint32_t end) {
  Range range;
  range.begin = begin;
  range.end = end;
  for (std::uint32_t i = begin; i < end; ++i) range.include(references[i]);
  return range;
}

Pair split_at(std::span<const BvhReference> references, const Range& range, std::uint32_t middle) {
  return {measured(references, range.begin, middle), measured(references, middle, range.end)};
}

/// Assigns references to bins of equal width between the outermost centres, on each axis.
struct Binning {
  explicit Binning(const Range& range) : origin(range.centers.low) {
    const Quadruple extent = range.centers.high - range.centers.low;
    // A reciprocal of a smaller extent might not be finite; then all references share bin 0.
    for (int axis = 0; axis < 3; ++axis) scale[axis] = extent[axis] > 1e-30f ? kBins / extent[axis] : 0.0f;
  }
  IntQuadruple bins_of(const BvhReference& reference) const {
    const Quadruple position = ((low_of(reference) + high_of(reference)) - origin) * scale;
    constexpr float kLast = kBins - 1;
    return __builtin_convertvector(min_of(position, Quadruple{kLast, kLast, kLast, kLast}), IntQuadruple);
  }
  int bin_of(const BvhReference& reference, int axis) const {
    const float position = ((reference.low[axis] + reference.high[axis]) - origin[axis]) * scale[axis];
    return static_cast<int>(position < kBins - 1 ? position : kBins - 1);
  }

  Quadruple origin;
  Quadruple scale{};
};

struct Bin {
  Box box;
  std::uint32_t count = 0;

  void include(const Bin& other) {
    box.include(other.box.low, other.box.high);
    count += other.count;
  }
};

struct BinSplit {
  float cost = kInfinity;
  int axis = 0;
  int first_right = 0;  ///< bin
};

/// The cheapest split of one axis between bins that leaves kSmallestSide on both sides.
BinSplit cheapest_split(const Bin (&bins)[kBins], int axis) {
  float right_cost[kBins];
  std::uint32_t right_count[kBins];
  Bin right;
  for (int i = kBins - 1; i > 0; --i) {
    right.include(bins[i]);
    right_count[i] = right.count;
    right_cost[i] =
        right.count >= kSmallestSide ? right.box.half_area() * static_cast<float>(right.count) : kInfinity;
  }
  BinSplit best;
  Bin left;
  for (int i = 1; i < kBins; ++i) {
    left.include(bins[i - 1]);
    if (left.count < kSmallestSide || right_count[i] < kSmallestSide) continue;
    const float cost = left.box.half_area() * static_cast<float>(left.count) + right_cost[i];
    if (cost < best.cost) best = {cost, axis, i};
  }
  return best;
}

Pair partition(std::span<BvhReference> references, const Range& range, const Binning& binning,
               const BinSplit& split) {
  Pair pair;
  std::uint32_t i = range.begin;
  std::uint32_t j = range.end;
  for (;;) {
    for (; i < j && binning.bin_of(references[i], split.axis) < split.first_right; ++i)
      pair.left.include(references[i]);
    for (; i < j && binning.bin_of(references[j - 1], split.axis) >= split.first_right; --j) {
      pair.right.include(references[j - 1]);
    }
    if (i == j) break;
    std::swap(references[i], references[j - 1]);
  }
  pair.left.begin = range.begin;
  pair.left.end = i;
  pair.right.begin = i;
  pair.right.end = range.end;
  return pair;
}

Pair split_binned(std::span<BvhReference> references, const Range& range) {
  const Binning binning(range);
  Bin bins[3][kBins];
  for (std::uint32_t i = range.begin; i < range.end; ++i) {
    const Quadruple low = low_of(references[i]);
    const Quadruple high = high_of(references[i]);
    const IntQuadruple index = binning.bins_of(references[i]);
    for (int axis = 0; axis < 3; ++axis) {
      Bin& bin = bins[axis][index[axis]];
      bin.box.include(low, high);
      bin.count += 1;
    }
  }
  BinSplit best;
  for (int axis = 0; axis < 3; ++axis) {
    const BinSplit split = cheapest_split(bins[axis], axis);
    if (split.cost < best.cost) best = split;
  }
  if (best.cost == kInfinity) return split_at(references, range, range.begin + range.count() / 2);
  return partition(references, range, binning, best);
}

/// Positions 0 to count - 1 in the order of centres along `axis`, equal ones in their present order.
void order_by_center(std::span<const BvhReference> references, int axis, std::uint64_t* order) {
  for (std::size_t i = 0; i < references.size(); ++i) {
    const auto bits = std::bit_cast<std::uint32_t>(references[i].low[axis] + references[i].high[axis]);
    // Maps floats to integers of the same order.
    const std::uint32_t key = (bits & 0x80000000U) != 0 ? ~bits : bits | 0x80000000U;
    const std::uint64_t added = std::uint64_t{key} << 32 | i;
    std::size_t place = i;
    for (; place > 0 && order[place - 1] > added; --place) order[place] = order[place - 1];
    order[place] = added;
  }
}

struct ExactSplit {
  float cost = kInfinity;
  std::uint32_t left_count = 0;
};

/// Leaves needed by `count` primitives, as a cost.
float leaf_cost(std::uint32_t count) {
  return static_cast<float>((count + kLeafSize - 1) / kLeafSize);
}

/// The cheapest split of references in the given order that leaves one side a multiple of the leaf size.
ExactSplit cheapest_in_order(std::span<const BvhReference> references, const std::uint64_t* order) {
  const auto count = static_cast<std::uint32_t>(references.size());
  const auto at = [&](std::uint32_t i) -> const BvhReference& { return references[order[i] & 0xffffffffU]; };
  float right_area[kSmallCount];
  Box right;
  for (std::uint32_t i = count - 1; i > 0; --i) {
    right.include(low_of(at(i)), high_of(at(i)));
    right_area[i] = right.half_area();
  }
  ExactSplit best;
  Box left;
  for (std::uint32_t i = 1; i < count; ++i) {
    left.include(low_of(at(i - 1)), high_of(at(i - 1)));
    if (i % kLeafSize != 0 && (count - i) % kLeafSize != 0) continue;
    const float cost = left.half_area() * leaf_cost(i) + right_area[i] * leaf_cost(count - i);
    if (cost < best.cost) best = {cost, i};
  }
  return best;
}

/// Splits more than kLeafSize and fewer than kSmallCount references.
Pair split_small(std::span<BvhReference> all, const Range& range) {
  const std::span<BvhReference> references = all.subspan(range.begin, range.count());
  std::uint64_t orders[3][kSmallCount];
  ExactSplit best{kInfinity, kLeafSize};
  int best_axis = 0;
  for (int axis = 0; axis < 3; ++axis) {
    order_by_center(references, axis, orders[axis]);
    const ExactSplit split = cheapest_in_order(references, orders[axis]);
    if (split.cost < best.cost) {
      best = split;
      best_axis = axis;
    }
  }
  BvhReference ordered[kSmallCount];
  for (std::size_t i = 0; i < references.size(); ++i)
    ordered[i] = references[orders[best_axis][i] & 0xffffffffU];
  std::copy_n(ordered, references.size(), references.begin());
  return split_at(all, range, range.begin + best.left_count);
}

/// A range that waits for its node or leaf, and where the index of that belongs.
struct Task {
  Range range;
  std::uint32_t parent = 0;
  int lane = 0;
  int level = 0;
};

class Builder {
 public:
  Builder(std::span<BvhReference> references, std::span<BvhNode> nodes, const LeafWriter& leaves)
      : references_(references), nodes_(nodes), leaves_(leaves) {}

  BvhSize build() {
    const auto count = static_cast<std::uint32_t>(references_.size());
    tasks_[task_count_++].range = measured(references_, 0, count);
    while (task_count_ > 0) {
      const Task task = tasks_[--task_count_];
      const bool is_root = task.level == 0;
      const std::uint32_t child =
          is_root || task.range.count() > kLeafSize ? make_node(task) : write_leaf(task.range);
      if (!is_root) nodes_[task.parent].children[task.lane] = child;
    }
    return size_;
  }

 private:
  /// Divides `range` into up to kNodeWidth children; returns how many.
  int open_children(const Range& range, int level, Range (&children)[kNodeWidth]) {
    if (range.count() == 0) return 0;
    children[0] = range;
    int count = 1;
    while (count < kNodeWidth) {
      int widest = -1;
      float most = -1.0f;
      for (int i = 0; i < count; ++i) {
        if (children[i].count() <= kLeafSize) continue;
        // Below the last level by surface area, halving the most numerous child bounds the depth.
        const float weight = level < kSurfaceAreaLevels ? children[i].box.half_area()
                                                        : static_cast<float>(children[i].count());
        if (weight > most) {
          most = weight;
          widest = i;
        }
      }
      if (widest < 0) break;
      const Pair pair = split(children[widest], level);
      children[widest] = pair.left;
      children[count++] = pair.right;
    }
    return count;
  }

  Pair split(const Range& range, int level) {
    if (range.count() < kSmallCount) return split_small(references_, range);
    if (level < kSurfaceAreaLevels) return split_binned(references_, range);
    return split_at(references_, range, range.begin + range.count() / 2);
  }

  std::uint32_t make_node(const Task& task) {
    MLT_CHECK_OP(task.level, <, kMaxLevels);
    MLT_CHECK_OP(size_.nodes, <, nodes_.size());
    const std::uint32_t index = size_.nodes++;
    size_.levels = std::max(size_.levels, task.level + 1);
    BvhNode& node = nodes_[index];
    Range children[kNodeWidth];
    const int count = open_children(task.range, task.level, children);
    for (int lane = 0; lane < kNodeWidth; ++lane) {
      const Box box = lane < count ? children[lane].box : Box{};
      for (int axis = 0; axis < 3; ++axis) {
        node.planes[axis][0][lane] = box.low[axis];
        node.planes[axis][1][lane] = box.high[axis];
      }
      node.children[lane] = kLeafBit;
    }
    // The child whose references come first is taken up first, so that leaves use them up in their order.
    int order[kNodeWidth];
    std::iota(order, order + count, 0);
    std::sort(order, order + count, [&](int a, int b) { return children[a].begin > children[b].begin; });
    MLT_CHECK_OP(task_count_ + count, <=, kTraversalStack);
    for (int i = 0; i < count; ++i) {
      tasks_[task_count_++] = {children[order[i]], index, order[i], task.level + 1};
    }
    return index;
  }

  std::uint32_t write_leaf(const Range& range) {
    leaves_.write(leaves_.context, size_.blocks, references_.subspan(range.begin, range.count()));
    return kLeafBit | size_.blocks++;
  }

  std::span<BvhReference> references_;
  std::span<BvhNode> nodes_;
  const LeafWriter& leaves_;
  BvhSize size_;
  // Depth first, so at most the siblings of each level wait.
  Task tasks_[kTraversalStack];
  int task_count_ = 0;
};

}  // namespace

BvhSize build_bvh(std::span<BvhReference> references, std::span<BvhNode> nodes, const LeafWriter& leaves) {
  MLT_CHECK_OP(references.size(), <=, kMaxBvhPrimitives);
  MLT_CHECK_OP(nodes.size(), >=, max_bvh_nodes(references.size()));
  return Builder(references, nodes, leaves).build();
}

}  // namespace mlt
