#include "job_plan.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <string>

#include "base/error.hpp"
#include "render/kernel_set.hpp"
#include "render/scene_info.hpp"

namespace mlt {
namespace {

/// A smaller job that fits the limit: fewer threads first, then a smaller film as well.
std::string what_would_fit(const WorldCounts& counts, RenderJob job) {
  while (job.threads > 1) {
    job.threads = (job.threads + 1) / 2;
    const JobPlan smaller(counts, job);
    if (smaller.memory.total_bytes() <= job.memory_limit) {
      return fmt::format("; --threads {} would fit with {} bytes", job.threads, smaller.memory.total_bytes());
    }
  }
  std::size_t least = 0;
  while (job.width > 1 || job.height > 1) {
    job.width = std::max(1U, job.width / 2);
    job.height = std::max(1U, job.height / 2);
    least = JobPlan(counts, job).memory.total_bytes();
    if (least <= job.memory_limit) {
      return fmt::format("; --width {} --height {} --threads 1 would fit with {} bytes", job.width,
                         job.height, least);
    }
  }
  least = JobPlan(counts, job).memory.total_bytes();
  return fmt::format("; even a film of one pixel and one thread would need {} bytes", least);
}

/// Items that a worker's share takes of a block: its own, then so many that no two workers write to one page.
template <class T>
std::size_t own_stride(std::size_t items) {
  constexpr std::size_t kUnit = kPage / sizeof(T);
  static_assert(kUnit * sizeof(T) == kPage);
  return (items + kUnit - 1) / kUnit * kUnit;
}

}  // namespace

JobPlan::JobPlan(const WorldCounts& counts, const RenderJob& render_job, const JobPlan* host)
    : job(render_job),
      features(find_features(counts, render_job)),
      kernel(kernel_set(render_job.instruction_set).select_kernel(features)),
      sample_capacity(kernel.primary_sample_capacity(render_job.depth)),
      group_size(std::clamp((job.chains + job.threads - 1) / job.threads, 1U, kernel.lanes)) {
  const std::uint64_t units =
      is_metropolis() ? chain_groups() : std::uint64_t{tile_count(job.width)} * tile_count(job.height);
  workers = host != nullptr ? host->workers
                            : static_cast<std::uint32_t>(std::min<std::uint64_t>(job.threads, units));
  if (host == nullptr) slots.world = kernel_set(job.instruction_set).plan_world(memory, counts);
  slots.image = memory.add<Vec3>("image", Lifetime::kScene, pixel_count());
  slots.error_blocks = memory.add<ErrorSums>("error estimate", Lifetime::kScene, pixel_units());
  if (host == nullptr) slots.threads = memory.add<pthread_t>("threads", Lifetime::kScene, workers);
  slots.workers = memory.add<WorkerStorage>("workers", Lifetime::kScene, workers);
  if (host == nullptr) slots.stacks = memory.add<WorkerStack>("thread stacks", Lifetime::kScene, workers);
  if (is_metropolis()) {
    plan_metropolis();
  } else {
    plan_path();
  }
}

/// As many as workers, who have one each in the bootstrap. More workers than one find work on up to twice as
/// many when they come to a bench whose turn has not ended; all benches have equally many groups, or one
/// less.
std::uint32_t JobPlan::count_benches() const {
  const std::uint64_t groups = chain_groups();
  const std::uint64_t most = workers == 1 ? 1 : 2 * workers;
  const std::uint64_t groups_each = (groups + most - 1) / most;
  return std::max(workers, static_cast<std::uint32_t>((groups + groups_each - 1) / groups_each));
}

void JobPlan::plan_metropolis() {
  benches = count_benches();
  slots.bootstrap =
      memory.add<BootstrapChunk>("bootstrap sums", Lifetime::kRender, bootstrap_chunk_count(job.bootstrap));
  slots.chains = memory.add<ChainStatistics>("chain statistics", Lifetime::kRender, job.chains);
  slots.benches = memory.add<ChainBench>("benches", Lifetime::kRender, benches);
  slots.samples = memory.add<std::byte>("primary samples", Lifetime::kRender,
                                        benches * own_stride<std::byte>(sample_bytes()));
  slots.saved = memory.add<std::byte>("saved primary samples", Lifetime::kRender,
                                      benches * own_stride<std::byte>(saved_bytes()));
  slots.splats = memory.add<Splat>("splats, two states", Lifetime::kRender,
                                   benches * own_stride<Splat>(2 * group_splats()));
  slots.groups = memory.add<std::byte>("groups of chains", Lifetime::kRender,
                                       benches * own_stride<std::byte>(kernel.group_bytes));
  const std::uint32_t wanted = films_for_all() <= job.film_memory ? workers : 1;
  films = static_cast<std::uint32_t>(std::clamp<std::size_t>(room_for_films() / film_bytes(), 1, wanted));
  slots.films = memory.add<FilmPixel>("films", Lifetime::kRender, films * pixel_count());
}

/// What --memory leaves to films, once all other blocks are planned.
std::size_t JobPlan::room_for_films() const {
  const std::size_t taken = memory.bytes(Lifetime::kScene) + memory.bytes(Lifetime::kRender);
  return job.memory_limit < taken ? 0 : (job.memory_limit - taken) / kPage * kPage;
}

std::string JobPlan::describe_films() const {
  if (films == workers) return fmt::format("{}, one for each worker", films);
  const bool limited_by_memory = films_for_all() <= job.film_memory;
  return fmt::format("{}, shared by {} workers with atomic adds; {}", films, workers,
                     limited_by_memory ? std::string("--memory leaves no room for more")
                                       : fmt::format("one for each would exceed {} bytes", job.film_memory));
}

void JobPlan::plan_path() {
  slots.pixels = memory.add<PixelSum>("film", Lifetime::kRender, pixel_count());
  slots.tiles = memory.add<TileStatistics>("tile statistics", Lifetime::kRender,
                                           std::size_t{tile_count(job.width)} * tile_count(job.height));
}

void JobPlan::require_within_limit(const WorldCounts& counts) const {
  if (memory.total_bytes() <= job.memory_limit) return;
  throw ResourceError(fmt::format("--memory: the job needs {} bytes and {} are allowed{}",
                                  memory.total_bytes(), job.memory_limit, what_would_fit(counts, job)));
}

void JobPlan::take_storage(Arena& arena, RenderStorage& storage) const {
  storage.job = job;
  storage.path = PathSettings{job.depth, job.roulette};
  storage.image = arena.take(slots.image);
  storage.error_blocks = arena.take(slots.error_blocks);
  storage.workers = arena.take(slots.workers);
  if (is_metropolis()) {
    take_metropolis_storage(arena, storage);
  } else {
    storage.pixels = arena.take(slots.pixels);
    storage.tiles = arena.take(slots.tiles);
  }
}

void JobPlan::take_metropolis_storage(Arena& arena, RenderStorage& storage) const {
  storage.mutations = job.mutations;
  storage.chain_group_size = group_size;
  // Jobs that differ in the number of rounds alone give the same film as long as both run.
  storage.fraction_bits = job.in_rounds ? kMinFractionBits : film_fraction_bits(storage.mutations);
  storage.bootstrap = arena.take(slots.bootstrap);
  storage.chains = arena.take(slots.chains);
  const std::span<std::byte> samples = arena.take(slots.samples);
  const std::span<std::byte> saved = arena.take(slots.saved);
  const std::span<Splat> splats = arena.take(slots.splats);
  const std::span<std::byte> groups = arena.take(slots.groups);
  storage.benches = arena.take(slots.benches);
  for (std::size_t i = 0; i < benches; ++i) {
    ChainBench& bench = storage.benches[i];
    bench.samples = samples.subspan(i * own_stride<std::byte>(sample_bytes()), sample_bytes());
    bench.saved = saved.subspan(i * own_stride<std::byte>(saved_bytes()), saved_bytes());
    const std::size_t first_splat = i * own_stride<Splat>(2 * group_splats());
    bench.current = splats.subspan(first_splat, group_splats());
    bench.proposed = splats.subspan(first_splat + group_splats(), group_splats());
    bench.group = groups.subspan(i * own_stride<std::byte>(kernel.group_bytes), kernel.group_bytes);
  }
  storage.films = arena.take(slots.films);
  for (std::size_t i = 0; i < workers; ++i) {
    WorkerStorage& own = storage.workers[i];
    const std::size_t film = i % films;
    own.film = storage.film(film);
    own.film_writers = film + films < workers ? FilmWriters::several : FilmWriters::one;
  }
}

}  // namespace mlt
