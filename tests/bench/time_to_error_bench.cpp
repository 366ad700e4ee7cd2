// Processor seconds until relMSE falls to the stated error, for every scene of scenes.txt and every
// integrator, against the references of 256 pixels; and samples or mutations a second on the way. Renders are
// made at half, once and twice the budget of the table and the time interpolated between them
// (converge/measure.hpp). Start it from the checkout's root, after `make scenes`.
#include <algorithm>
#include <stdexcept>
#include <thread>

#include "converge/measure.hpp"
#include "converge/statistics.hpp"
#include "row.hpp"
#include "scene/parse.hpp"
#include "scene_table.hpp"

namespace mlt::test {
namespace {

constexpr std::uint32_t kReplicatesOfAll = 3;
/// What is shared is time, not random numbers: two threads halve the wait and leave processor time alone.
constexpr std::uint32_t kMostThreads = 2;

/// About twice the stated error takes half the budget.
BenchScene quick_scene(BenchScene bench) {
  bench.stated_error *= 2;
  bench.path_samples /= 2;
  bench.mutations /= 2;
  return bench;
}

std::vector<std::uint64_t> levels_about(std::uint64_t budget) {
  std::vector<std::uint64_t> levels{std::max<std::uint64_t>(1, budget / 2)};
  if (!quick_bench()) levels.push_back(std::max(levels.back() + 1, budget));
  levels.push_back(std::max(levels.back() + 1, 2 * budget));
  return levels;
}

ConvergePlan plan_for(const BenchScene& bench, const Reference& reference) {
  ConvergePlan plan;
  plan.methods.resize(2);
  plan.methods[0].name = "path";
  plan.methods[0].settings.integrator = IntegratorKind::path;
  plan.methods[0].budgets = levels_about(bench.path_samples);
  plan.methods[1].name = "pssmlt";
  plan.methods[1].settings.integrator = IntegratorKind::pssmlt;
  plan.methods[1].budgets = levels_about(bench.mutations);
  plan.replicates = quick_bench() ? 1 : kReplicatesOfAll;
  plan.request.width = reference.image.width;
  plan.request.height = reference.image.height;
  plan.request.seed = kDefaultConvergeSeed;
  plan.request.threads = std::clamp(std::thread::hardware_concurrency(), 1U, kMostThreads);
  return plan;
}

struct Curve {
  std::vector<double> seconds, errors;
};

Curve curve_of(const ConvergeRun& run, std::size_t method, std::uint32_t replicate) {
  Curve curve;
  for (std::size_t level = 0; level < run.level_count; ++level) {
    curve.seconds.push_back(run.row(method, level, replicate).cpu_seconds);
    curve.errors.push_back(run.row(method, level, replicate).rel_mse);
  }
  return curve;
}

/// An error that lies beyond the budgets gives a bound, and the note says which.
BenchRow time_row(const ConvergeRun& run, std::size_t method, const BenchScene& bench) {
  BenchRow row{fmt::format("{} to relMSE {:g}", run.methods[method].name, bench.stated_error), bench.name,
               "s"};
  for (std::uint32_t replicate = 0; replicate < run.replicates; ++replicate) {
    const Curve curve = curve_of(run, method, replicate);
    const Crossing crossing = find_crossing(curve.seconds, curve.errors, bench.stated_error);
    switch (crossing.reach) {
      case Reach::kReached:
        row.readings.push_back(crossing.x);
        break;
      case Reach::kBeforeFirst:
        row.readings.push_back(curve.seconds.front());
        row.note = fmt::format("at most: {:.2g} with {} a pixel", curve.errors.front(),
                               run.methods[method].budgets.front());
        break;
      case Reach::kNever:
        row.readings.push_back(curve.seconds.back());
        row.note = fmt::format("more: {:.2g} with {} a pixel", curve.errors.back(),
                               run.methods[method].budgets.back());
    }
  }
  return row;
}

BenchRow rate_row(const ConvergeRun& run, std::size_t method, const BenchScene& bench) {
  const bool metropolis = run.methods[method].settings.integrator == IntegratorKind::pssmlt;
  BenchRow row{metropolis ? "PSSMLT mutations" : "path-tracer samples", bench.name, "M/s"};
  const double pixels = double{1} * run.width * run.height;
  for (std::uint32_t replicate = 0; replicate < run.replicates; ++replicate) {
    const Measurement& longest = run.row(method, run.level_count - 1, replicate);
    row.readings.push_back(1e-6 * pixels * static_cast<double>(longest.budget) / longest.cpu_seconds);
  }
  return row;
}

void measure_scene(const BenchScene& bench) {
  const SceneDescription scene = parse_scene_file(bench.file);
  const Reference reference = read_reference(kLargeReferences + bench.name + ".pfm");
  const ConvergePlan plan = plan_for(bench, reference);
  check_plan(scene, plan);
  const std::atomic<bool> stop{false};
  ConvergeRun run = measure(scene, plan, stop, {});
  score(run, &reference);
  for (std::size_t method = 0; method < run.methods.size(); ++method) {
    print_row(rate_row(run, method, bench));
    print_row(time_row(run, method, bench));
  }
}

int run() {
  for (const BenchScene& bench : read_bench_scenes()) {
    measure_scene(quick_bench() ? quick_scene(bench) : bench);
  }
  return 0;
}

}  // namespace
}  // namespace mlt::test

int main() {
  return mlt::test::run_bench(&mlt::test::run);
}
