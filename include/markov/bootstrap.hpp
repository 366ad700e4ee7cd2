// The bootstrap: many paths that estimate b, the integral of the target function, and from which
// chains start with probability proportional to luminance. Luminances are not stored: paths are summed in
// chunks of fixed size, and a chain that starts replays the one chunk that its position falls into.
#pragma once

#include <cstdint>
#include <span>

#include "base/assert.hpp"
#include "markov/bootstrap_sampler.hpp"
#include "markov/contribution.hpp"
#include "math/rng.hpp"

namespace mlt {

inline constexpr std::uint64_t kBootstrapChunk = 64;  ///< paths

struct BootstrapChunk {
  double sum = 0;           ///< of luminance, in index order
  double sum_variance = 0;  ///< estimate of the sum's variance
  double cumulative = 0;    ///< sum of all chunks before this one; filled by accumulate_bootstrap
};

/// Moments of the luminance of independent paths.
struct LuminanceMoments {
  double sum = 0;
  double sum_squares = 0;
  std::uint64_t count = 0;

  void add(double luminance_value) {
    sum += luminance_value;
    sum_squares += luminance_value * luminance_value;
    count += 1;
  }
  void add(const LuminanceMoments& other) {
    sum += other.sum;
    sum_squares += other.sum_squares;
    count += other.count;
  }
  double mean() const { return count == 0 ? 0.0 : sum / static_cast<double>(count); }
  /// Standard error of the mean; 0 for fewer than two paths.
  double standard_error() const {
    if (count < 2) return 0.0;
    const double n = static_cast<double>(count);
    const double variance = (sum_squares - sum * sum / n) / (n - 1.0);
    return variance > 0.0 ? std::sqrt(variance / n) : 0.0;
  }
};

/// A sum of luminances and an estimate of its variance.
struct LuminanceSum {
  double sum = 0;
  double sum_variance = 0;
  std::uint64_t count = 0;

  void add(const LuminanceMoments& independent) {
    const double error = independent.standard_error() * static_cast<double>(independent.count);
    sum += independent.sum;
    sum_variance += error * error;
    count += independent.count;
  }
  double mean() const { return count == 0 ? 0.0 : sum / static_cast<double>(count); }
  double standard_error() const {
    return count == 0 ? 0.0 : std::sqrt(sum_variance) / static_cast<double>(count);
  }
};

/// Estimates the variance of a sum of values, each from a stratum of its own, by the differences of
/// neighbours, the last and the first among them. They hold the differences of the strata as well: for
/// independent values the expectation is never too small [Cochran77 section 5A.12].
class NeighbourDifferences {
 public:
  void add(double value) {
    if (count_ == 0) first_ = last_ = value;
    squares_ += (value - last_) * (value - last_);
    last_ = value;
    count_ += 1;
  }
  /// A value without a neighbour is taken for the error itself.
  double sum_variance() const {
    return count_ < 2 ? last_ * last_ : 0.5 * (squares_ + (last_ - first_) * (last_ - first_));
  }

