// What a ray hits: against the scalar definition (bit for bit), and against an
// independent method in double.
#include <bit>
#include <catch2/catch.hpp>
#include <cstring>

#include "reference.hpp"
#include "scene_fixture.hpp"

namespace mlt::test {
namespace {

bool same(const Hit& p, const Hit& q) {
  return p.primitive == q.primitive && (!p.found() || std::memcmp(&p.t, &q.t, sizeof p.t) == 0);
}

/// Flat list, tree and brute force agree on t and primitive; occluded agrees
/// with them, also at the limits.
void compare_with_brute_force(const Shapes& shapes, const std::vector<Triangle>& targets, int rays,
                              std::uint64_t seed, const Vec3& shift = Vec3{0, 0, 0}) {
  const BuiltGeometry flat(shapes, kAlwaysFlat);
  const BuiltGeometry tree(shapes, kAlwaysTree);
  Rng rng(seed, StreamPurpose::kTest, 3);
  int different = 0, found = 0, tree_differs = 0, occlusion_differs = 0;
  for (int i = 0; i < rays; ++i) {
    Ray ray = hard_ray(rng, targets);
    // Targets are shifted already.
    if (i % 8 != 0) ray.origin = ray.origin + shift;
    const Hit expected = brute_force(shapes, ray, flat->extent());
    const Hit hit = flat->intersect<true>(ray);
    different += !same(hit, expected);
    tree_differs += !same(hit, tree->intersect<true>(ray));
    occlusion_differs += tree->occluded<true>(ray) != hit.found() || flat->occluded<true>(ray) != hit.found();
    if (!hit.found()) continue;
    ++found;
    // A limit at the hit excludes it, the next float includes it.
    ray.t_max = hit.t;
    occlusion_differs +=
        tree->occluded<true>(ray) || flat->occluded<true>(ray) || tree->intersect<true>(ray).found();
    ray.t_max = std::nextafter(hit.t, 2e30f);
    occlusion_differs += !tree->occluded<true>(ray) || !flat->occluded<true>(ray);
    different += !same(tree->intersect<true>(ray), hit);
  }
  CHECK(different == 0);
  CHECK(tree_differs == 0);
  CHECK(occlusion_differs == 0);
  // Rays that aim at something, and hit it unless it lies so far away that it
  // is smaller than rounding.
  CHECK(found > rays / 32);
}

void compare_soups(int rays) {
  Shapes triangles;
  triangles.triangles = triangle_soup(100, 7);
  compare_with_brute_force(triangles, triangles.triangles, rays, 1);
  Shapes quads;
  quads.quads = quad_soup(80, 8);
  compare_with_brute_force(quads, halves_of(quads.quads), rays, 2);
}

TEST_CASE("soups with needles and duplicates equal brute force, flat and as a tree") {
  compare_soups(60000);
}
TEST_CASE("1e6 rays through soups equal brute force, flat and as a tree", "[.slow]") {
  compare_soups(1000000);
}

TEST_CASE("a flat list and a tree agree on many triangles") {
  Shapes shapes;
  shapes.triangles = triangle_soup(1000, 11);
  const BuiltGeometry flat(shapes, kAlwaysFlat);
  const BuiltGeometry tree(shapes, kAlwaysTree);
  Rng rng(9, StreamPurpose::kTest, 8);
  int different = 0;
  for (int i = 0; i < 100000; ++i) {
    const Ray ray = hard_ray(rng, shapes.triangles);
    different += !same(flat->intersect<true>(ray), tree->intersect<true>(ray));
  }
  CHECK(different == 0);
}

TEST_CASE(
    "pitfall 20: ties on shared edges, corners and coplanar duplicates "
    "give the lowest primitive index") {
  Shapes shapes;
  shapes.triangles = lattice(4);
  for (std::size_t i = 0; i < 20; ++i) shapes.triangles.push_back(shapes.triangles[i * 3]);
  shapes.quads = quad_soup(10, 9);
  for (std::size_t i = 0; i < 10; ++i) shapes.quads.push_back(shapes.quads[9 - i]);
  compare_with_brute_force(shapes, shapes.triangles, 60000, 3);

  // A duplicate is never the one that is reported.
  Shapes twice;
  for (int i = 0; i < 2; ++i) {
    for (const Triangle& t : triangle_soup(64, 10)) twice.triangles.push_back(t);
  }
  const BuiltGeometry tree(twice, kAlwaysTree);
  Rng rng(4, StreamPurpose::kTest, 4);
  int wrong = 0;
  for (int i = 0; i < 20000; ++i) {
    const Hit hit = tree->intersect<true>(hard_ray(rng, twice.triangles));
    wrong += hit.found() && hit.primitive >= 64;
  }
  CHECK(wrong == 0);
}

TEST_CASE("pitfall 16: meshes far from the origin, tiny and huge equal brute force") {
  const float scales[] = {1e-4f, 1.0f, 100.0f};
  const Vec3 shifts[] = {Vec3{0, 0, 0}, Vec3{1000, -2000, 500}};
  std::uint64_t seed = 20;
  for (const float scale : scales) {
    for (const Vec3& shift : shifts) {
      Shapes shapes;
      shapes.triangles = triangle_soup(80, seed);
      for (Triangle& t : shapes.triangles) {
        t = Triangle{t.a * scale + shift, t.b * scale + shift, t.c * scale + shift};
      }
      compare_with_brute_force(shapes, shapes.triangles, 10000, seed++, shift);
    }
  }
}

TEST_CASE(
    "a triangle and the quad whose last corners coincide give the same "
    "bits of t") {
  Shapes triangles, quads;
  triangles.triangles = triangle_soup(60, 30);
  for (const Triangle& t : triangles.triangles) quads.quads.push_back({t.a, t.b, t.c, t.c});
  const BuiltGeometry as_triangles(triangles, kAlwaysFlat);
  const BuiltGeometry as_quads(quads, kAlwaysFlat);
  Rng rng(5, StreamPurpose::kTest, 5);
  int different = 0;
  for (int i = 0; i < 100000; ++i) {
    const Ray ray = hard_ray(rng, triangles.triangles);
    const Hit hit = as_quads->intersect<true>(ray);
    different +=
        !same(hit, as_triangles->intersect<true>(ray)) || !same(hit, as_quads->intersect<false>(ray));
  }
  CHECK(different == 0);
}

void compare_with_double(const Shapes& shapes, const std::vector<Triangle>& triangles, int rays,
                         std::uint64_t seed) {
  const BuiltGeometry tree(shapes, kAlwaysTree);
  Rng rng(seed, StreamPurpose::kTest, 6);
  int wrong = 0, sure = 0, hits = 0;
  for (int i = 0; i < rays; ++i) {
    const Ray ray = hard_ray(rng, triangles);
    DoubleHit expected;
    for (const Triangle& t : triangles) moeller_trumbore(ray, t, expected);
    if (expected.doubtful) continue;
    ++sure;
    const Hit hit = tree->intersect<true>(ray);
    const bool meets = std::isfinite(expected.t);
    hits += meets;
    wrong += hit.found() != meets || (meets && std::fabs(double{hit.t} - expected.t) > expected.t_error);
  }
  CHECK(wrong == 0);
  CHECK(sure > rays / 4);
  CHECK(hits > rays / 20);
}

TEST_CASE("triangles and quads agree with Moeller and Trumbore's method in double") {
  Shapes shapes;
  shapes.triangles = triangle_soup(100, 40);
  compare_with_double(shapes, shapes.triangles, 60000, 6);
  Shapes quads;
  quads.quads = quad_soup(60, 41);
  compare_with_double(quads, halves_of(quads.quads), 60000, 7);
}

TEST_CASE("pitfall 21: degenerate primitives and rays never hit and never give NaN") {
  Shapes shapes;
  const Vec3 p{0.1f, 0.2f, 0.3f}, q{0.7f, 0.1f, -0.4f};
  shapes.triangles = {{p, p, p}, {p, q, q}, {p, q, p}, {p, p, q}, {{0, 0, 0}, {1, 1, 1}, {0.5f, 0.5f, 0.5f}}};
  for (int i = 0; i < 40; ++i) shapes.triangles.push_back({p, p, q});
  shapes.quads = {{p, p, p, p}, {p, q, q, p}, {p, p, q, q}};
  shapes.spheres = {{p, 0.0f}};
  for (const FlatLimits& limits : {kAlwaysFlat, kAlwaysTree}) {
    const BuiltGeometry geometry(shapes, limits);
    Rng rng(8, StreamPurpose::kTest, 7);
    int found = 0;
    for (int i = 0; i < 20000; ++i)
      found += geometry->intersect<true>(hard_ray(rng, shapes.triangles)).found();
    CHECK(found == 0);
  }
  Shapes sound;
  sound.triangles = triangle_soup(50, 42);
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  for (const FlatLimits& limits : {kAlwaysFlat, kAlwaysTree}) {
    const BuiltGeometry geometry(sound, limits);
    for (const Vec3& direction :
         {Vec3{0, 0, 0}, Vec3{-0.0f, 0, 0}, Vec3{nan, 0, 1}, Vec3{1, nan, nan}, Vec3{inf, 0, 1}}) {
      CHECK_FALSE(geometry->intersect<true>(Ray{Vec3{0, 0, 0}, direction, 1e30f}).found());
      CHECK_FALSE(geometry->occluded<true>(Ray{Vec3{0, 0, 0}, direction, 1e30f}));
    }
    CHECK_FALSE(geometry->occluded<true>(Ray{Vec3{nan, 0, 0}, Vec3{0, 0, 1}, 1e30f}));
    for (const float t_max : {0.0f, -1.0f, nan}) {
      CHECK_FALSE(geometry->occluded<true>(Ray{Vec3{0, 0, -2}, Vec3{0, 0, 1}, t_max}));
      CHECK_FALSE(geometry->intersect<true>(Ray{Vec3{0, 0, -2}, Vec3{0, 0, 1}, t_max}).found());
    }
  }
}

TEST_CASE("an empty geometry hits nothing") {
  const BuiltGeometry empty{Shapes{}};
  CHECK_FALSE(empty->intersect<true>(Ray{Vec3{0, 0, 0}, Vec3{0, 0, 1}, 1e30f}).found());
  CHECK_FALSE(empty->occluded<false>(Ray{Vec3{0, 0, 0}, Vec3{0, 0, 1}, 1e30f}));
}

TEST_CASE(
    "pitfall 20: hits and points have the same bits on every instruction "
    "set, compiler and structure") {
  Shapes shapes;
  shapes.triangles = triangle_soup(200, 70);
  for (const Triangle& t : lattice(2)) shapes.triangles.push_back(t);
  shapes.quads = quad_soup(40, 71);
  for (int i = 0; i < 20; ++i) shapes.quads.push_back(shapes.quads[static_cast<std::size_t>(i)]);
  Rng rng(10, StreamPurpose::kTest, 9);
  for (int i = 0; i < 40; ++i)
    shapes.spheres.push_back({point_in_cube(rng), 0.01f + 0.1f * rng.next_float()});
  for (const FlatLimits& limits : {kAlwaysFlat, kAlwaysTree}) {
    const BuiltGeometry geometry(shapes, limits);
    Rng rays(11, StreamPurpose::kTest, 10);
    std::uint64_t hash = 0;
    const auto add = [&](float value) { hash = mix64(hash ^ std::bit_cast<std::uint32_t>(value)); };
    for (int i = 0; i < 50000; ++i) {
      const Ray ray = hard_ray(rays, shapes.triangles);
      const Hit hit = geometry->intersect<true>(ray);
      hash = mix64(hash ^ hit.primitive);
      if (!hit.found()) continue;
      const SurfacePoint point = geometry->surface_point<true>(ray, hit);
      add(hit.t);
      for (int k = 0; k < 3; ++k) add(point.position[k]);
      for (int k = 0; k < 3; ++k) add(point.normal[k]);
      add(point.offset_bound);
    }
    // From g++ with 4 lanes; every other build must agree.
    CHECK(hash == 0xeadd9f4b780a2d53ULL);
  }
}

}  // namespace
}  // namespace mlt::test
