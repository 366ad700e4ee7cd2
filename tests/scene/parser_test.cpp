#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "scene/limits.hpp"
#include "scene/statements.hpp"
#include "scene_text.hpp"

using namespace mlt;
using namespace mlt::test;

TEST_CASE("A small scene is read in full") {
  const SceneDescription scene = parse_scene_text(
      "film 40 30\ndepth 7\n"
      "camera fov 30 target 0 1 0 eye 0 2 -5 up 0 0 1\n"
      "material red diffuse reflectance 0.6 0.1 0.1\n"
      "material m mirror reflectance 0.9\n"
      "material g dielectric ior 1.33\n"
      "material c conductor roughness 0.25 eta 1 2 3 k 0 5 6\n"
      "material au conductor preset gold\n"
      "sphere 1 2 3 0.5 material g emit 1 0 2\n"
      "triangle 0 0 0 1 0 0 0 1 0 material c\n",
      "s.txt");
  CHECK((scene.path == "s.txt" && scene.film_width == 40 && scene.film_height == 30 && scene.depth == 7U));
  CHECK(scene.camera.eye == DVec3{0, 2, -5});
  CHECK(scene.camera.target == DVec3{0, 1, 0});
  CHECK(scene.camera.up == DVec3{0, 0, 1});
  CHECK(scene.camera.vertical_fov_degrees == 30.0);
  CHECK(scene.camera.location.line == 3);
  REQUIRE(scene.materials.size() == 5);
  CHECK((scene.materials[0].name == "red" && scene.materials[0].kind == MaterialKind::diffuse));
  CHECK(scene.materials[0].reflectance == DVec3{0.6, 0.1, 0.1});
  CHECK((scene.materials[1].kind == MaterialKind::mirror &&
         scene.materials[1].reflectance == DVec3{0.9, 0.9, 0.9}));
  CHECK((scene.materials[2].kind == MaterialKind::dielectric && scene.materials[2].ior == 1.33));
  CHECK((scene.materials[3].kind == MaterialKind::conductor && scene.materials[3].roughness == 0.25));
  CHECK((scene.materials[3].eta == DVec3{1, 2, 3} && scene.materials[3].k == DVec3{0, 5, 6}));
  CHECK((scene.materials[4].eta == DVec3{0.143, 0.375, 1.442} && scene.materials[4].roughness == 0));
  REQUIRE(scene.spheres.size() == 1);
  CHECK((scene.spheres[0].center == DVec3{1, 2, 3} && scene.spheres[0].radius == 0.5));
  CHECK(
      (scene.spheres[0].attributes.material == 2 && scene.spheres[0].attributes.emission == DVec3{1, 0, 2}));
  CHECK((scene.spheres[0].attributes.location.line == 9 && scene.spheres[0].attributes.location.column == 1));
  REQUIRE(scene.polygons.size() == 1);
  CHECK((scene.polygons[0].corner_count == 3 && !scene.polygons[0].attributes.emission));
  CHECK(scene.warnings.empty());
}

TEST_CASE("Defaults of the settings are those of the description") {
  const SceneDescription scene = parse_with("");
  CHECK((scene.film_width == 256 && scene.film_height == 256 && !scene.depth.has_value()));
  CHECK((scene.camera.up == DVec3{0, 1, 0} && scene.camera.vertical_fov_degrees == 45.0));
}

TEST_CASE("Every preset of a conductor reflects as a metal does") {
  // Reflectance at normal incidence of the four metals in the visible range lies in [0.3, 1); silver and
  // aluminium are nearly grey, gold and copper reddish.
  for (const ConductorPreset& preset : kConductorPresets) {
    CAPTURE(preset.name);
    double reflectance[3] = {};
    for (int i = 0; i < 3; ++i) {
      const double n = preset.eta[i];
      const double k2 = preset.k[i] * preset.k[i];
      reflectance[i] = ((n - 1) * (n - 1) + k2) / ((n + 1) * (n + 1) + k2);
      CHECK((reflectance[i] > 0.3 && reflectance[i] < 1));
    }
    const bool reddish = std::string(preset.name) == "gold" || std::string(preset.name) == "copper";
    CHECK((reflectance[0] - reflectance[2] > 0.3) == reddish);
    CHECK((reflectance[0] > 0.8));
  }
}

TEST_CASE("Constants stand for one or more words, at the place of their use") {
  const SceneDescription scene = parse_with(
      "define ball 1 2 3\ndefine look material m emit 5\ndefine both $ball 4 $look\nsphere $both\nsphere "
      "$ball 2 $look\n");
  REQUIRE(scene.spheres.size() == 3);
  CHECK((scene.spheres[1].radius == 4 && scene.spheres[2].radius == 2));
  CHECK(scene.spheres[1].center == DVec3{1, 2, 3});
  CHECK(scene.spheres[2].attributes.emission == DVec3{5, 5, 5});
  const auto faults = faults_of(scene_with("define r 0 0 x\nsphere $r 1 material m\n"));
  REQUIRE(faults.size() == 1);
  CHECK_THAT(faults[0], Catch::StartsWith("test.txt:5:8: 'x' is not a number"));
}

