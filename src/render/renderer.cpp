#include "render/renderer.hpp"

#include <sys/resource.h>
#include <time.h>

#include <algorithm>

#include "base/render_zone.hpp"
#include "render/film_hash.hpp"
#include "render/kernel.hpp"
#include "render/scene_info.hpp"
#include "render/worker_pool.hpp"
#include "world/world.hpp"

namespace mlt {
namespace {

constexpr std::uint64_t kPixelsPerSumUnit = 4096;

std::uint64_t divide_up(std::uint64_t value, std::uint64_t unit) { return (value + unit - 1) / unit; }

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

double monotonic_seconds() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void add_defects(RenderStatistics& statistics, const DefectCounts& defects) {
  statistics.rejected_nan += defects.nan;
  statistics.rejected_infinite += defects.infinite;
  statistics.rejected_negative += defects.negative;
}

/// What the process had used of processor time and faults at one moment, over all threads.
struct Usage {
  double wall = monotonic_seconds();
  double cpu = 0;
  std::uint64_t minor_faults = 0;

  static Usage now() {
    Usage usage;
    rusage own{};
    ::getrusage(RUSAGE_SELF, &own);
    usage.cpu = seconds_of(own.ru_utime) + seconds_of(own.ru_stime);
    usage.minor_faults = static_cast<std::uint64_t>(own.ru_minflt);
    return usage;
  }
};

/// Names of the plan's blocks, resolved once the arena exists.
struct RenderSlots {
  WorldSlots world;
  Slot<WorkerStack> stacks;
  Slot<pthread_t> threads;
  Slot<WorkerStorage> workers;
  Slot<PrimarySample> samples;
  Slot<SavedSample> saved;
  Slot<Splat> splats;
  Slot<FilmPixel> films;
  Slot<BootstrapChunk> bootstrap;
  Slot<ChainStatistics> chains;
  Slot<PixelSum> pixels;
  Slot<TileStatistics> tiles;
  Slot<Vec3> image;
};

}  // namespace

struct Renderer::State {
  State(const SceneDescription& description, const RenderJob& render_job);

  void plan_metropolis();
  void plan_path();
  void take_storage();
  std::uint64_t pixel_count() const { return std::uint64_t{job.width} * job.height; }
  bool is_metropolis() const { return job.integrator == IntegratorKind::pssmlt; }

  std::uint64_t run_phase(const char* stage, UnitFunction function, std::uint64_t units, bool stoppable);
  void render_metropolis();
  void render_path();
  void develop_metropolis(std::uint64_t finished_chains);
  void collect_path();
  static void report_progress(void* state);

  const SceneDescription& scene;
  RenderJob job;
  WorldCounts counts;
  FeatureMask features;
  Kernel kernel;
  std::uint32_t workers;            ///< threads that can have work at all
  std::uint32_t sample_capacity;
  MemoryPlan plan;
  RenderSlots slots;

  std::unique_ptr<Arena> arena;
  World world;
  RenderStorage storage;
  WorkerPool pool;

