// Pitfalls 14 and 16 for whole pictures: size and place of a scene, and the length of paths, must not show.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <string>

#include "render_fixture.hpp"
#include "support/moved_scene.hpp"

namespace mlt::test {
namespace {

// Slivers, needles and touching shapes in a lit room; coordinates are multiples of 1/64.
constexpr const char* kSlivers = R"(
camera eye 0.25 1.5 5.5 target 0 1 0 fov 45
material grey diffuse reflectance 0.7
material red diffuse reflectance 0.7 0.2 0.2
material glass dielectric ior 1.5
material metal conductor preset silver roughness 0.25
quad -2 0 -2  -2 0 2  2 0 2  2 0 -2 material grey
quad -2 0 -2  2 0 -2  2 3 -2  -2 3 -2 material red
quad -0.5 2.5 -0.5  0.5 2.5 -0.5  0.5 2.5 0.5  -0.5 2.5 0.5 material grey emit 12
triangle -1 0 0  1 0 0  0 2 0.015625 material grey
triangle -1.5 0 0.5  1.5 1.5 0.5  1.5 1.515625 0.5 material red
sphere 1 0.5 0.5 0.5 material glass
sphere -1 0.5 1 0.5 material metal
)";

}  // namespace

TEST_CASE("pitfall 16: exact moves and powers of two leave the film's hash as it is") {
  const SceneDescription scene = parse_scene_text(kSlivers, "test");
  for (const IntegratorKind kind : kIntegrators) {
    const RenderRequest request = small_request(kind, 24, 8, 6);
    const std::string hash = render(scene, request).statistics.film_hash;
    // 2^21 is more than 1e5 times the size; multiples of 1/64 keep all their bits there.
    for (const DVec3& offset : {DVec3{0x1p21, 0, 0}, DVec3{-0x1p21, 0x1p20, 0x1p21}}) {
      CHECK(render(moved(scene, 1, offset), request).statistics.film_hash == hash);
    }
    for (const double scale : {0x1p-20, 0x1p20, 0x1p-60, 0x1p50}) {
      CHECK(render(moved(scene, scale, {0, 0, 0}), request).statistics.film_hash == hash);
    }
  }
}

TEST_CASE("pitfalls 14 and 16: a scene of any size at any place gives the same picture") {
  const SceneDescription scenes[] = {parse_scene_text(kSlivers, "test"),
                                     parse_scene_file("scenes/CornellBox.txt")};
  for (const SceneDescription& scene : scenes) {
    // Edges and coordinates of the Cornell box reach 559.2.
    const double size = &scene == &scenes[0] ? 3 : 560;
    const RenderRequest request = small_request(IntegratorKind::path, 32, 16, 6);
    const RenderResult original = render(scene, request);
    const double far = 1e6 * size;
    struct Move {
      double scale;
      DVec3 offset;
    };
    const Move moves[] = {{1e-6, {0, 0, 0}},          {1e6, {0, 0, 0}},         {1e-4, {0, 0, 0}},
                          {1e4, {0, 0, 0}},           {1, {far, 0, 0}},         {1, {-far, far, far}},
                          {1e-6, {1e-6 * far, 0, 0}}, {1e6, {0, 0, 1e6 * far}}, {1 / 3.0, {1, 2, 3}}};
    for (const Move& move : moves) {
      const RenderResult result = render(moved(scene, move.scale, move.offset), request);
      const double share = difference_share(original, result);
      INFO("scale " << move.scale << " offset " << move.offset.x << ": differing share " << share);
      // The primary samples are the same, so pictures differ by rounding: a path now and then passes the
      // other side of an edge. Noise between two seeds is 40 times this bound.
      CHECK(share < 5e-3);
      CHECK(result.statistics.rejected_non_finite() == 0);
    }
    RenderRequest other_seed = request;
    other_seed.seed = 1;
    CHECK(difference_share(original, render(scene, other_seed)) > 0.1);
  }
}

TEST_CASE("pitfalls 14 and 16: PSSMLT's picture of a scaled and moved scene agrees, too") {
  const SceneDescription scene = parse_scene_text(kSlivers, "test");
  const RenderRequest request = small_request(IntegratorKind::pssmlt, 16, scaled_effort(32), 6);
  const auto original = render_replicates(scene, request, 16, 1);
  for (const double scale : {1e-6, 1e6}) {
    const auto other =
        render_replicates(moved(scene, scale, DVec3{1e6, -1e6, 1e6} * scale), request, 16, 100);
    const TileComparison tiles = compare_tiles(original, other, 4);
    INFO("scale " << scale);
    CHECK(tiles.smallest_p_value > sidak_threshold(1e-3, 2 * tiles.tiles));
  }
}

TEST_CASE("pitfall 14: radiance scales exactly with the lights' radiance over 40 orders of two") {
  // Powers of two commute with rounding, so every pixel is the same up to the factor, except for what
  // comes from the chain's float comparisons, which are ratios.
  const SceneDescription scene = parse_scene_text(kSlivers, "test");
  for (const IntegratorKind kind : kIntegrators) {
    const RenderRequest request = small_request(kind, 16, 8, 6);
    const RenderResult original = render(scene, request);
    for (const double factor : {0x1p-20, 0x1p20}) {
      SceneDescription brighter = scene;
      for (PolygonDescription& polygon : brighter.polygons) {
        if (polygon.attributes.emission) *polygon.attributes.emission *= factor;
      }
      RenderResult result = render(brighter, request);
      for (Vec3& pixel : result.image.pixels) pixel *= static_cast<float>(1 / factor);
      INFO(name_of(kind) << " factor " << factor);
      CHECK(largest_difference(result.image.view(), original.image.view()) == 0.0);
    }
  }
}

}  // namespace mlt::test
