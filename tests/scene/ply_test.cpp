#include <catch2/catch.hpp>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "scene/mesh_file.hpp"

using namespace mlt;

namespace {

constexpr MeshBudget kPlenty{1000, 1000};
using Indices = std::vector<std::uint32_t>;

MeshData read(const std::string& bytes, const MeshBudget& budget = kPlenty) {
  return read_ply(bytes, "m.ply", budget);
}

std::string fault(const std::string& bytes) {
  try {
    read(bytes);
  } catch (const InputError& error) {
    return error.diagnostics().at(0).to_string();
  }
  return "accepted";
}

template <class T>
std::string raw(std::initializer_list<T> values) {
  std::string bytes;
  for (const T value : values) {
    char copy[sizeof value];
    std::memcpy(copy, &value, sizeof value);
    bytes.append(copy, sizeof value);
  }
  return bytes;
}

std::string header(const std::string& format, const std::string& body) {
  return "ply\nformat " + format + " 1.0\n" + body + "end_header\n";
}

std::string positions(const std::string& count) {
  return "element vertex " + count + "\nproperty float x\nproperty float y\nproperty float z\n";
}

std::string faces(const std::string& count, const std::string& list = "list uchar int vertex_indices") {
  return "element face " + count + "\nproperty " + list + "\n";
}

const std::string kAscii = header("ascii", positions("3") + faces("1"));
const std::string kBinary = header("binary_little_endian", positions("3") + faces("1"));
const std::string kCorners = raw<float>({0, 0, 0, 1, 0, 0, 0, 1, 0.1f});

}  // namespace

TEST_CASE("PLY ascii") {
  const MeshData mesh = read(kAscii + "0 0 0\n1 0 0\n0 1 0.1\n3 2 1 0\n");
  REQUIRE(mesh.vertices.size() == 3);
  CHECK(mesh.vertices[2] == DVec3{0, 1, 0.1});
  CHECK(mesh.indices == Indices{2, 1, 0});
  CHECK(mesh.warnings.empty());
}

TEST_CASE("PLY binary") {
  const MeshData mesh = read(kBinary + kCorners + raw<std::uint8_t>({3}) + raw<std::int32_t>({2, 1, 0}));
  REQUIRE(mesh.vertices.size() == 3);
  CHECK(mesh.vertices[2] == DVec3{0, 1, double{0.1f}});
  CHECK(mesh.indices == Indices{2, 1, 0});
  CHECK(mesh.warnings.empty());
}

TEST_CASE("PLY data begin right behind the header's line end, whatever the first byte") {
  // 0x0a and 0x20 as first bytes of a float, which a reader that skips blanks would lose.
  for (const std::uint32_t bits : {0x3f80000aU, 0x3f800d0aU, 0x3f802020U}) {
    float first = 0;
    std::memcpy(&first, &bits, 4);
    const std::string data =
        raw<float>({first, 0, 0, 1, 1, 0, 0, 1, 0}) + raw<std::uint8_t>({3}) + raw<std::int32_t>({0, 1, 2});
    CHECK(read(kBinary + data).vertices[0].x == double{first});
  }
}