 private:
  double squares_ = 0;
  double first_ = 0, last_ = 0;
  std::uint64_t count_ = 0;
};

/// Where a chain starts: a bootstrap path, and the luminance that its replay must reproduce bit for bit.
struct SeedPath {
  std::uint64_t index = 0;
  float target = 0;
};

constexpr std::uint64_t bootstrap_chunk_count(std::uint64_t paths) {
  return (paths + kBootstrapChunk - 1) / kBootstrapChunk;
}

/// Paths of chunk `chunk_index` when there are `paths` in all: the last chunk may have fewer than others.
constexpr std::uint64_t bootstrap_chunk_size(std::uint64_t paths, std::uint64_t chunk_index) {
  const std::uint64_t left = paths - chunk_index * kBootstrapChunk;
  return left < kBootstrapChunk ? left : kBootstrapChunk;
}

/// Calls visit(path index, target) for each path of a chunk, in order. The replay context's step is the
/// first path's index of those that are evaluated together, so that a path that fails can be told also when a
/// chain's search for its start evaluates it.
template <class Integrator, class Visit>
void visit_bootstrap_chunk(const Integrator& integrator, std::uint64_t seed, std::uint64_t chunk_index,
                           std::uint64_t paths, std::span<SplatOf<typename Integrator::Float>> splats,
                           DefectCounts& defects, Visit&& visit) {
  using F = typename Integrator::Float;
  const std::uint64_t first = chunk_index * kBootstrapChunk;
  const std::uint64_t last = first + bootstrap_chunk_size(paths, chunk_index);
  const BootstrapStreams streams(seed, paths);
  ContributionOf<F> contribution(splats);
  ReplayContext& context = replay_context();
  context.seed = seed;
  context.unit = chunk_index;
  for (std::uint64_t index = first; index < last; index += kLaneCount<F>) {
    context.step = index;
    const MaskOf<F> active = first_lanes<F>(last - index);
    BootstrapSamplerOf<F> sampler;
    for_lanes(active,
              [&](int lane) { sampler.set_lane(lane, streams, index + static_cast<std::uint64_t>(lane)); });
    evaluate_into(integrator, sampler, active, contribution, [&](int) -> DefectCounts& { return defects; });
    for_lanes(active, [&](int lane) {
      visit(index + static_cast<std::uint64_t>(lane), lane_of(contribution.target(), lane));
    });
  }
}

/// Adds the paths' defects to `defects`, of which each worker has one: there are too many chunks to keep
/// theirs. `splats` has room for those of a path, in all lanes.
template <class Integrator>
BootstrapChunk evaluate_bootstrap_chunk(const Integrator& integrator, std::uint64_t seed,
                                        std::uint64_t chunk_index, std::uint64_t paths,
                                        std::span<SplatOf<typename Integrator::Float>> splats,
                                        DefectCounts& defects) {
  BootstrapChunk chunk;
  NeighbourDifferences differences;
  visit_bootstrap_chunk(integrator, seed, chunk_index, paths, splats, defects,
                        [&](std::uint64_t, float target) {
                          const double value = target;
                          chunk.sum += value;
                          differences.add(value);
                        });
  chunk.sum_variance = differences.sum_variance();
  return chunk;
}

/// Fills the cumulative sums and returns the sum of all paths.
LuminanceSum accumulate_bootstrap(std::span<BootstrapChunk> chunks, std::uint64_t paths);

/// The chunk in which `position` (in [0, total luminance)) falls; it has a positive sum.
std::uint64_t find_bootstrap_chunk(std::span<const BootstrapChunk> chunks, double position);

/// Systematic resampling over all chains: chain c of C takes position (c + u) / C of the total
/// ([Kelemen02] starts from one such path; one stratum for each chain lowers the variance of the starts).
/// `round` numbers independent repetitions.
double seed_position(std::uint64_t seed, std::uint64_t round, std::uint64_t chain, std::uint64_t chains,
                     double total);

/// Replays a chunk to find the path at `position`. The replay must reproduce the chunk's sum bit for bit.
template <class Integrator>
SeedPath find_seed_path(const Integrator& integrator, std::uint64_t seed, std::uint64_t paths,
                        std::span<const BootstrapChunk> chunks, double position,
                        std::span<SplatOf<typename Integrator::Float>> splats) {
  const std::uint64_t chunk_index = find_bootstrap_chunk(chunks, position);
  const BootstrapChunk& chunk = chunks[chunk_index];
  SeedPath found;
  bool passed = false;
  double sum = 0;
  DefectCounts ignored;
  visit_bootstrap_chunk(integrator, seed, chunk_index, paths, splats, ignored,
                        [&](std::uint64_t index, float target) {
                          sum += static_cast<double>(target);
                          // Rounding may leave the position just behind the last path: then that one is
                          // taken.
                          if (!passed && target > 0.0f) found = SeedPath{index, target};
                          passed = passed || chunk.cumulative + sum > position;
                        });
  MLT_CHECK_OP(sum, ==, chunk.sum);
  MLT_CHECK_OP(found.target, >, 0.0f);
  return found;
}

}  // namespace mlt
