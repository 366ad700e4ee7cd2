// Microseconds of one core per path-tracer sample and per PSSMLT mutation on the Cornell box and the mesh
// scene, nanoseconds of a mutation of 30 primary samples and of a splat, and the speed-up of two threads.
// Medians of interleaved runs. Start it from the checkout's root, after `make scenes`.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "film/fixed_film.hpp"
#include "markov/primary_samples.hpp"
#include "render/renderer.hpp"
#include "scene/parse.hpp"

namespace mlt {
namespace {

constexpr int kRuns = 5;

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// A measurement: its unit, and a function that returns one reading.
struct Row {
  std::string name;
  std::string unit;
  std::function<double()> measure;
  std::vector<double> readings = {};
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

struct Job {
  const SceneDescription* scene;
  IntegratorKind integrator;
  std::uint32_t side;
  std::uint64_t samples;
  std::uint32_t threads;
  InstructionSet set;
};

RenderStatistics render(const Job& job) {
  RenderRequest request;
  request.integrator = job.integrator;
  request.width = request.height = job.side;
  request.samples_per_pixel = job.samples;
  request.depth = 5;
  request.threads = job.threads;
  request.instruction_set = job.set;
  Renderer renderer(*job.scene, resolve_job(request, *job.scene));
  renderer.prepare();
  const std::atomic<bool> stop{false};
  return renderer.run(stop, nullptr, nullptr);
}

/// Processor microseconds per sample or mutation; the bootstrap, a tenth as many paths, is a part of the
/// mutations.
double microseconds_each(const Job& job) {
  const RenderStatistics statistics = render(job);
  const std::uint64_t units =
      job.integrator == IntegratorKind::pssmlt ? statistics.mutations : statistics.samples;
  return 1e6 * statistics.cpu_seconds / static_cast<double>(units);
}

double mutation_nanoseconds() {
  constexpr std::uint32_t kSamples = 30;
  constexpr int kSteps = 200000;
  std::vector<PrimarySample> samples(kSamples);
  std::vector<SavedSample> saved(kSamples);
  PrimarySampleVector vector(
      samples, saved, Rng(1, StreamPurpose::kTest, 0),
      StepSource(BlockRng(1, StreamPurpose::kTest, 1), &Mutation<MutationKind::kelemen>::fill<BlockRng>, 1));
  std::uint32_t sum = 0;
  const double begin = seconds_now();
  for (int step = 0; step < kSteps; ++step) {
    vector.begin_proposal(step % 64 == 0);
    for (std::uint32_t i = 0; i < kSamples; ++i) sum += vector.next_fixed();
    vector.accept();
  }
  const double seconds = seconds_now() - begin;
  // The sum keeps the loop from being removed.
  return sum == 1 ? 0.0 : 1e9 * seconds / kSteps;
}

/// One draw of the scalar generator, each of which waits for the one before: a measure of the core's clock.
double draw_nanoseconds() {
  constexpr int kDraws = 5000000;
  Rng rng(1, StreamPurpose::kTest, 2);
  std::uint32_t sum = 0;
  const double begin = seconds_now();
  for (int i = 0; i < kDraws; ++i) sum ^= rng.next_fixed();
  const double seconds = seconds_now() - begin;
  return sum == 1 ? 0.0 : 1e9 * seconds / kDraws;
}

double splat_nanoseconds() {
  constexpr int kSplats = 2000000;
  std::vector<FilmPixel> pixels(256 * 256);
  FixedFilm film(pixels, 32);
  Rng rng(1, StreamPurpose::kTest, 1);
  const double begin = seconds_now();
  for (int i = 0; i < kSplats; ++i) film.splat(rng.next_fixed() >> 16, Vec3{0.5f, 0.25f, 0.125f}, 0.5, 0.0);
  const double seconds = seconds_now() - begin;
  return 1e9 * seconds / kSplats;
}

void add_renders(std::vector<Row>& rows, const std::string& name, const SceneDescription& scene) {
  for (std::uint8_t set = 0; set <= static_cast<std::uint8_t>(best_instruction_set()); ++set) {
    const auto instruction_set = static_cast<InstructionSet>(set);
    const std::string suffix = set == 0 ? ", base" : ", AVX2";
    const Job path{&scene, IntegratorKind::path, 128, 16, 1, instruction_set};
    const Job metropolis{&scene, IntegratorKind::pssmlt, 128, 32, 1, instruction_set};
    rows.push_back(
        {name + ", path-tracer sample" + suffix, "us", [path] { return microseconds_each(path); }});
    rows.push_back(
        {name + ", PSSMLT mutation" + suffix, "us", [metropolis] { return microseconds_each(metropolis); }});
  }
}

int run() {
  const SceneDescription box = parse_scene_file("scenes/CornellBox.txt");
  const SceneDescription mesh = parse_scene_file("build/scenes/mesh.txt");
  std::vector<Row> rows;
  add_renders(rows, "Cornell box, depth 5", box);
  add_renders(rows, "mesh, depth 5", mesh);
  rows.push_back({"mutation of 30 primary samples", "ns", &mutation_nanoseconds});
  rows.push_back({"draw of the scalar generator", "ns", &draw_nanoseconds});
  rows.push_back({"splat at a random pixel", "ns", &splat_nanoseconds});
  const Job one{&box, IntegratorKind::pssmlt, 256, 32, 1, best_instruction_set()};
  rows.push_back({"two threads over one, Cornell box", "x", [one] {
                    Job two = one;
                    two.threads = 2;
                    const double alone = render(one).wall_seconds;
                    return alone / render(two).wall_seconds;
                  }});
  for (int i = 0; i < kRuns; ++i) {
    for (Row& row : rows) row.readings.push_back(row.measure());
  }
  std::printf("%-44s %10s %10s %10s\n", "", "median", "min", "max");
  for (const Row& row : rows) {
    const auto [least, greatest] = std::minmax_element(row.readings.begin(), row.readings.end());
    std::printf("%-44s %10.3f %10.3f %10.3f %s\n", row.name.c_str(), median(row.readings), *least, *greatest,
                row.unit.c_str());
  }
  return 0;
}

}  // namespace
}  // namespace mlt

int main() {
  try {
    return mlt::run();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
