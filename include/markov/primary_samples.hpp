// The state of a Metropolis chain: a lazily mutated vector of primary samples [Kelemen02]. Each
// sample carries the time of its last change; a small step brings a sample up to date only when a path asks
// for it, one mutation for each accepted step that it missed, so that its distribution is the same as if it
// had been mutated every time. Rejected proposals are undone from a stack of fixed capacity. As many chains
// as F has lanes ask for their samples together, each with streams of its own.
#pragma once

#include <cstdint>
#include <span>

#include "base/assert.hpp"
#include "integrator/sampler.hpp"
#include "markov/bootstrap_sampler.hpp"
#include "markov/mutation.hpp"
#include "math/gather.hpp"
#include "math/rng.hpp"

namespace mlt {

/// The samples of one dimension, in all chains of a group.
template <class F>
struct PrimarySampleOf {
  UintOf<F> time{};   ///< accepted step of the last change; 0: never set
  UintOf<F> value{};  ///< 32-bit fixed point in [0,1)
};

/// What a proposal overwrote.
template <class F>
struct SavedSampleOf {
  PrimarySampleOf<F> sample;
  std::uint32_t index = 0;
};

/// Steps in stock. Their order of use is the order of each generator's numbers.
template <class F>
class StepSource {
  using U = UintOf<F>;

 public:
  StepSource(FillSteps fill, float step_size) : fill_(fill), step_size_(step_size) {
    for (int lane = 0; lane < kLaneCount<F>; ++lane)
      set_lane_of(first_, lane, static_cast<std::uint32_t>(lane) * kStock * kStepBytes);
  }
  void set_lane(int lane, const BlockRng& rng) {
    rng_[lane] = rng;
    set_lane_of(used_, lane, kStock * kStepBytes);
  }

  /// The next step of each lane of `active`.
  MLT_INLINE U take(MaskOf<F> active) {
    for_lanes(MaskOf<F>(active & (used_ == kStock * kStepBytes)), [&](int lane) { refill(lane); });
    // Lanes without stock, none of them active, read their first step.
    const U place = select(used_ == kStock * kStepBytes, U{}, used_);
    used_ += mask_bits(active) & kStepBytes;
    return gather_bytes<F>(stock_[0], first_ + place);
  }
  /// The next step of one lane.
  std::uint32_t take_one(int lane) {
    if (lane_of(used_, lane) == kStock * kStepBytes) refill(lane);
    const std::uint32_t place = lane_of(used_, lane) / kStepBytes;
    set_lane_of(used_, lane, (place + 1) * kStepBytes);
    return stock_[lane][place];
  }

 private:
  static constexpr std::uint32_t kStock = 4 * kBlockDraws;
  static constexpr std::uint32_t kStepBytes = sizeof(std::uint32_t);

  [[gnu::noinline]] void refill(int lane) {
    for (std::uint32_t first = 0; first < kStock; first += kBlockDraws) {
      fill_(rng_[lane], stock_[lane] + first, step_size_);
    }
    set_lane_of(used_, lane, 0U);
  }

  alignas(64) std::uint32_t stock_[kLaneCount<F>][kStock] = {};
  U used_ = broadcast_bits<U>(kStock * kStepBytes);  ///< bytes
  U first_{};                                        ///< where each lane's stock begins, in bytes
  BlockRng rng_[kLaneCount<F>];
  FillSteps fill_;
  float step_size_;
};

template <class F>
class PrimarySampleVectorOf : public FloatSamples<PrimarySampleVectorOf<F>, F> {
  using U = UintOf<F>;
  using M = MaskOf<F>;

 public:
  /// Both spans have the capacity that the integrator states; their contents are overwritten. `first_time`
  /// is where time starts (at least 1); it must not pass 2^32 - 1.
  PrimarySampleVectorOf(std::span<PrimarySampleOf<F>> samples, std::span<SavedSampleOf<F>> saved,
                        FillSteps fill, float step_size, std::uint32_t first_time = 1)
      : samples_(samples),
        saved_(saved),
        steps_(fill, step_size),
        time_(broadcast_bits<U>(first_time)),
        large_step_time_(broadcast_bits<U>(first_time)) {
    MLT_CHECK_OP(samples.size(), ==, saved.size());
    MLT_CHECK_OP(first_time, >=, 1U);
    for (PrimarySampleOf<F>& sample : samples_) sample = PrimarySampleOf<F>{};
  }

