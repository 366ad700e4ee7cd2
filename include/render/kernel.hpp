// Kernels: the render's inner work, compiled once for each set of features (integrator/features.hpp) and
// mutation kind, chosen before rendering. A kernel reads and writes the storage that RenderStorage lists and
// nothing else.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/event.hpp"
#include "film/error_estimate.hpp"
#include "film/fixed_film.hpp"
#include "film/pixel_film.hpp"
#include "integrator/features.hpp"
#include "integrator/path.hpp"
#include "markov/bootstrap.hpp"
#include "markov/chain.hpp"
#include "render/job.hpp"
#include "world/world.hpp"

namespace mlt {

inline constexpr std::uint32_t kTileSide = 16;  ///< pixels; the path tracer's unit of work

/// What the path tracer counts for each tile.
struct TileStatistics {
  LuminanceMoments luminance;  ///< of the first sequence of every pixel
  DefectCounts defects;
  std::uint64_t samples = 0;
  std::uint64_t primary_samples = 0;  ///< that the paths asked for

  void add(const TileStatistics& other) {
    luminance.add(other.luminance);
    defects.add(other.defects);
    samples += other.samples;
    primary_samples += other.primary_samples;
  }
};

/// Storage of one worker, its own but for the film.
struct WorkerStorage {
  std::span<FilmPixel> film;  ///< one of RenderStorage::films
  FilmWriters film_writers = FilmWriters::one;
  DefectCounts bootstrap_defects;
};

/// Mutations of each chain of a group until a worker may pass to another group: milliseconds, so that all
/// workers end together however fast each is, and a stopped render ends soon.
inline constexpr std::uint32_t kTurnMutations = 512;

/// Where groups of chains run, one after the other, by whichever worker takes the next turn.
struct ChainBench {
  std::span<std::byte> samples, saved;  ///< of a group of chains; Kernel tells their sizes
  std::span<Splat> current, proposed;   ///< of a group's chains
  std::span<std::byte> group;           ///< the group's other state
  bool is_running = false;              ///< a group that was begun and has not ended
  Event turns;                          ///< raised at the end of each
  std::uint32_t first_turn = 0;         ///< value of `turns` when the round began
};

/// All that kernels work on, in the arena.
struct RenderStorage {
  const World* world = nullptr;
  RenderJob job;
  PathSettings path;
  std::span<WorkerStorage> workers;

  // PSSMLT
  std::span<FilmPixel> films;  ///< one after the other, each of image.size() pixels
  std::span<BootstrapChunk> bootstrap;
  std::span<ChainStatistics> chains;  ///< of one round
  std::span<ChainBench> benches;      ///< at least as many as workers
  LuminanceSum bootstrap_luminance;
  std::uint64_t mutations = 0;         ///< of all chains
  std::uint64_t chain_group_size = 1;  ///< chains that are run together, at most the kernel's lanes
  std::uint32_t fraction_bits = 0;

  // Path tracer
  std::span<PixelSum> pixels;
  std::span<TileStatistics> tiles;  ///< of one round

  std::uint64_t round = 0;            ///< repetitions of the job's work, each with random numbers of its own
  std::span<ErrorSums> error_blocks;  ///< one a unit of development
  std::span<Vec3> image;
  const std::atomic<bool>* stop = nullptr;  ///< set: leave units, which may be long, before their end
  std::atomic<bool> left_early{false};      ///< a tile or a group of chains was left before its end
  std::atomic<std::uint64_t> done{0};       ///< paths finished, raised once a unit

  std::size_t film_count() const { return films.size() / image.size(); }
  /// Film `index`; development moves all of them into the first.
  std::span<FilmPixel> film(std::size_t index) const {
    return films.subspan(index * image.size(), image.size());
  }
};

/// Mutations of chain `index`: the job's total, spread evenly, the remainder over the first chains.
constexpr std::uint64_t chain_length(std::uint64_t mutations, std::uint64_t chains, std::uint64_t index) {
  return mutations / chains + (index < mutations % chains ? 1 : 0);
}

/// The turns of a round of chains: turn t is taken at bench t % benches, and ends after the bench's turn
/// before. Each bench has the groups of its own number and of every `benches`-th from there.
struct ChainTurns {
  std::uint64_t groups = 0;
  std::uint64_t benches = 1;
  std::uint64_t turns_of_group = 1;

  ChainTurns(std::uint64_t mutations, std::uint64_t chains, std::uint64_t group_size,
             std::uint64_t bench_count)
      : groups((chains + group_size - 1) / group_size),
        benches(bench_count),
        turns_of_group((chain_length(mutations, chains, 0) + kTurnMutations - 1) / kTurnMutations) {}

  /// Some of the last do nothing, where not all benches have equally many groups.
  std::uint64_t count() const { return (groups + benches - 1) / benches * turns_of_group * benches; }
  std::uint64_t bench(std::uint64_t turn) const { return turn % benches; }
  std::uint64_t at_bench(std::uint64_t turn) const { return turn / benches; }
  std::uint64_t group(std::uint64_t turn) const {
    return bench(turn) + at_bench(turn) / turns_of_group * benches;
  }
  std::uint64_t of_group(std::uint64_t turn) const { return at_bench(turn) % turns_of_group; }
};

constexpr std::uint32_t tile_count(std::uint32_t side) {
  return (side + kTileSide - 1) / kTileSide;
}

/// One unit each, for a RenderStorage as context.
struct Kernel {
  std::uint32_t (*primary_sample_capacity)(std::uint32_t depth) = nullptr;
  std::uint32_t max_splats = 0;  ///< of one path
  std::uint32_t lanes = 0;       ///< chains, or samples, that are advanced together
  std::size_t sample_bytes = 0;  ///< of one dimension in all lanes
  std::size_t saved_bytes = 0;   ///< of what a proposal overwrote of it
  std::size_t group_bytes = 0;   ///< of ChainBench::group
  void (*bootstrap_chunk)(void* storage, std::uint32_t worker, std::uint64_t chunk) = nullptr;
  void (*chain_turn)(void* storage, std::uint32_t worker, std::uint64_t turn) = nullptr;
  void (*tile)(void* storage, std::uint32_t worker, std::uint64_t tile) = nullptr;
};

Kernel select_kernel(FeatureMask features);

}  // namespace mlt
