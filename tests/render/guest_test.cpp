// A second job on a compiled scene, and a second run of a job: the same images as from renderers of their
// own.
#include <catch2/catch.hpp>

#include "render/worker_pool.hpp"
#include "render_fixture.hpp"

namespace mlt::test {
namespace {

struct Outcome {
  std::vector<Vec3> pixels;
  std::vector<Vec3> variances;
  RenderStatistics statistics;
};

Outcome run(Renderer& renderer) {
  const std::atomic<bool> stop{false};
  Outcome outcome;
  outcome.statistics = renderer.run(stop, nullptr, nullptr);
  const ImageView view = renderer.image();
  outcome.pixels.assign(view.pixels.begin(), view.pixels.end());
  for (std::size_t i = 0; i < outcome.pixels.size(); ++i) outcome.variances.push_back(renderer.variance(i));
  return outcome;
}

void check_same(const Outcome& a, const Outcome& b) {
  CHECK(a.pixels == b.pixels);
  CHECK(a.variances == b.variances);
  CHECK(a.statistics.film_hash == b.statistics.film_hash);
  CHECK(a.statistics.b == b.statistics.b);
  CHECK(a.statistics.samples == b.statistics.samples);
  CHECK(a.statistics.primary_samples == b.statistics.primary_samples);
}

RenderJob job_of(const SceneDescription& scene, IntegratorKind kind, std::uint64_t seed,
                 std::uint32_t roulette = 3) {
  RenderRequest request = small_request(kind, 24, 8, 6);
  request.seed = seed;
  request.roulette = roulette;
  request.threads = 3;
  return resolve_job(request, scene);
}

constexpr IntegratorKind kKinds[] = {IntegratorKind::path, IntegratorKind::pssmlt};

}  // namespace

TEST_CASE("a guest on the host's scene and threads renders what a renderer of its own does") {
  const SceneDescription box = parse_scene_file("scenes/CornellBox.txt");
  for (const IntegratorKind host_kind : kKinds) {
    for (const IntegratorKind guest_kind : kKinds) {
      CAPTURE(name_of(host_kind), name_of(guest_kind));
      Renderer host(box, job_of(box, host_kind, 1));
      host.prepare();
      Renderer guest(host, job_of(box, guest_kind, 2));
      guest.prepare();
      Renderer alone(box, job_of(box, guest_kind, 2));
      alone.prepare();
      const Outcome expected = run(alone);
      check_same(run(guest), expected);
      Renderer undisturbed(box, job_of(box, host_kind, 1));
      undisturbed.prepare();
      host.restart(1, 3);
      check_same(run(host), run(undisturbed));
      // Neither the scene nor stacks are planned twice.
      CHECK(guest.memory_plan().total_bytes() + 3 * sizeof(WorkerStack) <= alone.memory_plan().total_bytes());
    }
  }
}

TEST_CASE("a guest's film of another shape shows the host's whole view") {
  // Half of the view is bright, so is half of the film, whatever the shape of its pixels.
  const SceneDescription halves = parse_scene_text(
      "camera eye 0 0 0 target 0 0 1 up 0 1 0 fov 90\nmaterial m diffuse reflectance 0\n"
      "quad -9 9 2  9 9 2  9 0 2  -9 0 2  material m emit 1 1 1\n",
      "halves");
  RenderRequest request = small_request(IntegratorKind::path, 16, 4, 1);
  Renderer host(halves, resolve_job(request, halves));
  host.prepare();
  request.height = 6;
  request.threads = 1;
  Renderer guest(host, resolve_job(request, halves));
  guest.prepare();
  const std::vector<Vec3> pixels = run(guest).pixels;
  REQUIRE(pixels.size() == 16 * 6);
  for (std::size_t i = 0; i < pixels.size(); ++i) CHECK(pixels[i].x == (i < 16 * 3 ? 1.0f : 0.0f));
}

TEST_CASE("a restarted renderer renders what a new one does") {
  const SceneDescription box = parse_scene_file("scenes/CornellBox.txt");
  for (const IntegratorKind kind : kKinds) {
    CAPTURE(name_of(kind));
    Renderer again(box, job_of(box, kind, 1));
    again.prepare();
    const Outcome first = run(again);
    again.restart(2, 4);
    Renderer fresh(box, job_of(box, kind, 2, 4));
    fresh.prepare();
    check_same(run(again), run(fresh));
    again.restart(1, 3);
    check_same(run(again), first);
  }
}

TEST_CASE("a job may go without its film's hash") {
  const SceneDescription box = parse_scene_file("scenes/CornellBox.txt");
  for (const IntegratorKind kind : kKinds) {
    RenderJob job = job_of(box, kind, 1);
    job.hash_film = false;
    Renderer renderer(box, job);
    renderer.prepare();
    CHECK(run(renderer).statistics.film_hash.empty());
  }
}

TEST_CASE("a job may go without its error's estimate, and chains know their variances all the same") {
  const SceneDescription box = parse_scene_file("scenes/CornellBox.txt");
  for (const IntegratorKind kind : kKinds) {
    CAPTURE(name_of(kind));
    RenderJob job = job_of(box, kind, 1);
    Renderer with(box, job);
    with.prepare();
    const Outcome expected = run(with);
    REQUIRE(expected.statistics.error.known);
    job.estimate_error = false;
    Renderer without(box, job);
    without.prepare();
    const Outcome found = run(without);
    CHECK_FALSE(found.statistics.error.known);
    CHECK(found.statistics.film_hash == expected.statistics.film_hash);
    if (kind == IntegratorKind::pssmlt) CHECK(found.variances == expected.variances);
  }
}

}  // namespace mlt::test
