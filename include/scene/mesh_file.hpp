// Readers of OBJ and PLY files, from memory: any bytes give either a triangle mesh with finite vertices and
// indices in range, or an exception, in time and memory proportional to the file's size.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "math/vec.hpp"

namespace mlt {

/// What the scene may still take; see kMaxMeshVertices and kMaxMeshTriangles.
struct MeshBudget {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
};

struct MeshData {
  std::vector<DVec3> vertices;
  std::vector<std::uint32_t> indices;  ///< three per triangle, each < vertices.size()
  std::vector<std::string> warnings;   ///< about the file as a whole
};

/// Wavefront OBJ: v and f (v, v/vt, v//vn, v/vt/vn; negative indices count from the last vertex). Polygons
/// are split as fans from their first corner; that is right for convex ones, others are counted in a warning.
/// Other statements are ignored, unknown ones with a warning. `name` is used in diagnostics. Throws
/// InputError with up to kMaxDiagnostics faults, ResourceError above the budget.
MeshData read_obj(std::span<const char> bytes, const std::string& name, const MeshBudget& budget);

/// PLY 1.0, ascii or binary_little_endian: vertex elements with float or double x, y, z, face elements with a
/// list vertex_indices or vertex_index of integers. Other elements and properties are skipped by their types.
/// Declared counts are compared with the file's size before memory is taken. Throws as read_obj; the first
/// fault ends the reading.
MeshData read_ply(std::span<const char> bytes, const std::string& name, const MeshBudget& budget);

/// Appends a polygon as a fan of triangles from its first corner. Returns whether the fan covers the polygon
/// without overlap, that is whether it is planar and convex enough: every triangle of it faces the same way.
bool append_fan(std::span<const std::uint32_t> corners, const std::vector<DVec3>& vertices,
                std::vector<std::uint32_t>& indices);

/// Twice the vector area of a triangle, and whether it is degenerate: not finite, shorter than kMinLength, or
/// flatter than kDegenerateHeight.
bool is_degenerate(const DVec3& a, const DVec3& b, const DVec3& c);

}  // namespace mlt
