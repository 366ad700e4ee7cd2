// The experiment: renders of one scene by several methods at several budgets, repeated with other seeds. All
// of it runs in one process, replicates outermost, then budgets, then methods in an order that rotates from
// replicate to replicate, so that what disturbs the machine meets all methods alike. Images stay in memory
// until they are scored, since the mean of all may have to stand in for a reference.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "converge/reference.hpp"
#include "render/job.hpp"
#include "scene/description.hpp"

namespace mlt {

inline constexpr std::size_t kMaxConvergeLevels = 64;
inline constexpr std::uint32_t kMaxReplicates = 4096;
/// Below every seed of a run unless --seed says otherwise: references tend to be made from small seeds, and a
/// render that shares random numbers with its reference looks better than it is.
inline constexpr std::uint64_t kDefaultConvergeSeed = 1000000;

struct ConvergeMethod {
  MethodRequest settings;
  std::string name;                    ///< tells it from the other methods of the run
  std::vector<std::uint64_t> budgets;  ///< one a level: samples or mutations a pixel
};

struct ConvergePlan {
  std::vector<ConvergeMethod> methods;  ///< as many budgets each
  std::uint32_t replicates = 16;
  RenderRequest request;  ///< settings and samples are those of method and level; seed is the first

  std::size_t level_count() const { return methods.front().budgets.size(); }
  /// Another one for each replicate and level, and the same one for all methods.
  std::uint64_t seed_of(std::uint32_t replicate, std::size_t level) const {
    return request.seed + replicate * std::uint64_t{level_count()} + level;
  }
  RenderRequest request_of(std::size_t method, std::size_t level, std::uint32_t replicate) const;
};

/// One render.
struct Measurement {
  std::size_t method = 0;
  std::size_t level = 0;
  std::uint32_t replicate = 0;
  std::uint64_t budget = 0;
  std::uint64_t seed = 0;
  std::uint64_t samples = 0;  ///< paths evaluated, bootstrap included
  double wall_seconds = 0;
  double cpu_seconds = 0;
  std::string film_hash;
  double rel_mse_raw = 0;  ///< against the reference; without one the same as rel_mse
  double rel_mse = 0;      ///< less the reference's own noise, which may leave a negative number
  double mse = 0;          ///< against the reference, or the mean of the method's own replicates
  double mean = 0;         ///< of the image, over pixels and channels
};

struct ConvergeRun {
  std::vector<ConvergeMethod> methods;
  std::size_t level_count = 0;
  std::uint32_t replicates = 0;  ///< complete ones
  std::uint32_t width = 0, height = 0, depth = 0, threads = 0;
  bool interrupted = false;
  std::vector<Measurement> rows;    ///< by replicate, level, method
  std::vector<ImageBuffer> images;  ///< of the rows

  std::size_t index(std::size_t method, std::size_t level, std::uint32_t replicate) const {
    return (replicate * level_count + level) * methods.size() + method;
  }
  const Measurement& row(std::size_t method, std::size_t level, std::uint32_t replicate) const {
    return rows[index(method, level, replicate)];
  }
};

/// Resolves every job of the plan, so that all that is wrong is reported before time is spent. Throws
/// InputError, or ResourceError when a budget exceeds the film or the images exceed the memory limit.
void check_plan(const SceneDescription& scene, const ConvergePlan& plan);

/// Fills in the budgets that take about `times` (wall seconds, increasing) by trial renders of doubling
/// length, up to one that takes the last of them. False when `stop` was set.
bool budgets_for_times(const SceneDescription& scene, const std::vector<double>& times, ConvergePlan& plan,
                       const std::atomic<bool>& stop);

/// Called after each complete replicate.
using ReplicateCallback = std::function<void(std::uint32_t done)>;

/// Renders everything. When `stop` is set, the replicate that is being made is dropped and the rest returned.
ConvergeRun measure(const SceneDescription& scene, const ConvergePlan& plan, const std::atomic<bool>& stop,
                    const ReplicateCallback& progress);

/// Computes the errors of all rows. Without a reference (null) the error of a replicate is its squared
/// difference from the mean of its method's replicates at that level, times n / (n - 1), relative to the mean
/// of all methods' images of the last level: its expectation is the relative variance, and a bias stays
/// unseen. Then at least two replicates are needed.
void score(ConvergeRun& run, const Reference* reference);

/// The mean over the replicates.
ImageBuffer mean_image(const ConvergeRun& run, std::size_t method, std::size_t level);

/// The reference, or without one the mean of all methods' images of the last level.
ImageBuffer base_image(const ConvergeRun& run, const Reference* reference);

}  // namespace mlt
