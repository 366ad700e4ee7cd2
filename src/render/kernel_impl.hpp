// The kernels' bodies, instantiated by kernel_*.cpp; each of these compiles a share of the feature masks.
#pragma once

#include "chain_kernel.hpp"
#include "integrator/path_batch.hpp"
#include "integrator/pixel_sampler.hpp"
#include "render/kernel.hpp"

namespace mlt {

/// One sample's path, which used so many primary samples.
inline void add_sample(const RenderStorage& storage, const PixelSample& sample, const Splat& splat,
                       std::uint32_t dimension, TileStatistics& statistics) {
  MLT_CHECK_OP(splat.pixel, ==, sample.y * storage.job.width + sample.x);
  const bool rejected = statistics.defects.reject(splat.value);
  const int half = half_of_sequence(sample.index, storage.job.samples_per_pixel);
  const bool is_first = sample.sequence == 2 * storage.round;
  if (!rejected) storage.pixels[splat.pixel].add(splat.value, half, is_first ? 1 : -1);
  // The mean over the image weighs pixels alike, so the second sequence stays out of it.
  if (is_first) statistics.luminance.add(rejected ? 0.0 : luminance(splat.value));
  statistics.primary_samples += dimension;
  statistics.samples += 1;
}

struct TileBounds {
  std::uint32_t first_x, first_y, last_x, last_y;

  /// Calls visit(x, y) -> bool for the tile's pixels in order until it returns false; how many returned true.
  template <class Visit>
  std::uint32_t for_pixels(Visit&& visit) const {
    std::uint32_t visited = 0;
    for (std::uint32_t y = first_y; y < last_y; ++y) {
      for (std::uint32_t x = first_x; x < last_x; ++x) {
        if (!visit(x, y)) return visited;
        ++visited;
      }
    }
    return visited;
  }
};

/// The tile's samples, pixel after pixel, in blocks that begin and end anywhere. Returns the number of pixels
/// rendered before the stop.
template <FeatureMask kFeatures>
std::uint32_t render_pixels(const RenderStorage& storage, const TileBounds& tile,
                            TileStatistics& statistics) {
  const RenderJob& job = storage.job;
  const WideIntegrator<kFeatures> integrator(*storage.world, storage.path);
  PathBatch<WideIntegrator<kFeatures>> batch(integrator);
  PixelSamplerOf<WideFloat> sampler(job.seed, job.width, job.height, job.samples_per_pixel);
  const auto flush = [&] {
    replay_context().step = statistics.samples;
    batch.evaluate(sampler, [&](const PixelSample& sample, const Splat& splat, std::uint32_t dimension) {
      add_sample(storage, sample, splat, dimension, statistics);
    });
    sampler.clear();
  };
  const std::uint32_t rendered = tile.for_pixels([&](std::uint32_t x, std::uint32_t y) {
    if (storage.stop->load(std::memory_order_relaxed)) return false;
    for (std::uint32_t sequence = 0; sequence < sequences_in(x, y); ++sequence) {
      PixelSample next{x, y, 2 * storage.round + sequence, 0};
      while (next.index < job.samples_per_pixel) {
        next.index += sampler.place(next, job.samples_per_pixel - next.index);
        if (sampler.count() == sampler.kBlock) flush();
      }
    }
    return true;
  });
  if (sampler.count() > 0) flush();
  return rendered;
}

template <FeatureMask kFeatures>
void run_tile(void* context, std::uint32_t, std::uint64_t tile) {
  auto& storage = *static_cast<RenderStorage*>(context);
  const RenderJob& job = storage.job;
  const std::uint32_t tiles_across = tile_count(job.width);
  const std::uint32_t first_x = static_cast<std::uint32_t>(tile % tiles_across) * kTileSide;
  const std::uint32_t first_y = static_cast<std::uint32_t>(tile / tiles_across) * kTileSide;
  const TileBounds bounds{first_x, first_y, first_x + kTileSide < job.width ? first_x + kTileSide : job.width,
                          first_y + kTileSide < job.height ? first_y + kTileSide : job.height};
  replay_context().seed = job.seed;
  replay_context().unit = tile;
  TileStatistics statistics;
  std::uint32_t rendered = render_pixels<kFeatures>(storage, bounds, statistics);
  const std::uint32_t pixels = bounds.for_pixels([&](std::uint32_t x, std::uint32_t y) {
    if (rendered == 0) return false;
    --rendered;
    const std::uint32_t pixel = y * job.width + x;
    const std::uint64_t samples = sequences_in(x, y) * job.samples_per_pixel;
    storage.image[pixel] = develop_pixel(storage.pixels[pixel], (storage.round + 1) * samples);
    return true;
  });
  if (pixels < (bounds.last_x - bounds.first_x) * (bounds.last_y - bounds.first_y))
    storage.left_early.store(true, std::memory_order_relaxed);
  storage.tiles[tile].add(statistics);
  storage.done.fetch_add(statistics.samples, std::memory_order_relaxed);
}

template <FeatureMask kFeatures>
Kernel make_kernel() {
  using Integrator = WideIntegrator<kFeatures>;
  Kernel kernel;
  kernel.primary_sample_capacity = &Integrator::primary_sample_capacity;
  kernel.max_splats = Integrator::kMaxSplats;
  kernel.bootstrap_chunk = &run_bootstrap_chunk<kFeatures>;
  kernel.tile = &run_tile<kFeatures>;
  kernel.chain_turn = &run_chain_turn<kFeatures>;
  kernel.lanes = kWideLanes;
  kernel.sample_bytes = sizeof(PrimarySampleOf<WideFloat>);
  kernel.saved_bytes = sizeof(ProposedSampleOf<WideFloat>);
  kernel.group_bytes = sizeof(RunningGroup<kFeatures>);
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
