// The data of a PLY file: vertices and faces into a mesh, everything else skipped.
#include <bit>
#include <cmath>
#include <cstring>

#include "base/error.hpp"
#include "scene/lexer.hpp"
#include "scene/limits.hpp"
#include "scene/mesh_file.hpp"
#include "scene/ply_header.hpp"
#include "scene/precision.hpp"

namespace mlt {
namespace {

static_assert(std::endian::native == std::endian::little, "binary_little_endian values are read as they lie");

class PlyReader {
 public:
  PlyReader(std::span<const char> bytes, const std::string& name, const MeshBudget& budget)
      : scanner_(bytes, name), name_(name), budget_(budget) {
    header_ = read_ply_header(scanner_);
    data_ = bytes.subspan(scanner_.offset());
  }

  MeshData read();

 private:
  void check_layout() const;
  void read_vertices(const PlyElement& element);
  void read_faces(const PlyElement& element);
  void read_indices(const PlyProperty& property);
  void skip_element(const PlyElement& element);
  void skip_property(const PlyProperty& property);
  std::uint64_t read_length(const PlyProperty& property);
  double read_value(PlyType type);
  double read_word(PlyType type);
  [[noreturn]] void fail(const std::string& message) const;

  TextScanner scanner_;
  const std::string& name_;
  MeshBudget budget_;
  PlyHeader header_;
  std::span<const char> data_;  ///< what is left of a binary file
  MeshData mesh_;
  std::vector<std::uint32_t> corners_;
  std::uint64_t bent_ = 0;
  std::string_view element_name_;
  std::uint64_t record_ = 0;
};

bool is_index_list(const PlyProperty& property) {
  return property.is_list && (property.name == "vertex_indices" || property.name == "vertex_index");
}

int axis_of(const PlyProperty& property) {
  if (property.name == "x") return 0;
  if (property.name == "y") return 1;
  return property.name == "z" ? 2 : -1;
}

bool has_float_position(const PlyElement& element) {
  for (const PlyProperty& property : element.properties) {
    if (axis_of(property) >= 0 && property.type == PlyType::kFloat) return true;
  }
  return false;
}

MeshData PlyReader::read() {
  check_layout();
  for (const PlyElement& element : header_.elements) {
    element_name_ = element.name;
    record_ = 0;
    if (element.name == "vertex") {
      read_vertices(element);
      if (!header_.ascii && has_float_position(element)) {
        const std::string warning = warning_of_coarse_floats(mesh_.vertices);
        if (!warning.empty()) mesh_.warnings.push_back(warning);
      }
    } else if (element.name == "face") {
      read_faces(element);
    } else {
      skip_element(element);
    }
  }
  const std::size_t left = header_.ascii ? scanner_.word().size() : data_.size();
  if (left > 0) mesh_.warnings.push_back("bytes after the last element ignored");
  if (bent_ > 0) {
    mesh_.warnings.push_back(std::to_string(bent_) + " polygons are not convex; split as fans all the same");
  }
  return std::move(mesh_);
}

/// Vertices with positions first, then faces with indices, both within the budget.
void PlyReader::check_layout() const {
  const PlyElement* vertices = nullptr;
  const PlyElement* faces = nullptr;
  for (const PlyElement& element : header_.elements) {
    if (element.name == "vertex") vertices = &element;
    if (element.name == "face") faces = &element;
  }
  const SourceLocation whole{name_, 0, 0};
  if (vertices == nullptr) fail_at(whole, "the PLY file has no element 'vertex'");
  if (faces == nullptr) fail_at(whole, "the PLY file has no element 'face'; point clouds cannot be rendered");
  if (faces < vertices) fail_at(faces->location, "the element 'face' stands before 'vertex'");
  if (faces->count == 0) fail_at(faces->location, "the PLY file has no faces; at least one is expected");
  int axes = 0;
  for (const PlyProperty& property : vertices->properties) {
    if (axis_of(property) < 0) continue;
    if (property.is_list || is_integer(property.type)) {
      fail_at(vertices->location,
              "the property " + printable(property.name) + " of 'vertex' must be float or double");
    }
    ++axes;
  }
  if (axes != 3)
    fail_at(vertices->location, "the element 'vertex' lacks x, y or z; float or double are expected");
  bool indexed = false;
  for (const PlyProperty& property : faces->properties) {
    if (!is_index_list(property)) continue;
    if (indexed) fail_at(faces->location, "the element 'face' has both vertex_indices and vertex_index");
    if (!is_integer(property.type))
      fail_at(faces->location, "the list of vertex indices must have an integer type");
    indexed = true;
  }
  if (!indexed) fail_at(faces->location, "the element 'face' has no list vertex_indices or vertex_index");
  if (vertices->count > budget_.vertices || faces->count > budget_.triangles) {
    throw ResourceError(name_ + ": " + std::to_string(vertices->count) + " vertices and " +
                        std::to_string(faces->count) + " faces are declared; the limits of a scene leave " +
                        std::to_string(budget_.vertices) + " and " + std::to_string(budget_.triangles) +
                        " triangles");
  }
}

void PlyReader::read_vertices(const PlyElement& element) {
  mesh_.vertices.reserve(element.count);
  for (; record_ < element.count; ++record_) {
    DVec3 position{0, 0, 0};
    for (const PlyProperty& property : element.properties) {
      const int axis = axis_of(property);
      if (axis < 0) {
        skip_property(property);
        continue;
      }
      const double value = read_value(property.type);
      if (!std::isfinite(value))
        fail("the coordinate " + std::string(property.name) + " is not a finite number");
      position[axis] = value;
    }
    mesh_.vertices.push_back(position);
  }
}

void PlyReader::read_faces(const PlyElement& element) {
  // Most meshes consist of triangles. check_sizes has bounded the count by the file's size.
  mesh_.indices.reserve(element.count * 3);
  for (; record_ < element.count; ++record_) {
    for (const PlyProperty& property : element.properties) {
      if (is_index_list(property)) {
        read_indices(property);
      } else {
        skip_property(property);
      }
    }
  }
}

void PlyReader::read_indices(const PlyProperty& property) {
  const std::uint64_t length = read_length(property);
  if (length < 3 || length > kMaxPolygonCorners) {
    fail("the face has " + std::to_string(length) + " corners; 3 to " + std::to_string(kMaxPolygonCorners) +
         " are allowed");
  }
  if (mesh_.indices.size() / 3 + (length - 2) > budget_.triangles) {
    throw ResourceError(name_ + ": more than " + std::to_string(budget_.triangles) +
                        " triangles, which is what the limit of " + std::to_string(kMaxMeshTriangles) +
                        " for a scene leaves");
  }
  corners_.clear();
  const auto count = static_cast<double>(mesh_.vertices.size());
  for (std::uint64_t i = 0; i < length; ++i) {
    const double index = read_value(property.type);
    if (!(index >= 0 && index < count)) {
      fail("vertex index " + format_number(index) + " is out of range; there are " +
           std::to_string(mesh_.vertices.size()) + " vertices, counted from 0");
    }
    corners_.push_back(static_cast<std::uint32_t>(index));
  }
  if (!append_fan(corners_, mesh_.vertices, mesh_.indices)) ++bent_;
}

void PlyReader::skip_element(const PlyElement& element) {
  bool fixed_size = !header_.ascii;
  for (const PlyProperty& property : element.properties) fixed_size = fixed_size && !property.is_list;
  if (fixed_size) {
    const std::uint64_t record = element.least_record_bytes(false);
    if (element.count > data_.size() / record) fail("the file ends inside the element");
    data_ = data_.subspan(element.count * record);
    return;
  }
  for (; record_ < element.count; ++record_) {
    for (const PlyProperty& property : element.properties) skip_property(property);
  }
}

void PlyReader::skip_property(const PlyProperty& property) {
  const std::uint64_t length = property.is_list ? read_length(property) : 1;
  if (header_.ascii) {
    for (std::uint64_t i = 0; i < length; ++i) {
      if (scanner_.word().empty()) fail("the file ends inside the element");
    }
    return;
  }
  if (length > data_.size() / bytes_of(property.type)) fail("the file ends inside the element");
  data_ = data_.subspan(length * bytes_of(property.type));
}

std::uint64_t PlyReader::read_length(const PlyProperty& property) {
  const double length = read_value(property.count_type);
  if (!(length >= 0 && length <= 0xffffffffU)) {
    fail("the list " + printable(property.name) + " has the length " + format_number(length));
  }
  return static_cast<std::uint64_t>(length);
}

double PlyReader::read_value(PlyType type) {
  if (header_.ascii) return read_word(type);
  if (data_.size() < bytes_of(type)) fail("the file ends inside the element");
  const char* const source = data_.data();
  data_ = data_.subspan(bytes_of(type));
  const auto load = [source]<class T>(T value) {
    std::memcpy(&value, source, sizeof value);
    return static_cast<double>(value);
  };
  switch (type) {
    case PlyType::kInt8:
      return load(std::int8_t{});
    case PlyType::kUint8:
      return load(std::uint8_t{});
    case PlyType::kInt16:
      return load(std::int16_t{});
    case PlyType::kUint16:
      return load(std::uint16_t{});
    case PlyType::kInt32:
      return load(std::int32_t{});
    case PlyType::kUint32:
      return load(std::uint32_t{});
    case PlyType::kFloat:
      return load(float{});
    case PlyType::kDouble:
      return load(double{});
  }
  return 0;
}

double PlyReader::read_word(PlyType type) {
  const std::string_view word = scanner_.word();
  if (word.empty()) fail("the file ends inside the element");
  double value = 0;
  NumberFault fault = NumberFault::kNone;
  if (is_integer(type)) {
    std::int64_t integer = 0;
    fault = parse_integer(word, integer);
    value = static_cast<double>(integer);
  } else {
    fault = parse_number(word, value);
  }
  if (fault != NumberFault::kNone) {
    fail(describe_fault(fault, word) +
         (is_integer(type) ? "; a whole number is expected" : "; a number is expected"));
  }
  return value;
}

void PlyReader::fail(const std::string& message) const {
  const std::string text = printable(element_name_) + " " + std::to_string(record_) + ": " + message;
  fail_at(header_.ascii ? scanner_.location() : SourceLocation{name_, 0, 0}, text);
}

}  // namespace

MeshData read_ply(std::span<const char> bytes, const std::string& name, const MeshBudget& budget) {
  return PlyReader(bytes, name, budget).read();
}

}  // namespace mlt
