// Spheres against the quadratic formula in long double, and trees of spheres against flat lists.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>

#include "scene_fixture.hpp"

namespace mlt::test {
namespace {

std::vector<Sphere> sphere_soup(std::size_t count, std::uint64_t seed) {
  Rng rng(seed, StreamPurpose::kTest, 30);
  std::vector<Sphere> soup;
  while (soup.size() < count) {
    soup.push_back({point_in_cube(rng), std::ldexp(0.5f, -static_cast<int>(below(rng, 10)))});
    if (soup.size() % 10 == 0) soup.push_back(soup.back());
  }
  soup.resize(count);
  return soup;
}

/// At a sphere, or tangentially to it, or from its surface or inside, or anywhere.
Ray sphere_ray(Rng& rng, const std::vector<Sphere>& spheres) {
  const Sphere& s = spheres[below(rng, spheres.size())];
  Vec3 origin = point_in_cube(rng) * 1.5f;
  Vec3 direction = unit_direction(rng);
  const std::uint32_t kind = rng.next_fixed() % 5;
  const float depth = rng.next_float();
  if (kind == 1) origin = s.center + unit_direction(rng) * (s.radius * depth);
  if (kind == 2) origin = s.center + unit_direction(rng) * s.radius;
  if (kind == 3) direction = (s.center + unit_direction(rng) * s.radius) - origin;
  if (kind == 4) {
    const Vec3 across = cross(s.center - origin, direction);
    direction = (s.center + across * (s.radius / length(across))) - origin;
  }
  return Ray{origin, direction, 1e30f};
}

TEST_CASE("spheres: flat list and tree agree, ties give the lowest index, limits and occlusion hold") {
  Shapes shapes;
  shapes.spheres = sphere_soup(120, 1);
  const BuiltGeometry flat(shapes, kAlwaysFlat);
  const BuiltGeometry tree(shapes, kAlwaysTree);
  Rng rng(2, StreamPurpose::kTest, 31);
  int different = 0, duplicates = 0, found = 0;
  for (int i = 0; i < 150000; ++i) {
    Ray ray = sphere_ray(rng, shapes.spheres);
    const Hit hit = flat->intersect<true>(ray);
    const Hit other = tree->intersect<true>(ray);
    different += hit.primitive != other.primitive || (hit.found() && std::memcmp(&hit.t, &other.t, 4) != 0);
    different += flat->occluded<true>(ray) != hit.found() || tree->occluded<true>(ray) != hit.found();
    if (!hit.found()) continue;
    ++found;
    // Copies of the sphere before stand at 10, 20, 30...
    duplicates += (hit.primitive > 0 && hit.primitive % 10 == 0);
    ray.t_max = hit.t;
    different += tree->occluded<true>(ray) || flat->occluded<true>(ray);
    ray.t_max = std::nextafter(hit.t, 2e30f);
    different += !tree->occluded<true>(ray) || !flat->occluded<true>(ray);
  }
  CHECK(different == 0);
  CHECK(duplicates == 0);
  CHECK(found > 50000);
}

TEST_CASE("spheres agree with the quadratic formula in long double, from outside and inside") {
  using Long3 = glm::tvec3<long double>;
  Rng rng(3, StreamPurpose::kTest, 32);
  const std::vector<Sphere> spheres = sphere_soup(60, 2);
  int wrong = 0, sure = 0, inaccurate = 0;
  for (const Sphere& sphere : spheres) {
    Shapes one;
    one.spheres = {sphere};
    const BuiltGeometry geometry(one);
    for (int i = 0; i < 3000; ++i) {
      const Ray ray = sphere_ray(rng, one.spheres);
      const Long3 f = Long3{ray.origin} - Long3{sphere.center}, d{ray.direction};
      const long double r = sphere.radius, a = dot(d, d), b = dot(f, d);
      const long double nearest = std::sqrt(std::max(0.0L, dot(f, f) - b * b / a));
      // The nearest point is off by 12u|f| (sphere.hpp); the distance from the surface, by squares, by 7u
      // |f|.
      const long double slack = 16 * 0x1p-24L * (std::sqrt(dot(f, f)) + r);
      const long double off_surface = std::fabs(std::sqrt(dot(f, f)) - r);
      if (std::fabs(nearest - r) <= slack || off_surface <= slack) continue;
      ++sure;
      long double expected = -1;
      if (nearest < r) {
        const long double half = std::sqrt(b * b - a * (dot(f, f) - r * r));
        expected = (-b - half) / a > 0 ? (-b - half) / a : (-b + half) / a;
      }
      const Hit hit = geometry->intersect<true>(ray);
      wrong += hit.found() != (expected > 0);
      if (!hit.found() || !(expected > 0)) continue;
      // Slack across the ray shifts the crossing by at most slack / cosine, and the cosine at the crossing
      // is sqrt(1 - (nearest / r)^2).
      const long double cosine = std::sqrt(std::max(1e-12L, 1 - nearest * nearest / (r * r)));
      inaccurate += std::fabs(expected - static_cast<long double>(hit.t)) * std::sqrt(a) > 4 * slack / cosine;
    }
  }
  CHECK(wrong == 0);
  CHECK(inaccurate == 0);
  CHECK(sure > 100000);
}

}  // namespace
}  // namespace mlt::test
