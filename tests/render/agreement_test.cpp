// PSSMLT against the path tracer on every scene in scenes/: two estimates of one picture that share nothing
// but the integrand. Groups of chains that share no random number (whole renders with other seeds) are the
// replicates; states within a chain depend on each other and are never treated as samples.
//   Film means: Welch's t for each scene, Sidak-corrected over the scenes. What is lost or gained everywhere
//   shows here first, for the noise of single tiles is ten times as large.
//   Tile means: Welch's t for each tile, Sidak-corrected over all tiles of all scenes.
//   Their p-values must look uniform: Kolmogorov's distance over all tiles. Tiles of one picture are
//   correlated (a chain that dwells in one lacks in the others), so the distance's distribution is not
//   Kolmogorov's; it is found by flipping signs: under the null hypothesis a pair's difference is as likely
//   as its negative, all tiles together, which keeps their correlation. With 999 flips the least p-value is
//   1/1000.
// tools/planted_weight_test.sh builds the chains with 30 % less weight for rejected proposals, and expects
// the test with tag [agreement] to fail.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "math/rng.hpp"
#include "render_fixture.hpp"

namespace mlt::test {
namespace {

constexpr std::uint32_t kSide = 32;     // pixels
constexpr std::uint32_t kTileSize = 8;  // pixels
constexpr std::uint32_t kFlips = 999;

std::vector<std::string> scene_files() {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator("scenes")) {
    if (entry.path().extension() == ".txt") files.push_back(entry.path().string());
  }
  // `make scenes` writes the mesh scene, which is too large to be stored, and too large to be built again for
  // each replicate where every operation is ten times as slow.
  const bool fast = scaled_effort(8) == 8;
  if (fast && std::filesystem::exists("build/scenes/mesh.txt")) files.push_back("build/scenes/mesh.txt");
  std::sort(files.begin(), files.end());
  return files;
}

/// Tile means by tile and replicate.
using TileMeans = std::vector<std::vector<double>>;

TileMeans tile_means(const std::vector<RenderResult>& replicates) {
  TileMeans means;
  for (std::uint32_t y = 0; y < kSide; y += kTileSize) {
    for (std::uint32_t x = 0; x < kSide; x += kTileSize) {
      means.push_back(statistics_of(replicates, [x, y](const ImageView& image) {
        return mean_luminance(image, x, y, x + kTileSize, y + kTileSize);
      }));
    }
  }
  return means;
}

/// One scene's tile means by both integrators, replicate by replicate.
struct Comparison {
  std::string file;
  TileMeans path, pssmlt;

