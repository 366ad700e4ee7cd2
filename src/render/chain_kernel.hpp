// The units of work of PSSMLT: a chunk of the bootstrap, and a turn of a group of chains.
#pragma once

#include <memory>

#include "integrator/path.hpp"
#include "markov/chain.hpp"
#include "render/kernel.hpp"

namespace mlt {

template <FeatureMask kFeatures>
using WideIntegrator = PathIntegrator<kFeatures, WideFloat>;

/// The items of `Item` that fill `bytes`, which the arena laid out for them.
template <class Item>
std::span<Item> items_of(std::span<std::byte> bytes) {
  return {reinterpret_cast<Item*>(bytes.data()), bytes.size() / sizeof(Item)};
}

inline std::span<SplatOf<WideFloat>> splats_of(std::span<Splat> lanes) {
  return items_of<SplatOf<WideFloat>>(std::as_writable_bytes(lanes));
}

template <FeatureMask kFeatures>
void run_bootstrap_chunk(void* context, std::uint32_t worker, std::uint64_t chunk) {
  auto& storage = *static_cast<RenderStorage*>(context);
  const WideIntegrator<kFeatures> integrator(*storage.world, storage.path);
  storage.bootstrap[chunk] = evaluate_bootstrap_chunk(
      integrator, storage.job.seed, chunk, storage.job.bootstrap, splats_of(storage.benches[worker].proposed),
      storage.workers[worker].bootstrap_defects);
  storage.done.fetch_add(bootstrap_chunk_size(storage.job.bootstrap, chunk), std::memory_order_relaxed);
}

inline ChainSettings settings_of(const RenderStorage& storage) {
  const RenderJob& job = storage.job;
  ChainSettings settings;
  settings.seed = job.seed;
  settings.bootstrap = job.bootstrap;
  settings.large_step = job.large_step;
  settings.weight_b = static_cast<float>(storage.bootstrap_luminance.mean());
  settings.mutation = job.mutation;
  settings.step_size = job.step_size;
  return settings;
}

inline ChainWorkspaceOf<WideFloat> workspace_of(const ChainBench& bench) {
  return {items_of<PrimarySampleOf<WideFloat>>(bench.samples),
          items_of<ProposedSampleOf<WideFloat>>(bench.saved), splats_of(bench.current),
          splats_of(bench.proposed)};
}

/// A group of chains from its first turn to its last, in the memory of a bench.
template <FeatureMask kFeatures>
class RunningGroup {
 public:
  RunningGroup(const RenderStorage& storage, const ChainBench& bench, std::uint64_t group)
      : integrator_(*storage.world, storage.path),
        first_(group * storage.chain_group_size),
        count_(std::min(storage.job.chains - first_, storage.chain_group_size)),
        chains_(integrator_, settings_of(storage), workspace_of(bench), find_tasks(storage, bench),
                std::span(films_).first(count_), std::span(statistics_).first(count_)) {
    chains_.begin();
  }
  RunningGroup(const RunningGroup&) = delete;
  RunningGroup& operator=(const RunningGroup&) = delete;

  /// For the calls that follow.
  void splat_to_film_of(const WorkerStorage& worker, const RenderStorage& storage) {
    for (std::uint64_t i = 0; i < count_; ++i) {
      films_[i] = FixedFilm(worker.film, storage.fraction_bits, half_of(first_ + i, storage.job.chains),
                            worker.film_writers);
    }
  }

  void take_turn(RenderStorage& storage) {
    const std::uint64_t before = mutations();
    chains_.advance(kTurnMutations);
    storage.done.fetch_add(mutations() - before, std::memory_order_relaxed);
  }

  void end(RenderStorage& storage) {
    chains_.end();
    for (std::uint64_t i = 0; i < count_; ++i) storage.chains[first_ + i] = statistics_[i];
  }

 private:
  std::span<const ChainTask> find_tasks(const RenderStorage& storage, const ChainBench& bench) {
    const RenderJob& job = storage.job;
    for (std::uint64_t i = 0; i < count_; ++i) {
      const std::uint64_t index = first_ + i;
      // The first path that carries light lies where the cumulative luminance is still 0.
      const double position =
          job.start == StartKind::first_hit
              ? 0.0
              : seed_position(job.seed, storage.round, index, job.chains, storage.bootstrap_luminance.sum);
      tasks_[i] = {storage.round * job.chains + index, chain_length(storage.mutations, job.chains, index),
                   find_seed_path(integrator_, job.seed, job.bootstrap, storage.bootstrap, position,
                                  splats_of(bench.proposed))};
    }
    return std::span(tasks_).first(count_);
  }

  /// Of all chains.
  std::uint64_t mutations() const {
    std::uint64_t sum = 0;
    for (std::uint64_t i = 0; i < count_; ++i) sum += std::min(chains_.made(), tasks_[i].mutations);
    return sum;
  }

  WideIntegrator<kFeatures> integrator_;
  std::uint64_t first_, count_;  ///< chains
  ChainTask tasks_[kWideLanes];
  ChainStatistics statistics_[kWideLanes];
  FixedFilm films_[kWideLanes];  ///< of the worker whose turn it is
  ChainGroup<WideIntegrator<kFeatures>, FixedFilm> chains_;
};

/// Turns of a bench come one after the other; with more benches than workers none has to wait for another's
/// end as a rule. A stopped render ends the groups where they are: what their states have gathered belongs
/// into the film.
template <FeatureMask kFeatures>
void run_chain_turn(void* context, std::uint32_t worker, std::uint64_t turn) {
  auto& storage = *static_cast<RenderStorage*>(context);
  const ChainTurns turns(storage.mutations, storage.job.chains, storage.chain_group_size,
                         storage.benches.size());
  const std::uint64_t group = turns.group(turn);
  if (group >= turns.groups) return;
  ChainBench& bench = storage.benches[turns.bench(turn)];
  const std::uint32_t own_turn = bench.first_turn + static_cast<std::uint32_t>(turns.at_bench(turn));
  for (std::uint32_t ended = bench.turns.value(); ended != own_turn; ended = bench.turns.value())
    bench.turns.wait_while(ended);
  auto* running = reinterpret_cast<RunningGroup<kFeatures>*>(bench.group.data());
  const bool is_stopped = storage.stop->load(std::memory_order_relaxed);
  if (is_stopped) storage.left_early.store(true, std::memory_order_relaxed);
  if (!is_stopped && turns.of_group(turn) == 0) {
    std::construct_at(running, storage, bench, group);
    bench.is_running = true;
  }
  if (bench.is_running) {
    running->splat_to_film_of(storage.workers[worker], storage);
    if (!is_stopped) running->take_turn(storage);
    if (is_stopped || turns.of_group(turn) + 1 == turns.turns_of_group) {
      running->end(storage);
      bench.is_running = false;
    }
  }
  bench.turns.raise();
}

}  // namespace mlt
