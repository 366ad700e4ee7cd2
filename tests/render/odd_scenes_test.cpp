// Scenes that break renderers: no light, light that nothing reaches, light behind glass, back sides, shapes
// without area, surfaces in one place. Each has a right picture.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <string>

#include "render_fixture.hpp"

namespace mlt::test {
namespace {

constexpr std::uint32_t kReplicates = 16;

bool is_black(const ImageBuffer& image) {
  for (const Vec3& pixel : image.pixels) {
    if (!(pixel == Vec3{0, 0, 0})) return false;
  }
  return true;
}

void check_black(const SceneDescription& scene) {
  for (const IntegratorKind kind : kIntegrators) {
    const RenderResult result = render(scene, small_request(kind, 8, 16, 6));
    INFO(name_of(kind));
    CHECK(is_black(result.image));
    CHECK(result.statistics.black);
    CHECK_FALSE(result.statistics.partial);
    CHECK(result.statistics.b == 0.0);
    CHECK(result.statistics.b_standard_error == 0.0);
    CHECK(result.statistics.rejected_non_finite() == 0);
    CHECK(result.statistics.film_hash.size() == 64);
  }
}

/// A floor lit by a lamp, with room for something between them; the view is so narrow that the radiance is
/// that of the origin (closed_form_test.cpp).
std::string lit_floor(const std::string& more) {
  return "camera eye -4 1.5 0.5 target 0 0 0 fov 0.004\nmaterial grey diffuse reflectance 0.5\n"
         "material glass dielectric ior 1\nmaterial black diffuse reflectance 0\n"
         "quad -5 0 -5  -5 0 5  5 0 5  5 0 -5 material grey\n" +
         more;
}

/// Radiance of that floor under the lamp "quad -1 2 -1  1 2 -1  1 2 1  -1 2 1 emit 10": four times the form
/// factor of a unit square at height 2 over its corner [Howell82 B-4].
constexpr double kLampRadiance = 1.1972823523038676;
constexpr const char* kLamp = "quad -1 2 -1  1 2 -1  1 2 1  -1 2 1 material black emit 10\n";

void check_radiance(const SceneDescription& scene, std::uint32_t depth, double expected, double slack) {
  for (const IntegratorKind kind : kIntegrators) {
    const auto replicates =
        render_replicates(scene, small_request(kind, 4, scaled_effort(256), depth), kReplicates, 40);
    const Moments measured = luminance_of(replicates);
    INFO(name_of(kind) << " " << measured.mean << " +- " << measured.standard_error() << ", exactly "
                       << expected);
    CHECK(mean_p_value(measured, expected, slack) > sidak_threshold(1e-3, 20));
    for (const RenderResult& replicate : replicates) {
      REQUIRE(replicate.statistics.rejected_non_finite() == 0);
    }
  }
}

std::string hash_of(const SceneDescription& scene, IntegratorKind kind) {
  return render(scene, small_request(kind, 16, 16, 5)).statistics.film_hash;
}

/// A triangle of a mesh by its corners.
void append(MeshDescription& mesh, const DVec3& a, const DVec3& b, const DVec3& c) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {a, b, c});
  mesh.indices.insert(mesh.indices.end(), {first, first + 1, first + 2});
}

/// Triangles without area, of every kind: one point, a line, a line with a corner twice.
void append_degenerate(MeshDescription& mesh) {
  append(mesh, {0.3, 1, 0.2}, {0.3, 1, 0.2}, {0.3, 1, 0.2});
  append(mesh, {-0.5, 1, 0}, {0, 1, 0}, {0.5, 1, 0});
  append(mesh, {-0.5, 1.5, 0}, {0.5, 1.5, 0.1}, {0.5, 1.5, 0.1});
}

}  // namespace

TEST_CASE("pitfall 6: a scene without light renders black, and says so") {
  check_black(
      parse_scene_text("camera eye 0 0 5 target 0 0 0\nmaterial grey diffuse reflectance 0.5\n"
                       "sphere 0 0 0 1 material grey\n",
                       "test"));
}

