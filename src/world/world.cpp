#include "world/world.hpp"

#include <algorithm>
#include <cmath>

#include "base/assert.hpp"
#include "math/degrees.hpp"
#include "scene/bounds.hpp"

namespace mlt {
namespace {

bool emits(const ShapeAttributes& attributes) {
  return attributes.emission.has_value() && *attributes.emission != DVec3{0, 0, 0};
}

/// Calls visit(attributes, primitive count) for each shape, in no particular order of kinds.
template <class Visit>
void visit_shapes(const SceneDescription& scene, Visit&& visit) {
  for (const PolygonDescription& polygon : scene.polygons) visit(polygon.attributes, std::size_t{1});
  for (const MeshDescription& mesh : scene.meshes) visit(mesh.attributes, mesh.indices.size() / 3);
  for (const SphereDescription& sphere : scene.spheres) visit(sphere.attributes, std::size_t{1});
}

/// Centre of the scene's bounding box, and the power of two that brings its half extent into [0.5, 1).
struct Placement {
  DVec3 centre{0, 0, 0};
  double scale = 1;

  Vec3 point(const DVec3& p) const { return Vec3{(p - centre) * scale}; }
};

Placement place(const SceneDescription& scene) {
  const Bounds bounds = bounds_of(scene);
  Placement placement;
  if (!(bounds.low.x <= bounds.high.x)) return placement;
  placement.centre = bounds.low + (bounds.high - bounds.low) * 0.5;
  const DVec3 extent = (bounds.high - bounds.low) * 0.5;
  const double half = std::max({extent.x, extent.y, extent.z});
  MLT_CHECK(std::isfinite(half));
  int exponent = 0;
  if (half > 0.0) std::frexp(half, &exponent);
  placement.scale = std::ldexp(1.0, -exponent);
  return placement;
}

Camera compile_camera(const CameraDescription& description, const Placement& placement, std::uint32_t width,
                      std::uint32_t height) {
  const DVec3 forward = normalize(description.target - description.eye);
  const DVec3 right = normalize(cross(forward, description.up));
  const DVec3 up = cross(right, forward);
  const double half_height = tan_degrees(description.vertical_fov_degrees * 0.5);
  const double pixel = 2.0 * half_height / static_cast<double>(height);
  const double half_width = 0.5 * pixel * static_cast<double>(width);
  Camera camera;
  camera.eye = placement.point(description.eye);
  camera.corner = Vec3{(forward - right * half_width) + up * half_height};
  camera.step_x = Vec3{right * pixel};
  camera.step_y = Vec3{-up * pixel};
  camera.width = width;
  camera.height = height;
  return camera;
}

/// Fills shapes, primitive records and lights in one pass over the scene.
class ShapeCompiler {
 public:
  ShapeCompiler(const WorldCounts& counts, Arena& arena, const WorldSlots& slots)
      : counts_(counts),
        quads_(arena.take(slots.quads)),
        vertices_(arena.take(slots.vertices)),
        triangles_(arena.take(slots.triangles)),
        spheres_(arena.take(slots.spheres)),
        primitives_(arena.take(slots.primitives)),
        lights_(arena.take(slots.lights)) {}

  void compile(const SceneDescription& scene, const Placement& placement) {
    for (const PolygonDescription& polygon : scene.polygons) add_polygon(polygon, placement);
    for (const MeshDescription& mesh : scene.meshes) add_mesh(mesh, placement);
    for (const SphereDescription& sphere : scene.spheres) add_sphere(sphere, placement);
    MLT_CHECK_OP(quad_count_, ==, quads_.size());
    MLT_CHECK_OP(vertex_count_, ==, vertices_.size());
    MLT_CHECK_OP(triangle_count_, ==, triangles_.size());
    MLT_CHECK_OP(sphere_count_, ==, spheres_.size());
    MLT_CHECK_OP(light_count_, ==, lights_.size());
  }

  GeometryInput geometry() const { return {quads_, {vertices_, triangles_}, spheres_}; }
  std::span<const PrimitiveRecord> primitives() const { return primitives_; }
  std::span<Light> lights() const { return lights_; }

 private:
  void add_polygon(const PolygonDescription& polygon, const Placement& placement) {
    const Vec3 a = placement.point(polygon.corners[0]);
    const Vec3 b = placement.point(polygon.corners[1]);
    const Vec3 c = placement.point(polygon.corners[2]);
    if (polygon.corner_count == 3) {
      const std::uint32_t first = vertex_count_;
      for (const Vec3& corner : {a, b, c}) vertices_[vertex_count_++] = corner;
      add_triangle({first, first + 1, first + 2}, polygon.attributes);
      return;
    }
    const Quad quad{a, b, c, placement.point(polygon.corners[3])};
    const std::uint32_t index = quad_count_++;
    quads_[index] = quad;
    record(index, polygon.attributes, [&](const Vec3& radiance) { return make_quad_light(quad, radiance); });
  }

