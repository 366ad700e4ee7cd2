// The memory plan of a job: which blocks, how large, and the storage that they become.
#pragma once

#include <pthread.h>

#include <cstdint>
#include <string>

#include "base/memory.hpp"
#include "render/job.hpp"
#include "render/kernel.hpp"
#include "render/worker_pool.hpp"
#include "world/world.hpp"

namespace mlt {

/// Names of the plan's blocks; those of the other integrator stay unused.
struct RenderSlots {
  WorldSlots world;
  Slot<WorkerStack> stacks;
  Slot<pthread_t> threads;
  Slot<WorkerStorage> workers;
  Slot<std::byte> samples;
  Slot<std::byte> saved;
  Slot<std::byte> groups;
  Slot<ChainBench> benches;
  Slot<Splat> splats;
  Slot<FilmPixel> films;
  Slot<BootstrapChunk> bootstrap;
  Slot<ChainStatistics> chains;
  Slot<PixelSum> pixels;
  Slot<TileStatistics> tiles;
  Slot<Vec3> image;
  Slot<ErrorSums> error_blocks;
};

inline constexpr std::uint64_t kPixelsPerUnit = 256;  ///< of summing, development and error estimation

struct JobPlan {
  /// With a `host`, what a second job on its compiled scene and by its threads needs besides.
  JobPlan(const WorldCounts& counts, const RenderJob& render_job, const JobPlan* host = nullptr);

  /// Throws ResourceError with what is needed, what --memory allows, and what would fit.
  void require_within_limit(const WorldCounts& counts) const;

  /// Hands the arena's blocks to `storage`; the world's own blocks are taken by compile_world.
  void take_storage(Arena& arena, RenderStorage& storage) const;

  /// How many films there are, who adds to them and why there are no more: a line of `mlt info`.
  std::string describe_films() const;

  std::uint64_t pixel_count() const { return std::uint64_t{job.width} * job.height; }
  std::uint64_t pixel_units() const { return (pixel_count() + kPixelsPerUnit - 1) / kPixelsPerUnit; }
  std::uint64_t chain_groups() const { return (std::uint64_t{job.chains} + group_size - 1) / group_size; }
  bool is_metropolis() const { return job.integrator == IntegratorKind::pssmlt; }

  RenderJob job;
  FeatureMask features;
  Kernel kernel;
  std::uint32_t sample_capacity;  ///< primary samples of one path at most
  /// pssmlt: chains that one worker runs together, as many as the kernel has lanes, or fewer where there
  /// would be too few groups for the threads. The film does not depend on it.
  std::uint32_t group_size = 1;
  std::uint32_t workers;      ///< threads that can have work at all
  std::uint32_t benches = 0;  ///< pssmlt: places for groups of chains in progress
  std::uint32_t films = 1;    ///< pssmlt: 1 to workers; worker i splats to film i % films
  MemoryPlan memory;
  RenderSlots slots;

 private:
  void plan_metropolis();
  std::uint32_t count_benches() const;
  // Of one group of chains.
  std::size_t sample_bytes() const { return sample_capacity * kernel.sample_bytes; }
  std::size_t saved_bytes() const { return sample_capacity * kernel.saved_bytes; }
  std::size_t group_splats() const { return std::size_t{kernel.lanes} * kernel.max_splats; }
  std::size_t film_bytes() const { return pixel_count() * sizeof(FilmPixel); }
  std::size_t films_for_all() const { return workers * film_bytes(); }
  std::size_t room_for_films() const;
  void plan_path();
  void take_metropolis_storage(Arena& arena, RenderStorage& storage) const;
};

}  // namespace mlt
