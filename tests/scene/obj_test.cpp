#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "scene/mesh_file.hpp"

using namespace mlt;

namespace {

constexpr MeshBudget kPlenty{1000, 1000};
constexpr char kSquare[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

MeshData read(const std::string& text, const MeshBudget& budget = kPlenty) {
  return read_obj(text, "m.obj", budget);
}

MeshData read_square(const std::string& text) {
  return read(kSquare + text);
}

std::vector<std::string> faults(const std::string& text) {
  std::vector<std::string> lines;
  try {
    read(text);
  } catch (const InputError& error) {
    for (const Diagnostic& diagnostic : error.diagnostics()) lines.push_back(diagnostic.to_string());
  }
  return lines;
}

using Indices = std::vector<std::uint32_t>;

}  // namespace

TEST_CASE("OBJ vertices and faces of all forms") {
  const MeshData mesh = read_square("f 1 2 3\nf 1/7 2/8 3/9\nf 1//7 3//8 4//9\nf 1/1/1 2/2/2 4/3/3\n");
  REQUIRE(mesh.vertices.size() == 4);
  CHECK(mesh.vertices[2] == DVec3{1, 1, 0});
  CHECK(mesh.indices == Indices{0, 1, 2, 0, 1, 2, 0, 2, 3, 0, 1, 3});
  CHECK(mesh.warnings.empty());
}

TEST_CASE("OBJ numbers keep double precision, weights and colours are passed over") {
  const MeshData mesh = read("v 0.1 -1e-3 +2.5 1.0\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0\nf 1 2 3");
  CHECK(mesh.vertices[0] == DVec3{0.1, -1e-3, 2.5});
}

TEST_CASE("OBJ negative indices count from the last vertex above") {
  CHECK(read_square("f -4 -3 -2\nv 5 5 5\nf -1 -5 -4").indices == Indices{0, 1, 2, 4, 0, 1});
}

TEST_CASE("OBJ polygons become fans") {
  CHECK(read_square("f 1 2 3 4").indices == Indices{0, 1, 2, 0, 2, 3});
  const MeshData pentagon = read("v 0 0 0\nv 2 0 0\nv 3 1 0\nv 1 2 0\nv -1 1 0\nf 5 4 3 2 1");
  CHECK(pentagon.indices == Indices{4, 3, 2, 4, 2, 1, 4, 1, 0});
  CHECK(pentagon.warnings.empty());
  // A dart, from a corner whose fan overlaps itself.
  const MeshData dart = read("v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\nf 2 3 4 1");
  REQUIRE(dart.warnings.size() == 1);
  CHECK(dart.warnings[0] == "1 polygons are not convex; split as fans all the same");
}

TEST_CASE("OBJ comments, line ends and continued lines") {
  CHECK(read_square("# f 9 9 9\r\n\r\nf 1 2 \\\r\n 3\r\nf 1 \\\n 2 3 # trailing\n").indices ==
        Indices{0, 1, 2, 0, 1, 2});
}

TEST_CASE("OBJ statements without shape are ignored, unknown ones with one warning") {
  const MeshData mesh =
      read_square("vt 0 0\nvn 0 0 1\ng a\no b\ns 1\nusemtl c\nmtllib d\nl 1 2\np 1\nf 1 2 3\n");
  CHECK(mesh.warnings.empty());
  const MeshData odd = read_square("foo 1\nf 1 2 3\nbar\n");
  REQUIRE(odd.warnings.size() == 1);
  CHECK(odd.warnings[0] == "2 lines with unknown OBJ statements ignored, the first 'foo' in line 5");
}

TEST_CASE("OBJ faults have line and column, and several are reported") {
  const std::vector<std::string> lines =
      faults("v 0 0 0\nv 1 nan 0\nv 0 1\nf 1 2 4\nf 1 x 1\nf 1/ 1 1\nf 1 1\nf 0 1 1\nf 1/a 1 1\nf -4 1 1\n");
  REQUIRE(lines.size() == 9);
  CHECK_THAT(lines[0], Catch::StartsWith("m.obj:2:5: 'nan' is not a finite number"));
  CHECK_THAT(lines[1], Catch::StartsWith("m.obj:3:6: the line ends where a coordinate is expected"));
  CHECK_THAT(lines[2],
             Catch::StartsWith("m.obj:4:7: vertex index 4 is out of range; 3 vertices stand before"));
  CHECK_THAT(lines[3], Catch::StartsWith("m.obj:5:5: 'x' is no corner of a face"));
  CHECK_THAT(lines[4], Catch::StartsWith("m.obj:6:3: '1/' is no corner"));
  CHECK_THAT(lines[5], Catch::StartsWith("m.obj:7:6: the face has 2 corners; at least 3 are expected"));
  CHECK_THAT(lines[6], Catch::StartsWith("m.obj:8:3: vertex index 0 is out of range"));
  CHECK_THAT(lines[7], Catch::StartsWith("m.obj:9:3: '1/a' is no corner"));
  CHECK_THAT(lines[8], Catch::StartsWith("m.obj:10:3: vertex index -4 is out of range"));
}

TEST_CASE("OBJ files without a face, and empty ones, are refused") {
  CHECK_THAT(faults("").at(0), Catch::StartsWith("m.obj: the OBJ file has 0 vertices and no face"));
  CHECK_THAT(faults(kSquare).at(0), Catch::StartsWith("m.obj: the OBJ file has 4 vertices and no face"));
}

TEST_CASE("OBJ faults beyond the twentieth are not collected") {
  std::string text = kSquare;
  for (int i = 0; i < 100; ++i) text += "f 1 2 9\n";
  CHECK(faults(text).size() == 20);
}

TEST_CASE("OBJ meshes above the budget are a matter of resources") {
  CHECK_THROWS_AS(read(kSquare, MeshBudget{3, 10}), ResourceError);
  CHECK_THROWS_AS(read(kSquare + std::string("f 1 2 3 4"), MeshBudget{4, 1}), ResourceError);
  CHECK(read(kSquare + std::string("f 1 2 3 4"), MeshBudget{4, 2}).indices.size() == 6);
}
