// The pilot that chooses an integrator: the comparison on pictures made by hand, the choice on scenes whose
// answer docs/RESULTS.md has measured, and the same finding from any number of threads and instruction set.
#include "render/pilot.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "base/error.hpp"
#include "film/pixel_film.hpp"
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
  return {constant(side, side, radiance),
          constant(side, side, variance),
          per_pixel,
          10,
          10 * primary_samples,
          true};
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

std::string line(const SceneDescription& scene, const RenderRequest& request, const PilotFinding& found) {
  return describe(found, resolve_job(decided(request, found), scene));
}

}  // namespace

TEST_CASE("the advantage is the quotient of variance times work") {
  // Of independent samples: relative variance times samples a pixel times primary samples a path, of which
  // one takes PSSMLT 1.1 times as long. Values are read back from floats.
  const PilotRender path = flat(20, 2, 0.5f, 8, 30);
  const PilotRender chains = flat(20, 2, 0.25f, 4, 20);
  const double expected = (0.5 * 8 * 30) / (0.25 * 4 * 20 * 1.1);
  CHECK(pilot_advantage(path, chains) == Approx(expected).epsilon(1e-12));
  // Of films less wide than the means that radiance is taken from, too.
  CHECK(pilot_advantage(flat(7, 2, 0.5f, 8, 30), flat(7, 2, 0.25f, 4, 20)) ==
        Approx(expected).epsilon(1e-12));
  CHECK(pilot_advantage(flat(1, 2, 0.5f, 8, 30), flat(1, 2, 0.25f, 4, 20)) ==
        Approx(expected).epsilon(1e-12));
  // Four times the error of one.
  CHECK(pilot_advantage(flat(20, 2, 2, 8, 30), chains) == Approx(4 * expected).epsilon(1e-12));
  CHECK(pilot_advantage(path, flat(20, 2, 1, 4, 20)) == Approx(expected / 4).epsilon(1e-12));
  // With several lobes a primary sample of PSSMLT takes 1.4 times as long, and its error is 1.5 times what
  // pilots see.
  CHECK(pilot_advantage(path, chains, true) == Approx(expected * 1.1 / (1.4 * 1.5)).epsilon(1e-12));
  // No noise to get rid of.
  CHECK(pilot_advantage(flat(20, 2, 0, 8, 30), chains) == 0.0);
}

TEST_CASE("errors of two settings are compared after the same number of paths") {
  CHECK(pilot_error_ratio(flat(20, 2, 0.5f, 8, 30), flat(20, 2, 0.25f, 8, 60)) == Approx(2).epsilon(1e-12));
  // Neither makes any: nothing speaks for one of them.
  CHECK(pilot_error_ratio(flat(20, 2, 0, 8, 30), flat(20, 2, 0, 8, 60)) == 1.0);
}

