#include "converge/measure.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/assert.hpp"
#include "base/error.hpp"
#include "compare/compare.hpp"
#include "render/pilot.hpp"
#include "render/renderer.hpp"

namespace mlt {
namespace {

struct Rendered {
  RenderJob job;
  RenderStatistics statistics;
  ImageBuffer image;
};

/// Nothing when it was stopped.
std::optional<Rendered> render_once(const SceneDescription& scene, const RenderRequest& request,
                                    const std::atomic<bool>& stop) {
  Rendered result;
  RenderRequest settled = request;
  PilotFinding pilot;
  if (request.integrator == IntegratorKind::automatic) {
    pilot = run_pilot(scene, request, stop);
    settled = decided(request, pilot);
  }
  result.job = resolve_job(settled, scene);
  Renderer renderer(scene, result.job);
  renderer.prepare();
  result.statistics = renderer.run(stop, nullptr, nullptr);
  result.statistics.wall_seconds += pilot.wall_seconds;
  result.statistics.cpu_seconds += pilot.cpu_seconds;
  result.statistics.samples += pilot.paths;
  if (result.statistics.partial || stop) return std::nullopt;
  const ImageView view = renderer.image();
  result.image = {view.width, view.height, {view.pixels.begin(), view.pixels.end()}};
  return result;
}

/// What a request may end up with.
std::vector<IntegratorKind> candidates(IntegratorKind kind) {
  if (kind != IntegratorKind::automatic) return {kind};
  return {IntegratorKind::path, IntegratorKind::pssmlt};
}

struct Trial {
  double budget;
  double seconds;
};

/// The budget that takes `seconds`: between trials on a straight line, since a bootstrap makes time an affine
/// function of the budget; beyond the last, which only the largest budget leaves, in proportion.
std::uint64_t budget_for(const std::vector<Trial>& trials, double seconds) {
  std::size_t at = 0;
  while (at < trials.size() && trials[at].seconds < seconds) ++at;
  double budget = trials.front().budget;
  if (at == trials.size()) {
    budget = trials.back().budget * seconds / trials.back().seconds;
  } else if (at > 0) {
    const Trial& below = trials[at - 1];
    const double share = (seconds - below.seconds) / (trials[at].seconds - below.seconds);
    budget = below.budget + share * (trials[at].budget - below.budget);
  }
  const double most = static_cast<double>(kMaxSamplesPerPixel);
  return static_cast<std::uint64_t>(std::clamp(std::floor(budget + 0.5), 1.0, most));
}

/// The sum of squared differences of all pixels and channels, plain and divided by base^2 + 0.01.
struct Squares {
  double plain = 0;
  double relative = 0;
};

Squares squares_of(const ImageBuffer& image, const ImageBuffer& centre, const ImageBuffer& base) {
  Squares squares;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    for (int channel = 0; channel < 3; ++channel) {
      const double difference =
          static_cast<double>(image.pixels[i][channel]) - static_cast<double>(centre.pixels[i][channel]);
      const double scale = base.pixels[i][channel];
      squares.plain += difference * difference;
      squares.relative += difference * difference / (scale * scale + kRelMseOffset);
    }
  }
  return squares;
}

ImageBuffer mean_of_images(const ConvergeRun& run, const std::vector<std::size_t>& indices) {
  ImageBuffer mean{run.width, run.height, std::vector<Vec3>(run.images[indices[0]].pixels.size())};
  for (std::size_t i = 0; i < mean.pixels.size(); ++i) {
    double sum[3] = {0, 0, 0};
    for (const std::size_t index : indices) {
      for (int channel = 0; channel < 3; ++channel) sum[channel] += run.images[index].pixels[i][channel];
    }
    for (int channel = 0; channel < 3; ++channel) {
      mean.pixels[i][channel] = static_cast<float>(sum[channel] / static_cast<double>(indices.size()));
    }
  }
  return mean;
}

void score_without_reference(ConvergeRun& run) {
  MLT_CHECK_OP(run.replicates, >=, 2u);
  const ImageBuffer base = base_image(run, nullptr);
  const double n = run.replicates;
  const double count = 3.0 * static_cast<double>(base.pixels.size());
  for (std::size_t method = 0; method < run.methods.size(); ++method) {
    for (std::size_t level = 0; level < run.level_count; ++level) {
      const ImageBuffer centre = mean_image(run, method, level);
      for (std::uint32_t replicate = 0; replicate < run.replicates; ++replicate) {
        const std::size_t index = run.index(method, level, replicate);
        const Squares squares = squares_of(run.images[index], centre, base);
        run.rows[index].mse = squares.plain / count * (n / (n - 1));
        run.rows[index].rel_mse = run.rows[index].rel_mse_raw = squares.relative / count * (n / (n - 1));
      }
    }
  }
}

std::uint64_t image_bytes(const ConvergePlan& plan, const RenderJob& job) {
  // At most 2^6 levels, 2^12 replicates, 2^32 pixels of 2^4 bytes and a few methods: below 2^60.
  return std::uint64_t{plan.methods.size()} * plan.level_count() * plan.replicates * job.width * job.height *
         sizeof(Vec3);
}

}  // namespace

RenderRequest ConvergePlan::request_of(std::size_t method, std::size_t level, std::uint32_t replicate) const {
  RenderRequest result = request;
  static_cast<MethodRequest&>(result) = methods[method].settings;
  result.samples_per_pixel = methods[method].budgets[level];
  result.seed = seed_of(replicate, level);
  return result;
}