TEST_CASE("pitfall 6: a light that no path reaches renders black, and says so") {
  // Closed up in a black box that the camera looks at from outside.
  check_black(
      parse_scene_text("camera eye 0 0 5 target 0 0 0\nmaterial grey diffuse reflectance 0.5\n"
                       "material black diffuse reflectance 0\n"
                       "box -1 -1 -1 1 1 1 material black\n"
                       "sphere 0 0 0 0.5 material grey emit 5\n"
                       "quad -3 -1 -3  -3 -1 3  3 -1 3  3 -1 -3 material grey\n",
                       "test"));
  // All surfaces black, the light out of view: it shines, but nothing reflects it.
  check_black(
      parse_scene_text("camera eye 0 0 5 target 0 0 0 fov 20\nmaterial black diffuse reflectance 0\n"
                       "sphere 0 0 0 1 material black\n"
                       "sphere 0 0 20 0.5 material black emit 5\n",
                       "test"));
}

TEST_CASE("pitfall 6: PSSMLT draws a light so rare that most of its bootstrap is black") {
  // One pixel's worth of a large film sees the lamp, which lights nothing else.
  const SceneDescription scene = parse_scene_text(
      "camera eye 0 0 5 target 0 0 0 fov 90\nmaterial black diffuse reflectance 0\n"
      "sphere 0 0 0 0.05 material black emit 5\n",
      "test");
  RenderRequest request = small_request(IntegratorKind::pssmlt, 16, scaled_effort(64), 3);
  request.bootstrap = 65536;
  const Moments pssmlt = luminance_of(render_replicates(scene, request, kReplicates, 1));
  // The disc's share of the image plane: the sphere's outline at distance 5 has radius tan(asin(r/D)).
  const double radius = std::tan(std::asin(0.05 / 5));
  const double expected = 5 * 3.14159265358979323846 * radius * radius / 4;
  INFO(pssmlt.mean << " +- " << pssmlt.standard_error() << ", exactly " << expected);
  CHECK(mean_p_value(pssmlt, expected, 1e-5 * expected) > 1e-3);
}

TEST_CASE("pitfall 21: a lamp seen only through glass lights the floor as if it were bare") {
  // Glass of index 1 bends nothing, so the closed form stays; light sampling is blocked by it all the same,
  // and everything must come by BSDF sampling through the delta lobe with full weight. Two interfaces: 4
  // edges.
  const std::string shell = "box -1.5 1 -1.5 1.5 3 1.5 material glass\n";
  check_radiance(parse_scene_text(lit_floor(kLamp + shell), "test"), 4, kLampRadiance, 1.2e-5);
  check_radiance(
      parse_scene_text(lit_floor(std::string(kLamp) + "quad -2 1 -2  2 1 -2  2 1 2  -2 1 2 material glass\n"),
                       "test"),
      3, kLampRadiance, 1.2e-5);
}

TEST_CASE("pitfall 21: the back of a lamp is dark, seen directly, by light sampling and by reflection") {
  // The lamp turned over: its front faces up, away from floor and camera.
  const std::string turned = "quad -1 2 -1  -1 2 1  1 2 1  1 2 -1 material black emit 10\n";
  check_black(parse_scene_text(lit_floor(turned), "test"));
  check_black(parse_scene_text(
      "camera eye 0 0 0 target 0 2 0.01 fov 30\nmaterial black diffuse reflectance 0\n" + turned, "test"));
  // From inside a sphere its front is turned away, too.
  check_black(
      parse_scene_text("camera eye 0 0 0 target 0 0 1\nmaterial grey diffuse reflectance 0.5\n"
                       "sphere 0 0 0 1 material grey emit 3\nsphere 0 0 0.5 0.1 material grey\n",
                       "test"));
  // Both: only the side that faces the floor counts.
  check_radiance(parse_scene_text(lit_floor(kLamp + std::string("quad -1 2.1 -1  -1 2.1 1  1 2.1 1  1 2.1 -1 "
                                                                "material black emit 100\n")),
                                  "test"),
                 2, kLampRadiance, 1.2e-5);
}