TEST_CASE("PLY of every type, with elements and properties that are passed over") {
  const std::string body =
      "comment a comment\nobj_info something\n"
      "element camera 2\nproperty float64 focus\nproperty list uint16 int16 lens\n"
      "element vertex 4\nproperty uchar red\nproperty double z\nproperty list char short tags\nproperty "
      "float32 x\n"
      "property float64 y\n"
      "element dust 2\nproperty int8 a\nproperty uint32 b\n"
      "element face 2\nproperty ushort flags\nproperty list int8 uint16 vertex_index\nproperty list uint int "
      "groups\n"
      "element edge 1\nproperty int a\n";
  std::string binary = header("binary_little_endian", body);
  binary += raw<double>({35}) + raw<std::uint16_t>({2}) + raw<std::int16_t>({1, 2});
  binary += raw<double>({50}) + raw<std::uint16_t>({0});
  for (int i = 0; i < 4; ++i) {
    binary +=
        raw<std::uint8_t>({255}) + raw<double>({i + 0.5}) + raw<std::int8_t>({1}) + raw<std::int16_t>({-3});
    binary += raw<float>({static_cast<float>(i * i)}) + raw<double>({-1.0 * i});
  }
  binary += raw<std::int8_t>({1}) + raw<std::uint32_t>({2}) + raw<std::int8_t>({3}) + raw<std::uint32_t>({4});
  binary += raw<std::uint16_t>({9}) + raw<std::int8_t>({3}) + raw<std::uint16_t>({0, 1, 2}) +
            raw<std::uint32_t>({1}) + raw<std::int32_t>({-1});
  binary += raw<std::uint16_t>({9}) + raw<std::int8_t>({4}) + raw<std::uint16_t>({3, 2, 1, 0}) +
            raw<std::uint32_t>({0});
  binary += raw<std::int32_t>({7});
  const std::string ascii = header("ascii", body) +
                            "35 2 1 2\n50 0\n"
                            "255 0.5 1 -3 0 0\n255 1.5 1 -3 1 -1\n255 2.5 1 -3 4 -2\n255 3.5 1 -3 9 -3\n"
                            "1 2\n3 4\n9 3 0 1 2 1 -1\n9 4 3 2 1 0 0\n7\n";
  for (const std::string& bytes : {binary, ascii}) {
    const MeshData mesh = read(bytes);
    REQUIRE(mesh.vertices.size() == 4);
    for (int i = 0; i < 4; ++i)
      CHECK(mesh.vertices[static_cast<std::size_t>(i)] == DVec3{i * i, -1.0 * i, i + 0.5});
    CHECK(mesh.indices == Indices{0, 1, 2, 3, 2, 1, 3, 1, 0});
    for (const std::string& warning : mesh.warnings)
      CHECK(warning == "1 polygons are not convex; split as fans all the same");
  }
}

TEST_CASE("PLY headers with carriage returns") {
  CHECK(read("ply\r\nformat ascii 1.0\r\n" + positions("3") + faces("1") +
             "end_header\r\n0 0 0\r\n1 0 0\r\n0 1 0\r\n3 0 1 2\r\n")
            .indices == Indices{0, 1, 2});
}

TEST_CASE("PLY counts beyond the file's size are refused before memory is taken") {
  for (const char* format : {"ascii", "binary_little_endian"}) {
    CAPTURE(format);
    CHECK_THAT(fault(header(format, positions("1000000000") + faces("1")) + "0123456789"),
               Catch::Contains("1000000000 elements 'vertex' are declared") &&
                   Catch::Contains("only 10 bytes follow"));
    CHECK_THAT(fault(header(format, positions("0") + faces("1000000000")) + "0123456789"),
               Catch::StartsWith("m.ply:7:9: 1000000000 elements 'face' are declared"));
    CHECK_THAT(fault(header(format, positions("9223372036854775807") + faces("1"))),
               Catch::Contains("elements 'vertex' are declared"));
    CHECK_THAT(fault(header(format, positions("99999999999999999999") + faces("1"))),
               Catch::Contains("is not a number of elements"));
    CHECK_THAT(fault(header(format, positions("-1") + faces("1"))),
               Catch::Contains("is not a number of elements"));
    // Without properties, records take no bytes, and any number of them would fit.
    CHECK_THAT(fault(header(format, "element nothing 1000000000000\n" + positions("0") + faces("0"))),
               Catch::Contains("has no properties"));
  }
  // A list as long as 32 bits allow.
  CHECK_THAT(
      fault(kBinary.substr(0, kBinary.find("element face")) + faces("1", "list uint int vertex_indices") +
            "end_header\n" + kCorners + raw<std::uint32_t>({0xffffffffU})),
      Catch::Contains("the face has 4294967295 corners"));
  CHECK_THAT(fault(header("binary_little_endian",
                          "element junk 1\nproperty list uint double j\n" + positions("0") + faces("0")) +
                   raw<std::uint32_t>({0xffffffffU})),
             Catch::Contains("no faces"));
  CHECK_THAT(fault(header("binary_little_endian",
                          "element junk 1\nproperty list uint double j\n" + positions("0") + faces("1")) +
                   raw<std::uint32_t>({0xffffffffU}) + "0123456789"),
             Catch::Contains("'junk' 0: the file ends inside the element"));
}

