// PSSMLT's picture as an estimate: brightness, path lengths, chain lengths and roulette, against closed forms
// and against the path tracer. Replicates are whole renders with other seeds.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "film/pixel_film.hpp"
#include "render_fixture.hpp"

namespace mlt::test {
namespace {

RenderRequest path_request(std::uint32_t side, std::uint64_t samples, std::uint32_t depth) {
  return small_request(IntegratorKind::path, side, scaled_effort(samples), depth);
}
RenderRequest pssmlt_request(std::uint32_t side, std::uint64_t mutations, std::uint32_t depth) {
  return small_request(IntegratorKind::pssmlt, side, scaled_effort(mutations), depth);
}

SceneDescription cornell_box() {
  return parse_scene_file("scenes/CornellBox.txt");
}

/// Differences of consecutive means: the energy of the path lengths in between. Independent renders, so
/// variances add.
Moments difference(const Moments& longer, const Moments& shorter) {
  return Moments{std::min(longer.count, shorter.count), longer.mean - shorter.mean,
                 longer.variance + shorter.variance};
}

}  // namespace

TEST_CASE("pitfall 7: energy per path length, up to 80 edges, is the closed form's and the path tracer's") {
  // A furnace of albedo 0.95: k edges carry 0.95^(k-1), so that 65 to 80 edges still hold a fifth of a unit.
  const SceneDescription scene = parse_scene_text(
      "camera eye 0.2 -0.1 0.3 target 1 0.4 -0.6 fov 70\nmaterial wall diffuse reflectance 0.95\n"
      "box -1 -1 -1 1 1 1 inward material wall emit 1\n",
      "test");
  const std::uint32_t depths[] = {1, 2, 3, 4, 8, 16, 32, 64, 80};
  constexpr std::uint32_t kReplicates = 12;
  constexpr double kSignificance = 1e-3;
  std::vector<Moments> previous(std::size(kIntegrators), Moments{kReplicates, 0, 0});
  std::uint32_t previous_depth = 0;
  for (const std::uint32_t depth : depths) {
    double exact = 0;
    for (std::uint32_t k = previous_depth + 1; k <= depth; ++k) exact += std::pow(0.95, k - 1);
    std::vector<Moments> energies;
    for (std::size_t i = 0; i < std::size(kIntegrators); ++i) {
      RenderRequest request = small_request(kIntegrators[i], 4, scaled_effort(depth > 20 ? 16 : 64), depth);
      request.roulette = 0;
      const Moments all =
          luminance_of(render_replicates(scene, request, kReplicates, 1000 * (i + 1) + depth * 16));
      energies.push_back(difference(all, previous[i]));
      previous[i] = all;
      INFO(name_of(kIntegrators[i]) << " edges " << previous_depth + 1 << " to " << depth << ": "
                                    << energies[i].mean << " +- " << energies[i].standard_error()
                                    << ", exactly " << exact);
      CHECK(mean_p_value(energies[i], exact, 20 * 0x1p-20) >
            sidak_threshold(kSignificance, 3 * std::size(depths)));
    }
    for (const Moments& energy : energies) {
      if (energy.variance == 0 && energies[0].variance == 0) continue;  // one edge: the same for every path
      CHECK(welch_t_test(energy, energies[0]).p_value >
            sidak_threshold(kSignificance, 3 * std::size(depths)));
    }
    previous_depth = depth;
  }
}

TEST_CASE("pitfall 7: energy per path length in the Cornell box is the path tracer's") {
  const SceneDescription scene = cornell_box();
  constexpr std::uint32_t kReplicates = 16;
  Moments path{kReplicates, 0, 0}, pssmlt = path;
  for (const std::uint32_t depth : {1U, 2U, 3U, 4U, 6U, 12U}) {
    const Moments path_all =
        luminance_of(render_replicates(scene, path_request(16, 12, depth), kReplicates, 2000 + 32 * depth));
    const Moments pssmlt_all =
        luminance_of(render_replicates(scene, pssmlt_request(16, 12, depth), kReplicates, 4000 + 32 * depth));
    const Moments a = difference(path_all, path);
    const Moments b = difference(pssmlt_all, pssmlt);
    INFO("up to " << depth << " edges: path " << a.mean << " +- " << a.standard_error() << ", pssmlt "
                  << b.mean << " +- " << b.standard_error());
    CHECK(welch_t_test(a, b).p_value > sidak_threshold(1e-3, 6));
    path = path_all;
    pssmlt = pssmlt_all;
  }
}

TEST_CASE(
    "pitfall 8: the image's mean over 32 seeds is the path tracer's, and b's standard error is honest") {
  for (const char* file : {"scenes/CornellBox.txt", "scenes/CornellBox2.txt"}) {
    const SceneDescription scene = parse_scene_file(file);
    // Not scaled: of fewer large steps b comes from the bootstrap's strata, where its error is overstated.
    const auto path = render_replicates(scene, small_request(IntegratorKind::path, 16, 16, 6), 32, 1);
    const auto pssmlt = render_replicates(scene, small_request(IntegratorKind::pssmlt, 16, 16, 6), 32, 1001);
    const Moments a = luminance_of(path);
    const Moments b = luminance_of(pssmlt);
    INFO(file << ": path " << a.mean << " +- " << a.standard_error() << ", pssmlt " << b.mean << " +- "
              << b.standard_error());
    CHECK(welch_t_test(a, b).p_value > sidak_threshold(1e-3, 4));
    // b itself is an estimate of the same mean, from independent paths, with a standard error of its own: the
    // deviations in units of it must have variance 1 (chi-square over 32 seeds).
    double chi_square = 0;
    std::vector<double> estimates;
    for (const RenderResult& result : pssmlt) estimates.push_back(result.statistics.b);
    const Moments b_moments = moments(estimates);
    CHECK(welch_t_test(a, b_moments).p_value > sidak_threshold(1e-3, 4));
    for (const RenderResult& result : pssmlt) {
      const double z = (result.statistics.b - b_moments.mean) / result.statistics.b_standard_error;
      chi_square += z * z;
    }
    // Heavy tails make the error's own estimate noisy: only a factor of two either way is refused.
    CHECK(chi_square / 31 < 4);
    CHECK(chi_square / 31 > 0.25);
  }
}

TEST_CASE("pitfall 17: chains of one mutation, averaged, give the picture of long chains") {
  const SceneDescription scene = cornell_box();
  constexpr std::uint32_t kReplicates = 16;
  RenderRequest request = pssmlt_request(8, 16, 5);
  const std::uint64_t mutations = 64 * *request.samples_per_pixel;
  request.bootstrap = 2 * mutations;
  std::vector<std::vector<RenderResult>> pictures;
  for (const std::uint64_t chains : {mutations, mutations / 3, std::uint64_t{4}}) {
    request.chains = static_cast<std::uint32_t>(chains);
    pictures.push_back(render_replicates(scene, request, kReplicates, 100 * (pictures.size() + 1)));
    for (const RenderResult& result : pictures.back()) REQUIRE(result.statistics.mutations == mutations);
  }
  const auto path = render_replicates(scene, path_request(8, 16, 5), kReplicates, 900);
  for (const auto& picture : pictures) {
    const TileComparison tiles = compare_tiles(picture, path, 4);
    CHECK(tiles.smallest_p_value > sidak_threshold(1e-3, 3 * tiles.tiles));
  }
}

TEST_CASE("the probability of large steps and the kind of start leave the expectation alone") {
  const SceneDescription scene = cornell_box();
  constexpr std::uint32_t kReplicates = 16;
  // Not scaled: of fewer mutations without large steps all replicates may leave a tile black.
  const auto path = render_replicates(scene, small_request(IntegratorKind::path, 8, 64, 5), kReplicates, 1);
  struct Variation {
    float large_step;
    StartKind start;
    MutationKind mutation;
  };
  // Chains that start from the first path with light show it until they have forgotten it: one long chain.
  const Variation variations[] = {
      {1.0f, StartKind::resampled, MutationKind::kelemen},
      {0.5f, StartKind::resampled, MutationKind::gaussian},
      {0.05f, StartKind::resampled, MutationKind::kelemen},
      {0.0f, StartKind::resampled, MutationKind::gaussian},
      {1.0f, StartKind::first_hit, MutationKind::kelemen},
  };
  for (const Variation& variation : variations) {
    RenderRequest request = small_request(IntegratorKind::pssmlt, 8, 64, 5);
    request.large_step = variation.large_step;
    request.start = variation.start;
    request.mutation = variation.mutation;
    request.bootstrap = 8192;
    if (variation.start == StartKind::first_hit) request.chains = 1;
    const auto pssmlt = render_replicates(scene, request, kReplicates, 100);
    const TileComparison tiles = compare_tiles(pssmlt, path, 4);
    INFO("large step " << variation.large_step << " start " << static_cast<int>(variation.start));
    CHECK(tiles.smallest_p_value > sidak_threshold(1e-3, std::size(variations) * tiles.tiles));
  }
}

TEST_CASE("Russian roulette on or off gives the same picture, by every integrator") {
  const SceneDescription scene = parse_scene_file("scenes/spheres.txt");
  for (const IntegratorKind kind : kIntegrators) {
    RenderRequest request = small_request(kind, 8, scaled_effort(64), 8);
    request.roulette = 0;
    const auto without = render_replicates(scene, request, 16, 1);
    for (const std::uint32_t edge : {1U, 4U}) {
      request.roulette = edge;
      const auto with = render_replicates(scene, request, 16, 100 * edge);
      const TileComparison tiles = compare_tiles(with, without, 4);
      INFO(name_of(kind) << " roulette from edge " << edge);
      CHECK(tiles.smallest_p_value > sidak_threshold(1e-3, 4 * tiles.tiles));
    }
  }
}

TEST_CASE("the mean luminance weighs pixels alike, though some take twice the samples") {
  // One of two pixels is bright in every sample: the mean is 1/2 exactly, and a third off were the first
  // pixel, which takes two sequences of samples, counted twice.
  REQUIRE(sequences_in(0, 0) == 2);
  REQUIRE(sequences_in(1, 0) == 1);
  RenderRequest request = small_request(IntegratorKind::path, 2, 16, 1);
  request.height = 1;
  const RenderResult result = render(
      "camera eye 0 0 1 target 0 0 0 fov 60\nmaterial black diffuse reflectance 0\n"
      "quad -9 -9 0  0 -9 0  0 9 0  -9 9 0 material black emit 1\n",
      request);
  CHECK(result.statistics.b == 0.5);
}

}  // namespace mlt::test
