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

  /// Before each edge, after which either kind of term is added once at most. What is full is emptied here,
  /// where little else is held in registers.
  MLT_INLINE void begin_edge() {
    if constexpr (kWaits) {
      if (waiting_count_ >= kWidth) trace_group();
      if (term_count_ + 2 > kTerms) settle();
    }
  }

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
    terms_[term_count_] = {&sum, light, lanes_of(lanes)};
    return term_count_++;
  }

  /// What is kept of segments that wait for company.
  enum Component : std::uint32_t {
    kOrigin,
    kDirection = kOrigin + 3,
    kLeaves = kDirection + 3,
    kTarget,
    kPlace,  ///< number of the term, times lanes, plus lane
    kComponents
  };

  MLT_INLINE void wait(const RayOf<F>& segment, const SegmentEnds<F>& ends, std::uint32_t term, M lanes) {
    const LanePacking<F> packing(lanes);
    const auto put = [&](std::uint32_t component, const auto& values) __attribute__((always_inline)) {
      store_wide(waiting_[component] + waiting_count_, packing(values));
    };
    const auto put_vector = [&](std::uint32_t component, const V& v) __attribute__((always_inline)) {
      put(component, v.x);
      put(component + 1, v.y);
      put(component + 2, v.z);
    };
    put_vector(kOrigin, segment.origin);
    put_vector(kDirection, segment.direction);
    put(kLeaves, ends.leaves);
    put(kTarget, ends.target);
    put(kPlace, lane_numbers<U>() + term * kWidth);
    waiting_count_ += packing.count();
  }

  template <class W>
  MLT_INLINE W waiting(std::uint32_t component) const {
    return load_wide<W>(waiting_[component]);
  }
  MLT_INLINE V waiting_vector(std::uint32_t component) const {
    return {waiting<F>(component), waiting<F>(component + 1), waiting<F>(component + 2)};
  }

  /// Traces as many segments as fill all lanes.
  MLT_NOINLINE void trace_group() {
    trace(not_in(M{}));
    waiting_count_ -= kWidth;
    // Beyond those that wait nothing was written as yet.
    const U kept = mask_bits(M(lane_numbers<U>() < waiting_count_));
    for (auto& component : waiting_) store_wide(component, load_wide<U>(component + kWidth) & kept);
  }

  /// Traces the first segments that wait.
  MLT_INLINE void trace(M lanes) {
    const RayOf<F> segments{waiting_vector(kOrigin), waiting_vector(kDirection), broadcast_to<F>(1.0f)};
    const SegmentEnds<F> ends{waiting<U>(kLeaves), waiting<U>(kTarget)};
    const M blocked = geometry_.template occluded_lanes<kGeneralGeometry, F>(segments, ends, lanes);
    const U places = waiting<U>(kPlace);
    for_lanes(M(blocked & lanes), [&](int lane) {
      const std::uint32_t place = lane_of(places, lane);
      terms_[place / kWidth].lanes &= ~(1U << place % kWidth);
    });
  }

  /// Traces all segments, whose lanes may be few, and adds all terms.
  MLT_NOINLINE void settle() {
    if (waiting_count_ >= kWidth) trace_group();
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
  alignas(64) std::uint32_t waiting_[kComponents][2 * kWidth];
};

}  // namespace mlt
