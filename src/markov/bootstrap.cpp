#include "markov/bootstrap.hpp"

namespace mlt {

LuminanceSum accumulate_bootstrap(std::span<BootstrapChunk> chunks, std::uint64_t paths) {
  LuminanceSum total;
  for (BootstrapChunk& chunk : chunks) {
    chunk.cumulative = total.sum;
    total.sum += chunk.sum;
    total.sum_variance += chunk.sum_variance;
  }
  total.count = paths;
  return total;
}

std::uint64_t find_bootstrap_chunk(std::span<const BootstrapChunk> chunks, double position) {
  // The last chunk whose cumulative sum does not exceed the position; chunks without light share their
  // cumulative sum with the next chunk and are therefore passed over.
  std::uint64_t first = 0;
  std::uint64_t last = chunks.size();
  while (last - first > 1) {
    const std::uint64_t middle = first + (last - first) / 2;
    if (chunks[middle].cumulative <= position) {
      first = middle;
    } else {
      last = middle;
    }
  }
  // A position rounded up to the total falls behind the last light; step back to a chunk that has some.
  while (first > 0 && !(chunks[first].sum > 0.0)) --first;
  return first;
}

double seed_position(std::uint64_t seed, std::uint64_t round, std::uint64_t chain, std::uint64_t chains,
                     double total) {
  const double u = Rng(seed, StreamPurpose::kSeedSelection, round).next_float();
  return (static_cast<double>(chain) + u) / static_cast<double>(chains) * total;
}

}  // namespace mlt