TEST_CASE("Constants that multiply themselves are stopped by the limit on words") {
  std::string half = "define half";
  for (std::size_t i = 0; i < kMaxStatementTokens / 2; ++i) half += " 1";
  // "define one $half" has 514 words, "define two $half $half" 1026.
  const auto beyond = faults_of(scene_with(half + "\ndefine one $half\ndefine two $half $half\n"));
  REQUIRE(beyond.size() == 1);
  CHECK_THAT(beyond[0], Catch::StartsWith("test.txt:6:18: the statement has more than 1024 words"));
  std::string lines = "define a0 1 1 1 1 1 1 1 1\n";
  for (int i = 1; i < 40; ++i) {
    const std::string before = " $a" + std::to_string(i - 1);
    lines += "define a" + std::to_string(i) + before + before + before + before + "\n";
  }
  const auto faults = faults_of(scene_with(lines));
  CHECK_THAT(faults.at(0), Catch::Contains("more than 1024 words after its constants are replaced"));
}

TEST_CASE("An inline mesh has its own vertices, clauses and transforms") {
  const SceneDescription scene = parse_with(
      "inline_mesh material m emit 2 translate 0 0 1 scale 2\n"
      "vertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0 # a comment\n\nvertex 0 1 0\nface 0 1 2 3\nface 2 1 "
      "0\nend\n");
  REQUIRE(scene.meshes.size() == 1);
  const MeshDescription& mesh = scene.meshes[0];
  CHECK(mesh.indices == std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3, 2, 1, 0});
  CHECK(mesh.vertices[2] == DVec3{2, 2, 2});
  CHECK(mesh.attributes.emission == DVec3{2, 2, 2});
  CHECK(mesh.attributes.location.line == 4);
}

TEST_CASE("Several faults are reported, each once, in the order of the lines") {
  const auto faults = faults_of(
      "camera eye 0 0 5 target 0 0 0\n"
      "materail m diffuse reflectance 1\n"
      "material n diffuse reflectance 2\n"
      "sphere 0 0 0 1 material n\n"
      "inline_mesh material q\n"
      "vertex 0 0 0\nface 0 0 0\nend\n"
      "sphere 0 0 0 material n\n");
  REQUIRE(faults.size() == 4);
  CHECK_THAT(faults[0],
             Catch::StartsWith("test.txt:2:1: 'materail' is not a statement, did you mean 'material'"));
  CHECK_THAT(faults[1],
             Catch::StartsWith("test.txt:3:32: a channel of the reflectance is 2; allowed is in [0, 1]"));
  CHECK_THAT(faults[2], Catch::StartsWith("test.txt:5:22: no material 'q' stands before this line"));
  CHECK_THAT(faults[3],
             Catch::StartsWith("test.txt:9:14: 'material' is not a number; the radius is expected"));
}

TEST_CASE("After twenty faults the reader gives up") {
  std::string text;
  for (int i = 0; i < 1000; ++i) text += "nonsense\n";
  CHECK(faults_of(text).size() == kMaxDiagnostics);
}

TEST_CASE("Warnings beyond the limit are only counted") {
  std::string lines;
  for (int i = 0; i < 60; ++i) lines += "triangle 0 0 0 1 0 0 2 0 0 material m\n";
  const SceneDescription scene = parse_with(lines);
  REQUIRE(scene.warnings.size() == kMaxWarnings + 1);
  CHECK(scene.warnings[0] == "test.txt:4:1: degenerate triangle dropped");
  CHECK(scene.warnings.back() == "10 more warnings not shown");
}

TEST_CASE("pitfall 6: a scene without a light is accepted with a warning") {
  const SceneDescription scene =
      parse_scene_text(std::string(kCamera) + kMaterial + "sphere 0 0 0 1 material m\n", "dark.txt");
  REQUIRE(scene.warnings.size() == 1);
  CHECK(scene.warnings[0] == "dark.txt: the scene has no light; its image is black");
}

TEST_CASE("Every scene file of the project is read without warnings") {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("scenes")) {
    if (entry.path().extension() != ".txt") continue;
    CAPTURE(entry.path().string());
    const SceneDescription scene = parse_scene_file(entry.path().string());
    CHECK(scene.warnings.empty());
    CHECK(scene.depth.has_value());
    ++count;
  }
  CHECK(count >= 14);
  // Parallelograms alone, so that the renderer's fastest path applies.
  for (const char* name : {"CornellBox", "CornellBox2", "cornell_hidden"}) {
    const SceneDescription scene = parse_scene_file("scenes/" + std::string(name) + ".txt");
    CHECK(scene.polygons.size() == 18);
    for (const PolygonDescription& polygon : scene.polygons) CHECK(polygon.corner_count == 4);
  }
}
