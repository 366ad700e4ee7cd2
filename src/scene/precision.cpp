#include "scene/precision.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>

#include "scene/bounds.hpp"
#include "scene/limits.hpp"

namespace mlt {
namespace {

double largest_component(const DVec3& v) {
  return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
}

/// Twice the area of a triangle, and its least height.
struct TriangleSize {
  double area = 0, height = 0;

  TriangleSize(const DVec3& a, const DVec3& b, const DVec3& c) {
    const double longest = std::max({length(b - a), length(c - a), length(c - b)});
    height = length(cross((b - a) / longest, (c - a) / longest)) * longest;
    area = height * longest;
  }
};

bool emits(const ShapeAttributes& attributes) {
  return attributes.emission.has_value();
}

/// The share of a light's area that lies in triangles of less than this height.
double narrow_share(const PolygonDescription& polygon, double height) {
  const auto& corners = polygon.corners;
  // Half of a parallelogram has its height or, over a diagonal, less.
  const TriangleSize size(corners[0], corners[1], corners[2]);
  const double edge = std::max(length(corners[1] - corners[0]), length(corners[2] - corners[1]));
  return (polygon.corner_count == 4 ? size.area / edge : size.height) < height ? 1.0 : 0.0;
}

double narrow_share(const MeshDescription& mesh, double height) {
  double all = 0, narrow = 0;
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const TriangleSize size(mesh.vertices[mesh.indices[i]], mesh.vertices[mesh.indices[i + 1]],
                            mesh.vertices[mesh.indices[i + 2]]);
    all += size.area;
    if (size.height < height) narrow += size.area;
  }
  return all > 0 ? narrow / all : 0.0;
}

template <class Shape>
void warn_of_light(const Shape& shape, double size, DiagnosticCollector& diagnostics) {
  if (!emits(shape.attributes)) return;
  if (largest_component(*shape.attributes.emission) < kDimRadiance) {
    diagnostics.warn(shape.attributes.location,
                     "a light of radiance " + format_number(largest_component(*shape.attributes.emission)) +
                         ", below " + format_number(kDimRadiance) +
                         ", may be lost: PSSMLT takes paths dimmer than 8e-31 for black; scale all emission");
  }
  if constexpr (!std::is_same_v<Shape, SphereDescription>) {
    if (narrow_share(shape, kLeastDetail * size) > 0.01) {
      diagnostics.warn(shape.attributes.location,
                       "the light is narrower than " + format_number(kLeastDetail) +
                           " of the scene's size; rounded positions change its area by a percent or more");
    }
  }
}

/// Triangles of meshes count one by one.
std::uint64_t shapes_smaller_than(double size, const SceneDescription& scene) {
  std::uint64_t count = 0;
  for (const PolygonDescription& polygon : scene.polygons) {
    const auto& p = polygon.corners;
    if (std::max(length(p[2] - p[0]), length(p[3] - p[1])) < size) ++count;
  }
  for (const MeshDescription& mesh : scene.meshes) {
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
      const DVec3& a = mesh.vertices[mesh.indices[i]];
      const DVec3& b = mesh.vertices[mesh.indices[i + 1]];
      const DVec3& c = mesh.vertices[mesh.indices[i + 2]];
      if (std::max({length(b - a), length(c - a), length(c - b)}) < size) ++count;
    }
  }
  for (const SphereDescription& sphere : scene.spheres) {
    if (2 * sphere.radius < size) ++count;
  }
  return count;
}

}  // namespace

void warn_of_lost_precision(const SceneDescription& scene, DiagnosticCollector& diagnostics) {
  const Bounds bounds = bounds_of(scene);
  const double size = largest_component(bounds.high - bounds.low);
  const double reach = std::max(largest_component(bounds.low), largest_component(bounds.high));
  const SourceLocation whole{scene.camera.location.file, 0, 0};
  if (reach > kFarScene * size) {
    diagnostics.warn(whole, "the scene lies as far from the origin as " +
                                format_number(std::floor(reach / size)) + " times its size, more than " +
                                format_number(kFarScene) +
                                "; its positions are rounded too coarsely, move it nearer");
  }
  const DVec3 centre = bounds.low + (bounds.high - bounds.low) * 0.5;
  const double distance = largest_component(scene.camera.eye - centre);
  if (distance > kFarCamera * size) {
    diagnostics.warn(scene.camera.location,
                     "the camera is as far from the scene as " + format_number(std::floor(distance / size)) +
                         " times the scene's size, more than " + format_number(kFarCamera) +
                         "; its rays are rounded too coarsely, move it nearer with a wider view");
  }
  if (const std::uint64_t small = shapes_smaller_than(kLeastDetail * size, scene); small > 0) {
    const std::string what = small == 1 ? " shape or triangle is" : " shapes or triangles are";
    diagnostics.warn(whole, std::to_string(small) + what + " smaller than " + format_number(kLeastDetail) +
                                " of the scene's size; rounded positions change it by a percent or more");
  }
  for (const PolygonDescription& polygon : scene.polygons) warn_of_light(polygon, size, diagnostics);
  for (const MeshDescription& mesh : scene.meshes) warn_of_light(mesh, size, diagnostics);
  for (const SphereDescription& sphere : scene.spheres) warn_of_light(sphere, size, diagnostics);
}

std::string warning_of_coarse_floats(const std::vector<DVec3>& vertices) {
  Bounds bounds;
  for (const DVec3& vertex : vertices) bounds.include(vertex);
  const double size = largest_component(bounds.high - bounds.low);
  const double reach = std::max(largest_component(bounds.low), largest_component(bounds.high));
  if (vertices.empty() || !(reach > kFarFloatMesh * size)) return {};
  return "the vertices are 32-bit floats and lie " + format_number(reach) +
         " from the origin, where these are rounded to " + format_number(reach * 0x1p-24) +
         "; the whole mesh measures " + format_number(size) + ". Store them as double or nearer";
}

}  // namespace mlt
