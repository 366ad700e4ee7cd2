// The pilot that chooses an integrator: the comparison on pictures made by hand, the choice on scenes whose
// answer docs/RESULTS.md has measured, and the same finding from any number of threads and instruction set.
#include "render/pilot.hpp"

#include <catch2/catch.hpp>

#include "base/error.hpp"
#include "render_fixture.hpp"
#include "support/temporary_folder.hpp"

namespace mlt::test {
namespace {

ImageBuffer constant(std::uint32_t width, std::uint32_t height, float value) {
  return {width, height, std::vector<Vec3>(std::size_t{width} * height, Vec3{value, value, value})};
}

/// A picture of one radiance and one variance everywhere.
PilotRender flat(std::uint32_t side, float radiance, float variance, double per_pixel,
                 double primary_samples) {
  return {constant(side, side, radiance), constant(side, side, variance), per_pixel, primary_samples, true};
}

/// `integrator` is left to the pilot.
RenderRequest automatic(std::uint32_t width, std::uint32_t height, std::uint64_t samples_per_pixel) {
  RenderRequest request;
  request.integrator = IntegratorKind::automatic;
  request.width = width;
  request.height = height;
  request.samples_per_pixel = samples_per_pixel;
  request.threads = 1;
  return request;
}

PilotFinding find(const SceneDescription& scene, const RenderRequest& request) {
  const std::atomic<bool> stop = false;
  return run_pilot(scene, request, stop);
}

}  // namespace

TEST_CASE("the advantage is the quotient of variance times work") {
  // Of independent samples: relative variance times samples a pixel times primary samples a path. 0.85 is the
  // measured cost of a primary sample; values are read back from floats.
  const PilotRender path = flat(20, 2, 0.5f, 8, 30);
  const PilotRender chains = flat(60, 2, 0.25f, 4, 20);
  const double expected = (0.5 * 8 * 30) / (0.25 * 4 * 20 * 0.85);
  CHECK(pilot_advantage(path, chains) == Approx(expected).epsilon(1e-12));
  // Sides that are no multiples of each other: every pixel still counts, in means.
  CHECK(pilot_advantage(flat(7, 2, 0.5f, 8, 30), flat(60, 2, 0.25f, 4, 20)) ==
        Approx(expected).epsilon(1e-12));
  CHECK(pilot_advantage(flat(1, 2, 0.5f, 8, 30), flat(3, 2, 0.25f, 4, 20)) ==
        Approx(expected).epsilon(1e-12));
  // Four times the error of one.
  CHECK(pilot_advantage(flat(20, 2, 2, 8, 30), chains) == Approx(4 * expected).epsilon(1e-12));
  CHECK(pilot_advantage(path, flat(60, 2, 1, 4, 20)) == Approx(expected / 4).epsilon(1e-12));
  // No noise to get rid of.
  CHECK(pilot_advantage(flat(20, 2, 0, 8, 30), chains) == 0.0);
}

TEST_CASE("both errors are relative to one radiance, and a small lamp to its own") {
  // Were each divided by its own picture, twice the radiance would be a quarter of the error.
  const double even = pilot_advantage(flat(40, 1, 1, 1, 1), flat(40, 1, 1, 1, 1));
  CHECK(pilot_advantage(flat(40, 0.5f, 1, 1, 1), flat(40, 1.5f, 1, 1, 1)) == Approx(even).epsilon(1e-12));
  // A lamp of one pixel, 1e4 times as bright as all else, with as much relative noise in the path tracer's
  // picture: one pixel of 1600 more, and not 1e8 times one.
  PilotRender path = flat(40, 1, 1, 1, 1), chains = path;
  path.image.pixels[820] = chains.image.pixels[820] = Vec3{1e4f, 1e4f, 1e4f};
  path.variances.pixels[820] = Vec3{1e8f, 1e8f, 1e8f};
  // Its neighbours are dimmer than the mean around them then, in both pictures alike.
  CHECK(pilot_advantage(path, chains) < 3 * even);
  // The same pixel as a firefly, which the chains do not confirm, is an error, if not one of 1e8: the mean
  // over its 9 neighbours and both pictures has 1/18 of it.
  chains.image.pixels[820] = Vec3{1, 1, 1};
  CHECK(pilot_advantage(path, chains) > 1.15 * even);
}

TEST_CASE("the choice is that of the measurements, and the same from all threads and instruction sets") {
  const SceneDescription box = parse_scene_file("scenes/CornellBox.txt");
  RenderRequest request = automatic(64, 64, 256);
  const PilotFinding expected = find(box, request);
  CHECK(expected.outcome == PilotOutcome::compared);
  CHECK(expected.chosen == IntegratorKind::path);
  CHECK(expected.advantage > 0.0);
  CHECK(expected.advantage < 0.5);
  // A few per cent of the job, and never nothing.
  CHECK(expected.paths < 64 * 64 * 256 / 16);
  CHECK(expected.paths > 64 * 64 * 256 / 32);
  const auto check_same = [&] {
    const PilotFinding found = find(box, request);
    CHECK(found.chosen == expected.chosen);
    CHECK(found.advantage == expected.advantage);
    CHECK(describe(found) == describe(expected));
  };
  for (const std::uint32_t threads : {2U, 7U}) {
    request.threads = threads;
    check_same();
  }
  request.instruction_set = InstructionSet::base;
  check_same();
  // What only one of the two looks at does not matter to the other's pilot, nor do outer limits.
  request.chains = 3;
  request.bootstrap = 99;
  check_same();
  request.seed = 1;
  CHECK(find(box, request).advantage != expected.advantage);
}

TEST_CASE("chains are chosen where light turns two corners") {
  const SceneDescription corridor = parse_scene_file("scenes/corridor.txt");
  const PilotFinding found = find(corridor, automatic(256, 192, 24));
  CHECK(found.outcome == PilotOutcome::compared);
  CHECK(found.chosen == IntegratorKind::pssmlt);
  CHECK(found.advantage > 2 * kPilotThreshold);
  CHECK_THAT(describe(found), Catch::StartsWith("pssmlt: in a pilot of"));
}

TEST_CASE("light that is seen directly has no noise, and is path traced") {
  const PilotFinding found = find(parse_scene_file("scenes/conductor.txt"), automatic(128, 128, 64));
  CHECK(found.chosen == IntegratorKind::path);
}

TEST_CASE("there is no pilot where there is nothing to choose") {
  const SceneDescription box = parse_scene_file("scenes/CornellBox.txt");
  PilotFinding found = find(box, automatic(64, 64, 255));
  CHECK(found.outcome == PilotOutcome::too_small);
  CHECK((found.chosen == IntegratorKind::path && found.paths == 0));
  CHECK_THAT(describe(found), Catch::Contains("1048576"));
  // Rounds count.
  RenderRequest request = automatic(32, 32, 256);
  request.rounds = 4;
  CHECK(find(box, request).outcome == PilotOutcome::compared);
  request.max_per_pixel = 512;
  CHECK(find(box, request).outcome == PilotOutcome::too_small);
  found = find(box, automatic(2048, 2048, 1024));
  CHECK(found.outcome == PilotOutcome::too_large);
  CHECK(found.chosen == IntegratorKind::path);
  SceneDescription dark = parse_scene_text(
      "camera eye 0 0 0 target 0 0 1 up 0 1 0 fov 40\nmaterial m diffuse reflectance 0.5\n"
      "sphere 0 0 5 1 material m\n",
      "dark");
  found = find(dark, automatic(64, 64, 256));
  CHECK(found.outcome == PilotOutcome::no_light);
  CHECK(found.chosen == IntegratorKind::path);
  request = automatic(64, 64, 256);
  request.depth = 0;
  CHECK_THROWS_AS(find(box, request), InputError);
  const std::atomic<bool> stopped = true;
  found = run_pilot(box, automatic(64, 64, 256), stopped);
  CHECK((found.chosen == IntegratorKind::path && found.outcome == PilotOutcome::no_light));
}

TEST_CASE("primary samples are counted as the paths ask for them") {
  // In a closed diffuse room every path of two edges takes 2 of the film, 2 of a light, 2 of a direction, and
  // one more that chooses among several lights.
  const SceneDescription furnace = parse_scene_file("scenes/furnace.txt");
  for (const IntegratorKind kind : kIntegrators) {
    const RenderResult result = render(furnace, small_request(kind, 16, 8, 2));
    CHECK(result.statistics.primary_samples == 16 * 16 * 8 * 7);
  }
}

TEST_CASE("variances are the squares of standard errors before these are smoothed") {
  const SceneDescription box = parse_scene_file("scenes/CornellBox.txt");
  Renderer renderer(box, resolve_job(small_request(IntegratorKind::path, 1, 64, 4), box));
  renderer.prepare();
  const std::atomic<bool> stop = false;
  renderer.run(stop, nullptr, nullptr);
  const Vec3 error = renderer.standard_errors().pixels[0];
  for (int c = 0; c < 3; ++c) {
    CHECK(error[c] > 0);
    // Two roundings to float.
    CHECK(renderer.variances().pixels[0][c] == Approx(error[c] * error[c]).epsilon(1e-6));
  }
}

}  // namespace mlt::test
