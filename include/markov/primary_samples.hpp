// The state of a Metropolis chain: a lazily mutated vector of primary samples [Kelemen02]. Each
// sample carries the time of its last change; a small step brings a sample up to date only when a path asks
// for it, one mutation for each accepted step that it missed, so that its distribution is the same as if it
// had been mutated every time. A proposal's samples are kept apart, in a stack of fixed capacity, and taken
// over where it is accepted. As many chains as F has lanes ask for their samples together, each with streams
// of its own.
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

/// The same as a proposal has it.
template <class F>
struct ProposedSampleOf {
  UintOf<F> value{};
  MaskOf<F> asked{};  ///< lanes whose paths asked for it
};

template <class F>
class PrimarySampleVectorOf : public FloatSamples<PrimarySampleVectorOf<F>, F> {
  using U = UintOf<F>;
  using M = MaskOf<F>;

 public:
  /// Both spans have the capacity that the integrator states; their contents are overwritten. `first_time`
  /// is where time starts (at least 1); it must not pass 2^32 - 1.
  PrimarySampleVectorOf(std::span<PrimarySampleOf<F>> samples, std::span<ProposedSampleOf<F>> proposed,
                        MakeSteps<F> make_steps, float step_size, std::uint32_t first_time = 1)
      : samples_(samples),
        proposed_(proposed),
        make_steps_(make_steps),
        step_size_(step_size),
        time_(broadcast_bits<U>(first_time)),
        large_step_time_(broadcast_bits<U>(first_time)) {
    MLT_CHECK_OP(samples.size(), ==, proposed.size());
    MLT_CHECK_OP(first_time, >=, 1U);
    for (PrimarySampleOf<F>& sample : samples_) sample = PrimarySampleOf<F>{};
  }

  /// The stream of one lane's chain.
  void set_lane(int lane, const Rng& rng) { rng_.set_lane(lane, rng); }

  /// Takes the first state's samples from `source`, in the order in which the path asks for them.
  void begin_initial(const BootstrapSamplerOf<F>& source) {
    initial_ = source;
    is_initial_ = true;
    progress_.restart();
  }
  void end_initial() { is_initial_ = false; }

  /// `large_step` in the lanes that make one; the others make a small step.
  void begin_proposal(M large_step) {
    large_step_ = large_step;
    progress_.restart();
    current_time_ = select(large_step, broadcast_bits<U>(kNever), time_);
    time_ += 1U;
  }

  MLT_INLINE U next_fixed(M active = not_in(M{})) {
    const std::uint32_t index = progress_.advance(1, active);
    MLT_CHECK_OP(index, <, samples_.size());
    if (is_initial_) [[unlikely]]
      return draw_initial(samples_[index], active);
    return propose(
        index, active, rng_, [&](const U& draws, M lanes) __attribute__((always_inline)) {
          return is_usual() ? Usual::template steps<F>(draws, rng_, lanes, step_size_)
                            : make_steps_(draws, rng_, lanes, step_size_);
        });
  }

  /// The generator stays in registers meanwhile, so that nothing here may call a function that could read it.
  template <bool kLightChoice, bool kLobeChoice>
  MLT_NOINLINE VertexSamples<F> next_vertex(M lit, M active) {
    constexpr std::uint32_t kLight = 2 + (kLightChoice ? 1 : 0), kBsdf = 2 + (kLobeChoice ? 1 : 0);
    if (is_initial_ || !is_usual()) [[unlikely]]
      return Floats::template next_vertex<kLightChoice, kLobeChoice>(lit, active);
    const std::uint32_t first = progress_.advance(kLight + kBsdf, active);
    MLT_CHECK_OP(first + kLight + kBsdf, <=, samples_.size());
    RngOf<F> rng = rng_;
    const auto steps = [&](const U& draws, M lanes) __attribute__((always_inline)) {
      return Usual::template steps<F>(draws, rng, lanes, step_size_);
    };
    F values[kLight + kBsdf];
    for (std::uint32_t i = 0; i < kLight + kBsdf; ++i)
      values[i] = unit_float(propose(first + i, i < kLight ? lit : active, rng, steps));
    rng_ = rng;
    const F* const light = values + kLight - 2;
    const F* const bsdf = values + kLight + kBsdf - 2;
    return {values[0], {light[0], light[1]}, values[kLight], {bsdf[0], bsdf[1]}};
  }

