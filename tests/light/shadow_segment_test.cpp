// Shadow segments against the scene's own intersection code: a segment to a sample of a light must never be
// blocked by that light, from wherever it starts, and must be blocked by what stands before it.
#include <catch2/catch.hpp>
#include <cmath>

#include "base/memory.hpp"
#include "geometry/geometry.hpp"
#include "geometry/scene_fixture.hpp"
#include "light_reference.hpp"

namespace mlt::test {
namespace {

/// Geometry of a single shape, with its memory.
struct OneShape {
  MemoryPlan plan;
  GeometrySlots slots;
  std::optional<Arena> arena;
  std::optional<Geometry> geometry;

  explicit OneShape(const GeometryInput& input) {
    const GeometryCounts counts{static_cast<std::uint32_t>(input.quads.size()),
                                static_cast<std::uint32_t>(input.triangles.size()),
                                static_cast<std::uint32_t>(input.spheres.size())};
    slots = Geometry::plan(plan, counts);
    arena.emplace(plan);
    geometry.emplace(Geometry::build(*arena, slots, input));
  }
};

/// Reference points from far to touching: around a point near the light, at distances 1e-5 to 2.
Vec3 random_reference(Rng& rng, const Vec3& middle) {
  const double distance = 2 * std::pow(10.0, -5.3 * rng.next_float());
  const double z = 2.0 * rng.next_float() - 1;
  const double azimuth = 6.283185307179586 * rng.next_float();
  const double radius = std::sqrt(1 - z * z);
  const DVec3 offset{radius * std::cos(azimuth), radius * std::sin(azimuth), z};
  return Vec3{DVec3{middle} + offset * distance};
}

void check_never_blocked(const Light& light, const OneShape& shape, std::uint64_t stream) {
  Rng rng(61, StreamPurpose::kTest, stream);
  std::uint64_t blocked = 0;
  std::uint64_t lit = 0;
  for (int i = 0; i < 100000; ++i) {
    const LightSample middle = sample_one_light(light, Vec3{0, 0, 0}, random_pair(rng));
    const Vec3 reference = random_reference(rng, middle.position);
    const LightSample sample = sample_one_light(light, reference, random_pair(rng));
    // The integrator asks for lit samples only; sides that see the back have other ends.
    if (!(sample.pdf_solid_angle > 0) || is_zero(sample.radiance)) continue;
    // A reference closer to the plane than the rounding of its own coordinates (extent 1) is on either side.
    const double height = dot(DVec3{reference} - DVec3{light.origin}, DVec3{light.normal});
    if (light.shape != LightShape::kSphere && std::fabs(height) < 0x1p-24) continue;
    ++lit;
    const Ray segment{reference, sample.position - reference, 1.0f};
    if (shape.geometry->occluded<true>(segment)) ++blocked;
  }
  CHECK(blocked == 0);
  CHECK(lit > 20000);
}

}  // namespace

TEST_CASE("a shadow segment never hits the light that it leads to", "[light]") {
  // Shapes in a world of extent 1, where compiled scenes lie; axis-aligned, tilted, large, small, far off
  // centre.
  const Quad quads[] = {
      {{-0.3f, 0.9f, -0.3f}, {0.3f, 0.9f, -0.3f}, {0.3f, 0.9f, 0.3f}, {-0.3f, 0.9f, 0.3f}},
      {{-0.31f, 0.17f, 0.7f}, {0.11f, 0.33f, 0.81f}, {0.21f, 0.01f, 0.95f}, {-0.21f, -0.15f, 0.84f}},
      {{0.9f, 0.9f, 0.9f}, {0.9001f, 0.9f, 0.90003f}, {0.9001f, 0.9001f, 0.90003f}, {0.9f, 0.9001f, 0.9f}}};
  std::uint64_t stream = 0;
  for (const Quad& quad : quads) {
    const OneShape shape({{&quad, 1}, {}, {}});
    INFO("quad " << stream);
    check_never_blocked(make_quad_light(quad, Vec3{1, 1, 1}), shape, ++stream);
    const Triangle triangle{quad.a, quad.b, quad.c};
    const OneShape half({{}, TriangleSoup({triangle}).list(), {}});
    INFO("triangle " << stream);
    check_never_blocked(make_triangle_light(triangle, Vec3{1, 1, 1}), half, ++stream);
  }
  for (const Sphere& sphere : {Sphere{{0.1f, 0.5f, -0.2f}, 0.3f}, Sphere{{-0.7f, 0.6f, 0.8f}, 0.001f},
                               Sphere{{0, 0, 0.02f}, 0.97f}}) {
    const OneShape shape({{}, {}, {&sphere, 1}});
    INFO("sphere " << stream);
    check_never_blocked(make_sphere_light(sphere, Vec3{1, 1, 1}), shape, ++stream);
  }
}

TEST_CASE("a shadow segment is blocked by a quad close before the light", "[light]") {
  // The blocker is 1e-4 of the scene before the light: the offset must not jump over it.
  const Quad quad{{-0.3f, 0.3f, 0.9f}, {0.3f, 0.3f, 0.9f}, {0.3f, -0.3f, 0.9f}, {-0.3f, -0.3f, 0.9f}};
  const float z = 0.9f - 1e-4f;
  const Quad blocker{{-1, 1, z}, {1, 1, z}, {1, -1, z}, {-1, -1, z}};
  const OneShape shape({{&blocker, 1}, {}, {}});
  const Light light = make_quad_light(quad, Vec3{1, 1, 1});
  REQUIRE(light.normal == Vec3(0, 0, -1));
  Rng rng(62, StreamPurpose::kTest, 0);
  for (int i = 0; i < 10000; ++i) {
    const Vec2 xy = random_pair(rng);
    const Vec3 reference{2 * xy.x - 1, 2 * xy.y - 1, -1 + 1.5f * rng.next_float()};
    const LightSample sample = sample_one_light(light, reference, random_pair(rng));
    REQUIRE(shape.geometry->occluded<true>(Ray{reference, sample.position - reference, 1.0f}));
  }
}

}  // namespace mlt::test
