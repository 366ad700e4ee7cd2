#include "render/job.hpp"

#include <sched.h>

#include <algorithm>
#include <string>

#include "base/assert.hpp"
#include "base/error.hpp"
#include "film/fixed_film.hpp"

namespace mlt {
namespace {

// Defaults that follow from the job alone; the measurements behind them are in docs/RESULTS.md.
constexpr std::uint64_t kDefaultSamplesPerPixel = 64;
constexpr std::uint64_t kDefaultMutationsPerPixel = 100;
constexpr std::uint32_t kDefaultChains = 256;
constexpr std::uint64_t kMinDefaultChainLength = 256;    ///< mutations
constexpr std::uint64_t kMinDefaultBootstrap = 16384;    ///< paths
constexpr std::uint64_t kMaxDefaultBootstrap = 1 << 20;  ///< paths: b is then known well enough
constexpr std::uint64_t kBootstrapShare = 10;            ///< a tenth of the mutations

/// Collects what is wrong with a request, so that all of it is reported at once.
class RequestChecker {
 public:
  void check(bool valid, const std::string& option, const std::string& found, const std::string& allowed) {
    if (!valid) faults_.push_back({option, 0, 0, "found " + found + ", allowed is " + allowed});
  }

  template <class T>
  T in_range(const std::string& option, T value, T low, T high) {
    check(value >= low && value <= high, option, std::to_string(value),
          std::to_string(low) + " to " + std::to_string(high));
    return value;
  }

  void finish() const {
    if (!faults_.empty()) throw InputError(faults_);
  }

 private:
  std::vector<Diagnostic> faults_;
};

std::uint32_t available_threads() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) != 0) return 1;
  return static_cast<std::uint32_t>(std::max(1, CPU_COUNT(&set)));
}

std::string supported_sets() {
  std::string names;
#define MLT_APPEND(name, help, condition) \
  if (is_supported(InstructionSet::name)) names += (names.empty() ? "" : ", ") + std::string(#name);
  MLT_INSTRUCTION_SETS(MLT_APPEND)
#undef MLT_APPEND
  return names;
}

void require_headroom(std::uint64_t mutations) {
  if (film_fraction_bits(mutations) >= kMinFractionBits) return;
  throw ResourceError("--mutations: the job makes " + std::to_string(mutations) +
                      " mutations and the film's fixed point has room for " + std::to_string(kMaxMutations) +
                      "; render with several seeds and average the images");
}

/// How many rounds there may be: as many as asked for, else as many as the limits allow where something ends
/// them, else one.
void resolve_rounds(const RenderRequest& request, RequestChecker& checker, RenderJob& job) {
  checker.check(request.target_error.value_or(1.0) > 0.0, "--target-error",
                std::to_string(request.target_error.value_or(1.0)), "a number above 0");
  checker.check(request.seconds.value_or(1.0) > 0.0, "--time", std::to_string(request.seconds.value_or(1.0)),
                "a number above 0");
  job.target_error = request.target_error.value_or(0.0);
  job.seconds = request.seconds.value_or(0.0);
  const bool metropolis = job.integrator == IntegratorKind::pssmlt;
  const std::uint64_t pixels = std::uint64_t{job.width} * job.height;
  const std::uint64_t most = std::max<std::uint64_t>(
      1, (metropolis ? kMaxMutations / pixels : kMaxSamplesPerPixel) / job.samples_per_pixel);
  const bool ends = request.target_error || request.seconds;
  checker.check(!request.target_error || metropolis || job.samples_per_pixel >= 2, "--target-error",
                "rounds of " + std::to_string(job.samples_per_pixel) + " samples a pixel",
                "at least 2, whose differences tell the error");
  job.max_rounds = request.rounds.value_or(ends ? most : 1);
  if (request.max_per_pixel) {
    checker.check(*request.max_per_pixel >= job.samples_per_pixel, "--max-mutations",
                  std::to_string(*request.max_per_pixel),
                  "at least one round of " + std::to_string(job.samples_per_pixel));
    job.max_rounds =
        std::min(job.max_rounds, std::max<std::uint64_t>(1, *request.max_per_pixel / job.samples_per_pixel));
  }
  checker.check(
      job.max_rounds >= 1 && job.max_rounds <= most, "--rounds", std::to_string(job.max_rounds),
      "1 to " + std::to_string(most) + " with " + std::to_string(job.samples_per_pixel) + " a pixel each");
}

/// How the integrator estimates: what it needs besides the amount of work.
void resolve_settings(const MethodRequest& request, RequestChecker& checker, RenderJob& job) {
  checker.check(request.large_step >= 0.0f && request.large_step <= 1.0f, "--large-step",
                std::to_string(request.large_step), "0 to 1");
  job.large_step = request.large_step;
  checker.check(request.step_size >= kMinStepSize && request.step_size <= kMaxStepSize, "--step-size",
                std::to_string(request.step_size), "1/1024 to 16");
  job.step_size = request.step_size;
  job.start = request.start;
  job.mutation = request.mutation;
  // Roulette that could only start behind the longest path would waste a primary sample a vertex.
  job.roulette =
      checker.in_range("--roulette", request.roulette.value_or(kDefaultRouletteEdge), 0U, kMaxDepth);
  if (job.roulette >= job.depth) job.roulette = 0;
}

}  // namespace

