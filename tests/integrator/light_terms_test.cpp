// Terms that wait for their shadow segments against terms that are added at once: the same bits.
#include "integrator/light_terms.hpp"

#include <catch2/catch.hpp>
#include <cstdint>

#include "math/rng.hpp"
#include "support/compiled_scene.hpp"

namespace mlt::test {
namespace {

using F = WideFloat;
using V = Vec3Of<F>;

constexpr const char* kRoom = R"(
camera eye 0 0 3.5 target 0 0 0 fov 60
material grey diffuse reflectance 0.6
box -2 -2 -2  2 2 4  inward  material grey
box -1 -2 -1  0 -0.5 0  material grey
quad -0.5 1.9 -0.5  0.5 1.9 -0.5  0.5 1.9 0.5  -0.5 1.9 0.5  material grey emit 6 5 4
)";

struct Step {
  std::uint32_t sum;
  bool free_only;
  V light{F{}, F{}, F{}};
  RayOf<F> segment;
  MaskOf<F> lanes;
};

Step random_step(Rng& rng, std::uint32_t sums) {
  Step step;
  step.sum = rng.next_fixed() % sums;
  step.free_only = rng.next_float() < 0.7f;
  step.segment.t_max = broadcast_to<F>(1);
  step.lanes = mask_of<F>(rng.next_fixed() % (1U << kWideLanes));
  if (rng.next_float() < 0.1f) step.lanes = not_in(MaskOf<F>{});
  for (int lane = 0; lane < kWideLanes; ++lane) {
    const auto vector = [&](float scale) {
      return Vec3{rng.next_float() - 0.5f, rng.next_float() - 0.5f, rng.next_float() - 0.5f} * scale;
    };
    set_lane_of(step.segment.origin, lane, vector(1.0f));
    set_lane_of(step.segment.direction, lane, vector(1.0f));
    set_lane_of(step.light, lane, Vec3{rng.next_float(), rng.next_float(), rng.next_float()});
  }
  return step;
}

template <class Terms>
void take(Terms& terms, V& sum, const Step& step) {
  terms.begin_edge();
  if (step.free_only) {
    terms.add_if_free(sum, step.light, step.segment, {}, step.lanes);
  } else {
    terms.add(sum, step.light, step.lanes);
  }
}

bool same_bits(const V& a, const V& b) {
  return all(as_bits(a.x) == as_bits(b.x)) && all(as_bits(a.y) == as_bits(b.y)) &&
         all(as_bits(a.z) == as_bits(b.z));
}

TEST_CASE(
    "terms that wait for their segments are added in the order and with the bits of terms that do not") {
  const CompiledScene scene(kRoom, 8, 8);
  const Geometry& geometry = scene.world().geometry;
  constexpr std::uint32_t kSums = 3;
  Rng rng(41, StreamPurpose::kTest, 0);
  std::uint32_t blocked = 0, free = 0;
  for (int run = 0; run < 500; ++run) {
    LightTerms<false, F, true> waiting(geometry);
    LightTerms<false, F, false> at_once(geometry);
    V late[kSums]{{F{}, F{}, F{}}, {F{}, F{}, F{}}, {F{}, F{}, F{}}};
    V early[kSums]{{F{}, F{}, F{}}, {F{}, F{}, F{}}, {F{}, F{}, F{}}};
    // More than are kept, and none, between two looks.
    for (int looks = 0; looks < 3; ++looks) {
      const std::uint32_t steps = rng.next_fixed() % 50;
      for (std::uint32_t i = 0; i < steps; ++i) {
        const Step step = random_step(rng, kSums);
        take(waiting, late[step.sum], step);
        take(at_once, early[step.sum], step);
        for_lanes(step.lanes, [&](int lane) {
          (geometry.occluded<false>(lane_of(step.segment, lane), kNoPrimitive) ? blocked : free) += 1;
        });
      }
      waiting.finish();
      for (std::uint32_t i = 0; i < kSums; ++i) REQUIRE(same_bits(late[i], early[i]));
    }
  }
  CHECK(blocked > 5000);
  CHECK(free > 5000);
}

}  // namespace
}  // namespace mlt::test
