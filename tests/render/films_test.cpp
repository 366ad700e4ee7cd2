// Workers that share films: the same bits for any number of films, and as few films as memory asks for.
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdint>
#include <string>

#include "base/error.hpp"
#include "render_fixture.hpp"

namespace mlt::test {
namespace {

constexpr std::uint32_t kWorkers = 5;
constexpr std::size_t kFilmBytes = std::size_t{40} * 40 * sizeof(FilmPixel);

RenderRequest job_of(std::uint32_t workers) {
  RenderRequest request = small_request(IntegratorKind::pssmlt, 40, 8, 6);
  request.chains = 67;
  request.threads = workers;
  return request;
}

std::size_t planned_bytes(const SceneDescription& scene, const RenderRequest& request) {
  return Renderer(scene, resolve_job(request, scene)).memory_plan().total_bytes();
}

/// The line of `mlt info` about films.
std::string films_of(const SceneDescription& scene, const RenderRequest& request) {
  const Renderer renderer(scene, resolve_job(request, scene));
  for (const InfoLine& line : renderer.info()) {
    if (line.name == "films") return line.value;
  }
  return "no such line";
}

}  // namespace

TEST_CASE("pitfall 9: the film's hash is the same from any number of films", "[threads]") {
  for (const char* file : {"scenes/CornellBox.txt", "scenes/spheres.txt"}) {
    const SceneDescription scene = parse_scene_file(file);
    RenderRequest request = job_of(kWorkers);
    request.rounds = 3;  // films are moved into the first and filled again
    RenderRequest alone = request;
    alone.threads = 1;
    const RenderResult reference = render(scene, alone);
    for (const std::uint32_t films : {0U, kWorkers}) {
      request.film_memory = films * kFilmBytes;
      const RenderResult result = render(scene, request);
      INFO(file << ": " << films_of(scene, request));
      CHECK(result.statistics.film_hash == reference.statistics.film_hash);
      CHECK(result.statistics.error.rel_mse == reference.statistics.error.rel_mse);
      CHECK(result.image.pixels == reference.image.pixels);
    }
  }
}

TEST_CASE("where --memory leaves no room for a film for each worker they share, with the same bits") {
  const SceneDescription scene = parse_scene_file("scenes/CornellBox.txt");
  RenderRequest request = job_of(kWorkers);
  const std::string hash = render(scene, request).statistics.film_hash;
  const std::string why = " shared by 5 workers with atomic adds; --memory leaves no room for more";
  CHECK(films_of(scene, request) == "5, one for each worker");
  for (std::uint32_t films = kWorkers; films-- > 1;) {
    // A byte less than the plan before had needed.
    request.memory_limit = planned_bytes(scene, request) - 1;
    CHECK(films_of(scene, request) == std::to_string(films) + "," + why);
    CHECK(planned_bytes(scene, request) <= request.memory_limit);
    CHECK(render(scene, request).statistics.film_hash == hash);
  }
  request.memory_limit = planned_bytes(scene, request) - 1;
  CHECK_THROWS_AS(planned_bytes(scene, request), ResourceError);
}

TEST_CASE("a 256 x 256 film is shared by four workers, so that the whole job stays below 7.5 MB") {
  const SceneDescription scene = parse_scene_file("scenes/CornellBox.txt");
  RenderRequest request;
  request.width = request.height = 256;
  request.threads = 4;
  CHECK(films_of(scene, request) ==
        "1, shared by 4 workers with atomic adds; one for each would exceed 10485760 bytes");
  CHECK(planned_bytes(scene, request) < 7'500'000);
  request.threads = 2;
  CHECK(films_of(scene, request) == "2, one for each worker");
  request.threads = 4;
  request.width = request.height = 128;
  CHECK(films_of(scene, request) == "4, one for each worker");
}

TEST_CASE("the path tracer has no such films") {
  const SceneDescription scene = parse_scene_file("scenes/CornellBox.txt");
  CHECK(films_of(scene, small_request(IntegratorKind::path, 40, 8, 6)) == "no such line");
}

}  // namespace mlt::test
