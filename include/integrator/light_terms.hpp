// The terms of paths' radiance, added in the order in which the paths meet them. A term of light sampling
// counts only if its shadow segment is free; about half of the lanes have one at an edge, so segments wait
// until they fill all lanes, and terms until it is known what became of them. Sums have the bits that they
// would have if each segment were traced at once.
#pragma once

#include <cstdint>

#include "geometry/geometry.hpp"
#include "math/pack.hpp"
#include "math/vec.hpp"

namespace mlt {

/// Four lanes gain no more by company than it takes to bring segments together.
template <class F>
inline constexpr bool kSegmentsWait = kLaneCount<F> >= 8;

template <bool kGeneralGeometry, class F, bool kWaits = kSegmentsWait<F>>
class LightTerms {
  using V = Vec3Of<F>;
  using M = MaskOf<F>;
  using U = UintOf<F>;

 public:
  explicit LightTerms(const Geometry& geometry) : geometry_(geometry) {}

  /// Adds `light` to `sum` in the lanes of `lanes`. The sum must last until finish().
  MLT_INLINE void add(V& sum, const V& light, M lanes) {
    if constexpr (kWaits) {
      append(sum, light, lanes);
    } else {
      sum = select(lanes, sum + light, sum);
    }
  }

  /// The same where nothing lies on the segment.
  MLT_INLINE void add_if_free(V& sum, const V& light, const RayOf<F>& segment, const SegmentEnds<F>& ends,
                              M lanes) {
    if constexpr (kWaits) {
      const std::uint32_t term = append(sum, light, lanes);
      wait(segment, ends, term, lanes);
    } else {
      add(sum, light,
          lanes & not_in(geometry_.template occluded_lanes<kGeneralGeometry, F>(segment, ends, lanes)));
    }
  }

  /// Adds what still waits.
  MLT_INLINE void finish() {
    if constexpr (kWaits) {
      if (term_count_ > 0) settle();
    }
  }

 private:
  static constexpr std::uint32_t kWidth = kLaneCount<F>;
  static constexpr std::uint32_t kTerms = 16;

  struct Term {
    V* sum;
    V light;
    unsigned lanes;  ///< bits of those that count, as far as is known
  };

  MLT_INLINE std::uint32_t append(V& sum, const V& light, M lanes) {
    if (term_count_ == kTerms) settle();
    terms_[term_count_] = {&sum, light, lanes_of(lanes)};
    return term_count_++;
  }

  /// Segments that wait for company, in the first lanes.
  struct Waiting {
    V origin{F{}, F{}, F{}}, direction{F{}, F{}, F{}};
    U leaves{}, target{};
    U place{};  ///< number of the term, times lanes, plus lane
  };

  MLT_INLINE void wait(const RayOf<F>& segment, const SegmentEnds<F>& ends, std::uint32_t term, M lanes) {
    const LanePacking<F> packing(lanes, waiting_count_);
    const auto packed = [&](const V& v) { return V{packing(v.x), packing(v.y), packing(v.z)}; };
    const Waiting added{packed(segment.origin), packed(segment.direction), packing(ends.leaves),
                        packing(ends.target), packing(lane_numbers<U>() + term * kWidth)};
    const M old = lane_numbers<U>() < waiting_count_;
    waiting_ = {select(old, waiting_.origin, added.origin), select(old, waiting_.direction, added.direction),
                select(old, waiting_.leaves, added.leaves), select(old, waiting_.target, added.target),
                select(old, waiting_.place, added.place)};
    waiting_count_ += packing.count();
    if (waiting_count_ < kWidth) return;
    trace(not_in(M{}));
    // The others went on from lane 0.
    waiting_ = added;
    waiting_count_ -= kWidth;
  }

  /// Traces segments that wait.
  MLT_NOINLINE void trace(M lanes) {
    const RayOf<F> segments{waiting_.origin, waiting_.direction, broadcast_to<F>(1.0f)};
    const M blocked = geometry_.template occluded_lanes<kGeneralGeometry, F>(
        segments, {waiting_.leaves, waiting_.target}, lanes);
    for_lanes(M(blocked & lanes), [&](int lane) {
      const std::uint32_t place = lane_of(waiting_.place, lane);
      terms_[place / kWidth].lanes &= ~(1U << place % kWidth);
    });
  }

  /// Traces all segments, whose lanes may be few, and adds all terms.
  MLT_NOINLINE void settle() {
    if (waiting_count_ > 0) trace(first_lanes<F>(waiting_count_));
    waiting_count_ = 0;
    for (std::uint32_t i = 0; i < term_count_; ++i) {
      const Term& term = terms_[i];
      *term.sum = select(mask_of<F>(term.lanes), *term.sum + term.light, *term.sum);
    }
    term_count_ = 0;
  }

  const Geometry& geometry_;
  std::uint32_t term_count_ = 0;
  std::uint32_t waiting_count_ = 0;
  Term terms_[kTerms];
  Waiting waiting_;
};

}  // namespace mlt
