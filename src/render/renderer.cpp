#include "render/renderer.hpp"

#include <algorithm>

#include "base/process_usage.hpp"
#include "base/render_zone.hpp"
#include "job_plan.hpp"
#include "render/film_hash.hpp"
#include "render/kernel.hpp"
#include "render/kernel_set.hpp"
#include "render/scene_info.hpp"
#include "render/worker_pool.hpp"
#include "world/world.hpp"

namespace mlt {
namespace {

void add_defects(RenderStatistics& statistics, const DefectCounts& defects) {
  statistics.rejected_nan += defects.nan;
  statistics.rejected_infinite += defects.infinite;
  statistics.rejected_negative += defects.negative;
}

/// Code that the job does not run, and of which nothing need be in memory.
std::vector<CodeRange> code_of_other_sets(InstructionSet used) {
  std::vector<CodeRange> ranges;
#define MLT_ADD(name, help, condition) \
  if (used != InstructionSet::name) ranges.push_back(code_of(InstructionSet::name));
  MLT_INSTRUCTION_SETS(MLT_ADD)
#undef MLT_ADD
  return ranges;
}

}  // namespace

struct EstimateContext;

struct Renderer::State {
  /// A guest has a `host`.
  State(const SceneDescription& description, const RenderJob& job, State* host = nullptr)
      : home(host != nullptr ? *host : *this),
        scene(description),
        counts(host != nullptr ? host->counts : count_world(description)),
        plan(counts, job, host != nullptr ? &host->plan : nullptr) {
    plan.require_within_limit(counts);
  }

  std::uint64_t run_phase(const char* stage, UnitFunction function, std::uint64_t units, bool stoppable);
  void render_metropolis();
  bool run_chains(ChainStatistics& total);
  void develop_metropolis(const ChainStatistics& total);
  void render_path();
  void collect_path();
  bool wants_another_round();
  bool has_parts() const;
  EstimateContext error_context() const;
  void estimate();
  static void report_progress(void* state);
  void compile();
  void take_storage();
  bool is_guest() const { return &home != this; }
  bool has_film() const { return home.tenant == this; }

  State& home;                    ///< its own scene, threads and memory, or of a guest the host's
  const State* tenant = nullptr;  ///< whose film is in this home's memory for films
  const SceneDescription& scene;
  WorldCounts counts;
  JobPlan plan;
  std::unique_ptr<Arena> arena;
  World world;
  RenderStorage storage;
  WorkerPool own_pool;  // after the arena, whose stacks its threads run on until they are joined
  WorkerPool& pool = home.own_pool;

