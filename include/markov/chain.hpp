// One Markov chain of PSSMLT. Proposed and current states are both splatted with expected-value weights, and
// large steps, which are uniform samples, join the estimate by multiple importance sampling [Kelemen02]. In
// our notation, with target I, contribution F, large-step probability p, M mutations and the frozen estimate
// w of b, the image is
//   (b / M) * sum over states of a_i F / (I + p w)  +  (w / M) * sum over large steps of F / (I + p w),
// where a_i are the expected-value weights of the Metropolis samples. For any w > 0 both sums have the right
// expectation together, so a wrong w costs variance and no bias; b multiplies once, at development.
// docs/ESTIMATOR.md derives it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>

#include "base/assert.hpp"
#include "base/planted_fault.hpp"
#include "markov/acceptance.hpp"
#include "markov/bootstrap.hpp"
#include "markov/chain_statistics.hpp"
#include "markov/contribution.hpp"
#include "markov/primary_samples.hpp"

namespace mlt {

struct ChainSettings {
  std::uint64_t seed = 0;
  std::uint64_t bootstrap = 0;  ///< paths, one of which each chain starts from
  float large_step = 0.2f;      ///< probability in [0,1]
  float weight_b = 0;           ///< w above: the frozen b of the weights, > 0
  MutationKind mutation = MutationKind::kelemen;
  float step_size = 1;  ///< from kMinStepSize to kMaxStepSize
  std::uint32_t first_time = 1;
};

/// What one chain of a group has to do.
struct ChainTask {
  std::uint64_t chain_index = 0;
  std::uint64_t mutations = 0;
  SeedPath start;
};

/// Storage of one worker, reused for each group of chains it runs; splats of one state of all its chains.
template <class F>
struct ChainWorkspaceOf {
  std::span<PrimarySampleOf<F>> samples;
  std::span<ProposedSampleOf<F>> saved;
  std::span<SplatOf<F>> current;
  std::span<SplatOf<F>> proposed;
};
using ChainWorkspace = ChainWorkspaceOf<float>;

/// As many chains as the integrator has lanes, mutation by mutation; each is the chain that it would be
/// alone. Between begin() and end(), advance() may be called any number of times, by one thread after the
/// other. Film is anything with splat(pixel, value, metropolis_weight, uniform_weight), value being F / (I +
/// p w), and prefetch(pixel), which is called early for each proposal.
template <class Integrator, class Film>
class ChainGroup {
  using F = typename Integrator::Float;
  using M = MaskOf<F>;
  static constexpr int kCount = kLaneCount<F>;

 public:
  /// `films` and `statistics` have one for each task.
  ChainGroup(const Integrator& integrator, const ChainSettings& settings,
             const ChainWorkspaceOf<F>& workspace, std::span<const ChainTask> tasks, std::span<Film> films,
             std::span<ChainStatistics> statistics)
      : integrator_(integrator),
        settings_(settings),
        tasks_(tasks),
        films_(films),
        samples_(workspace.samples, workspace.saved, make_steps_of<F>(settings.mutation), settings.step_size,
                 settings.first_time),
        current_(workspace.current),
        proposed_(workspace.proposed),
        statistics_(statistics) {
    MLT_CHECK_OP(tasks.size(), <=, std::size_t{kCount});
    MLT_CHECK_OP(films.size(), ==, tasks.size());
    MLT_CHECK_OP(statistics.size(), ==, tasks.size());
    for (const ChainTask& task : tasks_) longest_ = task.mutations > longest_ ? task.mutations : longest_;
    MLT_CHECK_OP(longest_, <, std::uint64_t{~std::uint32_t{0}} - settings_.first_time);
  }

  /// Replays the paths that the chains start from.
  void begin() {
    replay_context().step = 0;
    name_in_reports();
    const BootstrapStreams streams(settings_.seed, settings_.bootstrap);
    BootstrapSamplerOf<F> starts;
    for (std::size_t i = 0; i < tasks_.size(); ++i) {
      const int lane = static_cast<int>(i);
      const std::uint64_t index = tasks_[i].chain_index;
      samples_.set_lane(lane, Rng(settings_.seed, StreamPurpose::kChain, index));
      starts.set_lane(lane, streams, tasks_[i].start.index);
    }
    samples_.begin_initial(starts);
    DefectCounts counted_by_the_bootstrap;
    evaluate_into(integrator_, samples_, first_lanes<F>(tasks_.size()), current_,
                  [&](int) -> DefectCounts& { return counted_by_the_bootstrap; });
    samples_.end_initial();
    for (std::size_t i = 0; i < tasks_.size(); ++i) {
      MLT_CHECK_OP(lane_of(current_.target(), static_cast<int>(i)), ==, tasks_[i].start.target);
    }
  }

  /// Makes `mutations` more of each chain, or those that are left, and counts them.
  void advance(std::uint64_t mutations) {
    name_in_reports();
    const std::uint64_t end = mutations < longest_ - made_ ? made_ + mutations : longest_;
    for (; made_ < end; ++made_) {
      const std::uint64_t step = made_ + 1;
      replay_context().step = step;
      if (step > unchanged_until_) active_ = chains_at(step, unchanged_until_);
      mutate(active_);
      if (step % LaneSums<F>::kMostCounts == 0) sums_.move_to(statistics_);
    }
  }

  /// Mutations of one of the longest chains.
  std::uint64_t made() const { return made_; }

