// What the statements' handlers share while a scene is read. A handler reads its words from a cursor, changes
// the state, and throws InputError on a fault; the loop in parser.cpp catches it and goes on.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "scene/cursor.hpp"
#include "scene/description.hpp"
#include "scene/diagnostics.hpp"
#include "scene/source.hpp"
#include "scene/transform.hpp"

namespace mlt {

/// The clauses of a shape statement.
struct ShapeClauses {
  ShapeAttributes attributes;
  Affine transform;
  bool inward = false;
};

/// A mesh between inline_mesh and end; its vertices are not yet transformed.
struct OpenMesh {
  MeshDescription mesh;
  ShapeClauses clauses;
  std::uint64_t bent_faces = 0;
};

struct ParserState {
  SceneDescription scene;
  DiagnosticCollector diagnostics;
  SourceFolder folder;

  std::map<std::string, std::uint32_t> material_index;  ///< also of materials whose statement was faulty
  std::optional<SourceLocation> camera_at, film_at, depth_at;
  std::optional<OpenMesh> open_mesh;
  bool faulty_mesh = false;  ///< inside an inline_mesh whose first line was faulty
  std::uint64_t mesh_vertices = 0;
  std::uint64_t mesh_triangles = 0;
  std::uint64_t shape_statements = 0;  ///< also those dropped as degenerate
};

void parse_camera(ParserState& state, StatementCursor& cursor);
void parse_film(ParserState& state, StatementCursor& cursor);
void parse_depth(ParserState& state, StatementCursor& cursor);
void parse_material(ParserState& state, StatementCursor& cursor);

void parse_triangle(ParserState& state, StatementCursor& cursor);
void parse_quad(ParserState& state, StatementCursor& cursor);
void parse_box(ParserState& state, StatementCursor& cursor);
void parse_sphere(ParserState& state, StatementCursor& cursor);
/// `relative_path` of the file that the statement stands in.
void parse_mesh(ParserState& state, StatementCursor& cursor, const std::string& relative_path);
void parse_inline_mesh(ParserState& state, StatementCursor& cursor);
void parse_vertex(ParserState& state, StatementCursor& cursor);
void parse_face(ParserState& state, StatementCursor& cursor);
void parse_end(ParserState& state, StatementCursor& cursor);

}  // namespace mlt
