// Rounds: the same image however they were ended, and by any number of threads; and the estimated error
// against the true one.
#include <catch2/catch.hpp>

#include "base/error.hpp"
#include "render_fixture.hpp"

namespace mlt::test {
namespace {

RenderRequest round_request(IntegratorKind kind) {
  RenderRequest request;
  request.integrator = kind;
  request.width = request.height = 32;
  request.samples_per_pixel = 16;
  request.depth = 5;
  request.threads = 2;
  request.bootstrap = 4096;
  request.chains = 16;
  return request;
}

}  // namespace

TEST_CASE("a job that ends by its error gives the film of as many rounds, on any number of threads") {
  const SceneDescription scene = parse_scene_file("scenes/CornellBox.txt");
  for (const IntegratorKind kind : kIntegrators) {
    INFO(name_of(kind));
    RenderRequest request = round_request(kind);
    request.target_error = kind == IntegratorKind::path ? 0.003 : 0.04;
    const RenderResult ended = render(scene, request);
    CHECK(ended.statistics.error.known);
    CHECK(ended.statistics.error.rel_mse <= *request.target_error);
    CHECK(ended.statistics.rounds > 2);
    request.threads = 5;
    CHECK(render(scene, request).statistics.film_hash == ended.statistics.film_hash);
    request.target_error.reset();
    request.rounds = ended.statistics.rounds;
    const RenderResult counted = render(scene, request);
    CHECK(counted.statistics.film_hash == ended.statistics.film_hash);
    CHECK(counted.image.pixels == ended.image.pixels);
    request.rounds = ended.statistics.rounds - 1;
    const RenderResult fewer = render(scene, request);
    CHECK(fewer.statistics.film_hash != ended.statistics.film_hash);
    CHECK(fewer.statistics.error.rel_mse > 0);
  }
}

TEST_CASE("rounds end by their limits, and one round begins whatever the time") {
  const SceneDescription scene = parse_scene_file("scenes/CornellBox.txt");
  for (const IntegratorKind kind : kIntegrators) {
    RenderRequest request = round_request(kind);
    request.target_error = 1e-12;
    request.max_per_pixel = 50;
    CHECK(render(scene, request).statistics.rounds == 3);
    request.seconds = 1e-9;
    CHECK(render(scene, request).statistics.rounds == 1);
    request.max_per_pixel = 15;
    CHECK_THROWS_AS(resolve_job(request, scene), InputError);
    request.max_per_pixel.reset();
    request.target_error = -1;
    CHECK_THROWS_AS(resolve_job(request, scene), InputError);
  }
}

TEST_CASE("the mean of an image does not depend on the number of rounds, but for noise") {
  const SceneDescription scene = parse_scene_file("scenes/CornellBox.txt");
  RenderRequest request = round_request(IntegratorKind::pssmlt);
  request.rounds = 8;
  const RenderResult rounds = render(scene, request);
  request.rounds.reset();
  request.samples_per_pixel = 128;
  const RenderResult once = render(scene, request);
  CHECK(rounds.statistics.mutations == once.statistics.mutations);
  const double error = std::hypot(rounds.statistics.b_standard_error, once.statistics.b_standard_error);
  CHECK(std::fabs(rounds.statistics.b - once.statistics.b) < 5 * error);
}

}  // namespace mlt::test
