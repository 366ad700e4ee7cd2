// What must not matter to the image (threads, what the scene declares but does not use) and what may stop or
// refuse a job.
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdint>
#include <string>

#include "base/error.hpp"
#include "render_fixture.hpp"

namespace mlt::test {
namespace {

SceneDescription cornell_box() {
  return parse_scene_file("scenes/CornellBox.txt");
}

std::string hash_of(const SceneDescription& scene, const RenderRequest& request) {
  return render(scene, request).statistics.film_hash;
}

/// The value of one line of `mlt info`.
std::string info_value(const Renderer& renderer, const std::string& name) {
  for (const InfoLine& line : renderer.info()) {
    if (line.name == name) return line.value;
  }
  return "no such line";
}

struct StopAfter {
  std::uint64_t paths = 0;
  std::atomic<bool> stop{false};
  static void progress(const RenderProgress& progress, void* context) {
    auto& own = *static_cast<StopAfter*>(context);
    CHECK(progress.done <= progress.total);
    if (progress.done > own.paths) own.stop.store(true);
  }
};

}  // namespace

TEST_CASE("pitfall 9: the film's hash is the same from 1, 2, 3, 7, 16 and 64 threads", "[threads]") {
  for (const char* file : {"scenes/CornellBox.txt", "scenes/spheres.txt"}) {
    const SceneDescription scene = parse_scene_file(file);
    for (const IntegratorKind kind : kIntegrators) {
      // 3 x 3 tiles, the last ones cut; more chains than the most threads.
      RenderRequest request = small_request(kind, 40, 8, 6);
      request.chains = 67;
      request.threads = 1;
      const RenderResult reference = render(scene, request);
      for (const std::uint32_t threads : {2U, 3U, 7U, 16U, 64U}) {
        request.threads = threads;
        const RenderResult result = render(scene, request);
        INFO(file << " " << name_of(kind) << " " << threads << " threads");
        CHECK(result.statistics.film_hash == reference.statistics.film_hash);
        CHECK(result.statistics.b == reference.statistics.b);
        CHECK(result.statistics.acceptance_small == reference.statistics.acceptance_small);
        CHECK(result.image.pixels == reference.image.pixels);
      }
    }
  }
}

TEST_CASE("a mesh whose hierarchy 1, 2, 3 or 7 threads have built gives the same film", "[threads]") {
  const SceneDescription scene = parse_scene_file("build/scenes/mesh.txt");
  RenderRequest request = small_request(IntegratorKind::path, 40, 1, 4);
  const std::string alone = hash_of(scene, request);
  for (const std::uint32_t threads : {2U, 3U, 7U}) {
    request.threads = threads;
    INFO(threads << " threads");
    CHECK(hash_of(scene, request) == alone);
  }
}

TEST_CASE("another seed, depth or film gives another hash, the same job the same") {
  const SceneDescription scene = cornell_box();
  for (const IntegratorKind kind : kIntegrators) {
    const RenderRequest request = small_request(kind, 16, 8, 4);
    const std::string hash = hash_of(scene, request);
    CHECK(hash.size() == 64);
    CHECK(hash_of(scene, request) == hash);
    RenderRequest other = request;
    other.seed = 1;
    CHECK(hash_of(scene, other) != hash);
    other.seed = std::uint64_t{1} << 63;
    CHECK(hash_of(scene, other) != hash);
    other = request;
    other.depth = 5;
    CHECK(hash_of(scene, other) != hash);
    other = request;
    other.samples_per_pixel = 9;
    CHECK(hash_of(scene, other) != hash);
  }
}

TEST_CASE("every instruction set gives the same film, and one that cannot run is refused by name") {
  const SceneDescription scene = cornell_box();
#define MLT_ENUMERATE(name, help, condition) InstructionSet::name,
  constexpr InstructionSet kSets[] = {MLT_INSTRUCTION_SETS(MLT_ENUMERATE)};
#undef MLT_ENUMERATE
  CHECK(is_supported(best_instruction_set()));
  for (const IntegratorKind kind : kIntegrators) {
    RenderRequest request = small_request(kind, 16, 8, 4);
    request.instruction_set = InstructionSet::base;
    const std::string hash = hash_of(scene, request);
    for (const InstructionSet set : kSets) {
      request.instruction_set = set;
      if (is_supported(set)) {
        CHECK(hash_of(scene, request) == hash);
        CHECK_THAT(info_value(Renderer(scene, resolve_job(request, scene)), "kernel"),
                   Catch::EndsWith(std::string("instruction set ") + instruction_set_name(set)));
      } else {
        CHECK_THROWS_WITH(
            resolve_job(request, scene),
            Catch::StartsWith(std::string("--isa: found ") + instruction_set_name(set) +
                              ", which this processor or this binary does not have, allowed is base"));
      }
    }
  }
}

TEST_CASE("materials that no shape uses change nothing: not a bit, not a byte of the kernel's storage") {
  const SceneDescription scene = cornell_box();
  SceneDescription more = scene;
  const std::size_t used = more.materials.size();
#define MLT_ENUMERATE(name)      \
  more.materials.emplace_back(); \
  more.materials.back().kind = MaterialKind::name;
  MLT_MATERIAL_KINDS(MLT_ENUMERATE)
#undef MLT_ENUMERATE
  REQUIRE(more.materials.size() > used);
  for (const IntegratorKind kind : kIntegrators) {
    const RenderRequest request = small_request(kind, 16, 8, 4);
    CHECK(hash_of(more, request) == hash_of(scene, request));
    const Renderer plain(scene, resolve_job(request, scene));
    const Renderer with_unused(more, resolve_job(request, more));
    CHECK(info_value(plain, "kernel") == info_value(with_unused, "kernel"));
    CHECK(info_value(plain, "primary samples") == info_value(with_unused, "primary samples"));
  }
}

TEST_CASE("roulette starts by default where the results say, and never behind the last edge") {
  const SceneDescription scene = cornell_box();
  const auto edge = [&scene](IntegratorKind kind, std::uint32_t depth) {
    RenderRequest request;
    request.integrator = kind;
    request.depth = depth;
    return resolve_job(request, scene).roulette;
  };
  for (const IntegratorKind kind : kIntegrators) {
    CHECK(edge(kind, 25) == 24);
    CHECK(edge(kind, 24) == 0);
  }
}

TEST_CASE("the bootstrap is by default a tenth of the mutations, within bounds that a request may pass") {
  const SceneDescription scene = cornell_box();
  RenderRequest request = small_request(IntegratorKind::pssmlt, 256, 1, 4);
  const auto paths = [&](std::uint64_t per_pixel) {
    request.samples_per_pixel = per_pixel;
    return resolve_job(request, scene).bootstrap;
  };
  request.bootstrap.reset();
  CHECK(paths(1) == 16384);
  CHECK(paths(100) == 655360);
  CHECK(paths(160) == 1048576);
  CHECK(paths(1000) == 1048576);
  request.bootstrap = 2000000;
  CHECK(paths(1000) == 2000000);
}

TEST_CASE("info names the features that were found and those that were skipped") {
  const RenderRequest request = small_request(IntegratorKind::pssmlt, 16, 8, 4);
  const SceneDescription plain_scene = cornell_box();
  const Renderer plain(plain_scene, resolve_job(request, plain_scene));
  CHECK(info_value(plain, "features found") == "none");
  CHECK(info_value(plain, "materials used") == "diffuse (18 primitives)");
  CHECK(info_value(plain, "materials skipped") == "mirror, dielectric, conductor");
  CHECK(info_value(plain, "depth") == "4 path edges from camera to light");
  CHECK(info_value(plain, "primary samples") == "at most 14 a path");

  const SceneDescription rich_scene = parse_scene_file("scenes/spheres.txt");
  RenderRequest with_roulette = request;
  with_roulette.roulette = 2;
  const Renderer rich(rich_scene, resolve_job(with_roulette, rich_scene));
  const std::string found = info_value(rich, "features found");
  CHECK(found.find("several lobes") != std::string::npos);
  CHECK(found.find("other than diffuse") != std::string::npos);
  CHECK(found.find("Russian roulette") != std::string::npos);
  CHECK(info_value(rich, "features skipped") == "at most one emitting primitive");
}

TEST_CASE(
    "a job runs in exactly the memory of its plan, and one byte less is refused before anything happens") {
  const SceneDescription scene = cornell_box();
  for (const IntegratorKind kind : kIntegrators) {
    RenderRequest request = small_request(kind, 64, 4, 4);
    request.threads = 4;
    request.film_memory = 0;  // one film, as where --memory leaves no room for more
    const std::size_t needed = Renderer(scene, resolve_job(request, scene)).memory_plan().total_bytes();
    const std::string hash = hash_of(scene, request);
    request.memory_limit = needed;
    CHECK(hash_of(scene, request) == hash);
    request.memory_limit = needed - 1;
    std::string message;
    try {
      Renderer(scene, resolve_job(request, scene));
    } catch (const ResourceError& error) {
      message = error.what();
    }
    INFO(message);
    CHECK(message.find("--memory") != std::string::npos);
    CHECK(message.find(std::to_string(needed)) != std::string::npos);
    CHECK(message.find(std::to_string(needed - 1)) != std::string::npos);
    CHECK(message.find("would fit") != std::string::npos);
    request.memory_limit = 1;
    CHECK_THROWS_AS(Renderer(scene, resolve_job(request, scene)), ResourceError);
  }
}

TEST_CASE("the advice of a refused job is right: what it says would fit does fit") {
  const SceneDescription scene = cornell_box();
  RenderRequest request = small_request(IntegratorKind::pssmlt, 64, 4, 4);
  request.chains = 1024;  // Enough groups for all threads.
  request.bootstrap = 1024;
  request.threads = 64;
  const std::size_t all = Renderer(scene, resolve_job(request, scene)).memory_plan().total_bytes();
  request.memory_limit = all / 4;
  std::string message;
  try {
    Renderer(scene, resolve_job(request, scene));
  } catch (const ResourceError& error) {
    message = error.what();
  }
  const std::string option = "; --threads ";
  const std::size_t at = message.find(option);
  REQUIRE(at != std::string::npos);
  request.threads = static_cast<std::uint32_t>(std::stoul(message.substr(at + option.size())));
  CHECK(*request.threads < 64);
  CHECK_NOTHROW(Renderer(scene, resolve_job(request, scene)));
}

TEST_CASE("a stopped render is marked partial, whole up to where it came, and as bright as a full one",
          "[threads]") {
  const SceneDescription scene = cornell_box();
  const RenderRequest finished = small_request(IntegratorKind::pssmlt, 16, scaled_effort(64), 5);
  const Moments full = luminance_of(render_replicates(scene, finished, 8, 1));
  // Far more than a quarter of a second, after which the first progress report stops it; short chains.
  RenderRequest request = small_request(IntegratorKind::pssmlt, 16, 1U << 16, 5);
  request.chains = 1U << 16;
  request.bootstrap = 4096;
  request.threads = 2;
  std::vector<double> means;
  for (request.seed = 50; request.seed < 54; ++request.seed) {
    Renderer renderer(scene, resolve_job(request, scene));
    renderer.prepare();
    StopAfter stopper{*request.bootstrap};
    const RenderStatistics statistics = renderer.run(stopper.stop, &StopAfter::progress, &stopper);
    CHECK(statistics.partial);
    CHECK(statistics.mutations > 0);
    CHECK(statistics.mutations < 256ULL << 16);
    CHECK(statistics.film_hash.size() == 64);
    means.push_back(mean_luminance(renderer.image()));
  }
  const Moments partial = moments(means);
  INFO("partial " << partial.mean << " +- " << partial.standard_error() << ", full " << full.mean << " +- "
                  << full.standard_error());
  CHECK(welch_t_test(partial, full).p_value > 1e-4);
}

TEST_CASE("a stopped path tracer has whole pixels alone, though blocks of samples span several",
          "[threads]") {
  constexpr std::uint64_t kSamples = 13;
  const SceneDescription scene = cornell_box();
  // More than a quarter of a second, after which the first progress report stops it.
  const std::uint32_t side = scaled_effort(8) == 8 ? 1024 : 384;
  RenderRequest request = small_request(IntegratorKind::path, side, kSamples, 8);
  request.threads = 2;
  const RenderResult full = render(scene, request);
  Renderer renderer(scene, resolve_job(request, scene));
  renderer.prepare();
  StopAfter stopper;
  const RenderStatistics statistics = renderer.run(stopper.stop, &StopAfter::progress, &stopper);
  CHECK(statistics.partial);
  CHECK(statistics.samples % kSamples == 0);
  std::size_t rendered = 0, black = 0;
  for (std::size_t i = 0; i < full.image.pixels.size(); ++i) {
    const Vec3 value = renderer.image().pixels[i];
    const bool is_whole = value == full.image.pixels[i];
    rendered += is_whole ? 1 : 0;
    black += !is_whole && is_zero(value) ? 1 : 0;
  }
  CHECK(rendered > 0);
  CHECK(black > 0);
  CHECK(rendered + black == full.image.pixels.size());
}

TEST_CASE("the bootstrap counts as progress and can be stopped") {
  RenderRequest request = small_request(IntegratorKind::pssmlt, 16, 8, 5);
  request.bootstrap = 1U << 24;
  const SceneDescription scene = cornell_box();
  Renderer renderer(scene, resolve_job(request, scene));
  renderer.prepare();
  StopAfter stopper;
  const RenderStatistics statistics = renderer.run(stopper.stop, &StopAfter::progress, &stopper);
  CHECK(statistics.partial);
  CHECK(statistics.mutations == 0);
  CHECK(statistics.samples > 0);
  CHECK(statistics.samples < 1U << 24);
  CHECK(statistics.b > 0.0);
}

TEST_CASE("a render that is stopped before it begins is black, partial and finite") {
  const SceneDescription scene = cornell_box();
  for (const IntegratorKind kind : kIntegrators) {
    const RenderRequest request = small_request(kind, 16, 8, 4);
    Renderer renderer(scene, resolve_job(request, scene));
    renderer.prepare();
    const std::atomic<bool> stop{true};
    const RenderStatistics statistics = renderer.run(stop, nullptr, nullptr);
    CHECK(statistics.partial);
    CHECK(statistics.samples == 0);
    CHECK(mean_luminance(renderer.image()) == 0.0);
  }
}

}  // namespace mlt::test
