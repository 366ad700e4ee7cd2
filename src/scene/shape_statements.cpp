// Shape statements: their arguments, the clauses common to all, and inline meshes.
#include <cmath>
#include <utility>

#include "scene/limits.hpp"
#include "scene/mesh_file.hpp"
#include "scene/shapes.hpp"

namespace mlt {
namespace {

constexpr bool kMayFaceInward = true;

DVec3 scale_factors(StatementCursor& cursor) {
  const SourceLocation at = cursor.last();
  const DVec3 factors = cursor.colour("a scale factor", {-kMaxCoordinate, kMaxCoordinate});
  if (factors.x == 0 || factors.y == 0 || factors.z == 0) {
    fail_at(at, "a scale factor of 0 makes the transform singular; other numbers are allowed");
  }
  return factors;
}

Affine read_rotation(StatementCursor& cursor) {
  const SourceLocation at = cursor.last();
  const double degrees = cursor.number_in("the angle of rotation in degrees", {-3600, 3600});
  const DVec3 axis = cursor.vector("a component of the rotation's axis");
  if (axis.x == 0 && axis.y == 0 && axis.z == 0) {
    fail_at(at, "the axis of the rotation has length 0, which makes the transform singular");
  }
  return rotation(degrees, axis);
}

std::uint32_t read_material(const ParserState& state, StatementCursor& cursor) {
  const std::string name(cursor.word("the name of a material"));
  const auto found = state.material_index.find(name);
  if (found != state.material_index.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [known_name, index] : state.material_index) known.push_back(known_name);
  fail_at(cursor.last(),
          "no material " + printable(name) + " stands before this line" + allowed_words(name, known));
}

void read_emission(ParserState& state, ShapeClauses& clauses, StatementCursor& cursor) {
  const SourceLocation at = cursor.last();
  const DVec3 radiance = cursor.colour("a channel of the emitted radiance", {0, kMaxRadiance});
  if (radiance.x == 0 && radiance.y == 0 && radiance.z == 0) {
    state.diagnostics.warn(at, "an emission of 0 0 0 dropped; the shape is no light");
    clauses.attributes.emission.reset();
  } else {
    clauses.attributes.emission = radiance;
  }
}

void read_clause(ParserState& state, ShapeClauses& clauses, ShapeClause clause, StatementCursor& cursor) {
  Affine& transform = clauses.transform;
  switch (clause) {
    case ShapeClause::material:
      clauses.attributes.material = read_material(state, cursor);
      break;
    case ShapeClause::emit:
      read_emission(state, clauses, cursor);
      break;
    case ShapeClause::translate:
      transform = compose(transform, translation(cursor.vector("a component of the translation")));
      break;
    case ShapeClause::rotate:
      transform = compose(transform, read_rotation(cursor));
      break;
    case ShapeClause::scale:
      transform = compose(transform, scaling(scale_factors(cursor)));
      break;
    case ShapeClause::inward:
      clauses.inward = true;
      break;
  }
}

/// Reads all clauses up to the statement's end.
ShapeClauses read_clauses(ParserState& state, StatementCursor& cursor, bool may_face_inward = false) {
  ShapeClauses clauses;
  clauses.attributes.location = cursor.start();
  bool given[std::size(kShapeClauses)] = {};
  while (!cursor.at_end()) {
    const std::size_t index = cursor.keyword(kShapeClauses, "a clause of a shape");
    const auto clause = static_cast<ShapeClause>(index);
    const bool repeatable =
        clause == ShapeClause::translate || clause == ShapeClause::rotate || clause == ShapeClause::scale;
    if (given[index] && !repeatable) {
      fail_at(cursor.last(), std::string(kShapeClauses[index].word) + " is given twice");
    }
    if (clause == ShapeClause::inward && !may_face_inward) {
      fail_at(cursor.last(), "'inward' does not apply to this shape; it is allowed after box");
    }
    given[index] = true;
    read_clause(state, clauses, clause, cursor);
  }
  if (!given[static_cast<std::size_t>(ShapeClause::material)]) {
    fail_at(cursor.here(), "the shape has no material; 'material NAME' is expected");
  }
  const double determinant = clauses.transform.determinant();
  if (determinant == 0 || !std::isfinite(determinant)) {
    fail_at(clauses.attributes.location,
            "the transforms together are singular or out of the range of numbers");
  }
  ++state.shape_statements;
  return clauses;
}

void read_corners(StatementCursor& cursor, std::span<DVec3> corners) {
  for (DVec3& corner : corners) corner = cursor.vector("a coordinate of a corner");
}

MeshBudget remaining(const ParserState& state) {
  std::uint64_t vertices = kMaxMeshVertices - state.mesh_vertices;
  std::uint64_t triangles = kMaxMeshTriangles - state.mesh_triangles;
  return MeshBudget{vertices, triangles};
}

bool ends_with(std::string_view text, std::string_view ending) {
  if (text.size() < ending.size()) return false;
  const std::string_view tail = text.substr(text.size() - ending.size());
  for (std::size_t i = 0; i < tail.size(); ++i) {
    const char lower = tail[i] >= 'A' && tail[i] <= 'Z' ? static_cast<char>(tail[i] - 'A' + 'a') : tail[i];
    if (lower != ending[i]) return false;
  }
  return true;
}

OpenMesh& require_open_mesh(ParserState& state, const StatementCursor& cursor, const char* word) {
  if (!state.open_mesh) {
    fail_at(cursor.start(), std::string("'") + word + "' stands outside of inline_mesh ... end");
  }
  return *state.open_mesh;
}

}  // namespace

void parse_triangle(ParserState& state, StatementCursor& cursor) {
  DVec3 corners[3] = {};
  read_corners(cursor, corners);
  add_polygon(state, read_clauses(state, cursor), corners);
}

void parse_quad(ParserState& state, StatementCursor& cursor) {
  DVec3 corners[4] = {};
  read_corners(cursor, corners);
  add_polygon(state, read_clauses(state, cursor), corners);
}

void parse_box(ParserState& state, StatementCursor& cursor) {
  const DVec3 low = cursor.vector("a coordinate of the least corner");
  const DVec3 high = cursor.vector("a coordinate of the greatest corner");
  const ShapeClauses clauses = read_clauses(state, cursor, kMayFaceInward);
  if (!(low.x < high.x && low.y < high.y && low.z < high.z)) {
    fail_at(clauses.attributes.location,
            "the box's first corner must be less than the second on every axis; a flat box is a quad");
  }
  const auto corner = [&](int index) {
    return DVec3{(index & 1) != 0 ? high.x : low.x, (index & 2) != 0 ? high.y : low.y,
                 (index & 4) != 0 ? high.z : low.z};
  };
  // Bits of a corner's index: x, y, z at the greatest value. Counter-clockwise seen from outside.
  constexpr int kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& face : kFaces) {
    DVec3 corners[4] = {corner(face[0]), corner(face[1]), corner(face[2]), corner(face[3])};
    if (clauses.inward) std::swap(corners[1], corners[3]);
    add_polygon(state, clauses, corners);
  }
}