  void add_mesh(const MeshDescription& mesh, const Placement& placement) {
    const std::uint32_t first = vertex_count_;
    vertex_count_ += static_cast<std::uint32_t>(mesh.vertices.size());
    // Vertices that no triangle has may lie anywhere, also where a float does not reach.
    for (const std::uint32_t index : mesh.indices)
      vertices_[first + index] = placement.point(mesh.vertices[index]);
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
      add_triangle({first + mesh.indices[i], first + mesh.indices[i + 1], first + mesh.indices[i + 2]},
                   mesh.attributes);
    }
  }

  void add_triangle(const TriangleCorners& corners, const ShapeAttributes& attributes) {
    const std::uint32_t index = triangle_count_++;
    triangles_[index] = corners;
    record(counts_.geometry.quads + index, attributes, [&](const Vec3& radiance) {
      return make_triangle_light(TriangleList{vertices_, triangles_}[index], radiance);
    });
  }

  void add_sphere(const SphereDescription& description, const Placement& placement) {
    const Sphere sphere{placement.point(description.center),
                        static_cast<float>(description.radius * placement.scale)};
    const std::uint32_t index = sphere_count_++;
    spheres_[index] = sphere;
    record(counts_.geometry.quads + counts_.geometry.triangles + index, description.attributes,
           [&](const Vec3& radiance) { return make_sphere_light(sphere, radiance); });
  }

  template <class MakeLight>
  void record(std::uint32_t primitive, const ShapeAttributes& attributes, MakeLight&& make_light) {
    primitives_[primitive].material = attributes.material;
    if (!emits(attributes)) return;
    primitives_[primitive].light = light_count_;
    Light& light = lights_[light_count_++];
    light = make_light(Vec3{*attributes.emission});
    light.primitive = primitive;
  }

  const WorldCounts& counts_;
  std::span<Quad> quads_;
  std::span<Vec3> vertices_;
  std::span<TriangleCorners> triangles_;
  std::span<Sphere> spheres_;
  std::span<PrimitiveRecord> primitives_;
  std::span<Light> lights_;
  std::uint32_t quad_count_ = 0, vertex_count_ = 0, triangle_count_ = 0, sphere_count_ = 0, light_count_ = 0;
};

}  // namespace

WorldCounts count_world(const SceneDescription& scene) {
  WorldCounts counts;
  counts.materials = static_cast<std::uint32_t>(scene.materials.size());
  for (const PolygonDescription& polygon : scene.polygons) {
    (polygon.corner_count == 4 ? counts.geometry.quads : counts.geometry.triangles) += 1;
    if (polygon.corner_count == 3) counts.triangle_vertices += 3;
  }
  for (const MeshDescription& mesh : scene.meshes) {
    counts.geometry.triangles += static_cast<std::uint32_t>(mesh.indices.size() / 3);
    counts.triangle_vertices += static_cast<std::uint32_t>(mesh.vertices.size());
  }
  counts.geometry.spheres = static_cast<std::uint32_t>(scene.spheres.size());
  visit_shapes(scene, [&](const ShapeAttributes& attributes, std::size_t primitives) {
    const auto count = static_cast<std::uint32_t>(primitives);
    const MaterialKind kind = scene.materials[attributes.material].kind;
    counts.used_kinds[static_cast<std::size_t>(kind)] += count;
    if (emits(attributes)) counts.lights += count;
  });
  return counts;
}

WorldSlots plan_world(MemoryPlan& plan, const WorldCounts& counts) {
  const std::size_t primitives =
      std::size_t{counts.geometry.quads} + counts.geometry.triangles + counts.geometry.spheres;
  WorldSlots slots;
  slots.quads = plan.add<Quad>("quads, input of the build", Lifetime::kScratch, counts.geometry.quads);
  slots.vertices =
      plan.add<Vec3>("vertices, input of the build", Lifetime::kScratch, counts.triangle_vertices);
  slots.triangles = plan.add<TriangleCorners>("triangles, input of the build", Lifetime::kScratch,
                                              counts.geometry.triangles);
  slots.spheres =
      plan.add<Sphere>("spheres, input of the build", Lifetime::kScratch, counts.geometry.spheres);
  slots.geometry = Geometry::plan(plan, counts.geometry);
  slots.materials = plan.add<Material>("materials", Lifetime::kScene, counts.materials);
  slots.primitives = plan.add<PrimitiveRecord>("primitive records", Lifetime::kScene, primitives);
  slots.lights = plan.add<Light>("lights", Lifetime::kScene, counts.lights);
  slots.light_cdf = plan.add<float>("light choice", Lifetime::kScene, counts.lights);
  return slots;
}

World compile_world(const SceneDescription& scene, const WorldCounts& counts, std::uint32_t width,
                    std::uint32_t height, Arena& arena, const WorldSlots& slots, const UnitRunner& runner) {
  const Placement placement = place(scene);
  ShapeCompiler shapes(counts, arena, slots);
  shapes.compile(scene, placement);
  const std::span<Material> materials = arena.take(slots.materials);
  for (std::size_t i = 0; i < materials.size(); ++i) materials[i] = compile_material(scene.materials[i]);
  const LightTable lights = build_light_table(shapes.lights(), arena.take(slots.light_cdf));

  return World{compile_camera(scene.camera, placement, width, height),
               Geometry::build(arena, slots.geometry, shapes.geometry(), runner),
               materials,
               shapes.primitives(),
               lights,
               box_around(lights.lights)};
}

}  // namespace mlt
