#include "scene/shapes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scene/limits.hpp"
#include "scene/mesh_file.hpp"

namespace mlt {
namespace {

bool in_range(const DVec3& point) {
  return std::fabs(point.x) <= kMaxCoordinate && std::fabs(point.y) <= kMaxCoordinate &&
         std::fabs(point.z) <= kMaxCoordinate;
}

DVec3 transformed(const ShapeClauses& clauses, const DVec3& point) {
  const DVec3 moved = clauses.transform.apply(point);
  if (!in_range(moved)) {
    fail_at(clauses.attributes.location,
            "a point of the shape lies at (" + format_number(moved.x) + ", " + format_number(moved.y) + ", " +
                format_number(moved.z) + ") after its transforms; coordinates must lie in [-" +
                format_number(kMaxCoordinate) + ", " + format_number(kMaxCoordinate) + "]");
  }
  return moved;
}

void warn_dropped(ParserState& state, const ShapeClauses& clauses, const std::string& what) {
  const std::string light = clauses.attributes.emission ? "; it was to emit light" : "";
  state.diagnostics.warn(clauses.attributes.location, what + " dropped" + light);
}

void check_shape_count(const ParserState& state, const ShapeClauses& clauses) {
  const SceneDescription& scene = state.scene;
  if (scene.polygons.size() + scene.spheres.size() + scene.meshes.size() >= kMaxShapes) {
    throw ResourceError(diagnostic_at(clauses.attributes.location, "more than " + std::to_string(kMaxShapes) +
                                                                       " shapes, which is the limit")
                            .to_string());
  }
}

void push_polygon(ParserState& state, const ShapeClauses& clauses, std::initializer_list<DVec3> corners) {
  check_shape_count(state, clauses);
  PolygonDescription polygon;
  std::copy(corners.begin(), corners.end(), polygon.corners);
  polygon.corner_count = static_cast<std::uint32_t>(corners.size());
  if (polygon.corner_count == 3) polygon.corners[3] = polygon.corners[2];
  polygon.attributes = clauses.attributes;
  state.scene.polygons.push_back(polygon);
}

void push_triangle(ParserState& state, const ShapeClauses& clauses, const DVec3& a, const DVec3& b,
                   const DVec3& c) {
  if (is_degenerate(a, b, c)) {
    warn_dropped(state, clauses, "degenerate triangle");
  } else {
    push_polygon(state, clauses, {a, b, c});
  }
}

/// Two equal neighbours or a straight corner leave a triangle of the quad; anything flatter has no area.
void push_quad(ParserState& state, const ShapeClauses& clauses, const DVec3 (&p)[4]) {
  const double diagonal = std::max(length(p[2] - p[0]), length(p[3] - p[1]));
  if (length((p[0] - p[1]) + (p[2] - p[3])) <= kParallelogramTolerance * diagonal) {
    if (is_degenerate(p[0], p[1], p[2])) {
      warn_dropped(state, clauses, "degenerate quad");
    } else {
      push_polygon(state, clauses, {p[0], p[1], p[2], p[3]});
    }
    return;
  }
  if (is_degenerate(p[0], p[1], p[2]) && is_degenerate(p[0], p[2], p[3]) && is_degenerate(p[1], p[2], p[3])) {
    warn_dropped(state, clauses, "degenerate quad");
    return;
  }
  // The diagonals' cross product is normal to a planar quad and twice its area long.
  const double scale = 1.0 / diagonal;
  const DVec3 area = cross((p[2] - p[0]) * scale, (p[3] - p[1]) * scale);
  if (!(length(area) > kDegenerateHeight)) {
    fail_at(clauses.attributes.location, "the quad crosses itself; give its corners in order around it");
  }
  const DVec3 normal = normalize(area);
  const double height = dot((p[1] - p[0]) * scale, normal);
  if (!(std::fabs(height) <= kPlanarTolerance)) {
    fail_at(clauses.attributes.location, "the quad is not planar: its corners lie " +
                                             format_number(std::fabs(height) * diagonal) +
                                             " apart from one plane; use two triangles");
  }
  for (int i = 0; i < 4; ++i) {
    const DVec3 before = (p[i] - p[(i + 3) % 4]) * scale;
    const DVec3 after = (p[(i + 1) % 4] - p[i]) * scale;
    if (dot(cross(before, after), normal) < -kPlanarTolerance * kPlanarTolerance) {
      fail_at(clauses.attributes.location, "the quad is not convex at corner " + std::to_string(i + 1) +
                                               "; give its corners in order around it, or use two triangles");
    }
  }
  push_triangle(state, clauses, p[0], p[1], p[2]);
  push_triangle(state, clauses, p[0], p[2], p[3]);
}

}  // namespace

void add_polygon(ParserState& state, const ShapeClauses& clauses, std::span<const DVec3> corners) {
  DVec3 moved[4] = {};
  for (std::size_t i = 0; i < corners.size(); ++i) moved[i] = transformed(clauses, corners[i]);
  // A reflection turns counter-clockwise into clockwise.
  if (clauses.transform.determinant() < 0) std::reverse(moved, moved + corners.size());
  if (corners.size() == 3) {
    push_triangle(state, clauses, moved[0], moved[1], moved[2]);
  } else {
    push_quad(state, clauses, moved);
  }
}

void add_sphere(ParserState& state, const ShapeClauses& clauses, const DVec3& center, double radius) {
  const double scale = similarity_scale(clauses.transform);
  if (!(scale > 0)) {
    fail_at(clauses.attributes.location,
            "the transforms of the sphere scale it unevenly; a sphere takes only a scale that is equal on "
            "all axes");
  }
  SphereDescription sphere;
  sphere.center = transformed(clauses, center);
  sphere.radius = radius * scale;
  sphere.attributes = clauses.attributes;
  if (!(sphere.radius <= kMaxCoordinate)) {
    fail_at(clauses.attributes.location, "the sphere's radius is " + format_number(sphere.radius) +
                                             " after its transforms; at most " +
                                             format_number(kMaxCoordinate) + " is allowed");
  }
  if (!(sphere.radius >= kMinLength)) {
    warn_dropped(state, clauses, "sphere of radius " + format_number(sphere.radius));
    return;
  }
  check_shape_count(state, clauses);
  state.scene.spheres.push_back(sphere);
}

void add_mesh(ParserState& state, const ShapeClauses& clauses, MeshDescription mesh,
              const std::string& name) {
  for (DVec3& vertex : mesh.vertices) vertex = transformed(clauses, vertex);
  const bool reflected = clauses.transform.determinant() < 0;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    std::uint32_t corner[3] = {mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]};
    if (is_degenerate(mesh.vertices[corner[0]], mesh.vertices[corner[1]], mesh.vertices[corner[2]])) continue;
    if (reflected) std::swap(corner[1], corner[2]);
    std::copy(corner, corner + 3, mesh.indices.begin() + static_cast<std::ptrdiff_t>(kept));
    kept += 3;
  }
  const std::size_t dropped = (mesh.indices.size() - kept) / 3;
  if (dropped > 0) {
    const std::string plural = dropped == 1 ? " degenerate triangle" : " degenerate triangles";
    warn_dropped(state, clauses, std::to_string(dropped) + plural + " of " + name);
  }
  mesh.indices.resize(kept);
  if (kept == 0) {
    warn_dropped(state, clauses, name + " without a triangle");
    return;
  }
  mesh.attributes = clauses.attributes;
  check_shape_count(state, clauses);
  state.mesh_vertices += mesh.vertices.size();
  state.mesh_triangles += mesh.indices.size() / 3;
  state.scene.meshes.push_back(std::move(mesh));
}

}  // namespace mlt