TEST_CASE("both errors are relative to one radiance, and a small lamp to its own") {
  // Were each divided by its own picture, twice the radiance would be a quarter of the error.
  const double even = pilot_advantage(flat(40, 1, 1, 1, 1), flat(40, 1, 1, 1, 1));
  CHECK(pilot_advantage(flat(40, 0.5f, 1, 1, 1), flat(40, 1.5f, 1, 1, 1)) == Approx(even).epsilon(1e-12));
  // Lamps of one pixel each, 1e4 times as bright as all else, with as much relative noise in the path
  // tracer's picture: ten pixels of 3600 more, and not 1e8 times ten.
  PilotRender path = flat(60, 1, 1, 1, 1), chains = path;
  const auto place = [](ImageBuffer& image, std::size_t count, float value) {
    for (std::size_t i = 0; i < count; ++i) image.pixels[620 + 250 * i] = Vec3{value, value, value};
  };
  place(path.image, 10, 1e4f);
  place(chains.image, 10, 1e4f);
  place(path.variances, 10, 1e8f);
  const double lamps = pilot_advantage(path, chains);
  // Around them the mean is bright, for both alike, so that few other pixels count.
  CHECK(lamps < 10 * even);
  // As fireflies, which the chains do not confirm, they are errors.
  place(chains.image, 10, 1);
  CHECK(pilot_advantage(path, chains) > 10 * lamps);
  // A single one is left out, one in 2000 of all values, and hardly moves anything.
  PilotRender lucky = flat(60, 1, 1, 1, 1);
  const PilotRender calm = lucky;
  place(lucky.image, 1, 1e4f);
  place(lucky.variances, 1, 1e8f);
  CHECK(pilot_advantage(lucky, calm) == Approx(even).epsilon(0.05));
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
  CHECK(expected.paths > 64 * 64 * 256 / 64);
  const auto check_same = [&] {
    const PilotFinding found = find(box, request);
    CHECK(found.chosen == expected.chosen);
    CHECK(found.advantage == expected.advantage);
    CHECK(line(box, request, found) == line(box, request, expected));
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
  const RenderRequest request = automatic(256, 192, 24);
  const PilotFinding found = find(corridor, request);
  CHECK(found.outcome == PilotOutcome::compared);
  CHECK(found.chosen == IntegratorKind::pssmlt);
  CHECK(found.advantage > 2 * kPilotThreshold);
  const std::string text = line(corridor, request, found);
  CHECK_THAT(text, Catch::StartsWith("pssmlt: in a pilot of"));
  CHECK_THAT(text, Catch::EndsWith("; 256 chains and a bootstrap of 117964 paths, by the job's size"));
  // Not deeper than the edge at which roulette begins.
  CHECK(!found.roulette);
}

TEST_CASE("deep jobs are tried with roulette from an early edge too") {
  // Of a bright room most light has been seen after 8 edges; what comes out of a corridor took more
  // (docs/RESULTS.md).
  const SceneDescription box = parse_scene_file("scenes/CornellBox.txt");
  RenderRequest request = automatic(128, 128, 32);
  request.depth = 64;
  PilotFinding found = find(box, request);
  CHECK(found.chosen == IntegratorKind::path);
  REQUIRE(found.roulette);
  CHECK(*found.roulette == kEarlyRouletteEdge);
  CHECK(found.early_roulette_error < kEarlyRouletteThreshold);
  CHECK_THAT(line(box, request, found),
             Catch::Contains("; roulette from edge 8: path's error from edge 8 was"));
  CHECK(resolve_job(decided(request, found), box).roulette == kEarlyRouletteEdge);
  request.roulette = 16;
  found = find(box, request);
  CHECK(!found.roulette);
  CHECK(resolve_job(decided(request, found), box).roulette == 16);

  const SceneDescription corridor = parse_scene_file("scenes/corridor.txt");
  request = automatic(128, 96, 64);
  request.depth = 64;
  found = find(corridor, request);
  REQUIRE(found.roulette);
  CHECK(*found.roulette == kDefaultRouletteEdge);
  CHECK(found.early_roulette_error > kEarlyRouletteThreshold);
}

TEST_CASE("a choice that is not clear takes a second round") {
  // The advantage is about 1 here (docs/RESULTS.md). A round takes 1/144 and 1/72 of the work, and an eighth
  // of the latter for the bootstrap. The path tracer's film is rounded down to whole pixels, a 16th of which
  // and those at its edges have two sequences of samples.
  const SceneDescription spheres = parse_scene_file("scenes/spheres.txt");
  const double one_round = 128.0 * 128 * 64 * (1.08 / 144 + 1.125 / 72);
  int second = 0;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    RenderRequest request = automatic(128, 128, 64);
    request.seed = seed;
    const PilotFinding found = find(spheres, request);
    CHECK(found.outcome == PilotOutcome::compared);
    CHECK(found.chosen == (found.advantage > 1 ? IntegratorKind::pssmlt : IntegratorKind::path));
    const double rounds = static_cast<double>(found.paths) / one_round;
    CHECK((std::abs(rounds - 1) < 0.01 || std::abs(rounds - 2) < 0.02));
    // One that was clear at once says so.
    if (rounds < 1.5) CHECK((found.advantage > 1.5 || found.advantage < 1 / 1.2));
    if (rounds > 1.5) ++second;
  }
  CHECK(second > 0);
  CHECK(second < 8);
}

TEST_CASE("light that is seen directly has no noise, and is path traced") {
  const PilotFinding found = find(parse_scene_file("scenes/conductor.txt"), automatic(128, 128, 64));
  CHECK(found.chosen == IntegratorKind::path);
}

TEST_CASE("there is no pilot where there is nothing to choose") {
  const SceneDescription box = parse_scene_file("scenes/CornellBox.txt");
  PilotFinding found = find(box, automatic(64, 64, 127));
  CHECK(found.outcome == PilotOutcome::too_small);
  CHECK((found.chosen == IntegratorKind::path && found.paths == 0));
  CHECK_THAT(line(box, automatic(64, 64, 127), found), Catch::Contains("524288"));
  // Rounds count.
  RenderRequest request = automatic(32, 32, 128);
  request.rounds = 4;
  CHECK(find(box, request).outcome == PilotOutcome::compared);
  request.max_per_pixel = 511;
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
  const RenderResult path = render(furnace, small_request(IntegratorKind::path, 16, 8, 2));
  CHECK(path.statistics.primary_samples == sequences_in_film(16, 16) * 8 * 7);
  const RenderResult chains = render(furnace, small_request(IntegratorKind::pssmlt, 16, 8, 2));
  CHECK(chains.statistics.primary_samples == 16 * 16 * 8 * 7);
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
    CHECK(renderer.variance(0)[c] == Approx(error[c] * error[c]).epsilon(1e-6));
  }
}

}  // namespace mlt::test
