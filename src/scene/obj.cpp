// Wavefront OBJ. One pass over the text; a faulty line is reported and the next one read.
#include <algorithm>
#include <iterator>

#include "scene/lexer.hpp"
#include "scene/limits.hpp"
#include "scene/mesh_file.hpp"
#include "scene/text_scanner.hpp"

namespace mlt {
namespace {

/// Statements that say nothing about the shape of a polygon mesh.
constexpr std::string_view kIgnored[] = {
    "vt",  "vn",     "vp",     "g",     "o",        "s",        "usemtl",     "mtllib",    "l", "p",
    "lod", "usemap", "maplib", "bevel", "c_interp", "d_interp", "shadow_obj", "trace_obj", "mg"};

class ObjReader {
 public:
  ObjReader(std::span<const char> bytes, const std::string& name, const MeshBudget& budget)
      : scanner_(bytes, name), name_(name), budget_(budget) {}

  MeshData read();

 private:
  void read_line();
  void read_vertex();
  void read_face();
  std::uint32_t read_corner(std::string_view word) const;
  std::int64_t read_index(std::string_view text, std::string_view word) const;

  TextScanner scanner_;
  const std::string& name_;
  MeshBudget budget_;
  MeshData mesh_;
  DiagnosticCollector diagnostics_;
  std::vector<std::uint32_t> corners_;
  std::uint64_t bent_ = 0;
  std::uint64_t unknown_ = 0;
  std::string first_unknown_;
};

MeshData ObjReader::read() {
  while (!scanner_.at_end() && !diagnostics_.full()) {
    try {
      read_line();
    } catch (const InputError& error) {
      diagnostics_.absorb(error);
    }
    scanner_.skip_line();
  }
  if (diagnostics_.empty() && mesh_.indices.empty()) {
    diagnostics_.add(Diagnostic{name_, 0, 0,
                                "the OBJ file has " + std::to_string(mesh_.vertices.size()) +
                                    " vertices and no face; at least one face ('f') is expected"});
  }
  diagnostics_.throw_if_any();
  if (bent_ > 0) {
    mesh_.warnings.push_back(std::to_string(bent_) + " polygons are not convex; split as fans all the same");
  }
  if (unknown_ > 0) {
    mesh_.warnings.push_back(std::to_string(unknown_) +
                             " lines with unknown OBJ statements ignored, the first " + first_unknown_);
  }
  return std::move(mesh_);
}

void ObjReader::read_line() {
  const std::string_view keyword = scanner_.word_on_line(true);
  if (keyword.empty() || keyword[0] == '#') return;
  if (keyword == "v") return read_vertex();
  if (keyword == "f") return read_face();
  if (std::find(std::begin(kIgnored), std::end(kIgnored), keyword) != std::end(kIgnored)) return;
  if (unknown_ == 0) {
    first_unknown_ = printable(keyword) + " in line " + std::to_string(scanner_.location().line);
  }
  ++unknown_;
}

void ObjReader::read_vertex() {
  if (mesh_.vertices.size() >= budget_.vertices) {
    throw ResourceError(name_ + ": more than " + std::to_string(budget_.vertices) +
                        " vertices, which is what the limit of " + std::to_string(kMaxMeshVertices) +
                        " for a scene leaves");
  }
  // Counted even if it turns out faulty, so that the faces that use it are not reported too.
  DVec3& position = mesh_.vertices.emplace_back(0, 0, 0);
  for (int axis = 0; axis < 3; ++axis) {
    const std::string_view word = scanner_.word_on_line(true);
    if (word.empty()) scanner_.fail("the line ends where a coordinate is expected; the form is: v X Y Z");
    const NumberFault fault = parse_number(word, position[axis]);
    if (fault != NumberFault::kNone) {
      scanner_.fail(describe_fault(fault, word) + "; a coordinate is expected, the form is: v X Y Z");
    }
  }
  // A weight or a colour may follow; both are ignored.
}

void ObjReader::read_face() {
  corners_.clear();
  while (true) {
    const std::string_view word = scanner_.word_on_line(true);
    if (word.empty() || word[0] == '#') break;
    if (corners_.size() == kMaxPolygonCorners) {
      scanner_.fail("the face has more than " + std::to_string(kMaxPolygonCorners) +
                    " corners, which is the limit");
    }
    corners_.push_back(read_corner(word));
  }
  if (corners_.size() < 3) {
    scanner_.fail("the face has " + std::to_string(corners_.size()) + " corners; at least 3 are expected");
  }
  if (mesh_.indices.size() / 3 + (corners_.size() - 2) > budget_.triangles) {
    throw ResourceError(name_ + ": more than " + std::to_string(budget_.triangles) +
                        " triangles, which is what the limit of " + std::to_string(kMaxMeshTriangles) +
                        " for a scene leaves");
  }
  if (!append_fan(corners_, mesh_.vertices, mesh_.indices)) ++bent_;
}

std::int64_t ObjReader::read_index(std::string_view text, std::string_view word) const {
  std::int64_t index = 0;
  if (parse_integer(text, index) != NumberFault::kNone) {
    scanner_.fail(printable(word) + " is no corner of a face; v, v/vt, v//vn or v/vt/vn is expected");
  }
  return index;
}

/// v, v/vt, v//vn or v/vt/vn. Texture and normal indices must be integers, but are not used.
std::uint32_t ObjReader::read_corner(std::string_view word) const {
  const std::size_t slash = word.find('/');
  const std::int64_t index = read_index(word.substr(0, slash), word);
  if (slash != std::string_view::npos) {
    const std::string_view rest = word.substr(slash + 1);
    const std::size_t second = rest.find('/');
    const std::string_view texture = rest.substr(0, second);
    if (!(texture.empty() && second != std::string_view::npos)) read_index(texture, word);
    if (second != std::string_view::npos) read_index(rest.substr(second + 1), word);
  }
  const auto count = static_cast<std::int64_t>(mesh_.vertices.size());
  const bool valid = index > 0 ? index <= count : index < 0 && index >= -count;
  if (!valid) {
    scanner_.fail("vertex index " + std::to_string(index) + " is out of range; " + std::to_string(count) +
                  " vertices stand before this line, so 1 to " + std::to_string(count) + " or -1 to -" +
                  std::to_string(count) + " are allowed");
  }
  return static_cast<std::uint32_t>(index > 0 ? index - 1 : count + index);
}

}  // namespace

MeshData read_obj(std::span<const char> bytes, const std::string& name, const MeshBudget& budget) {
  return ObjReader(bytes, name, budget).read();
}

}  // namespace mlt
