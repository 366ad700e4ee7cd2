// A scene elsewhere and in another size.
#pragma once

#include "scene/description.hpp"

namespace mlt::test {

/// Every position p becomes scale * p + offset.
inline SceneDescription moved(SceneDescription scene, double scale, const DVec3& offset) {
  const auto move = [&](DVec3& p) { p = p * scale + offset; };
  move(scene.camera.eye);
  move(scene.camera.target);
  for (PolygonDescription& polygon : scene.polygons) {
    for (DVec3& corner : polygon.corners) move(corner);
  }
  for (MeshDescription& mesh : scene.meshes) {
    for (DVec3& vertex : mesh.vertices) move(vertex);
  }
  for (SphereDescription& sphere : scene.spheres) {
    move(sphere.center);
    sphere.radius *= scale;
  }
  return scene;
}

}  // namespace mlt::test
