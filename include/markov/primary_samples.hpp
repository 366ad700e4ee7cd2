// The state of a Metropolis chain: a lazily mutated vector of primary samples [Kelemen02]. Each
// sample carries the time of its last change; a small step brings a sample up to date only when a path asks
// for it, one mutation for each accepted step that it missed, so that its distribution is the same as if it
// had been mutated every time. Rejected proposals are undone from a stack of fixed capacity.
#pragma once

#include <cstdint>
#include <span>

#include "base/assert.hpp"
#include "integrator/sampler.hpp"
#include "markov/mutation.hpp"
#include "math/rng.hpp"

namespace mlt {

struct PrimarySample {
  std::uint64_t time = 0;   ///< accepted step of the last change; 0: never set
  std::uint32_t value = 0;  ///< 32-bit fixed point in [0,1)
};

/// What a proposal overwrote.
struct SavedSample {
  std::uint64_t time = 0;
  std::uint32_t value = 0;
  std::uint32_t index = 0;
};

/// Steps in stock. Their order of use is the order of the generator's numbers.
class StepSource {
 public:
  StepSource(BlockRng rng, FillSteps fill, float step_size) : rng_(rng), fill_(fill), step_size_(step_size) {}

  bool empty() const { return used_ == kStock; }
  /// Must not be empty.
  std::uint32_t take() { return steps_[used_++]; }
  std::uint32_t next() {
    if (empty()) refill();
    return take();
  }

 private:
  static constexpr std::uint32_t kStock = 4 * kBlockDraws;

  void refill() {
    for (std::uint32_t first = 0; first < kStock; first += kBlockDraws) {
      fill_(rng_, steps_ + first, step_size_);
    }
    used_ = 0;
  }

  alignas(16) std::uint32_t steps_[kStock];
  BlockRng rng_;
  FillSteps fill_;
  float step_size_;
  std::uint32_t used_ = kStock;
};

class PrimarySampleVector : public FloatSamples<PrimarySampleVector> {
 public:
  /// Both spans have the capacity that the integrator states; their contents are overwritten. `first_time`
  /// is where time starts (at least 1).
  PrimarySampleVector(std::span<PrimarySample> samples, std::span<SavedSample> saved, Rng rng,
                      const StepSource& steps, std::uint64_t first_time = 1)
      : samples_(samples),
        saved_(saved),
        rng_(rng),
        steps_(steps),
        time_(first_time),
        large_step_time_(first_time) {
    MLT_CHECK_OP(samples.size(), ==, saved.size());
    MLT_CHECK_OP(first_time, >=, 1U);
    for (PrimarySample& sample : samples_) sample = PrimarySample{};
  }

  /// Draws the first state's samples from `source`, in the order in which the path asks for them, exactly as
  /// IndependentSampler would.
  void begin_initial(Rng source) {
    initial_ = source;
    mode_ = Mode::kInitial;
    cursor_ = 0;
    saved_count_ = 0;
    current_time_ = kNever;
  }
  void end_initial() { mode_ = Mode::kSmall; }

  void begin_proposal(bool large_step) {
    mode_ = large_step ? Mode::kLarge : Mode::kSmall;
    cursor_ = 0;
    saved_count_ = 0;
    current_time_ = large_step ? kNever : time_;
    time_ += 1;
  }

  std::uint32_t next_fixed() {
    MLT_CHECK_OP(cursor_, <, samples_.size());
    const std::uint32_t index = cursor_++;
    PrimarySample& sample = samples_[index];
    // Most often: a small step of a sample that is up to date.
    if (sample.time != current_time_ || steps_.empty()) [[unlikely]]
      return propose(sample, index);
    saved_[saved_count_++] = SavedSample{sample.time, sample.value, index};
    sample.time = time_;
    return sample.value += steps_.take();
  }

  void skip(std::uint32_t count) { cursor_ += count; }

  /// How far the path has come: primary samples asked for or skipped since the proposal began.
  std::uint32_t dimension() const { return cursor_; }

  void accept() {
    if (mode_ == Mode::kLarge) large_step_time_ = time_;
  }

  void reject() {
    while (saved_count_ > 0) {
      const SavedSample& saved = saved_[--saved_count_];
      samples_[saved.index] = PrimarySample{saved.time, saved.value};
    }
    time_ -= 1;
  }

  Rng& rng() { return rng_; }

 private:
  enum class Mode : std::uint8_t { kInitial, kLarge, kSmall };

  static constexpr std::uint64_t kNever = ~std::uint64_t{0};

  [[gnu::noinline]] std::uint32_t propose(PrimarySample& sample, std::uint32_t index) {
    if (mode_ == Mode::kInitial) {
      sample = PrimarySample{time_, initial_.next_fixed()};
      return sample.value;
    }
    if (mode_ == Mode::kSmall) catch_up(sample);
    saved_[saved_count_++] = SavedSample{sample.time, sample.value, index};
    sample.time = time_;
    sample.value = mode_ == Mode::kLarge ? rng_.next_fixed() : sample.value + steps_.next();
    return sample.value;
  }

  /// Brings a sample to the current state, one step before the proposal. A sample older than the last large
  /// step, or never asked for, is uniform and independent of all others, and the steps that it missed since
  /// would leave it so: it is drawn as of now.
  void catch_up(PrimarySample& sample) {
    if (sample.time < large_step_time_) sample = PrimarySample{time_ - 1, rng_.next_fixed()};
    for (; sample.time + 1 < time_; ++sample.time) sample.value += steps_.next();
  }

  std::span<PrimarySample> samples_;
  std::span<SavedSample> saved_;
  Rng rng_;
  StepSource steps_;
  Rng initial_;
  std::uint64_t time_;
  std::uint64_t current_time_ = kNever;  ///< of samples that a small step need not bring up to date
  std::uint64_t large_step_time_;
  std::uint32_t cursor_ = 0;
  std::uint32_t saved_count_ = 0;
  Mode mode_ = Mode::kSmall;
};

}  // namespace mlt