TEST_CASE("PLY elements must fit the file together, and a skipped list must fit to its last byte") {
  // 36 bytes hold three vertices or one face, and both counts fit alone, but not one after the other.
  CHECK_THAT(fault(header("binary_little_endian", positions("3") + faces("30")) + kCorners),
             Catch::StartsWith("m.ply:7:9: 30 elements 'face' are declared") &&
                 Catch::Contains("only 0 bytes follow"));
  // Two doubles are announced and 15 bytes follow.
  const std::string junk = header("binary_little_endian",
                                  "element vertex 0\nproperty float x\nproperty float y\n"
                                  "property float z\nelement junk 1\n"
                                  "property list uchar double j\n" +
                                      faces("1"));
  CHECK_THAT(fault(junk + raw<std::uint8_t>({2}) + std::string(15, '\0')),
             Catch::Contains("'junk' 0: the file ends inside the element"));
}

TEST_CASE("PLY data that end early or are wrong are refused with the record's number") {
  const std::string list = raw<std::uint8_t>({3});
  CHECK_THAT(fault(kBinary + kCorners + list + raw<std::int32_t>({0, 1})),
             Catch::Contains("'face' 0: the file ends inside the element"));
  CHECK_THAT(fault(kBinary + kCorners + list + raw<std::int32_t>({0, 1, 3})),
             Catch::Contains("'face' 0: vertex index 3 is out of range; there are 3 vertices"));
  CHECK_THAT(fault(kBinary + kCorners + list + raw<std::int32_t>({0, -1, 2})),
             Catch::Contains("vertex index -1 is out of range"));
  CHECK_THAT(fault(kBinary + kCorners + raw<std::uint8_t>({2}) + raw<std::int32_t>({0, 1, 3})),
             Catch::Contains("the face has 2 corners; 3 to 1024 are allowed"));
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    CHECK_THAT(
        fault(kBinary + raw<float>({0, 0, 0, 0, bad, 0, 0, 1, 0}) + list + raw<std::int32_t>({0, 1, 2})),
        Catch::Contains("'vertex' 1: the coordinate y is not a finite number"));
  }
  CHECK_THAT(fault(kAscii + "0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n"),
             Catch::StartsWith("m.ply:11:5: 'vertex' 1: 'nan'"));
  CHECK_THAT(fault(kAscii + "0 0 0\n1 0 0\n0 1 0\n3 0 1.5 2\n"),
             Catch::StartsWith("m.ply:13:5: 'face' 0: '1.5'"));
  CHECK_THAT(fault(kAscii + "0 0 0\n1 0 0\n0 1 0\n3 0 1 \n"),
             Catch::Contains("the file ends inside the element"));
  CHECK_THAT(fault(kAscii + "0 0 0\n1 0 0\n0 1 0\n-3 0 1 2\n"), Catch::Contains("has the length -3"));
}