  // One run
  const std::atomic<bool>* stop = nullptr;
  ProgressCallback progress = nullptr;
  void* progress_context = nullptr;
  double begin_seconds = 0;
  std::uint64_t progress_total = 0;
  RenderStatistics statistics;
  FilmNormalisation normalisation;
};

std::uint64_t Renderer::State::run_phase(const char* stage, UnitFunction function, std::uint64_t units,
                                         bool stoppable) {
  return pool.run(Phase{stage, function, &storage, units, stoppable}, *stop, &State::report_progress, this);
}

void Renderer::State::report_progress(void* context) {
  const State& state = *static_cast<State*>(context);
  if (state.progress == nullptr) return;
  const RenderProgress now{state.storage.done.load(std::memory_order_relaxed), state.progress_total,
                           monotonic_seconds() - state.begin_seconds};
  state.progress(now, state.progress_context);
}

void Renderer::State::render_metropolis() {
  progress_total = plan.job.bootstrap + storage.mutations * plan.job.max_rounds;
  const std::uint64_t chunks = storage.bootstrap.size();
  const std::uint64_t chunks_run = run_phase("bootstrap", plan.kernel.bootstrap_chunk, chunks, true);
  statistics.partial = chunks_run < chunks;
  storage.bootstrap_luminance =
      accumulate_bootstrap(storage.bootstrap, std::min(chunks_run * kBootstrapChunk, plan.job.bootstrap));
  for (const WorkerStorage& worker : storage.workers) add_defects(statistics, worker.bootstrap_defects);

  ChainStatistics total;
  statistics.black = !(storage.bootstrap_luminance.sum > 0.0);
  if (!statistics.partial && !statistics.black) {
    do {
      statistics.partial = !run_chains(total);
      develop_metropolis(total);
    } while (wants_another_round());
  } else {
    develop_metropolis(total);
  }
  add_defects(statistics, total.defects);
}

/// One round of all chains; false when it was stopped before its end.
bool Renderer::State::run_chains(ChainStatistics& total) {
  // Of groups that a stopped round does not come to, nothing counts.
  for (ChainStatistics& chain : storage.chains) chain = {};
  for (ChainBench& bench : storage.benches) bench.first_turn = bench.turns.value();
  const ChainTurns turns(storage.mutations, plan.job.chains, plan.group_size, plan.benches);
  run_phase("chain", plan.kernel.chain_turn, turns.count(), false);
  for (const ChainStatistics& chain : storage.chains) total.add(chain);
  return !storage.left_early;
}

/// Called at the end of a round, with the image developed.
bool Renderer::State::wants_another_round() {
  if (!statistics.partial) statistics.rounds = storage.round + 1;
  estimate();
  if (statistics.partial) return false;
  storage.round += 1;
  if (storage.round >= plan.job.max_rounds) return false;
  if (plan.job.target_error > 0.0 && statistics.error.known &&
      statistics.error.rel_mse <= plan.job.target_error)
    return false;
  return plan.job.seconds <= 0.0 || monotonic_seconds() - begin_seconds < plan.job.seconds;
}

struct DevelopContext {
  const RenderStorage& storage;
  const FilmNormalisation& normalisation;
};

/// Moves all films into the first one and develops the image, for one range of pixels.
void develop_unit(void* context, std::uint32_t, std::uint64_t unit) {
  const auto& [storage, normalisation] = *static_cast<const DevelopContext*>(context);
  const std::size_t first = unit * kPixelsPerUnit;
  const std::size_t last = std::min<std::size_t>(first + kPixelsPerUnit, storage.image.size());
  const std::span<FilmPixel> sum = storage.film(0);
  for (std::size_t i = 1; i < storage.film_count(); ++i) {
    const std::span<FilmPixel> film = storage.film(i);
    add_films(sum, film, first, last);
    std::fill(film.begin() + static_cast<std::ptrdiff_t>(first),
              film.begin() + static_cast<std::ptrdiff_t>(last), FilmPixel{});
  }
  if (normalisation.mutations > 0) develop_film(sum, normalisation, storage.image, first, last);
}

void Renderer::State::develop_metropolis(const ChainStatistics& total) {
  LuminanceSum uniform = storage.bootstrap_luminance;
  uniform.add(total.large_steps);
  // The weights' b was rounded to float for the chains; the same number must develop their film.
  normalisation = FilmNormalisation{
      uniform.mean(), static_cast<double>(static_cast<float>(storage.bootstrap_luminance.mean())),
      total.mutations, storage.fraction_bits};
  DevelopContext context{storage, normalisation};
  pool.run(Phase{"develop", &develop_unit, &context, plan.pixel_units(), false}, *stop, nullptr, nullptr);

  const std::uint64_t large_steps = total.large_steps.count;
  statistics.samples = storage.bootstrap_luminance.count + total.mutations;
  statistics.mutations = total.mutations;
  statistics.primary_samples = total.primary_samples;
  statistics.b = uniform.mean();
  statistics.b_standard_error = uniform.standard_error();
  statistics.acceptance_large =
      large_steps == 0 ? 0.0 : total.acceptance_large / static_cast<double>(large_steps);
  statistics.acceptance_small =
      total.small_steps == 0 ? 0.0 : total.acceptance_small / static_cast<double>(total.small_steps);
  statistics.longest_rejection_run = total.longest_rejection_run;
}

void Renderer::State::render_path() {
  const RenderJob& job = plan.job;
  progress_total = sequences_in_film(job.width, job.height) * job.samples_per_pixel * job.max_rounds;
  const std::uint64_t tiles = storage.tiles.size();
  do {
    statistics.partial =
        run_phase("path tracer", plan.kernel.tile, tiles, true) < tiles || storage.left_early;
  } while (wants_another_round());
  collect_path();
}

void Renderer::State::collect_path() {
  TileStatistics total;
  for (const TileStatistics& tile : storage.tiles) total.add(tile);
  add_defects(statistics, total.defects);
  statistics.samples = total.samples;
  statistics.primary_samples = total.primary_samples;
  statistics.b = total.luminance.mean();
  statistics.b_standard_error = total.luminance.standard_error();
  statistics.black = !(total.luminance.sum > 0.0);
}

struct EstimateContext {
  const RenderStorage& storage;
  ImageView image;
  bool is_metropolis;
  double scale;             ///< of pixel_differences
  double b_relative_error;  ///< of a factor common to all pixels
};

PixelDifferences differences_of(const EstimateContext& context, std::size_t pixel) {
  const auto x = static_cast<std::uint32_t>(pixel % context.image.width);
  const auto y = static_cast<std::uint32_t>(pixel / context.image.width);
  PixelDifferences differences =
      context.is_metropolis
          ? pixel_differences(context.storage.films[pixel], context.scale)
          : pixel_differences(context.storage.pixels[pixel], context.scale, sequences_in(x, y));
  for (int c = 0; c < 3; ++c) {
    const double common = static_cast<double>(context.image.pixels[pixel][c]) * context.b_relative_error;
    differences.halves[c] += common * common;
  }
  return differences;
}

void estimate_unit(void* context, std::uint32_t, std::uint64_t unit) {
  const auto& own = *static_cast<const EstimateContext*>(context);
  const std::size_t first = unit * kPixelsPerUnit;
  const std::size_t last = std::min<std::size_t>(first + kPixelsPerUnit, own.image.pixels.size());
  ErrorSums sum;
  for (std::size_t i = first; i < last; ++i) {
    const auto x = static_cast<std::uint32_t>(i % own.image.width);
    const auto y = static_cast<std::uint32_t>(i / own.image.width);
    sum.add(relative_differences(own.image, x, y, differences_of(own, i)));
  }
  own.storage.error_blocks[unit] = sum;
}

EstimateContext Renderer::State::error_context() const {
  EstimateContext context{
      storage, {plan.job.width, plan.job.height, storage.image}, plan.is_metropolis(), 0, 0};
  if (plan.is_metropolis()) {
    context.scale = film_scale(normalisation, storage.image.size()) * normalisation.weight_b;
    if (statistics.b > 0.0) context.b_relative_error = statistics.b_standard_error / statistics.b;
  } else {
    context.scale = 1.0 / static_cast<double>(statistics.rounds * plan.job.samples_per_pixel);
  }
  return context;
}

/// Whether the film is whole and has two halves to compare.
bool Renderer::State::has_parts() const {
  if (statistics.partial) return false;
  return plan.is_metropolis() ? plan.job.chains > 1 && normalisation.mutations > 0
                              : plan.job.samples_per_pixel >= 2;
}

void Renderer::State::estimate() {
  if (!plan.job.estimate_error || !has_parts()) return;
  EstimateContext context = error_context();
  pool.run(Phase{"estimate", &estimate_unit, &context, plan.pixel_units(), false}, *stop, nullptr, nullptr);
  statistics.error = estimate_error(storage.error_blocks, plan.pixel_count());
}

Renderer::Renderer(const SceneDescription& scene, const RenderJob& job)
    : state_(std::make_unique<State>(scene, job)) {}

Renderer::Renderer(Renderer& host, const RenderJob& job)
    : state_(std::make_unique<State>(host.state_->scene, job, host.state_.get())) {
  MLT_CHECK(host.state_->arena != nullptr && !host.state_->is_guest());
  MLT_CHECK(host.state_->plan.job.instruction_set == job.instruction_set);
}

Renderer::~Renderer() = default;

const MemoryPlan& Renderer::memory_plan() const {
  return state_->plan.memory;
}

std::vector<InfoLine> Renderer::info() const {
  const JobPlan& plan = state_->plan;
  std::vector<InfoLine> lines =
      describe_scene(state_->scene, state_->counts, plan.job, plan.features, plan.sample_capacity);
  if (plan.is_metropolis()) lines.push_back({"films", plan.describe_films()});
  return lines;
}

FeatureMask Renderer::features() const {
  return state_->plan.features;
}

void Renderer::State::compile() {
  if (!is_guest()) {
    prefault_process(code_of_other_sets(plan.job.instruction_set));
    pool.start(arena->take(plan.slots.stacks), arena->take(plan.slots.threads));
    world = kernel_set(plan.job.instruction_set)
                .compile_world(scene, counts, plan.job.width, plan.job.height, *arena, plan.slots.world,
                               pool.runner());
  } else {
    world = home.world;
    world.camera = home.world.camera.resized(plan.job.width, plan.job.height);
  }
  storage.world = &world;
}

void Renderer::State::take_storage() {
  plan.take_storage(*arena, storage);
  home.tenant = this;
}

void Renderer::prepare() {
  State& state = *state_;
  MLT_CHECK(state.arena == nullptr);
  state.arena = std::make_unique<Arena>(state.plan.memory, state.home.arena.get());
  state.compile();
  state.take_storage();
}

void Renderer::restart(std::uint64_t seed, std::uint32_t roulette) {
  State& state = *state_;
  MLT_CHECK(state.arena != nullptr && (roulette == 0) == (state.plan.job.roulette == 0));
  state.plan.job.seed = seed;
  state.plan.job.roulette = roulette;
  state.take_storage();
  state.storage.bootstrap_luminance = {};
  state.storage.round = 0;
  state.storage.left_early = false;
  state.storage.done = 0;
  state.statistics = {};
  state.normalisation = {};
}

RenderStatistics Renderer::run(const std::atomic<bool>& stop, ProgressCallback progress, void* context) {
  State& state = *state_;
  MLT_CHECK(state.has_film());
  state.stop = &stop;
  state.storage.stop = &stop;
  state.progress = progress;
  state.progress_context = context;
  prefault_stack(std::size_t{64} << 10);

  const ProcessUsage begin = ProcessUsage::now();
  state.begin_seconds = begin.wall;
  enter_render_zone();
  if (state.counts.lights == 0) {
    state.statistics.black = true;
  } else if (state.plan.is_metropolis()) {
    state.render_metropolis();
  } else {
    state.render_path();
  }
  leave_render_zone();
  const ProcessUsage end = ProcessUsage::now();

  state.statistics.wall_seconds = end.wall - begin.wall;
  state.statistics.cpu_seconds = end.cpu - begin.cpu;
  state.statistics.minor_faults = end.minor_faults - begin.minor_faults;
  if (state.plan.job.hash_film) {
    state.statistics.film_hash =
        state.plan.is_metropolis()
            ? hash_metropolis_film(state.storage, state.normalisation)
            : hash_path_film(state.storage, std::max<std::uint64_t>(state.statistics.rounds, 1));
  }
  return state.statistics;
}

ImageView Renderer::image() const {
  MLT_CHECK(state_->has_film());
  return {state_->plan.job.width, state_->plan.job.height, state_->storage.image};
}

ImageBuffer Renderer::standard_errors() const {
  const State& state = *state_;
  const RenderJob& job = state.plan.job;
  std::vector<PixelDifferences> differences(state.plan.pixel_count());
  if (state.statistics.error.known) {
    const EstimateContext context = state.error_context();
    for (std::size_t i = 0; i < differences.size(); ++i) differences[i] = differences_of(context, i);
  }
  return {job.width, job.height,
          smooth_standard_errors(differences, state.statistics.error.factor, job.width, job.height)};
}

Vec3 Renderer::variance(std::size_t index) const {
  const State& state = *state_;
  MLT_CHECK(state.has_film());
  const bool is_known = state.plan.is_metropolis() ? state.has_parts() : state.statistics.error.known;
  const PixelDifferences pixel = is_known ? differences_of(state.error_context(), index) : PixelDifferences{};
  const auto channel = [&](int c) {
    return static_cast<float>(state.statistics.error.factor * pixel.halves[c]);
  };
  return Vec3{channel(0), channel(1), channel(2)};
}

}  // namespace mlt
