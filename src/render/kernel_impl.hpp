// The kernels' bodies, instantiated by kernel_*.cpp; each of these compiles a share of the feature masks.
#pragma once

#include "integrator/pixel_sampler.hpp"
#include "render/kernel.hpp"

namespace mlt {

template <FeatureMask kFeatures>
void run_bootstrap_chunk(void* context, std::uint32_t worker, std::uint64_t chunk) {
  auto& storage = *static_cast<RenderStorage*>(context);
  const PathIntegrator<kFeatures> integrator(*storage.world, storage.path);
  WorkerStorage& own = storage.workers[worker];
  Contribution contribution(own.chain.proposed);
  storage.bootstrap[chunk] = evaluate_bootstrap_chunk(
      integrator, storage.job.seed, chunk, storage.job.bootstrap, contribution, own.bootstrap_defects);
  storage.done.fetch_add(bootstrap_chunk_size(storage.job.bootstrap, chunk), std::memory_order_relaxed);
}

inline FillSteps fill_steps_of(MutationKind kind) {
  switch (kind) {
#define MLT_CASE(name, help) \
  case MutationKind::name:   \
    return &Mutation<MutationKind::name>::fill<BlockRng>;
    MLT_MUTATION_KINDS(MLT_CASE)
#undef MLT_CASE
  }
  return nullptr;
}

template <FeatureMask kFeatures>
SeedPath find_start(const PathIntegrator<kFeatures>& integrator, const RenderStorage& storage,
                    const WorkerStorage& own, std::uint64_t chain) {
  // The first path that carries light lies where the cumulative luminance is still 0.
  const double position = storage.job.start == StartKind::first_hit
                              ? 0.0
                              : seed_position(storage.job.seed, storage.round, chain, storage.job.chains,
                                              storage.bootstrap_moments.sum);
  Contribution contribution(own.chain.proposed);
  return find_seed_path(integrator, storage.job.seed, storage.job.bootstrap, storage.bootstrap, position,
                        contribution);
}

template <FeatureMask kFeatures>
void run_chain(void* context, std::uint32_t worker, std::uint64_t index) {
  auto& storage = *static_cast<RenderStorage*>(context);
  const WorkerStorage& own = storage.workers[worker];
  const PathIntegrator<kFeatures> integrator(*storage.world, storage.path);
  const SeedPath start = find_start(integrator, storage, own, index);
  FixedFilm film(own.film, storage.fraction_bits, half_of(index, storage.job.chains), own.film_writers);
  ChainSettings settings;
  settings.seed = storage.job.seed;
  settings.chain_index = storage.round * storage.job.chains + index;
  settings.mutations = chain_length(storage.mutations, storage.job.chains, index);
  settings.large_step = storage.job.large_step;
  settings.weight_b = static_cast<float>(storage.bootstrap_moments.mean());
  settings.fill_steps = fill_steps_of(storage.job.mutation);
  settings.step_size = storage.job.step_size;
  Chain<PathIntegrator<kFeatures>, FixedFilm> chain(integrator, settings, own.chain, film);
  storage.chains[index] = chain.run(start);
  storage.done.fetch_add(settings.mutations, std::memory_order_relaxed);
}

/// All samples of one pixel, in order.
template <FeatureMask kFeatures>
void render_pixel(const PathIntegrator<kFeatures>& integrator, const RenderStorage& storage,
                  PixelSampler& sampler, std::uint32_t x, std::uint32_t y, TileStatistics& statistics) {
  const std::uint32_t pixel = y * storage.job.width + x;
  PixelSum& sum = storage.pixels[pixel];
  ReplayContext& context = replay_context();
  const std::uint64_t count = storage.job.samples_per_pixel;
  const std::uint32_t sequences = sequences_in(x, y);
  for (std::uint32_t sequence = 0; sequence < sequences; ++sequence) {
    for (std::uint64_t i = 0; i < count; ++i) {
      context.step = sequence * count + i;
      sampler.start(x, y, static_cast<std::uint32_t>(i), 2 * storage.round + sequence);
      integrator.evaluate(sampler, [&](const Splat& splat) {
        MLT_CHECK_OP(splat.pixel, ==, pixel);
        const bool rejected = statistics.defects.reject(splat.value);
        if (!rejected) sum.add(splat.value, half_of_sequence(i, count), sequence == 0 ? 1 : -1);
        // The mean over the image weighs pixels alike, so the second sequence stays out of it.
        if (sequence == 0) statistics.luminance.add(rejected ? 0.0 : luminance(splat.value));
      });
      statistics.primary_samples += sampler.dimension();
    }
  }
  statistics.samples += sequences * count;
  storage.image[pixel] = develop_pixel(sum, (storage.round + 1) * sequences * count);
}

template <FeatureMask kFeatures>
void run_tile(void* context, std::uint32_t, std::uint64_t tile) {
  auto& storage = *static_cast<RenderStorage*>(context);
  const RenderJob& job = storage.job;
  const PathIntegrator<kFeatures> integrator(*storage.world, storage.path);
  PixelSampler sampler(job.seed, job.width, job.height, job.samples_per_pixel);
  const std::uint32_t tiles_across = tile_count(job.width);
  const std::uint32_t first_x = static_cast<std::uint32_t>(tile % tiles_across) * kTileSide;
  const std::uint32_t first_y = static_cast<std::uint32_t>(tile / tiles_across) * kTileSide;
  const std::uint32_t last_x = first_x + kTileSide < job.width ? first_x + kTileSide : job.width;
  const std::uint32_t last_y = first_y + kTileSide < job.height ? first_y + kTileSide : job.height;
  replay_context().seed = job.seed;
  replay_context().unit = tile;
  TileStatistics statistics;
  for (std::uint32_t y = first_y; y < last_y; ++y) {
    for (std::uint32_t x = first_x; x < last_x; ++x) {
      if (storage.stop->load(std::memory_order_relaxed)) {
        storage.left_early.store(true, std::memory_order_relaxed);
        break;
      }
      render_pixel(integrator, storage, sampler, x, y, statistics);
    }
  }
  storage.tiles[tile].add(statistics);
  storage.done.fetch_add(statistics.samples, std::memory_order_relaxed);
}

template <FeatureMask kFeatures>
Kernel make_kernel() {
  using Integrator = PathIntegrator<kFeatures>;
  Kernel kernel;
  kernel.primary_sample_capacity = &Integrator::primary_sample_capacity;
  kernel.max_splats = Integrator::kMaxSplats;
  kernel.bootstrap_chunk = &run_bootstrap_chunk<kFeatures>;
  kernel.tile = &run_tile<kFeatures>;
  kernel.chain = &run_chain<kFeatures>;
  return kernel;
}

inline constexpr FeatureMask kKernelGroups = 4;
inline constexpr FeatureMask kMasksPerGroup = kFeatureMaskCount / kKernelGroups;

/// The kernel of `features` from the masks of one group; the mask must lie in it and be consistent.
template <FeatureMask kGroup, FeatureMask kIndex = 0>
Kernel kernel_of_group(FeatureMask features) {
  constexpr FeatureMask kMask = kGroup * kMasksPerGroup + kIndex;
  if constexpr (is_consistent(kMask)) {
    if (features == kMask) return make_kernel<kMask>();
  }
  if constexpr (kIndex + 1 < kMasksPerGroup) {
    return kernel_of_group<kGroup, kIndex + 1>(features);
  } else {
    MLT_CHECK_OP(features, ==, kMask);
    return {};
  }
}

}  // namespace mlt