  /// The chains end where they are.
  void end() {
    splat(first_lanes<F>(tasks_.size()), current_, weights_);
    sums_.move_to(statistics_);
    for (std::size_t i = 0; i < tasks_.size(); ++i) {
      statistics_[i].mutations = std::min(made_, tasks_[i].mutations);
      statistics_[i].longest_rejection_run = lane_of(longest_rejection_run_, static_cast<int>(i));
    }
  }

 private:
  /// What states have gathered while they were current; they are splatted once, when they are left.
  struct Weights {
    alignas(64) double metropolis[kCount] = {};  ///< expected-value weights
    M uniform{};                                 ///< lanes in which it was a large step's proposal
  };

  /// The chains that make mutation `step`, and the last mutation that the same chains make.
  M chains_at(std::uint64_t step, std::uint64_t& unchanged_until) const {
    M active{};
    unchanged_until = ~std::uint64_t{0};
    for (std::size_t i = 0; i < tasks_.size(); ++i) {
      const std::uint64_t last = tasks_[i].mutations;
      if (step > last) continue;
      set_lane_of(active, static_cast<int>(i), kLaneTrue<F>);
      if (last < unchanged_until) unchanged_until = last;
    }
    return active;
  }

  ChainStatistics& statistics_of(int lane) { return statistics_[static_cast<std::size_t>(lane)]; }

  void name_in_reports() const {
    replay_context().seed = settings_.seed;
    replay_context().unit = tasks_.empty() ? 0 : tasks_[0].chain_index;
  }

  void mutate(M active) {
    const M large_step = happens(samples_.rng(), broadcast_to<F>(settings_.large_step), active);
    samples_.begin_proposal(large_step);
    evaluate_into(
        integrator_, samples_, active, proposed_,
        [this](int lane) -> DefectCounts& { return statistics_of(lane).defects; },
        [this](int lane, std::uint32_t pixel) { films_[static_cast<std::size_t>(lane)].prefetch(pixel); });
    // The current target is positive from the start on, for only a positive proposal is ever accepted.
    const F ratio = proposed_.target() / nonzero(active, current_.target());
    const F acceptances = select(ratio < 1.0f, ratio, broadcast_to<F>(1.0f));
    sums_.count(active, large_step, acceptances, proposed_.target(), samples_.dimension());
    const M accepted = active & happens(samples_.rng(), acceptances, active);
    samples_.accept(accepted);
    samples_.reject(not_in(accepted));
    leave(active, accepted, large_step, acceptances);
  }

  /// Of the two states, splats the one that is left: the current one where the proposal is accepted,
  /// elsewhere the proposal. Both states' weights count the acceptance.
  void leave(M active, M accepted, M large_step, const F& acceptances) {
    // In lanes at rest the current state gains nothing.
    const DoubleOf<F> of_proposals = to_double(select(active, acceptances, broadcast_to<F>(1.0f)));
    DoubleOf<F> of_current = 1.0 - of_proposals;
    plant_weight_loss(of_current);
    Weights left;
    store_wide(left.metropolis, load_wide<DoubleOf<F>>(weights_.metropolis) + of_current);
    store_wide(weights_.metropolis, of_proposals);
    for_lanes(not_in(accepted),
              [&](int lane) { std::swap(left.metropolis[lane], weights_.metropolis[lane]); });
    left.uniform = (accepted & weights_.uniform) | (not_in(accepted) & large_step);
    weights_.uniform = (accepted & large_step) | (not_in(accepted) & weights_.uniform);
    proposed_.exchange(current_, accepted);
    splat(active, proposed_, left);
    rejection_run_ = select(accepted, UintOf<F>{}, rejection_run_ + (mask_bits(active) & 1U));
    longest_rejection_run_ =
        select(rejection_run_ > longest_rejection_run_, rejection_run_, longest_rejection_run_);
  }

  /// The one place where a chain splats: rejected proposals, states that are left, and the last state alike.
  void splat(M lanes, const ContributionOf<F>& states, const Weights& weights) {
    lanes &= states.target() > 0.0f;
    const F scale = 1.0f / nonzero(lanes, states.target() + settings_.large_step * settings_.weight_b);
    for (const SplatOf<F>& splat : states.splats()) {
      const M lit = lanes & not_in(is_zero<F>(splat.value));
      const Vec3Of<F> scaled = splat.value * scale;
      if constexpr (VectorType<F> && requires { Film::template splat_lanes<F>; }) {
        Film::template splat_lanes<F>(films_, lit, splat.pixel, scaled, weights.metropolis, weights.uniform);
      } else {
        for_lanes(lit, [&](int lane) {
          const bool is_uniform = (lanes_of(weights.uniform) >> lane & 1U) != 0;
          if (weights.metropolis[lane] == 0.0 && !is_uniform) return;
          films_[static_cast<std::size_t>(lane)].splat(lane_of(splat.pixel, lane), lane_of(scaled, lane),
                                                       weights.metropolis[lane], is_uniform ? 1.0 : 0.0);
        });
      }
    }
  }

  const Integrator& integrator_;
  ChainSettings settings_;
  std::span<const ChainTask> tasks_;
  std::span<Film> films_;
  PrimarySampleVectorOf<F> samples_;
  ContributionOf<F> current_, proposed_;
  Weights weights_;  ///< of the current states
  UintOf<F> rejection_run_{}, longest_rejection_run_{};
  std::span<ChainStatistics> statistics_;
  LaneSums<F> sums_;
  std::uint64_t longest_ = 0;  ///< mutations of a chain
  std::uint64_t made_ = 0;
  std::uint64_t unchanged_until_ = 0;  ///< the last mutation that the lanes of active_ make
  M active_{};
};

}  // namespace mlt
