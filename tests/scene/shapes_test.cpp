#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "scene/limits.hpp"
#include "scene_text.hpp"

using namespace mlt;
using namespace mlt::test;

namespace {

DVec3 normal_of(const PolygonDescription& polygon) {
  return normalize(cross(polygon.corners[1] - polygon.corners[0], polygon.corners[2] - polygon.corners[0]));
}

DVec3 middle_of(const PolygonDescription& polygon) {
  DVec3 sum{0, 0, 0};
  for (std::uint32_t i = 0; i < polygon.corner_count; ++i) sum += polygon.corners[i];
  return sum / static_cast<double>(polygon.corner_count);
}

/// Sum of the signed tetrahedra from the origin: the enclosed volume when all faces turn outwards.
double volume_of(const SceneDescription& scene) {
  double volume = 0;
  for (const PolygonDescription& polygon : scene.polygons) {
    for (std::uint32_t i = 2; i < polygon.corner_count; ++i) {
      volume += dot(cross(polygon.corners[0], polygon.corners[i - 1]), polygon.corners[i]) / 6;
    }
  }
  for (const MeshDescription& mesh : scene.meshes) {
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      const auto at = [&](std::size_t corner) { return mesh.vertices[mesh.indices[i + corner]]; };
      volume += dot(cross(at(0), at(1)), at(2)) / 6;
    }
  }
  return volume;
}

std::string first_fault(const std::string& lines) {
  return faults_of(scene_with(lines)).at(0);
}

}  // namespace

TEST_CASE("A box has six parallelograms that face outwards, or inwards") {
  for (const bool inward : {false, true}) {
    const SceneDescription scene =
        parse_with("box 1 2 3 2 4 6 material m" + std::string(inward ? " inward" : ""));
    REQUIRE(scene.polygons.size() == 6);
    for (const PolygonDescription& face : scene.polygons) {
      CHECK(face.corner_count == 4);
      const double side = dot(normal_of(face), middle_of(face) - DVec3{1.5, 3, 4.5});
      CHECK((inward ? side < 0 : side > 0));
    }
    CHECK(volume_of(scene) == Approx(inward ? -6 : 6).epsilon(1e-14));
  }
}

TEST_CASE("The front stays in front under reflections, for every kind of shape") {
  for (const char* transform :
       {"", " scale -1 1 1", " scale 1 -2 1 rotate 30 1 2 3", " scale -1", " scale -1 -1 1"}) {
    CAPTURE(transform);
    const std::string clauses = std::string(" material m emit 1") + transform + "\n";
    CHECK(volume_of(parse_with("box 1 1 1 2 2 2" + clauses)) > 0);
    CHECK(volume_of(parse_with("inline_mesh" + clauses +
                               "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nvertex 0 0 1\n"
                               "face 0 2 1\nface 0 1 3\nface 0 3 2\nface 1 2 3\nend\n")) > 0);
    // Two triangles that, with the normals along +z, see the point (0, 0, 1) scaled by the same transform.
    const SceneDescription scene =
        parse_with("triangle 0 0 0 1 0 0 0 1 0" + clauses + "quad 0 0 0 2 0 0 1 1 0 0 1 0" + clauses +
                   "triangle 5 5 1 6 5 1 5 6 1" + clauses);
    REQUIRE(scene.polygons.size() == 4);
    for (std::size_t i = 0; i < 3; ++i) {
      CHECK(dot(normal_of(scene.polygons[i]), middle_of(scene.polygons[3]) - scene.polygons[i].corners[0]) >
            0);
    }
  }
}

TEST_CASE("Quads: parallelograms stay one, other planar convex ones become two triangles") {
  const SceneDescription one = parse_with("quad 0 0 0 1 0 0 1.5 1 0.2 0.5 1 0.2 material m");
  REQUIRE(one.polygons.size() == 1);
  CHECK(one.polygons[0].corner_count == 4);
  const SceneDescription two = parse_with("quad 0 0 0 2 0 0 1 1 0 0 1 0 material m emit 1");
  REQUIRE(two.polygons.size() == 2);
  CHECK(two.polygons[0].corner_count == 3);
  CHECK(two.polygons[1].corners[1] == DVec3{1, 1, 0});
  CHECK(two.polygons[1].attributes.emission.has_value());
  // Within and beyond the tolerance of a parallelogram, 1e-6 of the diagonal of 1.41.
  CHECK(parse_with("quad 0 0 0 1 0 0 1.0000013 1 0 0 1 0 material m").polygons.size() == 1);
  CHECK(parse_with("quad 0 0 0 1 0 0 1.0000016 1 0 0 1 0 material m").polygons.size() == 2);
  // Written with six digits after a rotation: still one.
  CHECK(parse_with("quad 0 0 0 0.866025 0.5 0 0.366025 1.366025 0 -0.5 0.866025 0 material m")
            .polygons.size() == 1);
  // Two equal corners are a triangle; the rest of the quad has no area.
  const SceneDescription degenerate = parse_with("quad 0 0 0 1 0 0 1 0 0 0 1 0 material m");
  CHECK((degenerate.polygons.size() == 1 && degenerate.warnings.size() == 1));
}

