#include "scene/bounds.hpp"

#include <algorithm>

namespace mlt {

void Bounds::include(const DVec3& p) {
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = std::min(low[axis], p[axis]);
    high[axis] = std::max(high[axis], p[axis]);
  }
}

Bounds bounds_of(const SceneDescription& scene) {
  Bounds bounds;
  for (const PolygonDescription& polygon : scene.polygons) {
    for (std::uint32_t i = 0; i < polygon.corner_count; ++i) bounds.include(polygon.corners[i]);
  }
  for (const MeshDescription& mesh : scene.meshes) {
    for (const std::uint32_t index : mesh.indices) bounds.include(mesh.vertices[index]);
  }
  for (const SphereDescription& sphere : scene.spheres) {
    const DVec3 radius{sphere.radius, sphere.radius, sphere.radius};
    bounds.include(sphere.center - radius);
    bounds.include(sphere.center + radius);
  }
  return bounds;
}

}  // namespace mlt
