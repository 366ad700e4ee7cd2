// Points on surfaces, the offset of rays that leave them, and closed meshes that must not leak.
#include <catch2/catch.hpp>
#include <thread>

#include "reference.hpp"
#include "scene_fixture.hpp"

namespace mlt::test {
namespace {

using Long3 = glm::tvec3<long double>;

Long3 exact_normal(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Long3 n = cross(Long3{b} - Long3{a}, Long3{c} - Long3{a});
  return n / std::sqrt(dot(n, n));
}

struct SurfaceCounts {
  int hits = 0, wrong_side = 0, rehits = 0, off_surface = 0, bad_normal = 0;
};

/// Checks one hit on a polygon whose front is that of corners a, b, c. In long double, on exact float inputs.
void check_point(const Geometry& geometry, const SurfacePoint& point, std::uint32_t primitive,
                 const Vec3 (&abc)[3], const Vec3& leaving, SurfaceCounts& counts) {
  const Long3 n = exact_normal(abc[0], abc[1], abc[2]);
  counts.hits += 1;
  counts.bad_normal +=
      !(dot(Long3{point.normal}, n) > 1 - 1e-6L) || std::fabs(length(point.normal) - 1) > 1e-6f;
  counts.off_surface +=
      std::fabs(dot(Long3{point.position} - Long3{abc[0]}, n)) > (long double)point.offset_bound;
  const Vec3 origin = point.origin_towards(leaving);
  const long double side = dot(Long3{origin} - Long3{abc[0]}, n);
  counts.wrong_side += !(dot(leaving, point.normal) >= 0 ? side > 0 : side < 0);
  const Hit next = geometry.intersect<true>(Ray{origin, leaving, 1e30f});
  counts.rehits += next.primitive == primitive;
}

/// `scale` and `shift` move the shapes; rays come from about the same place.
void check_surfaces(Shapes shapes, float scale, const Vec3& shift, int rays, std::uint64_t seed) {
  const auto moved = [&](const Vec3& p) { return p * scale + shift; };
  for (Triangle& t : shapes.triangles) t = {moved(t.a), moved(t.b), moved(t.c)};
  for (Quad& q : shapes.quads) q = {moved(q.a), moved(q.b), moved(q.c), moved(q.d)};
  std::vector<Triangle> targets = halves_of(shapes.quads);
  targets.insert(targets.end(), shapes.triangles.begin(), shapes.triangles.end());
  // One polygon at a time: others in between would end most rays.
  std::vector<std::unique_ptr<BuiltGeometry>> single;
  for (const Quad& q : shapes.quads) single.push_back(std::make_unique<BuiltGeometry>(Shapes{{q}, {}, {}}));
  for (const Triangle& t : shapes.triangles)
    single.push_back(std::make_unique<BuiltGeometry>(Shapes{{}, {t}, {}}));
  Rng rng(seed, StreamPurpose::kTest, 8);
  SurfaceCounts counts;
  for (int i = 0; i < rays; ++i) {
    const std::uint32_t index = below(rng, single.size());
    const bool quad = index < shapes.quads.size();
    const Geometry& geometry = **single[index];
    Vec3 corners[4];
    if (quad) {
      const Quad& q = shapes.quads[index];
      corners[0] = q.a, corners[1] = q.b, corners[2] = q.c, corners[3] = q.d;
    } else {
      const Triangle& t = shapes.triangles[index - shapes.quads.size()];
      corners[0] = t.a, corners[1] = t.b, corners[2] = t.c, corners[3] = t.c;
    }
    const float v = rng.next_float();
    const float w = rng.next_float() * (1.0f - v);
    const int middle = quad && (rng.next_fixed() & 1U) != 0 ? 3 : 1;
    const Vec3 target = corners[0] + ((corners[middle] - corners[0]) * v + (corners[2] - corners[0]) * w);
    Ray ray{unit_direction(rng) * (scale * 2.0f) + target, Vec3{0, 0, 1}, 1e30f};
    ray.direction = target - ray.origin;
    const Hit hit = geometry.intersect<true>(ray);
    if (!hit.found()) continue;
    const SurfacePoint point = geometry.surface_point<true>(ray, hit);
    // Half of the directions graze, down to a cosine of about 1e-5.
    Vec3 leaving = unit_direction(rng);
    if ((rng.next_fixed() & 1U) != 0) {
      const int exponent = -static_cast<int>(below(rng, 16));
      const float grazing = std::ldexp(signed_unit(rng), exponent);
      leaving = (leaving - point.normal * dot(leaving, point.normal)) + point.normal * grazing;
    }
    if (std::fabs(dot(leaving, point.normal)) < 1e-6f) continue;
    check_point(geometry, point, hit.primitive, {corners[0], corners[1], corners[2]}, leaving, counts);
  }
  CHECK(counts.wrong_side == 0);
  CHECK(counts.rehits == 0);
  CHECK(counts.off_surface == 0);
  CHECK(counts.bad_normal == 0);
  CHECK(counts.hits > rays / 2);
}

TEST_CASE(
    "pitfall 16: points lie within their bound, offset origins on their side, and rays do not meet their own "
    "polygon") {
  Shapes shapes;
  shapes.triangles = triangle_soup(100, 50);
  shapes.quads = quad_soup(60, 51);
  // Needles whose corners are collinear to within rounding have no normal to compare with.
  std::erase_if(shapes.triangles, [](const Triangle& t) {
    const Vec3 e1 = t.b - t.a, e2 = t.c - t.a;
    return length(cross(e1, e2)) < 1e-5f * length(e1) * length(e2);
  });
  std::erase_if(shapes.quads, [](const Quad& q) {
    const Vec3 e1 = q.b - q.a, e2 = q.d - q.a;
    return length(cross(e1, e2)) < 1e-5f * length(e1) * length(e2);
  });
  check_surfaces(shapes, 1.0f, Vec3{0, 0, 0}, 300000, 60);
  check_surfaces(shapes, 1e-3f, Vec3{0.7f, -0.6f, 0.5f}, 100000, 61);
  check_surfaces(shapes, 100.0f, Vec3{0, 0, 0}, 100000, 62);
}

TEST_CASE("points on spheres lie on them, and rays that leave do not meet them again from outside") {
  Rng rng(63, StreamPurpose::kTest, 9);
  int rehits = 0, wrong_side = 0, missed_far_side = 0, off_surface = 0, found = 0;
  for (int i = 0; i < 200000; ++i) {
    const Sphere sphere{point_in_cube(rng), std::ldexp(1.0f, -static_cast<int>(below(rng, 12)))};
    static const Shapes one{{}, {}, {Sphere{}}};
    Shapes shapes = one;
    shapes.spheres[0] = sphere;
    SphereBlock block{};
    for (int k = 0; k < 3; ++k) block.center[k] = broadcast(sphere.center[k]);
    block.radius = broadcast(sphere.radius);
    const float extent = 2.0f;
    Ray ray{point_in_cube(rng) * 2.0f, Vec3{0, 0, 1}, 1e30f};
    ray.direction = (sphere.center + unit_direction(rng) * (sphere.radius * 0.999f)) - ray.origin;
    SphereHits hits{};
    if ((intersect_block(block, RayFrame(ray, extent), broadcast(ray.t_max), hits) & 1U) == 0) continue;
    ++found;
    const SurfacePoint point = sphere_point(block, 0, ray, hits.t[0]);
    const auto outside = [&](const Vec3& p) {
      const Long3 f = Long3{p} - Long3{sphere.center};
      return std::sqrt(dot(f, f)) - static_cast<long double>(sphere.radius);
    };
    off_surface += std::fabs(outside(point.position)) > static_cast<long double>(point.offset_bound);
    const Vec3 leaving = unit_direction(rng);
    const bool outwards = dot(leaving, point.normal) >= 0;
    const Vec3 origin = point.origin_towards(leaving);
    wrong_side += outwards ? !(outside(origin) > 0) : !(outside(origin) < 0);
    const bool met =
        (intersect_block(block, RayFrame(Ray{origin, leaving, 1e30f}, extent), broadcast(1e30f), hits) &
         1U) != 0;
    rehits += outwards && met;
    missed_far_side += !outwards && !met;
    if (!outwards && met) {
      // The far end of the chord.
      const double chord = -2.0 * dot(DVec3{leaving}, DVec3{point.normal}) * double{sphere.radius};
      off_surface += std::fabs(chord - double{hits.t[0]}) >
                     8.0 * double{point.offset_bound} / -dot(leaving, point.normal);
    }
  }
  CHECK(rehits == 0);
  CHECK(wrong_side == 0);
  CHECK(missed_far_side == 0);
  CHECK(off_surface == 0);
  CHECK(found > 190000);
}

/// Rays from inside a closed mesh at its edges and corners; returns how many escape.
std::uint64_t count_leaks(const Geometry& geometry, const std::vector<Triangle>& mesh, std::uint64_t rays,
                          std::uint64_t stream) {
  Rng rng(70, StreamPurpose::kTest, stream);
  std::uint64_t leaks = 0;
  for (std::uint64_t i = 0; i < rays; ++i) {
    const Triangle& t = mesh[below(rng, mesh.size())];
    const Vec3 origin = point_in_cube(rng) * 0.3f;
    const Vec3 target = i % 4 == 0 ? t.a : t.a + (t.b - t.a) * rng.next_float();
    const Ray ray{origin, target - origin, 1e30f};
    leaks += !geometry.intersect<true>(ray).found() || !geometry.occluded<true>(ray);
  }
  return leaks;
}

/// As count_leaks from the surface itself: offset origins on one wall of the mesh, aimed at corners. The
/// origins keep away from edges, where a point's rounding error may put it behind the neighbouring wall.
std::uint64_t count_leaks_from_walls(const Geometry& geometry, const std::vector<Triangle>& mesh,
                                     std::uint64_t rays) {
  Rng rng(71, StreamPurpose::kTest, 0);
  std::uint64_t leaks = 0;
  for (std::uint64_t i = 0; i < rays; ++i) {
    const Triangle& t = mesh[below(rng, mesh.size())];
    const float v = 0.01f + 0.9f * rng.next_float();
    const float w = 0.01f + (0.98f - v) * rng.next_float();
    const Vec3 target = t.a + ((t.b - t.a) * v + (t.c - t.a) * w);
    const Vec3 start = point_in_cube(rng) * 0.1f;
    const Ray ray{start, target - start, 1e30f};
    const Hit hit = geometry.intersect<true>(ray);
    if (!hit.found()) {
      ++leaks;
      continue;
    }
    const SurfacePoint point = geometry.surface_point<true>(ray, hit);
    const Vec3 inwards = dot(point.normal, ray.direction) < 0 ? point.normal : -point.normal;
    const Vec3 origin = point.origin_towards(inwards);
    const Triangle& other = mesh[below(rng, mesh.size())];
    leaks += !geometry.intersect<true>(Ray{origin, other.a - origin, 1e30f}).found();
  }
  return leaks;
}

Shapes closed_box() {
  Shapes box;
  const Vec3 v[8] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                     {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
  const int faces[6][4] = {{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 5, 4},
                           {2, 3, 7, 6}, {1, 2, 6, 5}, {0, 3, 7, 4}};
  // Turned, so that edge functions round.
  const auto turned = [](const Vec3& p) {
    return Vec3{0.36f * p.x + 0.48f * p.y - 0.8f * p.z, -0.8f * p.x + 0.6f * p.y,
                0.48f * p.x + 0.64f * p.y + 0.6f * p.z};
  };
  for (const auto& f : faces)
    box.quads.push_back({turned(v[f[0]]), turned(v[f[1]]), turned(v[f[2]]), turned(v[f[3]])});
  return box;
}

TEST_CASE("pitfall 16: no ray at a shared edge or corner leaks out of a closed mesh") {
  Shapes sphere;
  sphere.triangles = tessellated_sphere(24, 48, 0.9f);
  const BuiltGeometry tree(sphere, kAlwaysTree);
  CHECK(count_leaks(*tree, sphere.triangles, 100000, 0) == 0);
  CHECK(count_leaks_from_walls(*tree, sphere.triangles, 50000) == 0);
  for (const FlatLimits& limits : {kAlwaysFlat, kAlwaysBounds, kAlwaysTree}) {
    const BuiltGeometry box(closed_box(), limits);
    CHECK(count_leaks(*box, halves_of(closed_box().quads), 100000, 1) == 0);
    CHECK(count_leaks_from_walls(*box, halves_of(closed_box().quads), 50000) == 0);
  }
}

TEST_CASE("pitfall 16: 1e8 rays at shared edges and corners do not leak", "[.slow]") {
  Shapes sphere;
  sphere.triangles = tessellated_sphere(24, 48, 0.9f);
  const BuiltGeometry tree(sphere, kAlwaysTree);
  // Streams are fixed; threads only share them out.
  constexpr unsigned kThreads = 4;
  std::uint64_t leaks[kThreads] = {};
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < kThreads; ++i) {
    threads.emplace_back([&, i] { leaks[i] = count_leaks(*tree, sphere.triangles, 25000000, 100 + i); });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(leaks[0] + leaks[1] + leaks[2] + leaks[3] == 0);
}

}  // namespace
}  // namespace mlt::test
