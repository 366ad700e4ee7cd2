// Every scene, by every integrator, against its golden image: means of tiles and of the film by Welch's t
// with the errors of both, Sidak-corrected. A picture that fails is left in build/<variant>/golden_failures/
// with its reference, the difference and the p-values. And the film hashes of fixed jobs, which change when
// any bit does.
#include "golden.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "image/image_io.hpp"

namespace mlt::test {
namespace {

constexpr std::uint32_t kReplicates = 32;
constexpr std::uint64_t kSamples = 4;   // a pixel and replicate
constexpr std::uint32_t kTile = 16;     // pixels
constexpr double kSignificance = 1e-3;  // for all scenes, integrators, areas and channels together

/// A square of pixels: a tile, or the whole film, where an error of the brightness shows first.
struct Area {
  std::uint32_t x = 0, y = 0, side = 0;

  double mean(const ImageView& image, int channel) const {
    return mean_of(image, channel, x, y, x + side, y + side);
  }
};

std::vector<Area> compared_areas() {
  std::vector<Area> areas{{0, 0, kGoldenSide}};
  for (std::uint32_t y = 0; y < kGoldenSide; y += kTile) {
    for (std::uint32_t x = 0; x < kGoldenSide; x += kTile) areas.push_back({x, y, kTile});
  }
  return areas;
}

/// Mean of an area of the reference, as the sample that it is: pixels of the path tracer are independent.
Moments reference_moments(const GoldenReference& reference, int channel, const Area& area) {
  const double pixels = double{1} * area.side * area.side;
  const double variance = area.mean(reference.variance.view(), channel) / pixels;
  return {kReferenceReplicates, area.mean(reference.mean.view(), channel), variance * kReferenceReplicates};
}

double p_value(const std::vector<RenderResult>& replicates, const GoldenReference& reference, int channel,
               const Area& area) {
  const Moments expected = reference_moments(reference, channel, area);
  const Moments measured =
      moments_of(replicates, [&area, channel](const ImageView& image) { return area.mean(image, channel); });
  // Where neither scatters (a mirror in uniform light) float rounding of the stored mean remains.
  const double difference = std::fabs(expected.mean - measured.mean);
  if (difference <= 2 * 0x1p-23 * std::fabs(expected.mean)) return 1;
  return welch_t_test(measured, expected).p_value;
}

struct GoldenComparison {
  double smallest_p_value = 1;
  std::string p_values;  ///< one line an area: x y side, then three p-values
};

GoldenComparison compare(const std::vector<RenderResult>& replicates, const GoldenReference& reference) {
  GoldenComparison result;
  for (const Area& area : compared_areas()) {
    result.p_values +=
        std::to_string(area.x) + " " + std::to_string(area.y) + " " + std::to_string(area.side);
    for (int channel = 0; channel < 3; ++channel) {
      const double p = p_value(replicates, reference, channel, area);
      result.smallest_p_value = std::min(result.smallest_p_value, p);
      result.p_values += " " + std::to_string(p);
    }
    result.p_values += "\n";
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

/// Excess brightness that the comparison must see on the Cornell box. PSSMLT's film mean is as good as its b,
/// whose standard error over the replicates is 1 %, for the lamp in view makes the luminance of paths uneven:
/// at 5 % the p-value is 6e-5, above the threshold.
float visible_excess(IntegratorKind kind) {
  switch (kind) {
    case IntegratorKind::path:
      return 0.05f;
    case IntegratorKind::pssmlt:
      return 0.1f;
    case IntegratorKind::automatic:
      break;
  }
  return 0;
}

}  // namespace

TEST_CASE("every scene by every integrator shows its golden image") {
  const std::vector<GoldenScene> scenes = golden_scenes();
  REQUIRE(scenes.size() >= 10);
  const double threshold =
      sidak_threshold(kSignificance, scenes.size() * std::size(kIntegrators) * compared_areas().size() * 3);
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

TEST_CASE("the comparison sees a picture that is too bright, or whose red and green are swapped") {
  for (const GoldenScene& scene : golden_scenes()) {
    if (scene.name != "CornellBox") continue;
    const GoldenReference reference = read_reference(scene);
    for (const IntegratorKind kind : kIntegrators) {
      auto brighter = test_replicates(scene, kind);
      auto swapped = brighter;
      for (std::size_t i = 0; i < brighter.size(); ++i) {
        for (Vec3& pixel : brighter[i].image.pixels) pixel *= 1.0f + visible_excess(kind);
        for (Vec3& pixel : swapped[i].image.pixels) std::swap(pixel.x, pixel.y);
      }
      INFO(name_of(kind));
      CHECK(compare(brighter, reference).smallest_p_value < 1e-5);
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

TEST_CASE("a rounded value is the nearest one with so many bits, and few bits are left") {
  CHECK(round_mantissa(0.0f, 10) == 0.0f);
  CHECK(round_mantissa(1.0f, 3) == 1.0f);
  CHECK(round_mantissa(1.0f + 0x1p-4f, 3) == 1.125f);
  CHECK(round_mantissa(1.0f + 0x1.fp-5f, 3) == 1.0f);
  // Rounding up carries into the exponent.
  CHECK(round_mantissa(1.99f, 3) == 2.0f);
  for (float x = 1e-6f; x < 1e6f; x *= 1.37f) {
    const float rounded = round_mantissa(x, 10);
    CHECK(std::fabs(rounded - x) <= x * 0x1p-11f);
    CHECK(std::fmod(std::ldexp(rounded, 10 - std::ilogb(rounded)), 1.0f) == 0.0f);
  }
}

TEST_CASE("every stored golden image belongs to a scene") {
  const std::vector<GoldenScene> scenes = golden_scenes();
  for (const auto& [name, line] : read_table(std::string(kGoldenFolder) + kIndexName, 1)) {
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