  void skip(std::uint32_t count, M active = not_in(M{})) {
    const std::uint32_t first = progress_.advance(count, active);
    if (is_initial_) return;
    MLT_CHECK_OP(first + count, <=, proposed_.size());
    for (std::uint32_t i = first; i < first + count; ++i) proposed_[i].asked = M{};
  }

  /// How far the paths have come since the proposal began.
  U dimension() const { return progress_.reached(); }

  void accept(M accepted = not_in(M{})) {
    large_step_time_ = select(accepted & large_step_, time_, large_step_time_);
    for (std::uint32_t i = 0; i < progress_.cursor(); ++i) {
      const M taken = accepted & proposed_[i].asked;
      PrimarySampleOf<F>& sample = samples_[i];
      sample.time = select(taken, time_, sample.time);
      sample.value = select(taken, proposed_[i].value, sample.value);
    }
  }

  void reject(M rejected = not_in(M{})) { time_ -= mask_bits(rejected) & 1U; }

  RngOf<F>& rng() { return rng_; }

 private:
  static constexpr std::uint32_t kNever = ~std::uint32_t{0};
  using Floats = FloatSamples<PrimarySampleVectorOf, F>;
  using Usual = Mutation<MutationKind::kelemen>;

  /// Steps of the usual kind are made without a call, which would write all registers to memory.
  MLT_INLINE bool is_usual() const { return make_steps_ == &Usual::template steps<F, RngOf<F>>; }

  [[gnu::noinline]] U draw_initial(PrimarySampleOf<F>& sample, M active) {
    const U value = initial_.next_fixed(active);
    sample.time = select(active, time_, sample.time);
    sample.value = select(active, value, sample.value);
    return value;
  }

  /// The proposal's sample of one dimension; steps(draws, lanes) makes small steps.
  template <class Steps>
  MLT_INLINE U propose(std::uint32_t index, M active, RngOf<F>& rng, Steps&& steps) {
    PrimarySampleOf<F>& sample = samples_[index];
    // Most often: small steps of samples that are up to date.
    const M small_step = active & not_in(large_step_);
    if (const M late = small_step & (sample.time != current_time_); any(late)) [[unlikely]]
      catch_up(sample, late, rng, steps);
    const U draws = rng.next_fixed(active);
    const U value = select(large_step_, draws, sample.value + steps(draws, small_step));
    ProposedSampleOf<F>& proposed = proposed_[index];
    proposed.value = value;
    proposed.asked = active;
    return value;
  }

  /// Brings samples of the lanes of `late`, which make small steps, to the current state, one step before the
  /// proposal. A sample older than the last large step, or never asked for, is uniform and independent of all
  /// others, and the steps that it missed since would leave it so: it is drawn as of now.
  template <class Steps>
  MLT_INLINE void catch_up(PrimarySampleOf<F>& sample, M late, RngOf<F>& rng, Steps&& steps) const {
    if (const M forgotten = late & (sample.time < large_step_time_); any(forgotten)) {
      sample.value = select(forgotten, rng.next_fixed(forgotten), sample.value);
      sample.time = select(forgotten, current_time_, sample.time);
    }
    for (M behind = late; any(behind &= sample.time < current_time_);) {
      const U draws = rng.next_fixed(behind);
      sample.value = select(behind, sample.value + steps(draws, behind), sample.value);
      sample.time += mask_bits(behind) & 1U;
    }
  }

  std::span<PrimarySampleOf<F>> samples_;
  std::span<ProposedSampleOf<F>> proposed_;
  RngOf<F> rng_;
  MakeSteps<F> make_steps_;
  float step_size_;
  BootstrapSamplerOf<F> initial_;
  U time_;
  U current_time_{};  ///< of samples that a small step need not bring up to date
  U large_step_time_;
  M large_step_{};
  Progress<F> progress_;
  bool is_initial_ = false;
};
using PrimarySampleVector = PrimarySampleVectorOf<float>;

}  // namespace mlt
