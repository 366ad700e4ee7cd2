// The box that decides which last edges are traced: it must never pass over a light, and should pass over
// most of what is none.
#include "world/light_box.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "geometry/shapes.hpp"
#include "light/light.hpp"
#include "math/rng.hpp"

using namespace mlt;

namespace {

constexpr Vec3 kWhite{1, 1, 1};

float signed_unit(Rng& rng) {
  return 2.0f * rng.next_float() - 1.0f;
}
Vec3 random_point(Rng& rng) {
  const float x = signed_unit(rng), y = signed_unit(rng);
  return {x, y, signed_unit(rng)};
}
/// Now and then at the very end.
float along_edge(Rng& rng) {
  const float u = rng.next_float();
  return u < 0.1f ? 0.0f : u > 0.9f ? 1.0f : u;
}

/// A light of the given shape, and a point on it.
Light random_light(Rng& rng, LightShape shape, Vec3& point) {
  const Vec3 origin = random_point(rng), u = random_point(rng) * 0.3f, v = random_point(rng) * 0.3f;
  const float s = along_edge(rng), t = along_edge(rng);
  if (shape == LightShape::kQuad) {
    point = origin + u * s + v * t;
    return make_quad_light({origin, origin + u, origin + u + v, origin + v}, kWhite);
  }
  if (shape == LightShape::kTriangle) {
    point = origin + u * (s * t) + v * (s * (1.0f - t));
    return make_triangle_light({origin, origin + u, origin + v}, kWhite);
  }
  const float radius = 0.3f * s + 1e-3f;
  point = origin + normalize(u) * radius;
  return make_sphere_light({origin, radius}, kWhite);
}

}  // namespace

TEST_CASE("no ray towards a light passes its box, whatever the shape") {
  Rng rng(1, StreamPurpose::kTest, 0);
  for (int i = 0; i < 300000; ++i) {
    std::vector<Light> lights;
    Vec3 point;
    for (int k = 0; k <= i % 3; ++k) {
      lights.push_back(random_light(rng, static_cast<LightShape>((i / 3 + k) % 3), point));
    }
    const LightBox box = box_around(lights);
    Vec3 origin = random_point(rng);
    // Along axes, within the plane of a side, and from the surface itself, too.
    if (i % 4 == 0) origin.x = point.x;
    if (i % 8 == 0) origin.y = point.y;
    if (i % 16 == 15) origin = point + random_point(rng) * 1e-6f;
    const Vec3 to_light = point - origin;
    if (!(dot(to_light, to_light) > 0.0f)) continue;
    REQUIRE(box.may_be_met_by<float>(Ray{origin, normalize(to_light), 1e30f}));
  }
}

TEST_CASE("rays that leave a lamp behind or pass it by are told so") {
  const std::vector<Light> lamp = {make_quad_light(
      {{-0.2f, 0.9f, -0.2f}, {0.2f, 0.9f, -0.2f}, {0.2f, 0.9f, 0.2f}, {-0.2f, 0.9f, 0.2f}}, kWhite)};
  const LightBox box = box_around(lamp);
  Rng rng(2, StreamPurpose::kTest, 0);
  for (int i = 0; i < 100000; ++i) {
    const Vec3 origin{signed_unit(rng), -0.9f + rng.next_float(), signed_unit(rng)};
    const Vec3 target{signed_unit(rng), 0.9f, signed_unit(rng)};
    const Ray towards{origin, normalize(target - origin), 1e30f};
    const Ray away{origin, -towards.direction, 1e30f};
    // A hundredth of the world's size is far more than the padding.
    const float margin = std::fmax(std::fabs(target.x), std::fabs(target.z)) - 0.2f;
    if (margin < 0.0f) REQUIRE(box.may_be_met_by<float>(towards));
    if (margin > 0.01f) REQUIRE_FALSE(box.may_be_met_by<float>(towards));
    REQUIRE_FALSE(box.may_be_met_by<float>(away));
  }
}

TEST_CASE("a world without lights is met by no ray's last edge") {
  const LightBox box = box_around({});
  Rng rng(3, StreamPurpose::kTest, 0);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 direction = i < 3 ? Vec3{i == 0 ? 1.0f : 0.0f, i == 1 ? 1.0f : 0.0f, i == 2 ? 1.0f : 0.0f}
                                 : normalize(random_point(rng));
    CHECK_FALSE(box.may_be_met_by<float>(Ray{random_point(rng), direction, 1e30f}));
  }
}

TEST_CASE("lanes of rays are told what one ray is told") {
  using F = WideFloat;
  Rng rng(4, StreamPurpose::kTest, 0);
  Vec3 point;
  const std::vector<Light> lights = {random_light(rng, LightShape::kSphere, point)};
  const LightBox box = box_around(lights);
  int met = 0;
  for (int i = 0; i < 20000; ++i) {
    RayOf<F> rays;
    for (int lane = 0; lane < kLaneCount<F>; ++lane) {
      set_lane_of(rays.origin, lane, random_point(rng));
      set_lane_of(rays.direction, lane, normalize(random_point(rng)));
    }
    const MaskOf<F> told = box.may_be_met_by<F>(rays);
    for (int lane = 0; lane < kLaneCount<F>; ++lane) {
      const bool alone = box.may_be_met_by<float>(lane_of(rays, lane));
      REQUIRE(((lanes_of(told) >> lane & 1U) != 0) == alone);
      met += alone ? 1 : 0;
    }
  }
  CHECK(met > 100);
}
