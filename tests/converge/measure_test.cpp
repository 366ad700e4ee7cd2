// Real renders of a tiny scene: seeds, order, budgets from times, references from files.
#include "converge/measure.hpp"

#include <catch2/catch.hpp>
#include <set>

#include "base/error.hpp"
#include "image/image_io.hpp"
#include "math/rng.hpp"
#include "render/renderer.hpp"
#include "scene/parse.hpp"
#include "support/temporary_folder.hpp"

namespace mlt {
namespace {

constexpr char kRoom[] =
    "film 8 6\n"
    "camera eye 0 1 3.9 target 0 1 0 up 0 1 0 fov 45\n"
    "material white diffuse reflectance 0.7\n"
    "box -1 0 -1  1 2 4  inward  material white\n"
    "quad -0.3 1.99 -0.3  0.3 1.99 -0.3  0.3 1.99 0.3  -0.3 1.99 0.3  material white emit 9\n";

ConvergePlan small_plan() {
  ConvergePlan plan;
  MethodRequest path, chains;
  path.integrator = IntegratorKind::path;
  chains.bootstrap = 64;
  chains.chains = 2;
  plan.methods = {{path, "path", {1, 4}}, {chains, "pssmlt", {2, 3}}};
  plan.replicates = 3;
  plan.request.seed = 50;
  plan.request.threads = 1;
  return plan;
}

TEST_CASE("every row is the render that its seed and budget name") {
  const SceneDescription scene = parse_scene_text(kRoom, "test");
  const std::atomic<bool> stop = false;
  std::uint32_t told = 0;
  const ConvergePlan plan = small_plan();
  check_plan(scene, plan);
  ConvergeRun run = measure(scene, plan, stop, [&told](std::uint32_t done) { told = done; });
  CHECK(told == 3);
  CHECK((run.replicates == 3 && run.width == 8 && run.height == 6 && !run.interrupted));
  REQUIRE(run.rows.size() == 12);
  std::set<std::uint64_t> seeds;
  for (std::uint32_t replicate = 0; replicate < 3; ++replicate) {
    for (std::size_t level = 0; level < 2; ++level) {
      CHECK(run.row(0, level, replicate).seed == run.row(1, level, replicate).seed);
      seeds.insert(run.row(0, level, replicate).seed);
    }
  }
  CHECK((seeds.size() == 6 && *seeds.begin() == 50));
  const Measurement& row = run.row(1, 1, 2);
  CHECK((row.budget == 3 && row.replicate == 2 && row.level == 1 && row.method == 1));
  RenderRequest request = plan.request;
  request.integrator = IntegratorKind::pssmlt;
  request.bootstrap = 64;
  request.chains = 2;
  request.samples_per_pixel = row.budget;
  request.seed = row.seed;
  Renderer renderer(scene, resolve_job(request, scene));
  renderer.prepare();
  CHECK(renderer.run(stop, nullptr, nullptr).film_hash == row.film_hash);
  CHECK(row.samples == 64 + 8 * 6 * 3);
  score(run, nullptr);
  CHECK(run.row(0, 1, 0).rel_mse > 0);
}

TEST_CASE("methods of one integrator differ in their settings, and share all else") {
  const SceneDescription scene = parse_scene_text(kRoom, "test");
  const std::atomic<bool> stop = false;
  ConvergePlan plan = small_plan();
  plan.methods[0] = plan.methods[1];
  plan.methods[0].name = "pssmlt --step-size 2";
  plan.methods[0].settings.step_size = 2;
  plan.request.width = 5;
  const ConvergeRun run = measure(scene, plan, stop, nullptr);
  CHECK(run.width == 5);
  for (std::size_t level = 0; level < 2; ++level) {
    CHECK(run.row(0, level, 0).samples == run.row(1, level, 0).samples);
    CHECK(run.row(0, level, 0).film_hash != run.row(1, level, 0).film_hash);
  }
}

TEST_CASE("a stop keeps complete replicates alone") {
  const SceneDescription scene = parse_scene_text(kRoom, "test");
  std::atomic<bool> stop = false;
  const ConvergeRun run =
      measure(scene, small_plan(), stop, [&stop](std::uint32_t done) { stop = done == 2; });
  CHECK((run.interrupted && run.replicates == 2));
  CHECK((run.rows.size() == 8 && run.images.size() == 8));
}

TEST_CASE("budgets for times increase with the time") {
  const SceneDescription scene = parse_scene_text(kRoom, "test");
  const std::atomic<bool> stop = false;
  ConvergePlan plan = small_plan();
  for (ConvergeMethod& method : plan.methods) method.budgets.clear();
  // A factor of 75, so that a busy machine's hiccups cannot turn the order around.
  REQUIRE(budgets_for_times(scene, {0.002, 0.003, 0.15}, plan, stop));
  for (const ConvergeMethod& method : plan.methods) {
    REQUIRE(method.budgets.size() == 3);
    CHECK((method.budgets[0] >= 1 && method.budgets[0] <= method.budgets[1]));
    CHECK(method.budgets[1] < method.budgets[2]);
  }
  const std::atomic<bool> stopped = true;
  CHECK_FALSE(budgets_for_times(scene, {0.001}, plan, stopped));
}

TEST_CASE("jobs that do not fit are refused beforehand") {
  const SceneDescription scene = parse_scene_text(kRoom, "test");
  ConvergePlan plan = small_plan();
  plan.methods[1].budgets[1] = 1ULL << 29;
  CHECK_THROWS_WITH(check_plan(scene, plan), Catch::Contains("budget 536870912 of pssmlt"));
  plan = small_plan();
  plan.replicates = 4096;
  plan.request.width = plan.request.height = 1000;
  plan.request.memory_limit = std::size_t{1} << 30;
  CHECK_THROWS_WITH(check_plan(scene, plan), Catch::Contains("--memory") && Catch::Contains("196608000000"));
}

TEST_CASE("the variance beside a reference is its noise") {
  const TemporaryFolder folder;
  const std::string path = folder / "a.b.pfm";
  CHECK(variance_path_of(path) == folder / "a.b.variance.pfm");
  CHECK(variance_path_of("x.y/name") == "x.y/name.variance.pfm");
  write_pfm(path, ImageBuffer{2, 1, {Vec3{1, 2, 3}, Vec3{0, 0, 0}}}.view());
  CHECK(read_reference(path).own_rel_mse == 0);
  CHECK(read_reference(path).mean == 1);
  // Deviations 0.1 and 0.2 in all channels: relative sum, and (0.3^2 + 0.6^2)^(1/2) / 6.
  write_pfm(folder / "a.b.variance.pfm",
            ImageBuffer{2, 1, {Vec3{0.01f, 0.01f, 0.01f}, Vec3{0.04f, 0.04f, 0.04f}}}.view());
  const Reference reference = read_reference(path);
  const double relative = 0.01 / 1.01 + 0.01 / 4.01 + 0.01 / 9.01 + 3 * 4.0;
  CHECK(reference.own_rel_mse == Approx(relative / 6).epsilon(1e-6));
  CHECK(reference.mean_standard_error == Approx(std::sqrt(0.09 + 0.36) / 6).epsilon(1e-6));
  write_pfm(folder / "a.b.variance.pfm", ImageBuffer{2, 1, {Vec3{0, -1, 0}, Vec3{0, 0, 0}}}.view());
  CHECK_THROWS_WITH(read_reference(path), Catch::Contains("negative variance"));
  write_pfm(folder / "a.b.variance.pfm", ImageBuffer{1, 1, {Vec3{0, 0, 0}}}.view());
  CHECK_THROWS_WITH(read_reference(path), Catch::Contains("expected 2 x 1"));
}

TEST_CASE("with its variance beside it a noisy reference measures what a clean one would") {
  // Image and reference have noise of variance s^2 each, so half of relMSE is the reference's. 12288 normal
  // squares know their mean to 1.3 %, twice that relative to the half; four standard errors are 10 %.
  constexpr std::uint32_t kSide = 64;
  constexpr double kDeviation = 0.01;
  Rng rng(5, StreamPurpose::kTest, 0);
  const auto noisy = [&rng] {
    ImageBuffer image{kSide, kSide, std::vector<Vec3>(kSide * kSide)};
    for (Vec3& pixel : image.pixels) {
      for (int channel = 0; channel < 3; ++channel) {
        // The sum of twelve uniform numbers has variance 1.
        double sum = -6;
        for (int i = 0; i < 12; ++i) sum += static_cast<double>(rng.next_float());
        pixel[channel] = static_cast<float>(2 + kDeviation * sum);
      }
    }
    return image;
  };
  const TemporaryFolder folder;
  const float variance = kDeviation * kDeviation;
  write_pfm(folder / "r.pfm", noisy().view());
  write_pfm(
      folder / "r.variance.pfm",
      ImageBuffer{kSide, kSide, std::vector<Vec3>(kSide * kSide, Vec3{variance, variance, variance})}.view());
  const Reference reference = read_reference(folder / "r.pfm");
  ConvergeRun run;
  run.methods = {{{}, "pssmlt", {1}}};
  run.level_count = run.replicates = 1;
  run.width = run.height = kSide;
  run.rows.resize(1);
  run.images = {noisy()};
  score(run, &reference);
  const double expected = kDeviation * kDeviation / 4.01;
  CHECK(run.rows[0].rel_mse == Approx(expected).epsilon(0.1));
  CHECK(run.rows[0].rel_mse_raw == Approx(2 * expected).epsilon(0.1));
}

}  // namespace
}  // namespace mlt