  double p_value(std::size_t tile) const {
    return welch_t_test(moments(path[tile]), moments(pssmlt[tile])).p_value;
  }
};

/// Means over the tiles, which are of one size.
Moments film_moments(const TileMeans& tiles) {
  std::vector<double> means(tiles[0].size(), 0.0);
  for (const auto& tile : tiles) {
    for (std::size_t i = 0; i < means.size(); ++i) means[i] += tile[i] / static_cast<double>(tiles.size());
  }
  return moments(means);
}

void check_film(const Comparison& comparison, std::size_t scenes) {
  const Moments path = film_moments(comparison.path);
  const Moments pssmlt = film_moments(comparison.pssmlt);
  INFO(comparison.file << " film: path " << path.mean << " +- " << path.standard_error() << ", pssmlt "
                       << pssmlt.mean << " +- " << pssmlt.standard_error());
  CHECK(path.mean > 0);
  CHECK(welch_t_test(path, pssmlt).p_value > sidak_threshold(1e-3, scenes));
}

Comparison compare(const std::string& file, std::uint32_t replicates, std::uint64_t samples) {
  const SceneDescription scene = parse_scene_file(file);
  const std::uint32_t depth = scene.depth.value_or(kDefaultDepth);
  Comparison comparison{file, {}, {}};
  const RenderRequest path = small_request(IntegratorKind::path, kSide, samples, depth);
  comparison.path = tile_means(render_replicates(scene, path, replicates, 1));
  const RenderRequest pssmlt = small_request(IntegratorKind::pssmlt, kSide, samples, depth);
  comparison.pssmlt = tile_means(render_replicates(scene, pssmlt, replicates, 100001));
  return comparison;
}

/// Differences of a tile's replicates, and the p-value of their mean being 0 after sign flips.
double flipped_p_value(const std::vector<double>& differences, const std::vector<double>& signs) {
  std::vector<double> flipped(differences.size());
  for (std::size_t i = 0; i < flipped.size(); ++i) flipped[i] = differences[i] * signs[i];
  return student_t_test(moments(flipped), 0.0).p_value;
}

struct SceneDifferences {
  std::vector<std::vector<double>> tiles;
  std::size_t replicates = 0;
};

/// Kolmogorov's distance of all tiles' p-values from uniform, each scene's replicates flipped by `draw_sign`.
template <class DrawSign>
double kolmogorov_distance(const std::vector<SceneDifferences>& scenes, DrawSign&& draw_sign) {
  std::vector<double> p_values;
  for (const SceneDifferences& scene : scenes) {
    std::vector<double> signs(scene.replicates);
    for (double& sign : signs) sign = draw_sign();
    for (const auto& tile : scene.tiles) p_values.push_back(flipped_p_value(tile, signs));
  }
  return ks_uniform_test(p_values).distance;
}

double uniformity_p_value(const std::vector<Comparison>& comparisons) {
  std::vector<SceneDifferences> scenes;
  for (const Comparison& comparison : comparisons) {
    SceneDifferences scene;
    scene.replicates = comparison.path[0].size();
    for (std::size_t tile = 0; tile < comparison.path.size(); ++tile) {
      std::vector<double> differences;
      for (std::size_t i = 0; i < scene.replicates; ++i) {
        differences.push_back(comparison.path[tile][i] - comparison.pssmlt[tile][i]);
      }
      if (moments(differences).variance > 0) scene.tiles.push_back(differences);
    }
    scenes.push_back(scene);
  }
  const double observed = kolmogorov_distance(scenes, [] { return 1.0; });
  Rng rng(7, StreamPurpose::kTest, 0);
  std::uint32_t as_extreme = 1;
  for (std::uint32_t flip = 0; flip < kFlips; ++flip) {
    const double distance =
        kolmogorov_distance(scenes, [&rng] { return (rng.next_fixed() >> 31) != 0 ? 1.0 : -1.0; });
    if (distance >= observed) as_extreme += 1;
  }
  return as_extreme / (kFlips + 1.0);
}

void check_agreement(std::uint32_t replicates, std::uint64_t samples) {
  std::vector<Comparison> comparisons;
  std::size_t tiles = 0;
  for (const std::string& file : scene_files()) {
    comparisons.push_back(compare(file, replicates, samples));
    tiles += comparisons.back().path.size();
  }
  REQUIRE(comparisons.size() >= 10);
  for (const Comparison& comparison : comparisons) {
    check_film(comparison, comparisons.size());
    for (std::size_t tile = 0; tile < comparison.path.size(); ++tile) {
      const Moments path = moments(comparison.path[tile]);
      const Moments pssmlt = moments(comparison.pssmlt[tile]);
      INFO(comparison.file << " tile " << tile << ": path " << path.mean << " +- " << path.standard_error()
                           << ", pssmlt " << pssmlt.mean << " +- " << pssmlt.standard_error());
      CHECK(comparison.p_value(tile) > sidak_threshold(1e-3, tiles));
    }
  }
  CHECK(uniformity_p_value(comparisons) > 1e-3);
}

}  // namespace

TEST_CASE("PSSMLT agrees with the path tracer on every scene", "[agreement]") {
  check_agreement(32, scaled_effort(8));
}

TEST_CASE("PSSMLT agrees with the path tracer on every scene, to a quarter of the error", "[.slow]") {
  check_agreement(64, scaled_effort(64));
}

}  // namespace mlt::test
