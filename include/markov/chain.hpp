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
#include <atomic>
#include <cstdint>
#include <span>
#include <utility>

#include "base/assert.hpp"
#include "base/planted_fault.hpp"
#include "markov/acceptance.hpp"
#include "markov/bootstrap.hpp"
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
  /// Ends chains early, at the mutation that they have come to; nothing asks for it where it is null.
  const std::atomic<bool>* stop = nullptr;
};

/// What one chain of a group has to do.
struct ChainTask {
  std::uint64_t chain_index = 0;
  std::uint64_t mutations = 0;
  SeedPath start;
};

/// Storage of one worker, reused for each group of chains it runs; splats for one state of all its chains.
template <class F>
struct ChainWorkspaceOf {
  std::span<PrimarySampleOf<F>> samples;
  std::span<SavedSampleOf<F>> saved;
  std::span<Splat> current;
  std::span<Splat> proposed;
};
using ChainWorkspace = ChainWorkspaceOf<float>;

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

/// As many chains as the integrator has lanes, mutation by mutation; each is the chain that it would be
/// alone. Film is anything with splat(pixel, value, metropolis_weight, uniform_weight), value being F / (I +
/// p w), and prefetch(pixel), which is called early for each proposal.
template <class Integrator, class Film>
class ChainGroup {
  using F = typename Integrator::Float;
  using M = MaskOf<F>;
  static constexpr int kCount = kLaneCount<F>;

 public:
  /// `films` has one for each task.
  ChainGroup(const Integrator& integrator, const ChainSettings& settings,
             const ChainWorkspaceOf<F>& workspace, std::span<const ChainTask> tasks, std::span<Film> films)
      : integrator_(integrator),
        settings_(settings),
        tasks_(tasks),
        films_(films),
        samples_(workspace.samples, workspace.saved, make_steps_of<F>(settings.mutation), settings.step_size,
                 settings.first_time),
        states_{Contributions<F>(workspace.current), Contributions<F>(workspace.proposed)} {
    MLT_CHECK_OP(tasks.size(), <=, std::size_t{kCount});
    MLT_CHECK_OP(films.size(), ==, tasks.size());
  }

  /// Replays the starts, makes all mutations and adds what was counted to `statistics`, one for each task.
  /// Returns false if it was stopped before.
  bool run(std::span<ChainStatistics> statistics) {
    statistics_ = statistics;
    begin();
    std::uint64_t longest = 0;
    for (const ChainTask& task : tasks_) longest = task.mutations > longest ? task.mutations : longest;
    MLT_CHECK_OP(longest, <, std::uint64_t{~std::uint32_t{0}} - settings_.first_time);
    ReplayContext& context = replay_context();
    std::uint64_t unchanged_until = 0;
    M active{};
    std::uint64_t made = 0;
    for (; made < longest && !is_stopped_after(made); ++made) {
      const std::uint64_t step = made + 1;
      context.step = step;
      if (step > unchanged_until) active = chains_at(step, unchanged_until);
      mutate(active);
    }
    for (std::size_t i = 0; i < tasks_.size(); ++i) {
      flush(static_cast<int>(i), current_[i]);
      statistics_[i].mutations += std::min(made, tasks_[i].mutations);
    }
    return made == longest;
  }

 private:
  /// The flag is looked at every few milliseconds.
  static constexpr std::uint64_t kStepsBetweenLooks = 1024;
  bool is_stopped_after(std::uint64_t steps) const {
    return steps % kStepsBetweenLooks == 0 && settings_.stop != nullptr &&
           settings_.stop->load(std::memory_order_relaxed);
  }

  /// A state with the weights that it has gathered while it was current, splatted once when it is left.
  struct State {
    Contribution* contribution = nullptr;
    double metropolis_weight = 0;  ///< expected-value weights
    double uniform_weight = 0;     ///< 1 when it was a large step's proposal
    std::uint64_t rejection_run = 0;
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

  /// Replays the paths that the chains start from.
  void begin() {
    ReplayContext& context = replay_context();
    context.seed = settings_.seed;
    context.unit = tasks_.empty() ? 0 : tasks_[0].chain_index;
    context.step = 0;
    BootstrapSamplerOf<F> starts;
    for (std::size_t i = 0; i < tasks_.size(); ++i) {
      const int lane = static_cast<int>(i);
      const std::uint64_t index = tasks_[i].chain_index;
      samples_.set_lane(lane, Rng(settings_.seed, StreamPurpose::kChain, index));
      starts.set_lane(lane, settings_.seed, tasks_[i].start.index, settings_.bootstrap);
    }
    samples_.begin_initial(starts);
    DefectCounts counted_by_the_bootstrap;
    evaluate_into(
        integrator_, samples_, first_lanes<F>(tasks_.size()),
        [this](int lane) -> Contribution& { return states_[0].lane[lane]; },
        [&](int) -> DefectCounts& { return counted_by_the_bootstrap; });
    samples_.end_initial();
    for (std::size_t i = 0; i < tasks_.size(); ++i) {
      current_[i].contribution = &states_[0].lane[i];
      proposed_[i].contribution = &states_[1].lane[i];
      MLT_CHECK_OP(current_[i].contribution->target(), ==, tasks_[i].start.target);
    }
  }

