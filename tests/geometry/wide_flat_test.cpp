// Many rays against a flat list, each with the bits that it gets alone: also those on which the fast test
// leaves doubt, which rays at edges, at coinciding quads and from quads' own surfaces see to.
#include "geometry/wide_flat.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <vector>

#include "geometry/scene_fixture.hpp"

namespace mlt::test {
namespace {

using F = WideFloat;

constexpr std::uint32_t kQuads = 30;

/// Tilted parallelograms that cross each other, a third of them twice in the same place, and a cube, whose
/// faces rays to its edges and corners meet at the same distance, in an order that is not that of their axes.
Shapes crossing_quads(std::uint64_t seed) {
  Rng rng(seed, StreamPurpose::kTest, 0);
  Shapes shapes;
  for (int i = 0; i < 24; ++i) {
    const Vec3 a = point_in_cube(rng);
    const Vec3 u = point_in_cube(rng);
    const Vec3 v = point_in_cube(rng);
    shapes.quads.push_back(i % 3 == 2 ? shapes.quads.back() : Quad{a, a + u, a + u + v, a + v});
  }
  const auto face = [&](const Vec3& a, const Vec3& u, const Vec3& v) {
    shapes.quads.push_back(Quad{a, a + u, a + u + v, a + v});
  };
  const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, low{-0.5f, -0.5f, -0.5f};
  face(low, x, y);
  face(low + z, x, y);
  face(low, z, x);
  face(low + y, z, x);
  face(low, y, z);
  face(low + x, y, z);
  return shapes;
}

/// A parallelepiped's faces, of which some are left out, each from another corner on and either way round.
void add_cell(Shapes& shapes, const Vec3& corner, const Vec3 (&edges)[3], unsigned faces, Rng& rng) {
  for (unsigned i = 0; i < 6; ++i) {
    const Vec3 from = i % 2 == 1 ? corner + edges[i / 2] : corner;
    const Vec3 u = edges[(i / 2 + 1) % 3], v = edges[(i / 2 + 2) % 3];
    const Vec3 corners[4] = {from, from + u, from + u + v, from + v};
    const std::uint32_t start = rng.next_fixed() % 4, step = rng.next_fixed() % 2 == 0 ? 1 : 3;
    const auto at = [&](std::uint32_t k) { return corners[(start + k * step) % 4]; };
    if ((faces >> i & 1U) != 0) shapes.quads.push_back(Quad{at(0), at(1), at(2), at(3)});
  }
}

/// A room with an open side, blocks that stand on its floor, one against the other, a lamp in the ceiling, a
/// skewed block with missing faces, a thin one, and quads that cut through all.
Shapes rooms(std::uint64_t seed) {
  Rng rng(seed, StreamPurpose::kTest, 2);
  Shapes shapes;
  const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  const Vec3 low{-1, -1, -1}, room[3] = {x * 2.0f, y * 2.0f, z * 2.0f};
  add_cell(shapes, low, room, 0x2fU, rng);
  const Vec3 lamp{-0.2f, 1, -0.2f};
  shapes.quads.push_back(Quad{lamp, lamp + x * 0.4f, lamp + x * 0.4f + z * 0.3f, lamp + z * 0.3f});
  const float angle = rng.next_float();
  const Vec3 u{std::cos(angle) * 0.5f, 0, std::sin(angle) * 0.5f},
      v{std::sin(angle) * -0.4f, 0, std::cos(angle) * 0.4f};
  const Vec3 block[3] = {u, v, y * 0.7f};
  add_cell(shapes, Vec3{-0.6f, -1, -0.4f}, block, 0x3fU, rng);
  add_cell(shapes, Vec3{-0.6f, -1, -0.4f} + v, block, 0x3fU, rng);
  const Vec3 skewed[3] = {point_in_cube(rng), point_in_cube(rng), point_in_cube(rng)};
  add_cell(shapes, point_in_cube(rng), skewed, 0x15U | rng.next_fixed() % 64, rng);
  const Vec3 thin[3] = {x * 0.3f, y * 1e-4f, z * 0.3f};
  add_cell(shapes, point_in_cube(rng) * 0.5f, thin, 0x3fU, rng);
  while (shapes.quads.size() < kQuads) {
    const Vec3 a = point_in_cube(rng), b = point_in_cube(rng), c = point_in_cube(rng);
    shapes.quads.push_back(Quad{a, a + b, a + b + c, a + c});
  }
  return shapes;
}

/// Spheres of many sizes that cross each other and walls, one twice in the same place.
void add_spheres(Shapes& shapes, std::uint64_t seed) {
  Rng rng(seed, StreamPurpose::kTest, 3);
  for (int i = 0; i < 9; ++i) {
    const Vec3 center = point_in_cube(rng);
    shapes.spheres.push_back({center, 0.5f * rng.next_float() * rng.next_float()});
  }
  shapes.spheres.push_back(shapes.spheres[3]);
}

/// With a pyramid and some more triangles, which lie in the same list.
Shapes rooms_with_spheres(std::uint64_t seed) {
  Shapes shapes = rooms(seed);
  Rng rng(seed, StreamPurpose::kTest, 4);
  const Vec3 top = point_in_cube(rng), base[3] = {point_in_cube(rng), point_in_cube(rng), point_in_cube(rng)};
  for (int i = 0; i < 3; ++i) shapes.triangles.push_back({top, base[i], base[(i + 1) % 3]});
  for (int i = 0; i < 6; ++i) {
    const Vec3 a = point_in_cube(rng), b = point_in_cube(rng), c = point_in_cube(rng);
    shapes.triangles.push_back({a, b, c});
  }
  add_spheres(shapes, seed);
  return shapes;
}

Shapes spheres_alone(std::uint64_t seed) {
  Shapes shapes;
  add_spheres(shapes, seed);
  return shapes;
}

/// A direction, towards the rim of a sphere or a corner or an edge of a quad more often than not.
Vec3 direction_from(const Vec3& origin, const Shapes& shapes, Rng& rng) {
  if (!shapes.spheres.empty() && (shapes.quads.empty() || rng.next_fixed() % 2 == 0)) {
    const Sphere& sphere = shapes.spheres[rng.next_fixed() % shapes.spheres.size()];
    const Vec3 to_center = sphere.center - origin;
    const Vec3 aside = normalize(cross(to_center, point_in_cube(rng)));
    const float part = rng.next_fixed() % 2 == 0 ? 1.0f : 1.2f * rng.next_float();
    return to_center + aside * (sphere.radius * part);
  }
  const Quad& quad = shapes.quads[rng.next_fixed() % shapes.quads.size()];
  const std::uint32_t kind = rng.next_fixed() % 4;
  const float along = rng.next_float();
  const Vec3 free = point_in_cube(rng);
  if (kind == 0) return quad.c - origin;
  if (kind == 1) return (quad.a + (quad.b - quad.a) * along) - origin;
  return free;
}

struct RayInLane {
  Ray ray;
  std::uint32_t leaves = kNoPrimitive;
};

/// A ray from anywhere, or from where another one hits.
RayInLane some_ray(const Geometry& geometry, const Shapes& shapes, Rng& rng) {
  const Vec3 origin = point_in_cube(rng) * 1.5f;
  const Ray first{origin, direction_from(origin, shapes, rng), std::numeric_limits<float>::infinity()};
  const Hit hit = geometry.intersect<true>(first);
  const std::uint32_t choice = rng.next_fixed() % 3;
  const Vec3 away = point_in_cube(rng);
  if (choice == 0 || !hit.found()) return {first};
  const SurfacePoint point = geometry.surface_point<true>(first, hit);
  const Vec3 origin_off = point.origin_towards(away);
  return {Ray{origin_off, away, choice == 1 ? first.t_max : 1.0f}, hit.primitive};
}

void check_same(const Hit& found, const Hit& expected) {
  REQUIRE(found.primitive == expected.primitive);
  if (!expected.found()) return;
  REQUIRE(as_bits(found.t) == as_bits(expected.t));
  REQUIRE(found.slot == expected.slot);
  REQUIRE(as_bits(found.weights[0]) == as_bits(expected.weights[0]));
  REQUIRE(as_bits(found.weights[1]) == as_bits(expected.weights[1]));
}

template <bool kGeneral>
void check_lanes(Shapes (&shapes_of)(std::uint64_t)) {
  int hits = 0, blocked = 0;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const Shapes shapes = shapes_of(seed);
    const BuiltGeometry built(shapes, kAlwaysBounds);
    const Geometry& geometry = *built;
    Rng rng(seed, StreamPurpose::kTest, 1);
    for (int group = 0; group < 4000; ++group) {
      RayInLane alone[kWideLanes];
      RayOf<F> rays;
      SegmentEnds<F> ends;
      MaskOf<F> active{};
      for (int lane = 0; lane < kWideLanes; ++lane) {
        alone[lane] = some_ray(geometry, shapes, rng);
        set_lane_of(rays.origin, lane, alone[lane].ray.origin);
        set_lane_of(rays.direction, lane, alone[lane].ray.direction);
        set_lane_of(rays.t_max, lane, alone[lane].ray.t_max);
        set_lane_of(ends.leaves, lane, alone[lane].leaves);
        set_lane_of(ends.target, lane, rng.next_fixed() % kQuads);
        if (rng.next_float() < 0.9f) set_lane_of(active, lane, kLaneTrue<F>);
      }
      const HitOf<F> found = geometry.intersect_lanes<kGeneral, F>(rays, ends.leaves, active);
      const MaskOf<F> is_blocked = geometry.occluded_lanes<kGeneral, F>(rays, ends, active);
      const SurfacePointOf<F> points = geometry.surface_points<kGeneral, F>(rays, found, active);
      for_lanes(active, [&](int lane) {
        const Ray& ray = alone[lane].ray;
        const Hit expected = geometry.intersect<kGeneral>(ray);
        check_same(lane_of(found, lane), expected);
        const bool expected_block = geometry.occluded<kGeneral>(ray, lane_of(ends.target, lane));
        REQUIRE((lane_of(is_blocked, lane) != 0) == expected_block);
        hits += expected.found() ? 1 : 0;
        blocked += expected_block ? 1 : 0;
        if (!expected.found()) return;
        const SurfacePoint point = geometry.surface_point<kGeneral>(ray, expected);
        REQUIRE(lane_of(points.position, lane) == point.position);
        REQUIRE(lane_of(points.normal, lane) == point.normal);
        REQUIRE(as_bits(lane_of(points.offset_bound, lane)) == as_bits(point.offset_bound));
      });
    }
  }
  CHECK(hits > 10000);
  CHECK(blocked > 5000);
}

TEST_CASE("rays in lanes meet what they meet alone, and are blocked as alone") {
  check_lanes<false>(crossing_quads);
}

TEST_CASE("rays in lanes meet rooms and blocks, which are tested whole, as they meet their faces alone") {
  check_lanes<false>(rooms);
}

TEST_CASE("rays in lanes meet spheres in rooms, and spheres alone, as they meet them alone") {
  check_lanes<true>(rooms_with_spheres);
  check_lanes<true>(spheres_alone);
}

}  // namespace
}  // namespace mlt::test
