// Which integrator suits a scene, a size of picture and an amount of work, and in deep scenes where its
// roulette should begin. A pilot renders a few per cent of the job by each of them and compares the errors
// that they would make with the same work. Work is counted in primary samples, not in seconds, and the
// pilot's size follows from the request, so that the choice is the same on every machine. Its paths have
// random numbers of their own and are thrown away: kept, they would bias the image, for what they found
// decided whether they are kept.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "film/image_view.hpp"
#include "render/job.hpp"
#include "scene/description.hpp"

namespace mlt {

/// A job of fewer samples or mutations in all has no pilot, which could not tell much, and is path traced.
inline constexpr std::uint64_t kLeastPiloted = std::uint64_t{1} << 19;

/// PSSMLT is taken where its pilot needed so many times less work than the path tracer's for the same error.
/// 1 is no hedge for either: where the choice is close, pilots of both find about the ratio of whole jobs
/// (docs/RESULTS.md).
inline constexpr double kPilotThreshold = 1.0;

/// What one integrator's pilot showed, as the mean over rounds of equal size.
struct PilotRender {
  ImageBuffer image;
  ImageBuffer variances;       ///< of the image's channels in one round, each from one difference a round
  double per_pixel = 0;        ///< samples or mutations of one round
  double paths = 0;            ///< of all rounds
  double primary_samples = 0;  ///< that these paths asked for
  bool found_light = false;
};

/// In jobs of more edges than kDefaultRouletteEdge that state no --roulette, the pilot tries this edge too.
inline constexpr std::uint32_t kEarlyRouletteEdge = 8;

/// It is taken for both integrators where the path tracer's relMSE with it is less than so many times that
/// with the default edge, from equally many samples: these take 1.3 to 2.6 times less time, 1.7 in the middle
/// (docs/RESULTS.md).
inline constexpr double kEarlyRouletteThreshold = 1.7;

enum class PilotOutcome : std::uint8_t {
  compared,
  too_small,    ///< no pilot: kLeastPiloted
  too_large,    ///< no pilot: more work than PSSMLT's film has headroom for
  only_chains,  ///< only PSSMLT's pilot found light
  no_light      ///< neither did, only the path tracer's did, or the pilot was stopped
};

struct PilotFinding {
  IntegratorKind chosen = IntegratorKind::path;
  PilotOutcome outcome = PilotOutcome::no_light;
  double advantage = 0;                   ///< of PSSMLT; where both pilots were compared
  std::optional<std::uint32_t> roulette;  ///< where the pilot tried two edges
  double early_roulette_error = 0;        ///< the path tracer's, of kEarlyRouletteEdge over the default
  std::uint64_t paths = 0;                ///< samples and mutations of the pilot, bootstrap included
  double wall_seconds = 0;                ///< all that the pilot took, the compilation of the scene included
  double cpu_seconds = 0;
};

/// Work that the path tracer needs over that of PSSMLT for the same relMSE, in a scene of materials with
/// several lobes or without. Both images show the same, in equally many pixels.
double pilot_advantage(const PilotRender& path, const PilotRender& pssmlt, bool several_lobes = false);

/// Error of `a` over that of `b`, whose films have equally many pixels.
double pilot_error_ratio(const PilotRender& a, const PilotRender& b);

/// Chooses for a request whose integrator is automatic; its settings must be valid for both integrators.
/// Throws as resolve_job and Renderer do.
PilotFinding run_pilot(const SceneDescription& scene, const RenderRequest& request,
                       const std::atomic<bool>& stop);

/// The request that a finding leads to.
RenderRequest decided(RenderRequest request, const PilotFinding& finding);

/// One line: what was chosen and why, for the job that `decided` leads to. It holds no time, so that it is
/// the same on every machine.
std::string describe(const PilotFinding& finding, const RenderJob& job);

}  // namespace mlt