  // One run
  const std::atomic<bool>* stop = nullptr;
  ProgressCallback progress = nullptr;
  void* progress_context = nullptr;
  double begin_seconds = 0;
  std::uint64_t progress_total = 0;
  RenderStatistics statistics;
  FilmNormalisation normalisation;
};

Renderer::State::State(const SceneDescription& description, const RenderJob& render_job)
    : scene(description),
      job(render_job),
      counts(count_world(description)),
      features(find_features(counts, job)),
      kernel(select_kernel(features, job.mutation)),
      sample_capacity(kernel.primary_sample_capacity(job.depth)) {
  const std::uint64_t units = is_metropolis()
                                  ? std::uint64_t{job.chains}
                                  : std::uint64_t{tile_count(job.width)} * tile_count(job.height);
  workers = static_cast<std::uint32_t>(std::min<std::uint64_t>(job.threads, units));
  slots.world = plan_world(plan, counts);
  slots.image = plan.add<Vec3>("image", Lifetime::kScene, pixel_count());
  slots.threads = plan.add<pthread_t>("threads", Lifetime::kScene, workers);
  slots.workers = plan.add<WorkerStorage>("workers", Lifetime::kScene, workers);
  if (is_metropolis()) {
    plan_metropolis();
  } else {
    plan_path();
  }
  slots.stacks = plan.add<WorkerStack>("thread stacks", Lifetime::kRender, workers);
  plan.require_within(job.memory_limit);
}

void Renderer::State::plan_metropolis() {
  slots.bootstrap = plan.add<BootstrapChunk>("bootstrap sums", Lifetime::kRender,
                                             bootstrap_chunk_count(job.bootstrap));
  slots.chains = plan.add<ChainStatistics>("chain statistics", Lifetime::kRender, job.chains);
  slots.samples = plan.add<PrimarySample>("primary samples", Lifetime::kRender,
                                          std::size_t{workers} * sample_capacity);
  slots.saved = plan.add<SavedSample>("saved primary samples", Lifetime::kRender,
                                      std::size_t{workers} * sample_capacity);
  slots.splats =
      plan.add<Splat>("splats, two states", Lifetime::kRender, std::size_t{workers} * 2 * kernel.max_splats);
  slots.films = plan.add<FilmPixel>("films, one a worker", Lifetime::kRender, workers * pixel_count());
}

void Renderer::State::plan_path() {
  slots.pixels = plan.add<PixelSum>("film", Lifetime::kRender, pixel_count());
  slots.tiles = plan.add<TileStatistics>("tile statistics", Lifetime::kRender,
                                         std::size_t{tile_count(job.width)} * tile_count(job.height));
}

void Renderer::State::take_storage() {
  storage.world = &world;
  storage.job = job;
  storage.path = PathSettings{job.depth, job.roulette};
  storage.image = arena->take(slots.image);
  storage.workers = arena->take(slots.workers);
  if (!is_metropolis()) {
    storage.pixels = arena->take(slots.pixels);
    storage.tiles = arena->take(slots.tiles);
    return;
  }
  storage.mutations = pixel_count() * job.samples_per_pixel;
  storage.fraction_bits = film_fraction_bits(storage.mutations);
  storage.bootstrap = arena->take(slots.bootstrap);
  storage.chains = arena->take(slots.chains);
  const std::span<PrimarySample> samples = arena->take(slots.samples);
  const std::span<SavedSample> saved = arena->take(slots.saved);
  const std::span<Splat> splats = arena->take(slots.splats);
  const std::span<FilmPixel> films = arena->take(slots.films);
  for (std::uint32_t i = 0; i < workers; ++i) {
    WorkerStorage& own = storage.workers[i];
    own.chain.samples = samples.subspan(std::size_t{i} * sample_capacity, sample_capacity);
    own.chain.saved = saved.subspan(std::size_t{i} * sample_capacity, sample_capacity);
    own.chain.current = splats.subspan(std::size_t{i} * 2 * kernel.max_splats, kernel.max_splats);
    own.chain.proposed =
        splats.subspan((std::size_t{i} * 2 + 1) * kernel.max_splats, kernel.max_splats);
    own.film = films.subspan(i * pixel_count(), pixel_count());
  }
}

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
  progress_total = storage.mutations;
  const std::uint64_t chunks = storage.bootstrap.size();
  const std::uint64_t chunks_run = run_phase("bootstrap", kernel.bootstrap_chunk, chunks, true);
  statistics.partial = chunks_run < chunks;
  storage.bootstrap_moments = accumulate_bootstrap(
      storage.bootstrap, std::min(chunks_run * kBootstrapChunk, job.bootstrap));
  for (const BootstrapChunk& chunk : storage.bootstrap) add_defects(statistics, chunk.defects);

  std::uint64_t finished_chains = 0;
  statistics.black = !(storage.bootstrap_moments.sum > 0.0);
  if (!statistics.partial && !statistics.black) {
    finished_chains = run_phase("chain", kernel.chain, job.chains, true);
    statistics.partial = finished_chains < job.chains;
  }
  develop_metropolis(finished_chains);
}

struct DevelopContext {
  const RenderStorage& storage;
  const FilmNormalisation& normalisation;
};

/// Sums the workers' films and develops the image, for one range of pixels.
void develop_unit(void* context, std::uint32_t, std::uint64_t unit) {
  const auto& [storage, normalisation] = *static_cast<const DevelopContext*>(context);
  const std::size_t first = unit * kPixelsPerSumUnit;
  const std::size_t last = std::min<std::size_t>(first + kPixelsPerSumUnit, storage.image.size());
  const std::span<FilmPixel> sum = storage.workers[0].film;
  for (std::size_t i = 1; i < storage.workers.size(); ++i) {
    add_films(sum, storage.workers[i].film, first, last);
  }
  if (normalisation.mutations > 0) develop_film(sum, normalisation, storage.image, first, last);
}

