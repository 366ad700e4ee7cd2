// Every scene, by every integrator, against its golden image: tile means by Welch's t with the errors of
// both, Sidak-corrected. A picture that fails is left in build/<variant>/golden_failures/ with its reference,
// the difference and the p-values. And the film hashes of fixed jobs, which change when any bit does.
#include "golden.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "image/image_io.hpp"

namespace mlt::test {
namespace {

constexpr std::uint32_t kReplicates = 32;
constexpr std::uint64_t kSamples = 4;  // a pixel and replicate
constexpr std::uint32_t kTile = 16;    // pixels
constexpr std::uint32_t kTiles = kGoldenSide / kTile * (kGoldenSide / kTile);
constexpr double kSignificance = 1e-3;  // for all scenes, integrators, tiles and channels together

/// Mean of a tile of the reference, as the sample that it is: pixels of the path tracer are independent.
Moments reference_moments(const GoldenReference& reference, int channel, std::uint32_t x, std::uint32_t y) {
  const double pixels = double{kTile} * kTile;
  const double mean = mean_of(reference.mean.view(), channel, x, y, x + kTile, y + kTile);
  const double variance = mean_of(reference.variance.view(), channel, x, y, x + kTile, y + kTile) / pixels;
  return {kReferenceReplicates, mean, variance * kReferenceReplicates};
}

struct GoldenComparison {
  double smallest_p_value = 1;
  std::string p_values;  ///< one line a tile: x y, then three p-values
};

GoldenComparison compare(const std::vector<RenderResult>& replicates, const GoldenReference& reference) {
  GoldenComparison result;
  for (std::uint32_t y = 0; y < kGoldenSide; y += kTile) {
    for (std::uint32_t x = 0; x < kGoldenSide; x += kTile) {
      result.p_values += std::to_string(x) + " " + std::to_string(y);
      for (int channel = 0; channel < 3; ++channel) {
        const Moments expected = reference_moments(reference, channel, x, y);
        const Moments measured = moments_of(replicates, [=](const ImageView& image) {
          return mean_of(image, channel, x, y, x + kTile, y + kTile);
        });
        // Where neither scatters (a mirror in uniform light) float rounding of the stored mean remains.
        const double difference = std::fabs(expected.mean - measured.mean);
        const bool same = difference <= 2 * 0x1p-23 * std::fabs(expected.mean);
        const double p = same ? 1.0 : welch_t_test(measured, expected).p_value;
        result.smallest_p_value = std::min(result.smallest_p_value, p);
        result.p_values += " " + std::to_string(p);
      }
      result.p_values += "\n";
    }
  }
  return result;
}

ImageBuffer mean_image(const std::vector<RenderResult>& replicates) {
  ImageBuffer mean = replicates[0].image;
  for (std::size_t i = 0; i < mean.pixels.size(); ++i) {
    DVec3 sum{0, 0, 0};
    for (const RenderResult& replicate : replicates) sum += DVec3{replicate.image.pixels[i]};
    mean.pixels[i] = Vec3{sum / static_cast<double>(replicates.size())};
  }
  return mean;
}

/// Leaves what a person needs to see, below the folder of the test's own binary; returns where.
std::string leave_failure(const std::string& name, const std::vector<RenderResult>& replicates,
                          const GoldenReference& reference, const std::string& p_values) {
  const auto folder = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "golden_failures";
  std::filesystem::create_directories(folder);
  const std::string base = (folder / name).string();
  const ImageBuffer image = mean_image(replicates);
  ImageBuffer difference = image;
  for (std::size_t i = 0; i < difference.pixels.size(); ++i) difference.pixels[i] -= reference.mean.pixels[i];
  write_image(base + ".png", image.view(), {});
  write_image(base + ".reference.png", reference.mean.view(), {});
  write_pfm(base + ".pfm", image.view());
  write_pfm(base + ".reference.pfm", reference.mean.view());
  write_pfm(base + ".difference.pfm", difference.view());
  std::ofstream(base + ".p_values.txt") << p_values;
  return base;
}

std::vector<RenderResult> test_replicates(const GoldenScene& golden, IntegratorKind kind) {
  const SceneDescription scene = parse_scene_file(golden.file);
  const std::uint32_t depth = scene.depth.value_or(kDefaultDepth);
  return render_replicates(scene, small_request(kind, kGoldenSide, kSamples, depth), kReplicates,
                           kFirstTestSeed);
}

}  // namespace

TEST_CASE("every scene by every integrator shows its golden image") {
  const std::vector<GoldenScene> scenes = golden_scenes();
  REQUIRE(scenes.size() >= 10);
  const double threshold =
      sidak_threshold(kSignificance, scenes.size() * std::size(kIntegrators) * kTiles * 3);
  for (const GoldenScene& scene : scenes) {
    const GoldenReference reference = read_reference(scene);
    REQUIRE(reference.mean.width == kGoldenSide);
    REQUIRE(reference.mean.height == kGoldenSide);
    REQUIRE(reference.variance.pixels.size() == reference.mean.pixels.size());
    for (const IntegratorKind kind : kIntegrators) {
      const auto replicates = test_replicates(scene, kind);
      const GoldenComparison comparison = compare(replicates, reference);
      const bool agrees = comparison.smallest_p_value > threshold;
      const std::string name = scene.name + "_" + name_of(kind);
      INFO(name << ": smallest p-value " << comparison.smallest_p_value << ", threshold " << threshold
                << (agrees ? ""
                           : ", left in " + leave_failure(name, replicates, reference, comparison.p_values)));
      CHECK(agrees);
    }
  }
}

TEST_CASE("the comparison sees a picture that is 5 % too bright, or whose red and green are swapped") {
  for (const GoldenScene& scene : golden_scenes()) {
    if (scene.name != "CornellBox") continue;
    const GoldenReference reference = read_reference(scene);
    for (const IntegratorKind kind : kIntegrators) {
      auto brighter = test_replicates(scene, kind);
      auto swapped = brighter;
      for (std::size_t i = 0; i < brighter.size(); ++i) {
        for (Vec3& pixel : brighter[i].image.pixels) pixel *= 1.05f;
        for (Vec3& pixel : swapped[i].image.pixels) std::swap(pixel.x, pixel.y);
      }
      CHECK(compare(brighter, reference).smallest_p_value < 1e-7);
      CHECK(compare(swapped, reference).smallest_p_value < 1e-7);
    }
  }
}

TEST_CASE("the film hashes of fixed jobs are the stored ones") {
  const auto hashes = read_table(kGoldenHashes, 2);
  for (const GoldenScene& scene : golden_scenes()) {
    for (const IntegratorKind kind : kIntegrators) {
      INFO(hash_key(scene, kind) << ": a changed hash needs `make refs` and a line in CHANGELOG.md");
      const auto stored = hashes.find(hash_key(scene, kind));
      REQUIRE(stored != hashes.end());
      CHECK(fixed_job_hash(scene, kind) == stored->second);
    }
  }
}

TEST_CASE("every stored golden image belongs to a scene") {
  const std::vector<GoldenScene> scenes = golden_scenes();
  for (const auto& [name, line] : read_table(kGoldenIndex, 1)) {
    INFO(name);
    const bool known = std::any_of(scenes.begin(), scenes.end(),
                                   [&name = name](const GoldenScene& scene) { return scene.name == name; });
    // The mesh scene is generated and may be absent.
    CHECK((known || name == "mesh"));
    CHECK(std::filesystem::exists("ref_images/" + name + ".pfm"));
    CHECK(std::filesystem::exists("ref_images/" + name + ".variance.pfm"));
  }
}

}  // namespace mlt::test
