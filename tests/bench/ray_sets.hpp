// The scenes and rays of ray_bench.cpp.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "geometry/scene_fixture.hpp"
#include "math/wide.hpp"

namespace mlt::test {

inline Quad quad(const Vec3& a, const Vec3& u, const Vec3& v) {
  return {a, a + u, (a + u) + v, a + v};
}

inline void add_block(std::vector<Quad>& quads, const Vec3& corner, const Vec3& x, const Vec3& z,
                      float height) {
  const Vec3 y{0, height, 0};
  quads.push_back(quad(corner + y, x, z));
  quads.push_back(quad(corner, x, z));
  for (const Vec3& from : {corner, corner + z}) quads.push_back(quad(from, x, y));
  for (const Vec3& from : {corner, corner + x}) quads.push_back(quad(from, z, y));
}

/// Five walls, a light below the ceiling and two turned blocks; the open side is at z = 1.
inline std::vector<Quad> cornell_quads() {
  const Vec3 x{2, 0, 0}, y{0, 2, 0}, z{0, 0, 2};
  std::vector<Quad> quads{
      quad({-1, -1, -1}, x, z), quad({-1, 1, -1}, x, z),
      quad({-1, -1, -1}, x, y), quad({-1, -1, -1}, y, z),
      quad({1, -1, -1}, y, z),  quad({-0.25f, 0.99f, -0.25f}, {0.5f, 0, 0}, {0, 0, 0.5f})};
  add_block(quads, {-0.7f, -1, -0.4f}, {0.57f, 0, -0.17f}, {0.17f, 0, 0.57f}, 1.2f);
  add_block(quads, {0.1f, -1, 0.1f}, {0.57f, 0, 0.17f}, {-0.17f, 0, 0.57f}, 0.6f);
  return quads;
}

/// The walls of the box around a ball of about 2 * rings * segments triangles with bumps of the given height.
inline Shapes ball_in_box(int rings, int segments, float bumps) {
  Shapes shapes;
  shapes.quads = cornell_quads();
  shapes.quads.resize(6);
  shapes.triangles = tessellated_sphere(rings, segments, 0.7f);
  const auto displaced = [&](const Vec3& p) {
    const float wave = std::sin(17.0f * p.x) * std::sin(19.0f * p.y) * std::sin(23.0f * p.z);
    return p * (1.0f + bumps * wave);
  };
  for (Triangle& t : shapes.triangles) t = {displaced(t.a), displaced(t.b), displaced(t.c)};
  return shapes;
}

/// Rays that are traced together.
struct RayGroup {
  RayOf<WideFloat> ray;
  UintOf<WideFloat> leaves = broadcast_bits<UintOf<WideFloat>>(kNoPrimitive);  ///< what each ray starts from
  MaskOf<WideFloat> active{};
};

/// Rays of one kind, each on its own and in groups.
struct RaySet {
  std::vector<Ray> rays;
  std::vector<RayGroup> groups;

  void add(const Ray& ray, std::uint32_t leaves) {
    const int lane = static_cast<int>(rays.size() % kWideLanes);
    if (lane == 0) groups.emplace_back();
    rays.push_back(ray);
    set_lane_of(groups.back().ray.origin, lane, ray.origin);
    set_lane_of(groups.back().ray.direction, lane, ray.direction);
    set_lane_of(groups.back().ray.t_max, lane, ray.t_max);
    set_lane_of(groups.back().leaves, lane, leaves);
    set_lane_of(groups.back().active, lane, kLaneTrue<WideFloat>);
  }
};

struct RaySets {
  RaySet primary, bounce, shadow;
};

/// Rays as a path tracer makes them: a pinhole image in pixel order, then from each point hit a
/// cosine-distributed direction and a segment to the light.
template <bool kGeneral>
RaySets make_rays(const Geometry& geometry, int side) {
  RaySets rays;
  Rng rng(1, StreamPurpose::kTest, 40);
  for (int i = 0; i < side * side; ++i) {
    const float x = (static_cast<float>(i % side) + rng.next_float()) / static_cast<float>(side) - 0.5f;
    const float y = (static_cast<float>(i / side) + rng.next_float()) / static_cast<float>(side) - 0.5f;
    Ray ray{Vec3{0, 0, 3.2f}, normalize(Vec3{x * 0.85f, y * 0.85f, -1}), 1e30f};
    rays.primary.add(ray, kNoPrimitive);
    // Bounces start anywhere along a path, not only at what the camera sees.
    for (int depth = 0; depth < 2; ++depth) {
      const Hit hit = geometry.intersect<kGeneral>(ray);
      if (!hit.found()) break;
      const SurfacePoint point = geometry.surface_point<kGeneral>(ray, hit);
      const Vec3 normal = dot(point.normal, ray.direction) < 0 ? point.normal : -point.normal;
      const Vec3 light = Vec3{-0.25f + 0.5f * rng.next_float(), 0.985f, -0.25f + 0.5f * rng.next_float()};
      const Vec3 origin = point.origin_towards(normal);
      rays.shadow.add({origin, light - origin, 1.0f}, hit.primitive);
      ray = {origin, normalize(normal + unit_direction(rng) * 0.9999f), 1e30f};
      rays.bounce.add(ray, hit.primitive);
    }
  }
  return rays;
}

}  // namespace mlt::test
