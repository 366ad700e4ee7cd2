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

/// Flat lists of both kinds, tree and brute force agree on t and primitive; occluded agrees
/// with them, also at the limits.
void compare_with_brute_force(const Shapes& shapes, const std::vector<Triangle>& targets, int rays,
                              std::uint64_t seed, const Vec3& shift = Vec3{0, 0, 0}) {
  const BuiltGeometry flat(shapes, kAlwaysFlat);
  const BuiltGeometry bounds(shapes, kAlwaysBounds);
  const BuiltGeometry tree(shapes, kAlwaysTree);
  const auto occluded = [&](const Ray& ray) {
    return flat->occluded<true>(ray) + bounds->occluded<true>(ray) + tree->occluded<true>(ray);
  };
  Rng rng(seed, StreamPurpose::kTest, 3);
  int different = 0, found = 0, tree_differs = 0, bounds_differ = 0, occlusion_differs = 0;
  for (int i = 0; i < rays; ++i) {
    Ray ray = hard_ray(rng, targets);
    // Targets are shifted already.
    if (i % 8 != 0) ray.origin = ray.origin + shift;
    const Hit expected = brute_force(shapes, ray, flat->extent());
    const Hit hit = flat->intersect<true>(ray);
    different += !same(hit, expected);
    tree_differs += !same(hit, tree->intersect<true>(ray));
    bounds_differ += !same(hit, bounds->intersect<true>(ray));
    occlusion_differs += occluded(ray) != (hit.found() ? 3 : 0);
    if (!hit.found()) continue;
    ++found;
    // A limit at the hit excludes it, the next float includes it.
    ray.t_max = hit.t;
    occlusion_differs +=
        occluded(ray) != 0 || tree->intersect<true>(ray).found() || bounds->intersect<true>(ray).found();
    ray.t_max = std::nextafter(hit.t, 2e30f);
    occlusion_differs += occluded(ray) != 3;
    different += !same(tree->intersect<true>(ray), hit) || !same(bounds->intersect<true>(ray), hit);
  }
  CHECK(different == 0);
  CHECK(tree_differs == 0);
  CHECK(bounds_differ == 0);
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

TEST_CASE("flat lists and a tree agree on many triangles") {
  Shapes shapes;
  shapes.triangles = triangle_soup(1000, 11);
  const BuiltGeometry flat(shapes, kAlwaysFlat);
  const BuiltGeometry bounds(shapes, kAlwaysBounds);
  const BuiltGeometry tree(shapes, kAlwaysTree);
  Rng rng(9, StreamPurpose::kTest, 8);
  int different = 0;
  for (int i = 0; i < 100000; ++i) {
    const Ray ray = hard_ray(rng, shapes.triangles);
    const Hit hit = tree->intersect<true>(ray);
    different += !same(flat->intersect<true>(ray), hit) || !same(bounds->intersect<true>(ray), hit);
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
  const BuiltGeometry as_list(quads, kAlwaysBounds);
  Rng rng(5, StreamPurpose::kTest, 5);
  int different = 0;
  for (int i = 0; i < 100000; ++i) {
    const Ray ray = hard_ray(rng, triangles.triangles);
    const Hit hit = as_quads->intersect<true>(ray);
    different += !same(hit, as_triangles->intersect<true>(ray)) ||
                 !same(hit, as_quads->intersect<false>(ray)) || !same(hit, as_list->intersect<false>(ray));
  }
  CHECK(different == 0);
}

/// Rays along the planes of polygons, from as close to them as a few roundings and at their edges.
Ray grazing_ray(Rng& rng, const std::vector<Triangle>& targets) {
  const Triangle& t = targets[below(rng, targets.size())];
  const Vec3 e1 = t.b - t.a, e2 = t.c - t.a;
  const float v = below(rng, 3) == 0 ? 0.0f : signed_unit(rng) * 2.0f;
  const float w = signed_unit(rng) * 2.0f;
  const Vec3 normal = normalize(cross(e1, e2));
  const float height = std::ldexp(signed_unit(rng), -static_cast<int>(below(rng, 30)));
  const float slope = std::ldexp(signed_unit(rng), -static_cast<int>(below(rng, 30)));
  const Vec3 origin = t.a + ((e1 * v + e2 * w) + normal * height);
  const Vec3 to = t.a + (e1 * rng.next_float() + e2 * (below(rng, 2) == 0 ? 0.0f : rng.next_float()));
  return Ray{origin, (to - origin) + normal * slope, below(rng, 2) == 0 ? 1.0f : 1e30f};
}

void compare_grazing(const Shapes& shapes, int rays) {
  const BuiltGeometry flat(shapes, kAlwaysFlat);
  const BuiltGeometry bounds(shapes, kAlwaysBounds);
  Rng rng(12, StreamPurpose::kTest, 11);
  const std::vector<Triangle> targets = halves_of(shapes.quads);
  int different = 0, occlusion_differs = 0, found = 0;
  for (int i = 0; i < rays; ++i) {
    const Ray ray = grazing_ray(rng, targets);
    const Hit hit = flat->intersect<true>(ray);
    found += hit.found();
    different += !same(hit, bounds->intersect<true>(ray));
    occlusion_differs += hit.found() != bounds->occluded<true>(ray);
  }
  CHECK(different == 0);
  CHECK(occlusion_differs == 0);
  CHECK(found > rays / 8);
}

void compare_all_grazing(int rays) {
  Shapes soup, box;
  soup.quads = quad_soup(80, 43);
  std::erase_if(soup.quads, [](const Quad& q) {
    const Vec3 e1 = q.b - q.a, e2 = q.c - q.a;
    return length(cross(e1, e2)) < 1e-6f * length(e1) * length(e2);
  });
  compare_grazing(soup, rays);
  const Vec3 x{2, 0, 0}, y{0, 2, 0}, z{0, 0, 2}, at{-1, -1, -1};
  for (const Vec3& side : {Vec3{0, 0, 0}, z})
    box.quads.push_back({at + side, at + side + x, at + side + x + y, at + side + y});
  for (const Vec3& side : {Vec3{0, 0, 0}, x})
    box.quads.push_back({at + side, at + side + y, at + side + y + z, at + side + z});
  for (const Vec3& side : {Vec3{0, 0, 0}, y})
    box.quads.push_back({at + side, at + side + z, at + side + z + x, at + side + x});
  compare_grazing(box, rays);
}

TEST_CASE("rays along polygons and at their edges: bounds of flat lists hide no hit and claim none") {
  compare_all_grazing(100000);
}
TEST_CASE("2e7 rays along polygons and at their edges: bounds of flat lists hide no hit and claim none",
          "[.slow]") {
  compare_all_grazing(10000000);
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
  for (const FlatLimits& limits : {kAlwaysFlat, kAlwaysBounds, kAlwaysTree}) {
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
  for (const FlatLimits& limits : {kAlwaysFlat, kAlwaysBounds, kAlwaysTree}) {
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
  for (const FlatLimits& limits : {kAlwaysFlat, kAlwaysBounds, kAlwaysTree}) {
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
