// Path-tracer samples and PSSMLT mutations a second of one core on the Cornell box and the mesh scene, with
// the memory of both; nanoseconds of a mutation of 30 primary samples, of a splat, of summing and developing
// a pixel; and the speed-up of two threads. Start it from the checkout's root, after `make scenes`.
#include <cstdio>
#include <string>
#include <vector>

#include "film/fixed_film.hpp"
#include "markov/primary_samples.hpp"
#include "render/renderer.hpp"
#include "row.hpp"
#include "scene/parse.hpp"

namespace mlt::test {
namespace {

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

/// Millions of samples or mutations a processor second; the bootstrap, a tenth as many paths, is a part of
/// the mutations.
double millions_a_second(const Job& job) {
  const RenderStatistics statistics = render(job);
  const std::uint64_t units =
      job.integrator == IntegratorKind::pssmlt ? statistics.mutations : statistics.samples;
  return 1e-6 * static_cast<double>(units) / statistics.cpu_seconds;
}

double mutation_nanoseconds() {
  constexpr std::uint32_t kSamples = 30;
  constexpr int kSteps = 200000;
  using F = WideFloat;
  std::vector<PrimarySampleOf<F>> samples(kSamples);
  std::vector<ProposedSampleOf<F>> saved(kSamples);
  PrimarySampleVectorOf<F> vector(samples, saved, make_steps_of<F>(MutationKind::kelemen), 1);
  for (int lane = 0; lane < kWideLanes; ++lane) {
    const auto index = static_cast<std::uint64_t>(lane);
    vector.set_lane(lane, Rng(1, StreamPurpose::kTest, index));
  }
  UintOf<F> sum{};
  const double begin = cpu_seconds();
  for (int step = 0; step < kSteps; ++step) {
    // Large steps are not simultaneous in all lanes.
    vector.begin_proposal(one_lane<F>(step % kWideLanes) &
                          first_lanes<F>(step % 64 < kWideLanes ? kWideLanes : 0));
    for (std::uint32_t i = 0; i < kSamples; ++i) sum += vector.next_fixed();
    vector.accept();
  }
  const double seconds = cpu_seconds() - begin;
  // The sum keeps the loop from being removed.
  return sum[0] == 1 ? 0.0 : 1e9 * seconds / kSteps / kWideLanes;
}

/// One draw of the scalar generator, each of which waits for the one before: a measure of the core's clock.
double draw_nanoseconds() {
  constexpr int kDraws = 5000000;
  Rng rng(1, StreamPurpose::kTest, 2);
  std::uint32_t sum = 0;
  const double begin = cpu_seconds();
  for (int i = 0; i < kDraws; ++i) sum ^= rng.next_fixed();
  const double seconds = cpu_seconds() - begin;
  return sum == 1 ? 0.0 : 1e9 * seconds / kDraws;
}

double splat_nanoseconds() {
  constexpr int kSplats = 2000000;
  std::vector<FilmPixel> pixels(256 * 256);
  FixedFilm film(pixels, 32);
  Rng rng(1, StreamPurpose::kTest, 1);
  const double begin = cpu_seconds();
  for (int i = 0; i < kSplats; ++i) film.splat(rng.next_fixed() >> 16, Vec3{0.5f, 0.25f, 0.125f}, 0.5, 0.0);
  const double seconds = cpu_seconds() - begin;
  return 1e9 * seconds / kSplats;
}

constexpr std::size_t kFilmPixels = 256 * 256;

double film_sum_nanoseconds() {
  std::vector<FilmPixel> sum(kFilmPixels), source(kFilmPixels);
  const double begin = cpu_seconds();
  add_films(sum, source, 0, kFilmPixels);
  return 1e9 * (cpu_seconds() - begin) / kFilmPixels;
}

double develop_nanoseconds() {
  const std::vector<FilmPixel> film(kFilmPixels);
  std::vector<Vec3> image(kFilmPixels);
  const double begin = cpu_seconds();
  develop_film(film, {1.0, 1.0, 1000000, 32}, image, 0, kFilmPixels);
  return 1e9 * (cpu_seconds() - begin) / kFilmPixels;
}

void add_rates(std::vector<BenchRow>& rows, const std::string& name, const SceneDescription& scene) {
#define MLT_ENUMERATE(set, help, condition) InstructionSet::set,
  constexpr InstructionSet kSets[] = {MLT_INSTRUCTION_SETS(MLT_ENUMERATE)};
#undef MLT_ENUMERATE
  for (const InstructionSet set : kSets) {
    if (!is_supported(set)) continue;
    const char* const set_name = instruction_set_name(set);
    const Job path{&scene, IntegratorKind::path, 128, 16, 1, set};
    const Job metropolis{&scene, IntegratorKind::pssmlt, 128, 32, 1, set};
    rows.push_back({fmt::format("path-tracer samples ({})", set_name), name, "M/s",
                    [path] { return millions_a_second(path); }});
    rows.push_back({fmt::format("PSSMLT mutations ({})", set_name), name, "M/s",
                    [metropolis] { return millions_a_second(metropolis); }});
  }
}

/// Of the whole arena, by one thread.
double arena_megabytes(const SceneDescription& scene, IntegratorKind integrator) {
  RenderRequest request;
  request.integrator = integrator;
  request.width = request.height = 256;
  request.threads = 1;
  return 1e-6 * static_cast<double>(Renderer(scene, resolve_job(request, scene)).memory_plan().total_bytes());
}

void add_memory(std::vector<BenchRow>& rows, const std::string& name, const SceneDescription& scene) {
  rows.push_back({"arena of the path tracer (256x256)", name, "MB",
                  [&scene] { return arena_megabytes(scene, IntegratorKind::path); }});
  rows.push_back({"arena of PSSMLT (256x256)", name, "MB",
                  [&scene] { return arena_megabytes(scene, IntegratorKind::pssmlt); }});
}

int run() {
  const SceneDescription box = parse_scene_file("scenes/CornellBox.txt");
  const SceneDescription mesh = parse_scene_file("build/scenes/mesh.txt");
  std::vector<BenchRow> rows;
  add_rates(rows, "CornellBox (depth 5)", box);
  add_rates(rows, "mesh (depth 5)", mesh);
  add_memory(rows, "CornellBox", box);
  add_memory(rows, "mesh", mesh);
  rows.push_back({"mutation of 30 primary samples", "-", "ns", &mutation_nanoseconds});
  rows.push_back({"dependent draw of a random number", "-", "ns", &draw_nanoseconds});
  rows.push_back({"splat at a random pixel", "film of 256x256", "ns", &splat_nanoseconds});
  rows.push_back({"sum of two films a pixel", "film of 256x256", "ns", &film_sum_nanoseconds});
  rows.push_back({"development a pixel", "film of 256x256", "ns", &develop_nanoseconds});
  const Job one{&box, IntegratorKind::pssmlt, 256, 32, 1, best_instruction_set()};
  rows.push_back({"wall time of one thread over two", "CornellBox (depth 5)", "x", [one] {
                    Job two = one;
                    two.threads = 2;
                    const double alone = render(one).wall_seconds;
                    return alone / render(two).wall_seconds;
                  }});
  measure_rows(rows, quick_bench() ? 2 : 5);
  return 0;
}

}  // namespace
}  // namespace mlt::test

int main() {
  return mlt::test::run_bench(&mlt::test::run);
}
