// Counts, records and lights of compiled scenes.
#include "world/world.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>

#include "base/error.hpp"
#include "support/compiled_scene.hpp"

namespace mlt::test {
namespace {

constexpr const char* kMixed = R"(
camera eye 0 0 9 target 0 0 0 fov 45
material unused mirror reflectance 0.9
material grey diffuse reflectance 0.5
material glass dielectric ior 1.5
sphere 0 0 0 1  material glass
triangle 3 0 0  4 0 0  3 1 0  material grey emit 0 2 0
quad -4 0 0  -3 0 0  -3 1 0  -4 1 0  material grey emit 1 0 0
sphere 0 3 0 0.5  material grey emit 0 0 3
quad -4 -2 0  -3 -2 0  -3 -1 0  -4 -1 0  material grey
inline_mesh material grey emit 4
vertex 3 -2 0
vertex 4 -2 0
vertex 4 -1 0
vertex 3 -1 0
face 0 1 2 3
end
)";

/// The primitive at (x, y) in the plane z = 0 as seen from the front.
std::uint32_t primitive_at(const CompiledScene& scene, double x, double y) {
  const World& world = scene.world();
  // The bounding box is [-4,4] x [-2,3.5] x [-1,1] and the scale 1/8.
  const Vec3 origin{static_cast<float>(x / 8), static_cast<float>((y - 0.75) / 8), 1};
  return world.geometry.intersect<true>(Ray{origin, Vec3{0, 0, -1}, 10}).primitive;
}

}  // namespace

TEST_CASE("counts are those of the description, by kind and by use") {
  const CompiledScene scene(kMixed, 8, 8);
  const WorldCounts& counts = scene.counts();
  CHECK(counts.geometry.quads == 2);
  CHECK(counts.geometry.triangles == 3);
  CHECK(counts.geometry.spheres == 2);
  CHECK(counts.lights == 5);
  CHECK(counts.materials == 3);
  CHECK(counts.used_kinds[static_cast<int>(MaterialKind::diffuse)] == 6);
  CHECK(counts.used_kinds[static_cast<int>(MaterialKind::dielectric)] == 1);
  CHECK(counts.used_kinds[static_cast<int>(MaterialKind::mirror)] == 0);
  CHECK(counts.used_kinds[static_cast<int>(MaterialKind::conductor)] == 0);
}

TEST_CASE("every primitive has its own material and light, whatever the order of statements") {
  const CompiledScene scene(kMixed, 8, 8);
  const World& world = scene.world();
  struct Place {
    double x, y;
    std::uint32_t material;
    Vec3 radiance;
  };
  const Place places[] = {
      {0, 0, 2, Vec3{0, 0, 0}},      {3.3, 0.3, 1, Vec3{0, 2, 0}},   {-3.5, 0.5, 1, Vec3{1, 0, 0}},
      {0, 3, 1, Vec3{0, 0, 3}},      {-3.5, -1.5, 1, Vec3{0, 0, 0}}, {3.8, -1.9, 1, Vec3{4, 4, 4}},
      {3.2, -1.1, 1, Vec3{4, 4, 4}},
  };
  for (const Place& place : places) {
    INFO("at " << place.x << " " << place.y);
    const std::uint32_t primitive = primitive_at(scene, place.x, place.y);
    REQUIRE(primitive != kNoPrimitive);
    const PrimitiveRecord record = world.primitives[primitive];
    CHECK(record.material == place.material);
    CHECK((record.light != kNoLight) == (place.radiance != Vec3{0, 0, 0}));
    if (record.light != kNoLight) CHECK(world.lights.lights[record.light].radiance == place.radiance);
  }
}

TEST_CASE("the choice among lights covers the unit interval in proportion to power") {
  const CompiledScene scene(kMixed, 8, 8);
  const LightTable& table = scene.world().lights;
  REQUIRE(table.lights.size() == 5);
  double total_power = 0, total_probability = 0;
  for (const Light& light : table.lights) total_power += light_power(light);
  for (const Light& light : table.lights) {
    total_probability += static_cast<double>(light.choice_probability);
    // Each of 5 lights gets 2^-24 first; rounding adds at most another.
    CHECK(std::fabs(static_cast<double>(light.choice_probability) - light_power(light) / total_power) <=
          7 * 0x1p-24);
  }
  CHECK(total_probability == 1.0);
  CHECK(table.cdf.back() == 1.0f);
}

TEST_CASE("a description with material parameters out of range is refused, whoever made it") {
  SceneDescription scene = parse_scene_text(kMixed, "test");
  scene.materials[1].reflectance = DVec3{0.5, 1.5, 0.5};
  CHECK_THROWS_AS(CompiledScene(scene, 8, 8), InputError);
  scene.materials[1].reflectance = DVec3{0.5, std::nan(""), 0.5};
  CHECK_THROWS_AS(CompiledScene(scene, 8, 8), InputError);
}

TEST_CASE("a mesh of a million triangles takes less than 108 bytes a triangle to compile and to keep") {
  WorldCounts counts;
  counts.geometry.triangles = 1'000'000;
  counts.triangle_vertices = 500'000;
  counts.materials = 1;
  MemoryPlan plan;
  plan_world(plan, counts);
  CHECK(plan.total_bytes() < 108'000'000);
  CHECK(plan.bytes(Lifetime::kScene) < 87'000'000);
}

TEST_CASE("scenes without shapes, and whose shapes are all in one point, compile and show nothing") {
  SceneDescription scene;
  const CompiledScene nothing(scene, 4, 4);
  CHECK_FALSE(nothing.look(2, 2, Vec2{0, 0}).found());

  scene.materials.resize(1);
  PolygonDescription point;
  for (DVec3& corner : point.corners) corner = DVec3{1, 2, 3};
  point.attributes.emission = DVec3{1, 1, 1};
  scene.polygons.push_back(point);
  scene.camera.target = DVec3{1, 2, 3};
  const CompiledScene one_point(scene, 4, 4);
  CHECK_FALSE(one_point.look(2, 2, Vec2{0, 0}).found());
  CHECK(one_point.world().lights.lights[0].area == 0.0f);
  CHECK(one_point.world().lights.lights[0].choice_probability == 0.0f);
}

}  // namespace mlt::test