TEST_CASE("PLY headers that promise nothing to render, or nonsense, are refused") {
  const std::string ascii = "ascii";
  CHECK_THAT(fault(""), Catch::StartsWith("m.ply:1:1: the file does not begin with a line 'ply'"));
  CHECK_THAT(fault("plx\n"), Catch::Contains("does not begin"));
  CHECK_THAT(fault("ply"), Catch::Contains("does not begin"));
  CHECK_THAT(fault("ply\n"), Catch::Contains("the file ends inside the header"));
  CHECK_THAT(
      fault("ply\nformat binary_big_endian 1.0\n"),
      Catch::StartsWith("m.ply:2:8: the format is 'binary_big_endian'; ascii and binary_little_endian"));
  CHECK_THAT(fault("ply\nformat ascii 2.0\n"), Catch::StartsWith("m.ply:2:14: the version is '2.0'"));
  CHECK_THAT(fault("ply\n" + positions("1") + "end_header\n"), Catch::Contains("has no format line"));
  CHECK_THAT(fault("ply\nformat ascii 1.0\nformat ascii 1.0\n"), Catch::Contains("a second format line"));
  CHECK_THAT(fault(header(ascii, faces("1")) + "3 0 1 2"), Catch::Contains("has no element 'vertex'"));
  CHECK_THAT(fault(header(ascii, positions("1")) + "0 0 0"), Catch::Contains("has no element 'face'"));
  CHECK_THAT(fault(header(ascii, faces("1") + positions("1")) + "3 0 0 0 0 0 0"),
             Catch::Contains("stands before 'vertex'"));
  CHECK_THAT(fault(header(ascii, "element vertex 1\nproperty float x\nproperty float y\n" + faces("1")) +
                   "0 0 3 0 0 0"),
             Catch::Contains("lacks x, y or z"));
  CHECK_THAT(fault(header(ascii, "element vertex 1\nproperty int x\nproperty float y\nproperty float z\n" +
                                     faces("1")) +
                   "0 0 0 3 0 0 0"),
             Catch::Contains("the property 'x' of 'vertex' must be float or double"));
  CHECK_THAT(
      fault(header(ascii, positions("1") + faces("1", "list uchar float vertex_indices")) + "0 0 0 3 0 0 0"),
      Catch::Contains("must have an integer type"));
  CHECK_THAT(fault(header(ascii, positions("1") + faces("1", "list float int vertex_indices"))),
             Catch::Contains("length of a list must have an integer type"));
  CHECK_THAT(fault(header(ascii, positions("1") + faces("1", "list uchar int corners")) + "0 0 0 3 0 0 0"),
             Catch::Contains("has no list vertex_indices"));
  CHECK_THAT(fault(header(ascii, positions("3") + faces("0")) + "0 0 0 0 0 0 0 0 0"),
             Catch::Contains("has no faces"));
  CHECK_THAT(fault(header(ascii, "property float x\n")), Catch::Contains("stands before the first element"));
  CHECK_THAT(fault(header(ascii, "element vertex 1\nproperty flaot x\n")),
             Catch::Contains("did you mean 'float'?"));
  CHECK_THAT(fault(header(ascii, "elemnet vertex 1\n")), Catch::Contains("did you mean 'element'"));
  CHECK_THAT(fault(header(ascii, positions("1") + positions("1"))),
             Catch::Contains("a second element 'vertex'"));
  CHECK_THAT(fault(header(ascii, "element vertex 1\nproperty float x\nproperty float x\n")),
             Catch::Contains("a second property 'x'"));
  CHECK_THAT(fault(header(ascii, "element vertex 1 2\n")), Catch::Contains("'2' is one word too many"));
}

TEST_CASE("PLY bytes after the last element are ignored with a warning") {
  CHECK(read(kAscii + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\nmore").warnings.size() == 1);
  CHECK(read(kBinary + kCorners + raw<std::uint8_t>({3}) + raw<std::int32_t>({2, 1, 0}) + "x")
            .warnings.size() == 1);
}

TEST_CASE("PLY meshes above the budget are a matter of resources") {
  const std::string bytes = kAscii + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  CHECK_THROWS_AS(read(bytes, MeshBudget{2, 10}), ResourceError);
  CHECK_THROWS_AS(read(bytes, MeshBudget{3, 0}), ResourceError);
  // One face may still become more triangles than are left.
  CHECK_THROWS_AS(read(kAscii + "0 0 0\n1 0 0\n0 1 0\n4 0 1 2 0\n", MeshBudget{3, 1}), ResourceError);
  CHECK(read(bytes, MeshBudget{3, 1}).indices.size() == 3);
}
