// Checked shapes into the scene: applies the transform, keeps the front side in front under reflections,
// turns quads that are no parallelograms into triangles, and drops what has no area, with a warning.
#pragma once

#include <span>
#include <string>

#include "scene/parser_state.hpp"

namespace mlt {

/// A triangle (3 corners) or quad (4), counter-clockwise seen from the front. Throws InputError for a quad
/// that is not planar and convex, and for positions beyond kMaxCoordinate.
void add_polygon(ParserState& state, const ShapeClauses& clauses, std::span<const DVec3> corners);

/// Throws InputError when the transform does not keep spheres round.
void add_sphere(ParserState& state, const ShapeClauses& clauses, const DVec3& center, double radius);

/// `name` stands in warnings.
void add_mesh(ParserState& state, const ShapeClauses& clauses, MeshDescription mesh, const std::string& name);

}  // namespace mlt