void check_plan(const SceneDescription& scene, const ConvergePlan& plan) {
  RenderJob job;
  for (std::size_t method = 0; method < plan.methods.size(); ++method) {
    MLT_CHECK_OP(plan.methods[method].budgets.size(), ==, plan.level_count());
    for (std::size_t level = 0; level < plan.level_count(); ++level) {
      RenderRequest request = plan.request_of(method, level, 0);
      try {
        for (const IntegratorKind kind : candidates(request.integrator)) {
          request.integrator = kind;
          job = resolve_job(request, scene);
          const Renderer renderer(scene, job);
        }
      } catch (const ResourceError& error) {
        throw ResourceError("budget " + std::to_string(*request.samples_per_pixel) + " of " +
                            plan.methods[method].name + ": " + error.what());
      }
    }
  }
  const std::uint64_t bytes = image_bytes(plan, job);
  if (bytes <= job.memory_limit) return;
  throw ResourceError("--memory: the images of " + std::to_string(plan.replicates) + " replicates take " +
                      std::to_string(bytes) + " bytes and the limit is " + std::to_string(job.memory_limit) +
                      "; take fewer --replicates or a smaller --width and --height");
}

bool budgets_for_times(const SceneDescription& scene, const std::vector<double>& times, ConvergePlan& plan,
                       const std::atomic<bool>& stop) {
  constexpr double kShortest = 1e-6;  // a clock's tick
  for (ConvergeMethod& method : plan.methods) {
    RenderRequest request = plan.request;
    static_cast<MethodRequest&>(request) = method.settings;
    std::vector<Trial> trials;
    for (std::uint64_t budget = 1; budget <= kMaxSamplesPerPixel; budget *= 2) {
      request.samples_per_pixel = budget;
      const std::optional<Rendered> rendered = render_once(scene, request, stop);
      if (!rendered) return false;
      // The clock is noisy, and times must increase for the lines between them.
      const double floor = trials.empty() ? kShortest : trials.back().seconds * 1.0001;
      trials.push_back({static_cast<double>(budget), std::max(rendered->statistics.wall_seconds, floor)});
      if (trials.back().seconds >= times.back()) break;
    }
    for (const double seconds : times) method.budgets.push_back(budget_for(trials, seconds));
  }
  return true;
}

ConvergeRun measure(const SceneDescription& scene, const ConvergePlan& plan, const std::atomic<bool>& stop,
                    const ReplicateCallback& progress) {
  ConvergeRun run;
  run.methods = plan.methods;
  run.level_count = plan.level_count();
  const std::size_t count = plan.methods.size();
  const auto make_replicate = [&](std::uint32_t replicate) {
    for (std::size_t level = 0; level < run.level_count; ++level) {
      for (std::size_t turn = 0; turn < count; ++turn) {
        const std::size_t method = (turn + replicate) % count;
        std::optional<Rendered> rendered =
            render_once(scene, plan.request_of(method, level, replicate), stop);
        if (!rendered) return false;
        const RenderStatistics& statistics = rendered->statistics;
        Measurement& row = run.rows[run.index(method, level, replicate)];
        row = {method,
               level,
               replicate,
               plan.methods[method].budgets[level],
               plan.seed_of(replicate, level),
               statistics.samples,
               statistics.wall_seconds,
               statistics.cpu_seconds,
               statistics.film_hash};
        run.width = rendered->job.width;
        run.height = rendered->job.height;
        run.depth = rendered->job.depth;
        run.threads = rendered->job.threads;
        run.images[run.index(method, level, replicate)] = std::move(rendered->image);
      }
    }
    return true;
  };
  // Not counted: the first render of a process also pays for reading the program and waking the processor.
  run.interrupted = !render_once(scene, plan.request_of(0, 0, 0), stop);
  while (!run.interrupted && run.replicates < plan.replicates) {
    const std::size_t rows = (run.replicates + std::size_t{1}) * run.level_count * count;
    run.rows.resize(rows);
    run.images.resize(rows);
    run.interrupted = !make_replicate(run.replicates);
    if (run.interrupted) break;
    ++run.replicates;
    if (progress) progress(run.replicates);
  }
  run.rows.resize(run.replicates * run.level_count * count);
  run.images.resize(run.rows.size());
  return run;
}

void score(ConvergeRun& run, const Reference* reference) {
  for (std::size_t i = 0; i < run.rows.size(); ++i) {
    const ImageView image = run.images[i].view();
    const std::string name =
        run.methods[run.rows[i].method].name + " with seed " + std::to_string(run.rows[i].seed);
    const ImageView other = reference != nullptr ? reference->image.view() : image;
    require_comparable(name, image, reference != nullptr ? reference->path : name, other);
    run.rows[i].mean = mean_of_image(image);
    if (reference == nullptr) continue;
    const Squares squares = squares_of(run.images[i], reference->image, reference->image);
    const double count = 3.0 * static_cast<double>(image.pixels.size());
    run.rows[i].mse = squares.plain / count;
    run.rows[i].rel_mse_raw = squares.relative / count;
    run.rows[i].rel_mse = run.rows[i].rel_mse_raw - reference->own_rel_mse;
  }
  if (reference == nullptr) score_without_reference(run);
}

ImageBuffer mean_image(const ConvergeRun& run, std::size_t method, std::size_t level) {
  std::vector<std::size_t> indices;
  for (std::uint32_t i = 0; i < run.replicates; ++i) indices.push_back(run.index(method, level, i));
  return mean_of_images(run, indices);
}

ImageBuffer base_image(const ConvergeRun& run, const Reference* reference) {
  if (reference != nullptr) return reference->image;
  std::vector<std::size_t> indices;
  for (std::size_t method = 0; method < run.methods.size(); ++method) {
    for (std::uint32_t i = 0; i < run.replicates; ++i) {
      indices.push_back(run.index(method, run.level_count - 1, i));
    }
  }
  return mean_of_images(run, indices);
}

}  // namespace mlt
