// Groups of rays through a hierarchy so large that they take turns, each with the bits that it gets alone.
#include "geometry/turns.hpp"

#include <catch2/catch.hpp>
#include <cstdint>

#include "geometry/scene_fixture.hpp"

namespace mlt::test {
namespace {

using F = WideFloat;

/// A fine ball among large spheres, quads and triangles that cross each other.
Shapes large_mesh() {
  Shapes shapes;
  shapes.triangles = tessellated_sphere(363, 363, 0.6f);
  const std::vector<Triangle> soup = triangle_soup(500, 3);
  shapes.triangles.insert(shapes.triangles.end(), soup.begin(), soup.end());
  shapes.quads = quad_soup(40, 4);
  shapes.spheres = {Sphere{{0.5f, 0.5f, 0.5f}, 0.3f}, Sphere{{-0.7f, 0, 0}, 0.2f}};
  return shapes;
}

void check_same(const Hit& found, const Hit& expected) {
  REQUIRE(found.primitive == expected.primitive);
  if (!expected.found()) return;
  REQUIRE(as_bits(found.t) == as_bits(expected.t));
  REQUIRE(found.slot == expected.slot);
  REQUIRE(as_bits(found.weights[0]) == as_bits(expected.weights[0]));
  REQUIRE(as_bits(found.weights[1]) == as_bits(expected.weights[1]));
}

struct Countdown {
  int lane;
  int left;
};

TEST_CASE("every lane gets its turns, in places that are used again") {
  Rng rng(62, StreamPurpose::kTest, 0);
  for (int run = 0; run < 1000; ++run) {
    const std::uint32_t lanes = rng.next_fixed();
    std::uint32_t made = 0, ended = 0;
    int alive = 0, most = 0;
    take_turns<Countdown>(
        lanes,
        [&](std::byte* place, int lane) {
          REQUIRE((made >> lane & 1U) == 0);
          made |= 1U << lane;
          most = ++alive > most ? alive : most;
          return new (place) Countdown{lane, static_cast<int>(rng.next_fixed() % 10)};
        },
        [&](Countdown& way) {
          REQUIRE((ended >> way.lane & 1U) == 0);
          if (way.left-- > 0) return true;
          ended |= 1U << way.lane;
          --alive;
          return false;
        });
    REQUIRE(made == lanes);
    REQUIRE(ended == lanes);
    REQUIRE(most <= kTurns);
  }
  take_turns<Countdown>(
      0,
      [](std::byte*, int) -> Countdown* {
        FAIL();
        return nullptr;
      },
      [](Countdown&) { return false; });
}

TEST_CASE("rays that take turns meet what they meet alone, and are blocked as alone") {
  const Shapes shapes = large_mesh();
  REQUIRE(shapes.triangles.size() >= kLeastForTurns);
  const BuiltGeometry built(shapes);
  const Geometry& geometry = *built;
  Rng rng(61, StreamPurpose::kTest, 0);
  int hits = 0, misses = 0, blocked = 0, free = 0;
  for (int group = 0; group < 6000; ++group) {
    Ray alone[kWideLanes];
    RayOf<F> rays;
    SegmentEnds<F> ends;
    for (int lane = 0; lane < kWideLanes; ++lane) {
      alone[lane] = hard_ray(rng, shapes.triangles);
      if (rng.next_float() < 0.3f) alone[lane].t_max = rng.next_float();
      set_lane_of(rays.origin, lane, alone[lane].origin);
      set_lane_of(rays.direction, lane, alone[lane].direction);
      set_lane_of(rays.t_max, lane, alone[lane].t_max);
      set_lane_of(ends.target, lane, geometry.intersect<true>(alone[lane]).primitive);
    }
    // From none to all lanes, of which some have fewer rays than take turns.
    const MaskOf<F> active = mask_of<F>(rng.next_fixed() & rng.next_fixed() & ((1U << kWideLanes) - 1)) |
                             mask_of<F>(group % 3 == 0 ? (1U << kWideLanes) - 1 : 0);
    const HitOf<F> found = geometry.intersect_lanes<true, F>(rays, ends.leaves, active);
    const MaskOf<F> is_blocked = geometry.occluded_lanes<true, F>(rays, ends, active);
    for_lanes(active, [&](int lane) {
      const Hit expected = geometry.intersect<true>(alone[lane]);
      check_same(lane_of(found, lane), expected);
      const bool expected_block = geometry.occluded<true>(alone[lane], lane_of(ends.target, lane));
      REQUIRE((lane_of(is_blocked, lane) != 0) == expected_block);
      (expected.found() ? hits : misses) += 1;
      (expected_block ? blocked : free) += 1;
    });
  }
  CHECK(hits > 1000);
  CHECK(misses > 1000);
  CHECK(blocked > 1000);
  CHECK(free > 1000);
}

}  // namespace
}  // namespace mlt::test