  /// The streams of one lane's chain.
  void set_lane(int lane, const Rng& rng, const BlockRng& steps) {
    rng_.set_lane(lane, rng);
    steps_.set_lane(lane, steps);
  }

  /// Takes the first state's samples from `source`, in the order in which the path asks for them.
  void begin_initial(const BootstrapSamplerOf<F>& source) {
    initial_ = source;
    is_initial_ = true;
    progress_.restart();
    saved_count_ = 0;
  }
  void end_initial() { is_initial_ = false; }

  /// `large_step` in the lanes that make one; the others make a small step.
  void begin_proposal(M large_step) {
    large_step_ = large_step;
    progress_.restart();
    saved_count_ = 0;
    current_time_ = select(large_step, broadcast_bits<U>(kNever), time_);
    time_ += 1U;
  }

  MLT_INLINE U next_fixed(M active = not_in(M{})) {
    const std::uint32_t index = progress_.advance(1, active);
    MLT_CHECK_OP(index, <, samples_.size());
    PrimarySampleOf<F>& sample = samples_[index];
    if (is_initial_) [[unlikely]]
      return draw_initial(sample, active);
    // Most often: small steps of samples that are up to date.
    const M small_step = active & not_in(large_step_);
    if (const M late = small_step & (sample.time != current_time_); any(late)) [[unlikely]]
      for_lanes(late, [&](int lane) { catch_up(sample, lane); });
    saved_[saved_count_++] = SavedSampleOf<F>{sample, index};
    U value = sample.value + steps_.take(small_step);
    if (any(active & large_step_)) {
      value = select(large_step_, rng_.next_fixed(active & large_step_), value);
    }
    sample.time = select(active, time_, sample.time);
    sample.value = select(active, value, sample.value);
    return value;
  }

  void skip(std::uint32_t count, M active = not_in(M{})) { progress_.advance(count, active); }

  /// How far the paths have come since the proposal began.
  U dimension() const { return progress_.reached(); }

  void accept(M accepted = not_in(M{})) {
    large_step_time_ = select(accepted & large_step_, time_, large_step_time_);
  }

  void reject(M rejected = not_in(M{})) {
    for (std::uint32_t i = 0; i < saved_count_; ++i) {
      const SavedSampleOf<F>& saved = saved_[i];
      PrimarySampleOf<F>& sample = samples_[saved.index];
      sample.time = select(rejected, saved.sample.time, sample.time);
      sample.value = select(rejected, saved.sample.value, sample.value);
    }
    time_ -= mask_bits(rejected) & 1U;
  }

  RngOf<F>& rng() { return rng_; }

 private:
  static constexpr std::uint32_t kNever = ~std::uint32_t{0};

  [[gnu::noinline]] U draw_initial(PrimarySampleOf<F>& sample, M active) {
    const U value = initial_.next_fixed(active);
    sample.time = select(active, time_, sample.time);
    sample.value = select(active, value, sample.value);
    return value;
  }

  /// Brings a lane's sample to the current state, one step before the proposal. A sample older than the last
  /// large step, or never asked for, is uniform and independent of all others, and the steps that it missed
  /// since would leave it so: it is drawn as of now.
  [[gnu::noinline]] void catch_up(PrimarySampleOf<F>& sample, int lane) {
    const std::uint32_t now = lane_of(time_, lane);
    std::uint32_t time = lane_of(sample.time, lane);
    std::uint32_t value = lane_of(sample.value, lane);
    if (time < lane_of(large_step_time_, lane)) {
      value = lane_of(rng_.next_fixed(one_lane<F>(lane)), lane);
      time = now - 1;
    }
    for (; time + 1 < now; ++time) value += steps_.take_one(lane);
    set_lane_of(sample.time, lane, time);
    set_lane_of(sample.value, lane, value);
  }

  std::span<PrimarySampleOf<F>> samples_;
  std::span<SavedSampleOf<F>> saved_;
  RngOf<F> rng_;
  StepSource<F> steps_;
  BootstrapSamplerOf<F> initial_;
  U time_;
  U current_time_{};  ///< of samples that a small step need not bring up to date
  U large_step_time_;
  M large_step_{};
  Progress<F> progress_;
  std::uint32_t saved_count_ = 0;
  bool is_initial_ = false;
};
using PrimarySampleVector = PrimarySampleVectorOf<float>;

}  // namespace mlt