RenderJob resolve_job(const RenderRequest& request, const SceneDescription& scene) {
  static_assert(film_fraction_bits(kMaxMutations) == kMinFractionBits);
  MLT_CHECK(request.integrator != IntegratorKind::automatic);
  const bool metropolis = request.integrator == IntegratorKind::pssmlt;
  RequestChecker checker;
  RenderJob job;
  job.integrator = request.integrator;
  job.width = checker.in_range("--width", request.width.value_or(scene.film_width), 1U, kMaxFilmSide);
  job.height = checker.in_range("--height", request.height.value_or(scene.film_height), 1U, kMaxFilmSide);
  job.in_rounds = request.rounds || request.target_error || request.seconds;
  job.samples_per_pixel =
      checker.in_range(metropolis ? "--mutations" : "--spp",
                       request.samples_per_pixel.value_or(job.in_rounds ? kDefaultPerRound
                                                          : metropolis  ? kDefaultMutationsPerPixel
                                                                        : kDefaultSamplesPerPixel),
                       std::uint64_t{1}, kMaxSamplesPerPixel);
  resolve_rounds(request, checker, job);
  job.depth =
      checker.in_range("--depth", request.depth.value_or(scene.depth.value_or(kDefaultDepth)), 1U, kMaxDepth);
  job.threads = checker.in_range(
      "--threads", request.threads.value_or(std::min(available_threads(), kMaxThreads)), 1U, kMaxThreads);
  job.seed = request.seed;
  resolve_settings(request, checker, job);
  job.memory_limit = request.memory_limit;
  job.film_memory = request.film_memory;
  job.instruction_set = request.instruction_set.value_or(best_instruction_set());
  checker.check(is_supported(job.instruction_set), "--isa",
                std::string(instruction_set_name(job.instruction_set)) +
                    ", which this processor or this binary does not have",
                supported_sets());
  checker.finish();

  if (metropolis) {
    const std::uint64_t pixels = std::uint64_t{job.width} * job.height;
    const std::uint64_t mutations = job.mutations = pixels * job.samples_per_pixel;
    require_headroom(mutations * job.max_rounds);
    const std::uint64_t fitting = std::max<std::uint64_t>(1, mutations / kMinDefaultChainLength);
    const auto default_chains = static_cast<std::uint32_t>(std::min<std::uint64_t>(kDefaultChains, fitting));
    job.chains = checker.in_range("--chains", request.chains.value_or(default_chains), 1U, kMaxChains);
    job.bootstrap =
        checker.in_range("--bootstrap",
                         request.bootstrap.value_or(std::clamp(mutations / kBootstrapShare,
                                                               kMinDefaultBootstrap, kMaxDefaultBootstrap)),
                         std::uint64_t{1}, kMaxBootstrap);
    checker.check(job.chains > 1 || !request.target_error, "--target-error", "a job of one chain",
                  "at least two chains, whose difference tells the error");
    checker.check(job.chains <= mutations, "--chains", std::to_string(job.chains),
                  "at most one chain a mutation, " + std::to_string(mutations));
    checker.finish();
  }
  return job;
}

}  // namespace mlt
