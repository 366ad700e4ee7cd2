#include "geometry/bvh_split.hpp"

#include <algorithm>

namespace mlt {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

Pair split_at(std::span<const BvhReference> references, const Range& range, std::uint32_t middle) {
  return {measured(references, range.begin, middle), measured(references, middle, range.end)};
}

/// The cheapest split of one axis, if cheaper than `best`.
void improve_split(const Box (&boxes)[kBins], const std::uint32_t (&counts)[kBins], int axis,
                   BinSplit& best) {
  float right_cost[kBins];
  Box right_box[kBins];
  std::uint32_t right_count = 0;
  Box right;
  for (int i = kBins - 1; i > 0; --i) {
    right.include(boxes[i]);
    right_box[i] = right;
    right_count += counts[i];
    right_cost[i] =
        right_count >= kSmallestSide ? right.half_area() * static_cast<float>(right_count) : kInfinity;
  }
  const std::uint32_t all = right_count + counts[0];
  std::uint32_t left_count = 0;
  Box left;
  for (int i = 1; i < kBins; ++i) {
    left.include(boxes[i - 1]);
    left_count += counts[i - 1];
    if (left_count < kSmallestSide || all - left_count < kSmallestSide) continue;
    const float cost = left.half_area() * static_cast<float>(left_count) + right_cost[i];
    if (cost < best.cost) best = {cost, axis, i, left, right_box[i]};
  }
}

Pair split_binned(std::span<BvhReference> references, const Range& range) {
  const Binning binning(range);
  const std::span<BvhReference> run = references.subspan(range.begin, range.count());
  BinSet bins;
  bins.add(run, binning);
  const BinSplit best = bins.cheapest_split();
  if (!best.exists()) return split_in_halves(references, range);
  return sides(range, best, partition(run, binning, best));
}

/// A few references, their centres by axis in lanes, and their orders along the axes.
struct SmallRun {
  explicit SmallRun(std::span<const BvhReference> references)
      : count(static_cast<std::uint32_t>(references.size())) {
    for (auto& axis : centers) {
      for (float& center : axis) center = kInfinity;
    }
    for (std::uint32_t i = 0; i < count; ++i) {
      boxes[i] = Box(references[i]);
      const Float4 center = boxes[i].low() - boxes[i].minus_high();
      for (int axis = 0; axis < 3; ++axis) centers[axis][i] = center[axis];
    }
  }

  /// Positions in the order of centres, equal ones in their present order. The rank of each is the number of
  /// those before it, counted in lanes.
  void order_along(int axis) {
    const float* const center = centers[axis];
    LaneInt lanes{};
    for (int i = 0; i < kLanes; ++i) lanes[i] = i;
    for (std::uint32_t first = 0; first < count; first += kLanes) {
      const LaneFloat own = at(center + first);
      LaneInt ranks{};
      for (std::uint32_t i = 0; i < first; ++i) ranks -= broadcast(center[i]) <= own;
      for (std::uint32_t i = 0; i < kLanes; ++i) {
        const LaneFloat other = broadcast(center[first + i]);
        ranks -= (other < own) | ((other == own) & (lanes > static_cast<std::int32_t>(i)));
      }
      for (std::uint32_t i = first + kLanes; i < count; ++i) ranks -= broadcast(center[i]) < own;
      const std::uint32_t filled = std::min<std::uint32_t>(kLanes, count - first);
      for (std::uint32_t i = 0; i < filled; ++i)
        orders[axis][ranks[i]] = static_cast<std::uint8_t>(first + i);
    }
  }

  static LaneFloat at(const float* center) {
    LaneFloat lanes;
    std::memcpy(&lanes, center, sizeof(lanes));
    return lanes;
  }

