// libFuzzer harness of the scene format: any bytes give a scene that keeps its promises, or an error with a
// place. Files cannot be named from memory, so include and mesh are covered up to the point of opening.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "base/error.hpp"
#include "fuzz/fuzz.hpp"
#include "scene/limits.hpp"
#include "scene/parse.hpp"

namespace {

bool valid(const mlt::DVec3& point) {
  return std::fabs(point.x) <= mlt::kMaxCoordinate && std::fabs(point.y) <= mlt::kMaxCoordinate &&
         std::fabs(point.z) <= mlt::kMaxCoordinate;
}

void check(const mlt::SceneDescription& scene) {
  require(valid(scene.camera.eye) && valid(scene.camera.target));
  require(!scene.polygons.empty() || !scene.spheres.empty() || !scene.meshes.empty());
  for (const mlt::PolygonDescription& polygon : scene.polygons) {
    require(polygon.corner_count == 3 || polygon.corner_count == 4);
    require(polygon.attributes.material < scene.materials.size());
    for (const mlt::DVec3& corner : polygon.corners) require(valid(corner));
  }
  for (const mlt::SphereDescription& sphere : scene.spheres) {
    require(sphere.attributes.material < scene.materials.size());
    require(valid(sphere.center) && sphere.radius >= mlt::kMinLength && sphere.radius <= mlt::kMaxCoordinate);
  }
  for (const mlt::MeshDescription& mesh : scene.meshes) {
    require(mesh.attributes.material < scene.materials.size());
    require(!mesh.indices.empty() && mesh.indices.size() % 3 == 0);
    for (const std::uint32_t index : mesh.indices) require(index < mesh.vertices.size());
    for (const mlt::DVec3& vertex : mesh.vertices) require(valid(vertex));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    check(mlt::parse_scene_text({reinterpret_cast<const char*>(data), size}, "fuzz.txt"));
  } catch (const mlt::InputError& error) {
    require(!error.diagnostics().empty() && error.diagnostics().size() <= mlt::kMaxDiagnostics);
    for (const mlt::Diagnostic& diagnostic : error.diagnostics()) require(!diagnostic.message.empty());
  } catch (const mlt::ResourceError&) {
  }
  return 0;
}
