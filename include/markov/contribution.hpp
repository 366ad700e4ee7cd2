// What one primary-sample vector contributes: its splats, and the scalar that Metropolis sampling is
// proportional to. The capacity is the integrator's; one path may splat many pixels.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>

#include "base/assert.hpp"
#include "integrator/splat.hpp"
#include "math/vec.hpp"

namespace mlt {

/// Contributions that are not finite and non-negative, by kind; they count as zero.
struct DefectCounts {
  std::uint64_t nan = 0;
  std::uint64_t infinite = 0;
  std::uint64_t negative = 0;

  /// Counts the defect of `value` if it has one, and says whether it has.
  bool reject(const Vec3& value) {
    if (value.x >= 0.0f && value.y >= 0.0f && value.z >= 0.0f && is_finite(value)) [[likely]]
      return false;
    if (std::isnan(value.x) || std::isnan(value.y) || std::isnan(value.z)) {
      ++nan;
    } else if (!is_finite(value)) {
      ++infinite;
    } else {
      ++negative;
    }
    return true;
  }

  void add(const DefectCounts& other) {
    nan += other.nan;
    infinite += other.infinite;
    negative += other.negative;
  }
};

/// Contributions dimmer than this, some 30 orders of magnitude below a dim scene, count as black.
inline constexpr float kMinTarget = 0x1p-100f;

/// The contributions of as many vectors as F has lanes.
template <class F>
class ContributionOf {
  using V = Vec3Of<F>;
  using M = MaskOf<F>;

 public:
  explicit ContributionOf(std::span<SplatOf<F>> storage) : splats_(storage) {}

  void clear() {
    count_ = 0;
    target_ = F{};
  }

  /// Splats that are zero in all lanes need no place; exceeding the capacity is a bug of the integrator.
  MLT_INLINE void add(const SplatOf<F>& splat, M lanes) {
    lanes &= not_in(is_zero<F>(splat.value));
    if (!any(lanes)) return;
    MLT_CHECK_OP(count_, <, splats_.size());
    splats_[count_++] = {splat.pixel, select(lanes, splat.value, V{F{}, F{}, F{}})};
  }

  /// Sums the targets of `lanes`. A contribution of which any splat is defective counts as none: never
  /// accepted, never splatted; defects_of(lane) counts the first defect.
  template <class DefectsOf>
  MLT_INLINE void finish(M lanes, DefectsOf&& defects_of) {
    constexpr float kLargest = std::numeric_limits<float>::max();
    F sum{};
    M sound = lanes;
    for (const SplatOf<F>& splat : splats()) {
      for (const F& channel : {splat.value.x, splat.value.y, splat.value.z})
        sound &= (channel >= 0.0f) & (channel <= kLargest);
      sum += luminance<F>(splat.value);
    }
    // Finite channels can still have a sum beyond the largest float.
    sound &= sum <= kLargest;
    if (const M defective = lanes & not_in(sound); any(defective)) [[unlikely]]
      for_lanes(defective, [&](int lane) { count_defect(lane, defects_of(lane)); });
    // The reciprocal of a smaller target would overflow.
    target_ = select(sound & (sum >= kMinTarget), sum, F{});
  }

  /// What lanes without a target hold means nothing; zero where a lane has fewer splats than others.
  std::span<const SplatOf<F>> splats() const { return splats_.first(count_); }
  const F& target() const { return target_; }  ///< luminance of all splats

  /// Exchanges what both hold in `lanes`; they have storage for as many splats.
  MLT_INLINE void exchange(ContributionOf& other, M lanes) {
    const std::uint32_t count = count_ > other.count_ ? count_ : other.count_;
    for (std::uint32_t i = 0; i < count; ++i) {
      const SplatOf<F> own = splat(i), others = other.splat(i);
      splats_[i] = select(lanes, others, own);
      other.splats_[i] = select(lanes, own, others);
    }
    count_ = other.count_ = count;
    const F own_target = target_;
    target_ = select(lanes, other.target_, own_target);
    other.target_ = select(lanes, own_target, other.target_);
  }

 private:
  /// Zero beyond the last one.
  MLT_INLINE SplatOf<F> splat(std::uint32_t i) const { return i < count_ ? splats_[i] : SplatOf<F>{}; }

  void count_defect(int lane, DefectCounts& defects) const {
    for (const SplatOf<F>& splat : splats()) {
      if (defects.reject(lane_of(splat.value, lane))) return;
    }
    ++defects.infinite;
  }

  std::span<SplatOf<F>> splats_;
  std::uint32_t count_ = 0;
  F target_{};
};

/// The sink of evaluate_into.
template <class F, class Expect>
struct ContributionSink {
  ContributionOf<F>& contribution;
  Expect& expect_pixel;

  MLT_INLINE void operator()(const SplatOf<F>& splat, MaskOf<F> lanes = not_in(MaskOf<F>{})) const {
    contribution.add(splat, lanes);
  }
  MLT_INLINE void expect(const UintOf<F>& pixels, MaskOf<F> lanes) const {
    for_lanes(lanes, [&](int lane) { expect_pixel(lane, lane_of(pixels, lane)); });
  }
};

/// Evaluates the vectors of primary samples of the lanes of `active`; defects_of(lane) counts defects, and
/// expect_pixel(lane, pixel) is told of pixels that are likely to be splatted, as early as the integrator
/// knows.
template <class Integrator, class Sampler, class F, class DefectsOf, class ExpectPixel>
MLT_INLINE void evaluate_into(const Integrator& integrator, Sampler& sampler, const MaskOf<F>& active,
                              ContributionOf<F>& contribution, DefectsOf&& defects_of,
                              ExpectPixel&& expect_pixel) {
  contribution.clear();
  integrator.evaluate(
      sampler, ContributionSink<F, std::remove_reference_t<ExpectPixel>>{contribution, expect_pixel}, active);
  contribution.finish(active, defects_of);
}

/// The same where nobody waits for pixels.
template <class Integrator, class Sampler, class F, class DefectsOf>
MLT_INLINE void evaluate_into(const Integrator& integrator, Sampler& sampler, const MaskOf<F>& active,
                              ContributionOf<F>& contribution, DefectsOf&& defects_of) {
  evaluate_into(integrator, sampler, active, contribution, defects_of, [](int, std::uint32_t) {});
}

}  // namespace mlt