  std::uint32_t count;
  Box boxes[kSmallCount];
  alignas(sizeof(LaneFloat)) float centers[3][kSmallCount];
  std::uint8_t orders[3][kSmallCount];
};

/// Where few references may be split: so that one side is a multiple of the leaf size. Ascending.
struct SplitPlaces {
  explicit SplitPlaces(std::uint32_t references) {
    std::uint32_t from_left = kLeafSize;
    std::uint32_t from_right = references % kLeafSize == 0 ? references : references % kLeafSize;
    while (from_left < references || from_right < references) {
      const std::uint32_t place = std::min(from_left, from_right);
      if (from_left == place) from_left += kLeafSize;
      if (from_right == place) from_right += kLeafSize;
      places[count++] = place;
    }
  }
  std::uint32_t places[2 * kSmallCount / kLeafSize];
  std::uint32_t count = 0;
};

/// Leaves needed by `count` primitives, as a cost.
float leaf_cost(std::uint32_t count) {
  return static_cast<float>((count + kLeafSize - 1) / kLeafSize);
}

struct ExactSplit {
  float cost = kInfinity;
  int axis = 0;
  std::uint32_t left_count = kLeafSize;
};

void improve_split(const SmallRun& run, const SplitPlaces& places, int axis, ExactSplit& best) {
  const std::uint8_t* const order = run.orders[axis];
  float right_area[2 * kSmallCount / kLeafSize];
  Box right;
  std::uint32_t i = run.count;
  for (std::uint32_t k = places.count; k-- > 0;) {
    while (i > places.places[k]) right.include(run.boxes[order[--i]]);
    right_area[k] = right.half_area();
  }
  Box left;
  i = 0;
  for (std::uint32_t k = 0; k < places.count; ++k) {
    const std::uint32_t place = places.places[k];
    while (i < place) left.include(run.boxes[order[i++]]);
    const float cost = left.half_area() * leaf_cost(place) + right_area[k] * leaf_cost(run.count - place);
    if (cost < best.cost) best = {cost, axis, place};
  }
}

/// Splits more than kLeafSize and fewer than kSmallCount references. Their centres are not needed any more.
Pair split_small(std::span<BvhReference> all, const Range& range) {
  const std::span<BvhReference> references = all.subspan(range.begin, range.count());
  SmallRun run(references);
  const SplitPlaces places(run.count);
  ExactSplit best;
  for (int axis = 0; axis < 3; ++axis) {
    run.order_along(axis);
    improve_split(run, places, axis, best);
  }
  const std::uint32_t middle = range.begin + best.left_count;
  Pair pair{{range.begin, middle, {}, {}}, {middle, range.end, {}, {}}};
  const std::uint8_t* const order = run.orders[best.axis];
  Box box;
  for (std::uint32_t i = 0; i < run.count; ++i) {
    if (i == best.left_count) {
      pair.left.box = box;
      box = Box{};
    }
    const Box& own = run.boxes[order[i]];
    std::memcpy(static_cast<void*>(&references[i]), &own, sizeof(own));
    box.include(own);
  }
  pair.right.box = box;
  return pair;
}

}  // namespace

Binning::Binning(const Range& range) : origin(range.centers.low()) {
  // A number with which the fourth component, an index, becomes one that multiplication is fast with.
  origin[3] = 1.0f;
  // No product with the extent, rounded, reaches kBins.
  constexpr float kWidth = kBins * (1.0f - 0x1p-20f);
  const Float4 extent = -range.centers.minus_high() - range.centers.low();
  // A reciprocal of a smaller extent might not be finite; then all references share bin 0.
  for (int axis = 0; axis < 3; ++axis) scale[axis] = extent[axis] > 1e-30f ? kWidth / extent[axis] : 0.0f;
}

void BinSet::add(std::span<const BvhReference> references, const Binning& binning) {
  for (const BvhReference& reference : references) {
    __builtin_prefetch(&reference + 48);
    const Box box(reference);
    const Int4 bins = __builtin_convertvector(binning.position(box), Int4);
#pragma GCC unroll 3
    for (int axis = 0; axis < 3; ++axis) {
      const auto bin = static_cast<std::uint32_t>(bins[axis]);
      boxes[axis][bin].include(box);
      counts[axis][bin] += 1;
    }
  }
}

void BinSet::include(const BinSet& other) {
  for (int axis = 0; axis < 3; ++axis) {
    for (int bin = 0; bin < kBins; ++bin) {
      boxes[axis][bin].include(other.boxes[axis][bin]);
      counts[axis][bin] += other.counts[axis][bin];
    }
  }
}

BinSplit BinSet::cheapest_split() const {
  BinSplit best;
  for (int axis = 0; axis < 3; ++axis) improve_split(boxes[axis], counts[axis], axis, best);
  return best;
}

Partition partition(std::span<BvhReference> run, const Binning& binning, const BinSplit& split) {
  const auto first_right = static_cast<float>(split.first_right);
  Partition result;
  // In front of `next` stand references of the left, from there to the present one those of the right.
  // Without branches, which could not be predicted.
  BvhReference* next = run.data();
  for (BvhReference& reference : run) {
    __builtin_prefetch(&reference + 48, 1);
    const Box box(reference);
    const bool is_left = binning.position(box)[split.axis] < first_right;
    const LaneInt mask = LaneInt{} - static_cast<std::int32_t>(is_left);
    const Box center = box.center();
    result.left_centers.include_if(mask, center);
    result.right_centers.include_if(~mask, center);
    reference = *next;
    std::memcpy(static_cast<void*>(next), &box, sizeof(box));
    next += is_left ? 1 : 0;
  }
  result.left_count = static_cast<std::uint32_t>(next - run.data());
  return result;
}

Pair split_in_halves(std::span<const BvhReference> references, const Range& range) {
  return split_at(references, range, range.begin + range.count() / 2);
}

Pair split_range(std::span<BvhReference> references, const Range& range, int level) {
  if (range.count() < kSmallCount) return split_small(references, range);
  if (level < kSurfaceAreaLevels) return split_binned(references, range);
  return split_in_halves(references, range);
}

}  // namespace mlt
