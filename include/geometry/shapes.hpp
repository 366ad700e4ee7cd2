// Shapes in world space, as the geometry and the lights take them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "math/vec.hpp"

namespace mlt {

/// A parallelogram a, b, c, d in order around it; counter-clockwise seen from the front.
struct Quad {
  Vec3 a{0, 0, 0}, b{0, 0, 0}, c{0, 0, 0}, d{0, 0, 0};
};

/// Counter-clockwise seen from the front.
struct Triangle {
  Vec3 a{0, 0, 0}, b{0, 0, 0}, c{0, 0, 0};
};

/// Indices of a triangle's corners in a list of vertices.
struct TriangleCorners {
  std::uint32_t a = 0, b = 0, c = 0;
};

/// Triangles that share vertices, as meshes do: about two for each vertex, half the size of a list of
/// Triangle.
struct TriangleList {
  std::span<const Vec3> vertices;
  std::span<const TriangleCorners> corners;

  std::size_t size() const { return corners.size(); }
  Triangle operator[](std::size_t i) const {
    return {vertices[corners[i].a], vertices[corners[i].b], vertices[corners[i].c]};
  }
};

/// The front is the outside.
struct Sphere {
  Vec3 center{0, 0, 0};
  float radius = 0;
};

}  // namespace mlt
