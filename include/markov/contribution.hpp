// What one primary-sample vector contributes: its splats, and the scalar that Metropolis sampling is
// proportional to. The capacity is the integrator's; one path may splat many pixels.
#pragma once

#include <cmath>
#include <cstdint>
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

class Contribution {
 public:
  Contribution() = default;
  explicit Contribution(std::span<Splat> storage) : splats_(storage) {}

  void clear() {
    count_ = 0;
    target_ = 0;
  }

  /// Zero splats need no place; exceeding the capacity is a bug of the integrator.
  void add(const Splat& splat) {
    if (is_zero(splat.value)) return;
    MLT_CHECK_OP(count_, <, splats_.size());
    splats_[count_++] = splat;
  }

  /// Sums the target, or empties the contribution when any splat is defective: never accepted, never
  /// splatted.
  void finish(DefectCounts& defects) {
    target_ = 0;
    for (const Splat& splat : splats()) {
      if (defects.reject(splat.value)) [[unlikely]] {
        clear();
        return;
      }
      target_ += luminance(splat.value);
    }
    // Finite channels can still have a sum beyond the largest float.
    if (!std::isfinite(target_)) [[unlikely]] {
      ++defects.infinite;
      clear();
    }
    // The reciprocal of a smaller target would overflow.
    if (target_ < kMinTarget) clear();
  }

  std::span<const Splat> splats() const { return splats_.first(count_); }
  float target() const { return target_; }  ///< luminance of all splats

 private:
  std::span<Splat> splats_;
  std::uint32_t count_ = 0;
  float target_ = 0;
};

/// The contributions of as many vectors as F has lanes.
template <class F>
struct Contributions {
  static constexpr int kCount = kLaneCount<F>;
  Contribution lane[kCount];

  /// Storage of an equal part for each lane.
  explicit Contributions(std::span<Splat> storage) {
    const std::size_t part = storage.size() / kCount;
    for (std::size_t i = 0; i < kCount; ++i) lane[i] = Contribution(storage.subspan(i * part, part));
  }
};

/// The sink of evaluate_into.
template <class F, class ContributionOf, class Expect>
struct ContributionSink {
  ContributionOf& contribution_of;
  Expect& expect_pixel;

  MLT_INLINE void operator()(const SplatOf<F>& splat, MaskOf<F> lanes = not_in(MaskOf<F>{})) const {
    for_lanes(lanes, [&](int lane) {
      contribution_of(lane).add(Splat{lane_of(splat.pixel, lane), lane_of(splat.value, lane)});
    });
  }
  MLT_INLINE void expect(const UintOf<F>& pixels, MaskOf<F> lanes) const {
    for_lanes(lanes, [&](int lane) { expect_pixel(lane, lane_of(pixels, lane)); });
  }
};

/// Evaluates the vectors of primary samples of the lanes of `active` into contribution_of(lane);
/// defects_of(lane) counts defects, and expect_pixel(lane, pixel) is told of pixels that are likely to be
/// splatted, as early as the integrator knows.
template <class Integrator, class Sampler, class ContributionOf, class DefectsOf, class ExpectPixel>
MLT_INLINE void evaluate_into(const Integrator& integrator, Sampler& sampler,
                              MaskOf<typename Integrator::Float> active, ContributionOf&& contribution_of,
                              DefectsOf&& defects_of, ExpectPixel&& expect_pixel) {
  using F = typename Integrator::Float;
  for_lanes(active, [&](int lane) { contribution_of(lane).clear(); });
  using Sink =
      ContributionSink<F, std::remove_reference_t<ContributionOf>, std::remove_reference_t<ExpectPixel>>;
  integrator.evaluate(sampler, Sink{contribution_of, expect_pixel}, active);
  for_lanes(active, [&](int lane) { contribution_of(lane).finish(defects_of(lane)); });
}

/// The same where nobody waits for pixels.
template <class Integrator, class Sampler, class ContributionOf, class DefectsOf>
MLT_INLINE void evaluate_into(const Integrator& integrator, Sampler& sampler,
                              MaskOf<typename Integrator::Float> active, ContributionOf&& contribution_of,
                              DefectsOf&& defects_of) {
  evaluate_into(integrator, sampler, active, contribution_of, defects_of, [](int, std::uint32_t) {});
}

}  // namespace mlt
