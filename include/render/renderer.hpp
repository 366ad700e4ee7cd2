// One render from scene description to developed image, in three steps with a line between them:
// construction plans the memory, prepare() allocates it, compiles the scene and starts the workers, and
// run() renders without allocating, locking, throwing or faulting.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/memory.hpp"
#include "film/error_estimate.hpp"
#include "film/image_view.hpp"
#include "integrator/features.hpp"
#include "render/job.hpp"

namespace mlt {

struct RenderProgress {
  std::uint64_t done = 0;  ///< samples, or mutations and the bootstrap's paths
  std::uint64_t total = 0;
  double seconds = 0;  ///< since run() began
};

/// Called about four times a second from the thread that called run(), between render begin and render end:
/// it must not allocate, lock or throw.
using ProgressCallback = void (*)(const RenderProgress& progress, void* context);

struct RenderStatistics {
  double wall_seconds = 0;
  double cpu_seconds = 0;
  std::uint64_t samples = 0;    ///< paths evaluated, bootstrap included
  std::uint64_t rounds = 0;     ///< finished
  std::uint64_t mutations = 0;  ///< pssmlt
  /// That the paths of samples or mutations asked for, those of the bootstrap not counted: what a render
  /// costs, counted.
  std::uint64_t primary_samples = 0;
  double b = 0;  ///< mean luminance of the image, from bootstrap and large steps
  double b_standard_error = 0;
  double acceptance_large = 0;  ///< mean acceptance probability
  double acceptance_small = 0;
  std::uint64_t longest_rejection_run = 0;
  std::uint64_t rejected_nan = 0;  ///< contributions by kind of defect
  std::uint64_t rejected_infinite = 0;
  std::uint64_t rejected_negative = 0;
  std::uint64_t minor_faults = 0;  ///< page faults between render begin and render end, all threads
  ErrorEstimate error;             ///< estimated relMSE of the image
  bool partial = false;            ///< stopped before the end
  bool black = false;              ///< no path carried light
  std::string film_hash;           ///< 64 hexadecimal digits, SHA-256; empty where the job wants none

  std::uint64_t rejected_non_finite() const { return rejected_nan + rejected_infinite + rejected_negative; }
};

/// What `mlt info` prints: one line of name and value each.
struct InfoLine {
  std::string name;
  std::string value;
};

class Renderer {
 public:
  /// Computes the memory plan and checks it against the job's limit. `scene` must outlive prepare().
  Renderer(const SceneDescription& scene, const RenderJob& job);
  /// A guest: renders the scene that `host` has compiled, by the host's threads and, where it fits, in the
  /// memory of the host's film, which saves the time and the memory of both. Its film shows the host's view,
  /// in pixels that need not be square. The host must be prepared, outlive the guest and have a job of the
  /// same instruction set. Of the two, the one that was prepared or restarted last may run and shows what it
  /// has rendered.
  Renderer(Renderer& host, const RenderJob& job);
  ~Renderer();

  const MemoryPlan& memory_plan() const;
  /// Counts, features found, features skipped, dimensions per path.
  std::vector<InfoLine> info() const;
  FeatureMask features() const;

  void prepare();
  /// `stop` is looked at before each chain or pixel block; `progress` may be null.
  RenderStatistics run(const std::atomic<bool>& stop, ProgressCallback progress, void* context);
  /// Empties the film, for another run() of the same job with another seed and another edge at which roulette
  /// begins; it cannot be switched on or off. Ends what a guest or the host has rendered.
  void restart(std::uint64_t seed, std::uint32_t roulette);
  /// Valid after run() until restart() or until the renderer is destroyed.
  ImageView image() const;
  /// Estimated standard errors of the image's channels; zero where they are not known. Each pixel's variance
  /// is the mean over its 5 x 5 neighbours, since that of one pixel comes from a single difference.
  ImageBuffer standard_errors() const;
  /// Of pixel `index`, without that mean: single squared differences, whose sums over pixels alone tell much.
  Vec3 variance(std::size_t index) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace mlt
