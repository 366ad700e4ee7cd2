// The whole way of a Metropolis render, from the bootstrap to the developed image, over toy integrators:
// small enough to be repeated hundreds of times. An integrator states kPixels, kCapacity (primary samples)
// and kMaxSplats besides evaluate().
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "markov/bootstrap.hpp"
#include "markov/chain.hpp"

namespace mlt::test {

struct ToyJob {
  std::uint64_t seed = 1;
  std::uint64_t bootstrap = 1024;  ///< paths
  std::uint64_t chains = 32;
  std::uint64_t mutations = 64;  ///< of each chain
  float large_step = 0.3f;
  float step_size = 1;
  float weight_b = 0;  ///< the frozen b of the weights; 0: what the bootstrap finds
  std::uint32_t first_time = 1;
};

struct ToyBootstrap {
  std::vector<BootstrapChunk> chunks;
  LuminanceSum luminance;
  DefectCounts defects;
};

template <class Integrator>
ToyBootstrap run_bootstrap(const Integrator& integrator, std::uint64_t seed, std::uint64_t paths) {
  std::array<Splat, Integrator::kMaxSplats> splats;
  ToyBootstrap bootstrap;
  bootstrap.chunks.resize(bootstrap_chunk_count(paths));
  for (std::uint64_t i = 0; i < bootstrap.chunks.size(); ++i) {
    bootstrap.chunks[i] = evaluate_bootstrap_chunk(integrator, seed, i, paths, splats, bootstrap.defects);
  }
  bootstrap.luminance = accumulate_bootstrap(bootstrap.chunks, paths);
  return bootstrap;
}

template <class Integrator>
SeedPath seed_path_of_chain(const Integrator& integrator, const ToyJob& job, const ToyBootstrap& bootstrap,
                            std::uint64_t chain) {
  std::array<Splat, Integrator::kMaxSplats> splats;
  const double position = seed_position(job.seed, 0, chain, job.chains, bootstrap.luminance.sum);
  return find_seed_path(integrator, job.seed, job.bootstrap, bootstrap.chunks, position, splats);
}

template <MutationKind kKind>
constexpr MutationKind kind_of(Mutation<kKind>) {
  return kKind;
}

/// One chain with storage of its own.
template <class Mutation, class Integrator, class Film>
ChainStatistics run_chain(const Integrator& integrator, const ToyJob& job, float weight_b,
                          std::uint64_t chain_index, const SeedPath& start, Film& film) {
  std::array<PrimarySampleOf<float>, Integrator::kCapacity> samples;
  std::array<ProposedSampleOf<float>, Integrator::kCapacity> saved;
  std::array<Splat, Integrator::kMaxSplats> current, proposed;
  ChainSettings settings;
  settings.seed = job.seed;
  settings.bootstrap = job.bootstrap;
  settings.large_step = job.large_step;
  settings.weight_b = weight_b;
  settings.mutation = kind_of(Mutation{});
  settings.step_size = job.step_size;
  settings.first_time = job.first_time;
  const ChainTask task{chain_index, job.mutations, start};
  ChainStatistics statistics;
  ChainGroup<Integrator, Film> chain(integrator, settings, {samples, saved, current, proposed}, {&task, 1},
                                     {&film, 1}, {&statistics, 1});
  chain.begin();
  chain.advance(job.mutations);
  chain.end();
  return statistics;
}

inline float weight_b_of(const ToyJob& job, const ToyBootstrap& bootstrap) {
  return job.weight_b > 0.0f ? job.weight_b : static_cast<float>(bootstrap.luminance.mean());
}

/// All chains, in order, into one film.
template <class Mutation, class Integrator, class Film>
ChainStatistics run_chains(const Integrator& integrator, const ToyJob& job, const ToyBootstrap& bootstrap,
                           Film& film) {
  ChainStatistics statistics;
  if (!(bootstrap.luminance.sum > 0.0)) return statistics;
  for (std::uint64_t chain = 0; chain < job.chains; ++chain) {
    const SeedPath start = seed_path_of_chain(integrator, job, bootstrap, chain);
    statistics.add(run_chain<Mutation>(integrator, job, weight_b_of(job, bootstrap), chain, start, film));
  }
  return statistics;
}

/// A film without fixed point, for the tests of the stage that has none yet.
class DoubleFilm {
 public:
  explicit DoubleFilm(std::size_t pixels) : metropolis_(3 * pixels), uniform_(3 * pixels) {}

  void splat(std::uint32_t pixel, const Vec3& value, double metropolis_weight, double uniform_weight) {
    const double channels[3] = {value.x, value.y, value.z};
    for (std::size_t c = 0; c < 3; ++c) {
      metropolis_[3 * pixel + c] += channels[c] * metropolis_weight;
      uniform_[3 * pixel + c] += channels[c] * uniform_weight;
    }
  }

  void prefetch(std::uint32_t) const {}

  /// Radiance, three channels a pixel (docs/ESTIMATOR.md).
  std::vector<double> develop(double b, double weight_b, std::uint64_t mutations) const {
    const double scale = static_cast<double>(metropolis_.size() / 3) / static_cast<double>(mutations);
    std::vector<double> image(metropolis_.size());
    for (std::size_t i = 0; i < image.size(); ++i) {
      image[i] = scale * (b * metropolis_[i] + weight_b * uniform_[i]);
    }
    return image;
  }

  bool operator==(const DoubleFilm&) const = default;

 private:
  std::vector<double> metropolis_, uniform_;
};

/// The image of one job, developed with b from the bootstrap alone. With a frozen w this is unbiased exactly,
/// even with few bootstrap paths and short chains: a chain's start weighted by that b estimates the integral
/// without bias [Veach97 chapter 11].
template <class Mutation, class Integrator>
std::vector<double> render_toy(const Integrator& integrator, const ToyJob& job) {
  const ToyBootstrap bootstrap = run_bootstrap(integrator, job.seed, job.bootstrap);
  DoubleFilm film(Integrator::kPixels);
  run_chains<Mutation>(integrator, job, bootstrap, film);
  return film.develop(bootstrap.luminance.mean(), weight_b_of(job, bootstrap), job.chains * job.mutations);
}

/// Calls visit.operator()<kind>(name) for each registered kind of mutation.
template <class Visit>
void for_each_mutation(Visit&& visit) {
#define MLT_VISIT(name, help) visit.template operator()<MutationKind::name>(#name);
  MLT_MUTATION_KINDS(MLT_VISIT)
#undef MLT_VISIT
}

}  // namespace mlt::test
