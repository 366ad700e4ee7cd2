// Meshes from files far from the origin: OBJ has decimal numbers, which are read in double; PLY's are float,
// and coarser than the mesh from some distance on, which nothing can mend afterwards.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "scenes.hpp"
#include "support/temporary_folder.hpp"
#include "sweep.hpp"

namespace mlt::test {
namespace {

/// Corners of a box of side 2, bits of the index: x, y, z; faces that look inward.
constexpr int kFaces[6][4] = {{0, 2, 6, 4}, {1, 5, 7, 3}, {0, 4, 5, 1},
                              {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 6, 7, 5}};

DVec3 corner(int index, const DVec3& offset) {
  return DVec3{(index & 1) != 0 ? 1 : -1, (index & 2) != 0 ? 1 : -1, (index & 4) != 0 ? 1 : -1} + offset;
}

/// `sizes` times the box's size away.
DVec3 offset_of(double sizes) {
  return DVec3{1, -0.7, 0.3} * (2 * sizes * 1.0123456789);
}

std::string text_of(const DVec3& p) {
  return exact_text_of(p.x) + " " + exact_text_of(p.y) + " " + exact_text_of(p.z);
}

std::string obj_of(const DVec3& offset) {
  std::string text;
  for (int i = 0; i < 8; ++i) text += "v " + text_of(corner(i, offset)) + "\n";
  for (const auto& face : kFaces) {
    text += "f";
    for (const int index : face) text += " " + std::to_string(index + 1);
    text += "\n";
  }
  return text;
}

/// Binary, little-endian as all machines that this runs on.
std::string ply_of(const DVec3& offset) {
  std::string text =
      "ply\nformat binary_little_endian 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
      "property float z\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n";
  const auto append = [&text](const auto& value) {
    std::array<char, sizeof value> bytes;
    std::memcpy(bytes.data(), &value, sizeof value);
    text.append(bytes.data(), bytes.size());
  };
  for (int i = 0; i < 8; ++i) {
    const Vec3 p{corner(i, offset)};
    append(p.x);
    append(p.y);
    append(p.z);
  }
  for (const auto& face : kFaces) {
    append(std::uint8_t{4});
    for (const int index : face) append(std::int32_t{index});
  }
  return text;
}

/// A closed room in a file, with the camera in it; returns the scene's path.
std::string write_room(const TemporaryFolder& folder, const std::string& mesh_name, const std::string& mesh,
                       const DVec3& offset) {
  write_text(folder / mesh_name, mesh);
  write_text(folder / "scene.txt", "camera eye " + text_of(DVec3{0.2, -0.1, 0.3} + offset) + " target " +
                                       text_of(DVec3{1, 0.4, -0.6} + offset) +
                                       " fov 70\nmaterial wall diffuse reflectance 0.5\nmesh " + mesh_name +
                                       " material wall emit 1\n");
  return folder / "scene.txt";
}

void sweep_files(SweepTable& table, bool ply, const std::vector<double>& distances, std::uint64_t samples) {
  for (const double sizes : distances) {
    const TemporaryFolder folder;
    const DVec3 offset = offset_of(sizes);
    const std::string path = ply ? write_room(folder, "room.ply", ply_of(offset), offset)
                                 : write_room(folder, "room.obj", obj_of(offset), offset);
    const SceneDescription scene = parse_scene_file(path);
    for (const IntegratorKind kind : kIntegrators) {
      const auto replicates =
          render_replicates(scene, small_request(kind, 4, scaled_effort(samples), 8), 16, 100);
      table.add(mlt::test::text_of(sizes) + (ply ? " PLY " : " OBJ ") + name_of(kind),
                film_mean(replicates, furnace_radiance(0.5, 8), 1e-6));
    }
  }
}

constexpr const char* kFileBasis =
    "a closed room that emits 1: 1/(1-a), cut at 8 edges; Student's test over 16 seeds, plus rounding";

}  // namespace

TEST_CASE("pitfall 16: meshes in files, 0 to 1e8 times their size away", "[.stress]") {
  SweepTable table("meshes in files", "sizes away", kFileBasis);
  sweep_files(table, false, {0, 1, 1e3, 1e5, 1e7, 1e8}, 512);
  sweep_files(table, true, {0, 1, 1e3, 1e4}, 512);
}

TEST_CASE("mesh files out of the range of numbers end in a message") {
  SweepTable table("outside of the range of mesh files", "what", "the message");
  const auto row = [&table](const char* what, const std::string& name, const std::string& mesh, double sizes,
                            const std::string& wanted) {
    const TemporaryFolder folder;
    const std::string message = file_messages_of(write_room(folder, name, mesh, offset_of(sizes)));
    const std::size_t start =
        message.rfind(folder.path().string(), 0) == 0 ? folder.path().string().size() + 1 : 0;
    table.add_fact(what, message.empty() ? "(no message)" : message.substr(start, message.find('\n') - start),
                   wanted.empty() ? message.empty() : message.find(wanted) != std::string::npos);
  };
  row("OBJ 1e7 sizes away", "room.obj", obj_of(offset_of(1e7)), 1e7, "");
  row("OBJ 1e10 sizes away", "room.obj", obj_of(offset_of(1e10)), 1e10, "far from the origin");
  row("PLY 1e3 sizes away", "room.ply", ply_of(offset_of(1e3)), 1e3, "");
  row("PLY 1e6 sizes away", "room.ply", ply_of(offset_of(1e6)), 1e6, "the vertices are 32-bit floats");
  row("PLY 1e9 sizes away", "room.ply", ply_of(offset_of(1e9)), 1e9, "degenerate");
  row("OBJ vertex at 1e19", "room.obj", "v 1e19 0 0\nv 0 1 0\nv 1 0 0\nf 1 2 3\n", 0,
      "must lie in [-1e+18, 1e+18]");
  row("OBJ vertex at 1e400", "room.obj", "v 1e400 0 0\nv 0 1 0\nv 1 0 0\nf 1 2 3\n", 0, "1e400");
  row("PLY vertex at infinity", "room.ply", ply_of(DVec3{HUGE_VAL, 0, 0}), 0, "finite");
}

}  // namespace mlt::test
