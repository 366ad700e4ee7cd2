// One Markov chain of PSSMLT. Proposed and current states are both splatted with expected-value weights, and
// large steps, which are uniform samples, join the estimate by multiple importance sampling [Kelemen02]. In
// our notation, with target I, contribution F, large-step probability p, M mutations and the frozen estimate
// w of b, the image is
//   (b / M) * sum over states of a_i F / (I + p w)  +  (w / M) * sum over large steps of F / (I + p w),
// where a_i are the expected-value weights of the Metropolis samples. For any w > 0 both sums have the right
// expectation together, so a wrong w costs variance and no bias; b multiplies once, at development.
// docs/ESTIMATOR.md derives it.
#pragma once

#include <cstdint>
#include <span>

#include "base/assert.hpp"
#include "base/planted_fault.hpp"
#include "markov/acceptance.hpp"
#include "markov/bootstrap.hpp"
#include "markov/contribution.hpp"
#include "markov/primary_samples.hpp"

namespace mlt {

struct ChainSettings {
  std::uint64_t seed = 0;
  std::uint64_t chain_index = 0;
  std::uint64_t mutations = 0;
  float large_step = 0.2f;  ///< probability in [0,1]
  float weight_b = 0;       ///< w above: the frozen b of the weights, > 0
  FillSteps fill_steps = nullptr;
  float step_size = 1;  ///< from kMinStepSize to kMaxStepSize
  std::uint64_t first_time = 1;
};

/// Storage of one worker, reused for each chain it runs.
struct ChainWorkspace {
  std::span<PrimarySample> samples;
  std::span<SavedSample> saved;
  std::span<Splat> current;
  std::span<Splat> proposed;
};

struct ChainStatistics {
  LuminanceMoments large_steps;  ///< uniform samples, which join the estimate of b
  double acceptance_large = 0;   ///< sum of acceptance probabilities
  double acceptance_small = 0;
  std::uint64_t small_steps = 0;
  std::uint64_t longest_rejection_run = 0;
  std::uint64_t mutations = 0;
  std::uint64_t primary_samples = 0;  ///< that the mutations' paths asked for
  DefectCounts defects;

  void add(const ChainStatistics& other);
};

/// A state with the weights that it has gathered while it was current, splatted once when it is left.
struct ChainState {
  Contribution contribution;
  double metropolis_weight = 0;  ///< expected-value weights
  double uniform_weight = 0;     ///< 1 when it was a large step's proposal
};

/// Film is anything with splat(pixel, value, metropolis_weight, uniform_weight), value being F / (I + p w).
template <class Integrator, class Film>
class Chain {
 public:
  Chain(const Integrator& integrator, const ChainSettings& settings, const ChainWorkspace& workspace,
        Film& film)
      : integrator_(integrator),
        settings_(settings),
        film_(film),
        samples_(workspace.samples, workspace.saved,
                 Rng(settings.seed, StreamPurpose::kChain, settings.chain_index),
                 StepSource(BlockRng(settings.seed, StreamPurpose::kSteps, settings.chain_index),
                            settings.fill_steps, settings.step_size),
                 settings.first_time),
        current_{Contribution(workspace.current)},
        proposed_{Contribution(workspace.proposed)} {}

  /// Replays the start, makes all mutations and returns what was counted.
  ChainStatistics run(const SeedPath& start) {
    ReplayContext& context = replay_context();
    context.seed = settings_.seed;
    context.unit = settings_.chain_index;
    context.step = 0;
    samples_.begin_initial(bootstrap_stream(settings_.seed, start.index));
    DefectCounts counted_by_the_bootstrap;
    evaluate_into(integrator_, samples_, current_.contribution, counted_by_the_bootstrap);
    samples_.end_initial();
    MLT_CHECK_OP(current_.contribution.target(), ==, start.target);
    for (std::uint64_t step = 1; step <= settings_.mutations; ++step) {
      context.step = step;
      mutate();
    }
    flush(current_);
    statistics_.mutations = settings_.mutations;
    return statistics_;
  }

 private:
  void mutate() {
    const bool large_step = happens(samples_.rng(), settings_.large_step);
    samples_.begin_proposal(large_step);
    evaluate_into(integrator_, samples_, proposed_.contribution, statistics_.defects);
    statistics_.primary_samples += samples_.dimension();

    // The current target is positive from the start on, for only a positive proposal is ever accepted.
    const float ratio = proposed_.contribution.target() / current_.contribution.target();
    const float acceptance = ratio < 1.0f ? ratio : 1.0f;
    count(large_step, acceptance);
    proposed_.metropolis_weight = acceptance;
    proposed_.uniform_weight = large_step ? 1.0 : 0.0;
    current_.metropolis_weight += planted_weight(1.0 - static_cast<double>(acceptance));
    if (happens(samples_.rng(), acceptance)) {
      samples_.accept();
      flush(current_);
      swap_states();
      rejection_run_ = 0;
    } else {
      samples_.reject();
      flush(proposed_);
      rejection_run_ += 1;
      if (rejection_run_ > statistics_.longest_rejection_run)
        statistics_.longest_rejection_run = rejection_run_;
    }
  }

  void count(bool large_step, float acceptance) {
    if (large_step) {
      statistics_.large_steps.add(proposed_.contribution.target());
      statistics_.acceptance_large += acceptance;
    } else {
      statistics_.acceptance_small += acceptance;
      statistics_.small_steps += 1;
    }
  }

  /// The one place where a chain splats: rejected proposals, states that are left, and the last state alike.
  void flush(ChainState& state) {
    const double metropolis_weight = state.metropolis_weight;
    const double uniform_weight = state.uniform_weight;
    state.metropolis_weight = 0;
    state.uniform_weight = 0;
    if (metropolis_weight == 0.0 && uniform_weight == 0.0) return;
    if (state.contribution.splats().empty()) return;
    const float scale = 1.0f / (state.contribution.target() + settings_.large_step * settings_.weight_b);
    for (const Splat& splat : state.contribution.splats()) {
      film_.splat(splat.pixel, splat.value * scale, metropolis_weight, uniform_weight);
    }
  }

  void swap_states() {
    const ChainState left = current_;
    current_ = proposed_;
    proposed_ = left;
  }

  const Integrator& integrator_;
  ChainSettings settings_;
  Film& film_;
  PrimarySampleVector samples_;
  ChainState current_;
  ChainState proposed_;
  ChainStatistics statistics_;
  std::uint64_t rejection_run_ = 0;
};

}  // namespace mlt