void Renderer::State::develop_metropolis(std::uint64_t finished_chains) {
  ChainStatistics total;
  for (std::uint64_t i = 0; i < finished_chains; ++i) total.add(storage.chains[i]);
  LuminanceMoments moments = storage.bootstrap_moments;
  moments.add(total.large_steps);
  // The weights' b was rounded to float for the chains; the same number must develop their film.
  normalisation = FilmNormalisation{
      moments.mean(), static_cast<double>(static_cast<float>(storage.bootstrap_moments.mean())),
      total.mutations, storage.fraction_bits};
  DevelopContext context{storage, normalisation};
  pool.run(Phase{"develop", &develop_unit, &context, divide_up(pixel_count(), kPixelsPerSumUnit), false}, *stop,
           nullptr, nullptr);

  const std::uint64_t large_steps = total.large_steps.count;
  statistics.samples = storage.bootstrap_moments.count + total.mutations;
  statistics.mutations = total.mutations;
  statistics.b = moments.mean();
  statistics.b_standard_error = moments.standard_error();
  statistics.acceptance_large =
      large_steps == 0 ? 0.0 : total.acceptance_large / static_cast<double>(large_steps);
  statistics.acceptance_small =
      total.small_steps == 0 ? 0.0 : total.acceptance_small / static_cast<double>(total.small_steps);
  statistics.longest_rejection_run = total.longest_rejection_run;
  add_defects(statistics, total.defects);
}

void Renderer::State::render_path() {
  progress_total = pixel_count() * job.samples_per_pixel;
  const std::uint64_t tiles = storage.tiles.size();
  statistics.partial = run_phase("path tracer", kernel.tile, tiles, true) < tiles;
  collect_path();
}

void Renderer::State::collect_path() {
  LuminanceMoments moments;
  for (const TileStatistics& tile : storage.tiles) {
    moments.add(tile.luminance);
    add_defects(statistics, tile.defects);
  }
  statistics.samples = moments.count;
  statistics.b = moments.mean();
  statistics.b_standard_error = moments.standard_error();
  statistics.black = !(moments.sum > 0.0);
}

Renderer::Renderer(const SceneDescription& scene, const RenderJob& job)
    : state_(std::make_unique<State>(scene, job)) {}

Renderer::~Renderer() = default;

const MemoryPlan& Renderer::memory_plan() const { return state_->plan; }

std::vector<InfoLine> Renderer::info() const {
  return describe_scene(state_->scene, state_->counts, state_->job, state_->features, state_->sample_capacity);
}

void Renderer::prepare() {
  State& state = *state_;
  state.arena = std::make_unique<Arena>(state.plan);
  state.world = compile_world(state.scene, state.counts, state.job.width, state.job.height, *state.arena,
                              state.slots.world);
  state.take_storage();
  prefault_process();
  state.pool.start(state.arena->take(state.slots.stacks), state.arena->take(state.slots.threads));
}

RenderStatistics Renderer::run(const std::atomic<bool>& stop, ProgressCallback progress, void* context) {
  State& state = *state_;
  MLT_CHECK(state.arena != nullptr);
  state.stop = &stop;
  state.progress = progress;
  state.progress_context = context;
  prefault_stack(std::size_t{64} << 10);

  const Usage begin = Usage::now();
  state.begin_seconds = begin.wall;
  enter_render_zone();
  if (state.counts.lights == 0) {
    state.statistics.black = true;
  } else if (state.is_metropolis()) {
    state.render_metropolis();
  } else {
    state.render_path();
  }
  leave_render_zone();
  const Usage end = Usage::now();

  state.statistics.wall_seconds = end.wall - begin.wall;
  state.statistics.cpu_seconds = end.cpu - begin.cpu;
  state.statistics.minor_faults = end.minor_faults - begin.minor_faults;
  state.statistics.film_hash = state.is_metropolis()
                                   ? hash_metropolis_film(state.storage, state.normalisation)
                                   : hash_path_film(state.storage);
  return state.statistics;
}

ImageView Renderer::image() const {
  return {state_->job.width, state_->job.height, state_->storage.image};
}

}  // namespace mlt