  void mutate(M active) {
    const M large_step = happens(samples_.rng(), broadcast_to<F>(settings_.large_step), active);
    samples_.begin_proposal(large_step);
    evaluate_into(
        integrator_, samples_, active,
        [this](int lane) -> Contribution& { return *proposed_[lane].contribution; },
        [this](int lane) -> DefectCounts& { return statistics_of(lane).defects; },
        [this](int lane, std::uint32_t pixel) { films_[static_cast<std::size_t>(lane)].prefetch(pixel); });
    const F acceptances = weigh(active, large_step);
    const M accepted = active & happens(samples_.rng(), acceptances, active);
    samples_.accept(accepted);
    samples_.reject(not_in(accepted));
    for_lanes(accepted, [this](int lane) { move(lane); });
    for_lanes(active & not_in(accepted), [this](int lane) { stay(lane); });
  }

  /// The probabilities of accepting the proposals, which both states' weights count. What kind of step a lane
  /// makes cannot be predicted, so that each kind has a loop of its own.
  F weigh(M active, M large_step) {
    F proposed{}, current{};
    for_lanes(active, [&](int lane) {
      set_lane_of(proposed, lane, proposed_[lane].contribution->target());
      set_lane_of(current, lane, current_[lane].contribution->target());
    });
    // The current target is positive from the start on, for only a positive proposal is ever accepted.
    const F ratio = proposed / nonzero(active, current);
    const F acceptances = select(ratio < 1.0f, ratio, broadcast_to<F>(1.0f));
    const UintOf<F> dimensions = samples_.dimension();
    for_lanes(active, [&](int lane) {
      const float acceptance = lane_of(acceptances, lane);
      proposed_[lane].metropolis_weight = acceptance;
      current_[lane].metropolis_weight += planted_weight(1.0 - static_cast<double>(acceptance));
      statistics_of(lane).primary_samples += lane_of(dimensions, lane);
    });
    for_lanes(active & not_in(large_step), [&](int lane) {
      statistics_of(lane).acceptance_small += lane_of(acceptances, lane);
      statistics_of(lane).small_steps += 1;
    });
    for_lanes(active & large_step, [&](int lane) {
      proposed_[lane].uniform_weight = 1;
      statistics_of(lane).acceptance_large += lane_of(acceptances, lane);
      statistics_of(lane).large_steps.add(lane_of(proposed, lane));
    });
    return acceptances;
  }

  /// To the proposal.
  void move(int lane) {
    flush(lane, current_[lane]);
    std::swap(current_[lane], proposed_[lane]);
    current_[lane].rejection_run = 0;
  }

  /// Where the chain is.
  void stay(int lane) {
    flush(lane, proposed_[lane]);
    State& current = current_[lane];
    current.rejection_run += 1;
    std::uint64_t& longest = statistics_of(lane).longest_rejection_run;
    if (current.rejection_run > longest) longest = current.rejection_run;
  }

  /// The one place where a chain splats: rejected proposals, states that are left, and the last state alike.
  void flush(int lane, State& state) {
    const double metropolis_weight = state.metropolis_weight;
    const double uniform_weight = state.uniform_weight;
    state.metropolis_weight = 0;
    state.uniform_weight = 0;
    if (metropolis_weight == 0.0 && uniform_weight == 0.0) return;
    if (state.contribution->splats().empty()) return;
    const float scale = 1.0f / (state.contribution->target() + settings_.large_step * settings_.weight_b);
    for (const Splat& splat : state.contribution->splats()) {
      films_[static_cast<std::size_t>(lane)].splat(splat.pixel, splat.value * scale, metropolis_weight,
                                                   uniform_weight);
    }
  }

  const Integrator& integrator_;
  ChainSettings settings_;
  std::span<const ChainTask> tasks_;
  std::span<Film> films_;
  PrimarySampleVectorOf<F> samples_;
  Contributions<F> states_[2];
  State current_[kCount];
  State proposed_[kCount];
  std::span<ChainStatistics> statistics_;
};

}  // namespace mlt