void parse_sphere(ParserState& state, StatementCursor& cursor) {
  const DVec3 center = cursor.vector("a coordinate of the centre");
  const double radius = cursor.number_in("the radius", {0, kMaxCoordinate});
  add_sphere(state, read_clauses(state, cursor), center, radius);
}

void parse_mesh(ParserState& state, StatementCursor& cursor, const std::string& relative_path) {
  const std::string name(cursor.word("the name of an OBJ or PLY file"));
  const SourceLocation name_at = cursor.last();
  const bool obj = ends_with(name, ".obj");
  if (!obj && !ends_with(name, ".ply")) {
    fail_at(name_at, "the mesh file " + printable(name) + " ends neither in .obj nor in .ply");
  }
  const ShapeClauses clauses = read_clauses(state, cursor);
  const SourceFile file = state.folder.read(name, relative_path, kMaxMeshFileBytes, name_at);
  MeshData data = obj ? read_obj(file.span(), file.shown_path, remaining(state))
                      : read_ply(file.span(), file.shown_path, remaining(state));
  for (const std::string& warning : data.warnings) {
    state.diagnostics.warn(SourceLocation{file.shown_path, 0, 0}, warning);
  }
  MeshDescription mesh;
  mesh.vertices = std::move(data.vertices);
  mesh.indices = std::move(data.indices);
  add_mesh(state, clauses, std::move(mesh), "mesh " + printable(name));
}

void parse_inline_mesh(ParserState& state, StatementCursor& cursor) {
  state.faulty_mesh = true;
  ShapeClauses clauses = read_clauses(state, cursor);
  state.faulty_mesh = false;
  state.open_mesh.emplace();
  state.open_mesh->clauses = std::move(clauses);
}

void parse_vertex(ParserState& state, StatementCursor& cursor) {
  OpenMesh& open = require_open_mesh(state, cursor, "vertex");
  const DVec3 position = cursor.vector("a coordinate of a vertex");
  cursor.expect_end();
  if (open.mesh.vertices.size() >= remaining(state).vertices) {
    throw ResourceError(diagnostic_at(cursor.start(), "more than " + std::to_string(kMaxMeshVertices) +
                                                          " mesh vertices, which is the limit of a scene")
                            .to_string());
  }
  open.mesh.vertices.push_back(position);
}

void parse_face(ParserState& state, StatementCursor& cursor) {
  OpenMesh& open = require_open_mesh(state, cursor, "face");
  const auto count = static_cast<std::int64_t>(open.mesh.vertices.size());
  if (count == 0) fail_at(cursor.start(), "a face stands before the first vertex of its mesh");
  std::vector<std::uint32_t> corners;
  while (!cursor.at_end() || corners.size() < 3) {
    corners.push_back(
        static_cast<std::uint32_t>(cursor.integer_in("the index of a vertex above", 0, count - 1)));
  }
  if (open.mesh.indices.size() / 3 + (corners.size() - 2) > remaining(state).triangles) {
    throw ResourceError(diagnostic_at(cursor.start(), "more than " + std::to_string(kMaxMeshTriangles) +
                                                          " mesh triangles, which is the limit of a scene")
                            .to_string());
  }
  if (!append_fan(corners, open.mesh.vertices, open.mesh.indices)) ++open.bent_faces;
}

void parse_end(ParserState& state, StatementCursor& cursor) {
  require_open_mesh(state, cursor, "end");
  cursor.expect_end();
  OpenMesh open = std::move(*state.open_mesh);
  state.open_mesh.reset();
  if (open.bent_faces > 0) {
    state.diagnostics.warn(
        open.clauses.attributes.location,
        std::to_string(open.bent_faces) + " faces are not convex; split as fans all the same");
  }
  add_mesh(state, open.clauses, std::move(open.mesh), "inline_mesh");
}

}  // namespace mlt