TEST_CASE("Quads that are not planar, not convex or crossed are errors") {
  CHECK_THAT(first_fault("quad 0 0 0 1 0 0 2 2 0.01 0 1 0 material m"), Catch::Contains("not planar"));
  CHECK(parse_with("quad 0 0 0 1 0 0 2 2 0.0001 0 1 0 material m").polygons.size() == 2);
  CHECK_THAT(first_fault("quad 0 0 0 4 0 0 1 1 0 0 4 0 material m"),
             Catch::Contains("not convex at corner 3"));
  CHECK_THAT(first_fault("quad 0 0 0 1 1 0 1 0 0 0 2 0 material m"), Catch::Contains("not convex"));
  CHECK_THAT(first_fault("quad 0 0 0 1 1 0 1 0 0 0 1 0 material m"), Catch::Contains("crosses itself"));
}

TEST_CASE("pitfall 21: shapes and lights without area are dropped with a warning") {
  const SceneDescription scene = parse_with(
      "triangle 0 0 0 1 0 0 2 0 0 material m\n"
      "triangle 1 1 1 1 1 1 0 0 0 material m emit 1\n"
      "quad 0 0 0 1 0 0 2 0 0 3 0 0 material m emit 1\n"
      "quad 0 0 0 1 0 0 1 0 0 0 0 0 material m\n"
      "sphere 0 0 0 0 material m emit 1\n"
      "inline_mesh material m emit 1\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nface 0 1 0\nface 0 1 2\nface "
      "1 1 1\nend\n"
      "inline_mesh material m\nvertex 0 0 0\nvertex 1 0 0\nface 0 1 0\nend\n"
      "triangle 0 0 0 1e-31 0 0 0 1e-31 0 material m\n"
      "triangle 0 0 0 1 0 0 0.5 1e-13 0 material m\n"
      "sphere 0 0 0 1 material m emit 0\n");
  CHECK((scene.polygons.empty() && scene.spheres.size() == 2));
  REQUIRE(scene.meshes.size() == 1);
  CHECK(scene.meshes[0].indices.size() == 3);
  CHECK_FALSE(scene.spheres[1].attributes.emission.has_value());
  const char* const expected[] = {
      "test.txt:4:1: degenerate triangle dropped",
      "test.txt:5:1: degenerate triangle dropped; it was to emit light",
      "test.txt:6:1: degenerate quad dropped; it was to emit light",
      "test.txt:7:1: degenerate quad dropped",
      "test.txt:8:1: sphere of radius 0 dropped; it was to emit light",
      "test.txt:9:1: 2 degenerate triangles of inline_mesh dropped; it was to emit light",
      "test.txt:17:1: 1 degenerate triangle of inline_mesh dropped",
      "test.txt:17:1: inline_mesh without a triangle dropped",
      "test.txt:22:1: degenerate triangle dropped",
      "test.txt:23:1: degenerate triangle dropped",
      "test.txt:24:27: an emission of 0 0 0 dropped; the shape is no light"};
  REQUIRE(scene.warnings.size() == std::size(expected));
  for (std::size_t i = 0; i < std::size(expected); ++i) CHECK(scene.warnings[i] == expected[i]);
}

TEST_CASE("Slivers that are thin but not flat are kept, at any scale") {
  for (const char* scale : {"1", "1e-12", "1e15"}) {
    CAPTURE(scale);
    const std::string lines = "triangle 0 0 0 1 0 0 0.5 1e-10 0 material m scale " + std::string(scale);
    CHECK(parse_with(lines).polygons.size() == 1);
  }
}

TEST_CASE("Duplicate triangles are kept, for their order decides") {
  CHECK(parse_with("triangle 0 0 0 1 0 0 0 1 0 material m\ntriangle 0 0 0 1 0 0 0 1 0 material m\n")
            .polygons.size() == 2);
}

TEST_CASE("Spheres follow similarities and nothing else") {
  const SceneDescription scene =
      parse_with("sphere 1 0 0 2 material m scale -3 rotate 90 0 0 1 translate 0 0 5");
  REQUIRE(scene.spheres.size() == 2);
  CHECK(scene.spheres[1].radius == Approx(6).epsilon(1e-15));
  // The quarter turn is exact.
  CHECK(scene.spheres[1].center == DVec3{0, -3, 5});
  CHECK_THAT(first_fault("sphere 0 0 0 1 material m scale 1 2 1"),
             Catch::StartsWith("test.txt:4:1: the transforms of the sphere scale it unevenly"));
  CHECK(parse_with("sphere 0 0 0 1 material m scale 2 1 1 scale 1 2 2").spheres[1].radius == 2);
}

TEST_CASE("Transforms that are singular or leave the range of numbers are errors") {
  CHECK_THAT(first_fault("box 0 0 0 1 1 1 material m scale 1 0 1"), Catch::Contains("singular"));
  CHECK_THAT(first_fault("box 0 0 0 1 1 1 material m rotate 10 0 0 0"),
             Catch::Contains("axis of the rotation has length 0"));
  CHECK_THAT(
      first_fault(
          "box 0 0 0 1 1 1 material m scale 1e-17 scale 1e-17 scale 1e-17 scale 1e-17 scale 1e-17 scale "
          "1e-17 scale 1e-17"),
      Catch::Contains("singular or out of the range"));
  CHECK_THAT(first_fault("box 0 0 0 1 1 1 material m scale 1e17 scale 1e17"),
             Catch::Contains("after its transforms"));
  CHECK_THAT(first_fault("box 0 0 0 1 1 1 material m translate 1e300 0 0 scale 1e17"),
             Catch::Contains("after its transforms"));
  CHECK_THAT(first_fault("box 0 0 0 1 1 1 material m translate 1e308 0 0 translate 1e308 0 0 scale -1"),
             Catch::Contains("after its transforms"));
  CHECK_THAT(first_fault("sphere 0 0 0 1e18 material m scale 2"), Catch::Contains("radius is 2e+18"));
}