TEST_CASE("pitfall 21: triangles without area are never hit and never shine") {
  // A lamp given as a mesh, with zero-area triangles among its two real ones; the reader would have dropped
  // them with a warning, and the world must stand them all the same.
  SceneDescription scene = parse_scene_text(lit_floor(""), "test");
  MeshDescription lamp;
  lamp.attributes.material = 2;
  lamp.attributes.emission = DVec3{10, 10, 10};
  append_degenerate(lamp);
  append(lamp, {-1, 2, -1}, {1, 2, -1}, {1, 2, 1});
  append_degenerate(lamp);
  append(lamp, {-1, 2, -1}, {1, 2, 1}, {-1, 2, 1});
  append_degenerate(lamp);
  scene.meshes.push_back(lamp);
  check_radiance(scene, 2, kLampRadiance, 1.2e-5);

  // A lamp of nothing but such triangles is no light.
  MeshDescription dark;
  dark.attributes.material = 2;
  dark.attributes.emission = DVec3{10, 10, 10};
  append_degenerate(dark);
  SceneDescription without = parse_scene_text(lit_floor(""), "test");
  without.meshes.push_back(dark);
  check_black(without);
}

TEST_CASE("pitfall 21: what the reader drops for want of area, it counts in a warning") {
  const SceneDescription scene = parse_scene_text(
      "camera eye 0 0 5 target 0 0 0\nmaterial grey diffuse reflectance 0.5\n"
      "sphere 0 0 0 1 material grey emit 1\ntriangle 0 0 0 1 1 1 2 2 2 material grey\n"
      "inline_mesh material grey emit 2\nvertex 0 0 0\nvertex 1 0 0\nvertex 2 0 0\nvertex 0 3 0\n"
      "face 0 1 2\nface 0 1 3\nend\n",
      "test");
  CHECK(scene.polygons.empty());
  REQUIRE(scene.meshes.size() == 1);
  CHECK(scene.meshes[0].indices.size() == 3);
  CHECK(scene.warnings.size() == 2);
}

TEST_CASE(
    "pitfall 20: of equal shapes in one place the first listed is seen, from lists and hierarchy alike") {
  const std::string view =
      "camera eye 0.3 1 4 target 0 0.9 0 fov 50\nmaterial red diffuse reflectance 0.8 0.1 0.1\n"
      "material green diffuse reflectance 0.1 0.8 0.1\n"
      "quad -0.5 2.5 -0.5  0.5 2.5 -0.5  0.5 2.5 0.5  -0.5 2.5 0.5 material red emit 9\n";
  const auto quads = [](const std::string& colour) {
    return "quad -2 0 -2  -2 0 2  2 0 2  2 0 -2 material " + colour +
           "\nquad -2 0 -2  2 0 -2  2 3 -2  -2 3 -2 material " + colour + "\n";
  };
  // The two halves of each quad meet at a shared edge.
  const auto triangles = [](const std::string& colour) {
    return "triangle -2 0 -2  -2 0 2  2 0 2 material " + colour +
           "\ntriangle -2 0 -2  2 0 2  2 0 -2 material " + colour +
           "\ntriangle -2 0 -2  2 0 -2  2 3 -2 material " + colour +
           "\ntriangle -2 0 -2  2 3 -2  -2 3 -2 material " + colour + "\n";
  };
  for (const IntegratorKind kind : kIntegrators) {
    INFO(name_of(kind));
    const auto hash = [&](const std::string& shapes) {
      return hash_of(parse_scene_text(view + shapes, "test"), kind);
    };
    const std::string of_quads = hash(quads("red"));
    const std::string of_triangles = hash(triangles("red"));
    CHECK(hash(quads("red") + quads("green")) == of_quads);
    CHECK(hash(quads("green") + quads("red")) != of_quads);
    CHECK(hash(triangles("red") + triangles("green")) == of_triangles);
    CHECK(hash(triangles("green") + triangles("red")) != of_triangles);
    // So many copies that a bounding volume hierarchy takes the place of the list.
    std::string many = triangles("red");
    for (int copy = 0; copy < 100; ++copy) many += triangles("green");
    CHECK(hash(many) == of_triangles);
  }
}

}  // namespace mlt::test
