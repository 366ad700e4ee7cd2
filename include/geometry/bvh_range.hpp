// Boxes and runs of references, as the builder of hierarchies handles them.
#pragma once

#include <cstdint>
#include <cstring>
#include <limits>
#include <span>

#include "geometry/bvh_builder.hpp"
#include "math/simd.hpp"

namespace mlt {

/// Low corner and negated high corner in eight floats, so that boxes are joined by minima alone. Fourth
/// components mean nothing; they hold indices, which are no numbers that arithmetic is slow with as long as
/// it only compares and adds them.
struct Box {
  static constexpr int kParts = 8 / kLanes;
  static_assert(kParts == 1 || kParts == 2);
  LaneFloat part[kParts];

  Box() {
    for (LaneFloat& lanes : part) lanes = broadcast(std::numeric_limits<float>::infinity());
  }
  MLT_INLINE explicit Box(const BvhReference& reference) { std::memcpy(part, &reference, sizeof(part)); }

  MLT_INLINE void include(const Box& other) {
    for (int i = 0; i < kParts; ++i) part[i] = min_lanes(part[i], other.part[i]);
  }
  /// The same where `mask` is set, nothing elsewhere.
  MLT_INLINE void include_if(LaneInt mask, const Box& other) {
    const LaneFloat nothing = broadcast(std::numeric_limits<float>::infinity());
    for (int i = 0; i < kParts; ++i) part[i] = min_lanes(part[i], select(mask, other.part[i], nothing));
  }
  MLT_INLINE Float4 low() const { return __builtin_shufflevector(part[0], part[kParts - 1], 0, 1, 2, 3); }
  MLT_INLINE Float4 minus_high() const {
    return __builtin_shufflevector(part[0], part[kParts - 1], 4, 5, 6, 7);
  }
  /// Twice the centre, as a box of that one point: low + high and its negative.
  MLT_INLINE Box center() const {
    Box center;
#if defined(__AVX2__)
    center.part[0] = part[0] - __builtin_shufflevector(part[0], part[0], 4, 5, 6, 7, 0, 1, 2, 3);
#else
    center.part[0] = part[0] - part[1];
    center.part[1] = part[1] - part[0];
#endif
    return center;
  }
  /// Half the surface; the box must not be empty.
  MLT_INLINE float half_area() const {
    // Of the negative extents, whose products are those of the extents.
    const Float4 d = low() + minus_high();
    return (d[0] * d[1] + d[1] * d[2]) + d[2] * d[0];
  }
};
static_assert(sizeof(Box) == sizeof(BvhReference));

/// A run of references with their box and the box of their centres, the latter scaled by 2.
struct Range {
  std::uint32_t begin = 0, end = 0;
  Box box, centers;

  std::uint32_t count() const { return end - begin; }
};

struct Pair {
  Range left, right;
};

inline Range measured(std::span<const BvhReference> references, std::uint32_t begin, std::uint32_t end) {
  Range range;
  range.begin = begin;
  range.end = end;
  for (std::uint32_t i = begin; i < end; ++i) {
    const Box box(references[i]);
    range.box.include(box);
    range.centers.include(box.center());
  }
  return range;
}

}  // namespace mlt
