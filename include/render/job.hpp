// What to render. A RenderRequest holds what a person asked for; resolve_job fills in every default from the
// scene and the request alone (never from the machine or the clock), which makes the RenderJob, and so the
// image, reproducible.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "markov/mutation.hpp"
#include "render/instruction_set.hpp"
#include "scene/description.hpp"
#include "scene/limits.hpp"

namespace mlt {

/// name, one-line description for the help text.
#define MLT_INTEGRATOR_KINDS(X)                                                       \
  X(path, "path tracing with next-event estimation and multiple importance sampling") \
  X(pssmlt, "primary-sample-space Metropolis light transport over the path tracer [Kelemen02]")

/// `automatic` stands in requests only: one of the others, which a pilot chooses (render/pilot.hpp).
enum class IntegratorKind : std::uint8_t {
#define MLT_ENUMERATE(name, help) name,
  MLT_INTEGRATOR_KINDS(MLT_ENUMERATE)
#undef MLT_ENUMERATE
      automatic
};

#define MLT_START_KINDS(X)                                                                  \
  X(resampled, "every chain starts from a bootstrap path drawn in proportion to luminance") \
  X(first_hit, "every chain starts from the first path found that carries light")

enum class StartKind : std::uint8_t {
#define MLT_ENUMERATE(name, help) name,
  MLT_START_KINDS(MLT_ENUMERATE)
#undef MLT_ENUMERATE
};

inline constexpr std::uint64_t kMaxMutations = std::uint64_t{1} << 31;  ///< of a whole job; film headroom
inline constexpr std::uint64_t kMaxSamplesPerPixel = std::uint64_t{1} << 30;
inline constexpr std::uint32_t kMaxChains = 1U << 20;
inline constexpr std::uint64_t kMaxBootstrap = std::uint64_t{1} << 36;  ///< paths
inline constexpr std::uint32_t kMaxDepth = kMaxPathEdges;               ///< path edges
inline constexpr std::uint32_t kMaxThreads = 1024;
inline constexpr std::size_t kDefaultFilmMemory = std::size_t{10} << 20;  ///< bytes
inline constexpr std::uint32_t kMaxFilmSide = kMaxFilmSidePixels;         ///< pixels
/// First path edge that Russian roulette may end (docs/RESULTS.md): in scenes of up to 24 edges both
/// integrators gained or were alike without roulette, but for PSSMLT where the path tracer is better anyway.
inline constexpr std::uint32_t kDefaultRouletteEdge = 24;
inline constexpr std::uint32_t kDefaultDepth = 8;  ///< path edges
/// Samples or mutations a pixel of each round, where a job speaks of rounds.
inline constexpr std::uint64_t kDefaultPerRound = 16;

/// How to estimate the image: an integrator and its settings.
struct MethodRequest {
  IntegratorKind integrator = IntegratorKind::pssmlt;
  std::optional<std::uint32_t> chains;            ///< pssmlt
  std::optional<std::uint64_t> bootstrap;         ///< pssmlt: bootstrap paths
  float large_step = 0.2f;                        ///< pssmlt: probability in [0,1]
  StartKind start = StartKind::resampled;         ///< pssmlt
  MutationKind mutation = MutationKind::kelemen;  ///< pssmlt: kind of small step
  float step_size = 1;  ///< pssmlt: factor on the small steps' sizes, kMinStepSize to kMaxStepSize
  std::optional<std::uint32_t> roulette;  ///< first path edge with Russian roulette; 0 switches it off
};

struct RenderRequest : MethodRequest {
  std::optional<std::uint32_t> width, height;      ///< pixels, 1 to kMaxFilmSide
  std::optional<std::uint64_t> samples_per_pixel;  ///< path: samples; pssmlt: mutations; >= 1
  std::optional<std::uint64_t> rounds;             ///< repetitions of that work, >= 1; default 1
  std::optional<double> target_error;              ///< estimated relMSE that ends the rounds; > 0
  std::optional<double> seconds;                   ///< after which no further round begins; > 0
  std::optional<std::uint64_t> max_per_pixel;      ///< limit of rounds * samples_per_pixel
  std::optional<std::uint32_t> depth;              ///< path edges from camera to light, 1 to kMaxDepth
  std::optional<std::uint32_t> threads;            ///< 1 to kMaxThreads; default: the machine's cores
  std::uint64_t seed = 0;
  std::size_t memory_limit = std::size_t{4} << 30;  ///< bytes
  std::size_t film_memory = kDefaultFilmMemory;     ///< pssmlt: bytes that a film for each worker may take
  std::optional<InstructionSet> instruction_set;    ///< default: the best that the processor has
};

struct RenderJob {
  IntegratorKind integrator = IntegratorKind::pssmlt;
  std::uint32_t width = 0, height = 0;
  std::uint64_t samples_per_pixel = 0;  ///< of one round
  bool in_rounds = false;               ///< whether the request speaks of rounds, their end or their limit
  std::uint64_t max_rounds = 1;
  double target_error = 0;  ///< 0: none
  double seconds = 0;       ///< 0: no limit
  std::uint32_t depth = 0;
  std::uint32_t threads = 0;                              ///< without influence on the image
  InstructionSet instruction_set = InstructionSet::base;  ///< without influence on the image
  std::uint64_t seed = 0;
  std::uint32_t chains = 0;
  std::uint64_t mutations = 0;  ///< pssmlt: of one round, all pixels together
  std::uint64_t bootstrap = 0;
  float large_step = 0;
  StartKind start = StartKind::resampled;
  MutationKind mutation = MutationKind::kelemen;
  float step_size = 1;
  std::uint32_t roulette = 0;  ///< 0: off
  std::size_t memory_limit = 0;
  std::size_t film_memory = 0;  ///< without influence on the image
  bool hash_film = true;        ///< false: the statistics' film hash stays empty, which saves its time
  bool estimate_error = true;   ///< false: so does its error; chains' variances are known all the same
};

/// The integrator of `request` must be chosen. Throws InputError (the option's name as file) when a value is
/// out of range, ResourceError when the job exceeds the film's fixed-point headroom.
RenderJob resolve_job(const RenderRequest& request, const SceneDescription& scene);

}  // namespace mlt
