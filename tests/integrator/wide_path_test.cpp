// Paths in lanes against the same paths one by one: the same bits, whatever the lanes beside them do.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>

#include "integrator/path.hpp"
#include "integrator/path_batch.hpp"
#include "integrator/pixel_sampler.hpp"
#include "integrator/sampler.hpp"
#include "support/compiled_scene.hpp"

namespace mlt::test {
namespace {

// Every material kind, shape of light and shape of surface.
constexpr const char* kRoom = R"(
camera eye 0 0 3.5 target 0 0 0 fov 60
material grey diffuse reflectance 0.6 0.5 0.4
material silver mirror reflectance 0.9
material glass dielectric ior 1.5
material air dielectric ior 1
material gold conductor preset gold roughness 0.3
material brass conductor preset copper roughness 0
box -2 -2 -2  2 2 4  inward  material grey
quad -0.5 1.9 -0.5  0.5 1.9 -0.5  0.5 1.9 0.5  -0.5 1.9 0.5  material grey emit 6 5 4
triangle -1.9 -0.5 0  -1.9 0 1  -1.9 0.5 0  material grey emit 1 2 3
sphere 1.2 1.2 -1 0.3  material grey emit 2 2 2
sphere -0.8 -1.2 0 0.7  material glass
sphere 0.9 -1.2 0.3 0.6  material gold
sphere 0 0.5 -0.5 0.3  material brass
sphere 0.3 -0.4 1.5 0.2  material air
quad -1 -1 -1.9  1 -1 -1.9  1 1 -1.9  -1 1 -1.9  material silver
)";

// Quads of diffuse surfaces under one lamp, with edges that meet and faces that coincide.
constexpr const char* kPlainRoom = R"(
camera eye 0.1 0.2 3.5 target 0 0 0 fov 60
material grey diffuse reflectance 0.6 0.5 0.4
material red diffuse reflectance 0.9 0.1 0
box -2 -2 -2  2 2 4  inward  material grey
box -1 -2 -1  0 -0.5 0  material red
box 0 -2 -1  1 -1 0  material grey
quad -0.5 1.999 -0.5  0.5 1.999 -0.5  0.5 1.999 0.5  -0.5 1.999 0.5  material grey emit 6 5 4
quad -0.5 1.999 -0.5  0.5 1.999 -0.5  0.5 1.999 0.5  -0.5 1.999 0.5  material red
)";

// Paths leave it after any edge.
constexpr const char* kOpenCorner = R"(
camera eye 0.1 0.2 3.5 target 0 0 0 fov 60
material grey diffuse reflectance 0.9
quad -2 -2 -2  2 -2 -2  2 -2 2  -2 -2 2  material grey
quad -2 -2 -2  2 -2 -2  2 2 -2  -2 2 -2  material grey
quad -0.5 1.9 -0.5  0.5 1.9 -0.5  0.5 1.9 0.5  -0.5 1.9 0.5  material grey emit 6 5 4
)";

constexpr std::uint32_t kSide = 16;

bool same_bits(const Vec3& a, const Vec3& b) {
  return as_bits(a.x) == as_bits(b.x) && as_bits(a.y) == as_bits(b.y) && as_bits(a.z) == as_bits(b.z);
}

Rng stream(std::uint64_t index) {
  return Rng(31, StreamPurpose::kTest, index);
}

template <FeatureMask kFeatures>
Vec3 alone(const World& world, const PathSettings& settings, std::uint64_t index, std::uint32_t& pixel) {
  const PathIntegrator<kFeatures> integrator(world, settings);
  IndependentSampler sampler(stream(index));
  Vec3 value{-1, -1, -1};
  integrator.evaluate(sampler, [&](const Splat& splat, bool) {
    value = splat.value;
    pixel = splat.pixel;
  });
  return value;
}

/// Paths with random lanes switched off; the others must not notice.
template <FeatureMask kFeatures>
void check_lanes(const World& world, const PathSettings& settings, std::uint64_t paths) {
  using F = WideFloat;
  const PathIntegrator<kFeatures, F> integrator(world, settings);
  Rng choices(32, StreamPurpose::kTest, 0);
  std::uint64_t carried_light = 0;
  for (std::uint64_t first = 0; first < paths; first += kWideLanes) {
    MaskOf<F> active{};
    RngOf<F> streams;
    for (int lane = 0; lane < kWideLanes; ++lane) {
      if (choices.next_float() < 0.8f) set_lane_of(active, lane, kLaneTrue<F>);
      streams.set_lane(lane, stream(first + static_cast<std::uint64_t>(lane)));
    }
    IndependentSamplerOf<F> sampler(streams);
    SplatOf<F> splats;
    integrator.evaluate(
        sampler, [&](const SplatOf<F>& splat, MaskOf<F>) { splats = splat; }, active);
    for_lanes(active, [&](int lane) {
      std::uint32_t pixel = 0;
      const Vec3 value = alone<kFeatures>(world, settings, first + static_cast<std::uint64_t>(lane), pixel);
      REQUIRE(lane_of(splats.pixel, lane) == pixel);
      REQUIRE(same_bits(lane_of(splats.value, lane), value));
      carried_light += is_zero(value) ? 0 : 1;
    });
  }
  CHECK(carried_light > paths / 10);
}

TEST_CASE("a path in a lane is the path that it would be alone, in all kernels") {
  const CompiledScene room(kRoom, kSide, kSide);
  const CompiledScene plain(kPlainRoom, kSide, kSide);
  constexpr FeatureMask kAll = kFeatureMaskCount - 1;
  check_lanes<kAll>(room.world(), {12, 3}, 20000);
  check_lanes<kAll & ~feature(FeatureBit::roulette)>(room.world(), {6, 1}, 20000);
  check_lanes<kAll>(plain.world(), {6, 2}, 20000);
  check_lanes<0>(plain.world(), {6, 1}, 60000);
  check_lanes<feature(FeatureBit::roulette)>(plain.world(), {20, 2}, 20000);
}

TEST_CASE("a sample in a lane is the sample that it would be alone") {
  using F = WideFloat;
  for (const std::uint64_t count : {1U, 5U, 64U, 1000U}) {
    PixelSampler one(7, kSide, kSide, count);
    PixelSamplerOf<F> many(7, kSide, kSide, count);
    for (std::uint32_t first = 0; first < count; first += kWideLanes) {
      many.start(3, 5, first, 2);
      const UintOf<F> x = many.next_fixed();
      const UintOf<F> y = many.next_fixed();
      const Vec2Of<F> pair = many.next_2d();
      many.skip(3);
      const F single = many.next();
      for (std::uint32_t lane = 0; lane < kWideLanes && first + lane < count; ++lane) {
        const auto at = static_cast<int>(lane);
        one.start(3, 5, first + lane, 2);
        REQUIRE(one.next_fixed() == lane_of(x, at));
        REQUIRE(one.next_fixed() == lane_of(y, at));
        const Vec2 own = one.next_2d();
        REQUIRE(own.x == lane_of(pair.x, at));
        REQUIRE(own.y == lane_of(pair.y, at));
        one.skip(3);
        REQUIRE(one.next() == lane_of(single, at));
      }
    }
  }
}

/// All samples of some pixels, in batches whose paths end at different edges.
template <FeatureMask kFeatures>
void check_batches(const World& world, const PathSettings& settings, std::uint64_t count) {
  using F = WideFloat;
  using Integrator = PathIntegrator<kFeatures, F>;
  const PathIntegrator<kFeatures> reference(world, settings);
  const Integrator integrator(world, settings);
  PathBatch<Integrator> batch(integrator);
  PixelSampler one(7, kSide, kSide, count);
  PixelSamplerOf<F> many(7, kSide, kSide, count);
  std::uint32_t shortest = ~0U, longest = 0;
  for (std::uint32_t x = 0; x < kSide; ++x) {
    for (std::uint32_t first = 0; first < count; first += batch.kCapacity) {
      std::uint32_t visited = 0;
      const auto in_batch = static_cast<std::uint32_t>(
          std::min<std::uint64_t>(count - first, PathBatch<Integrator>::kCapacity));
      batch.evaluate(many, x, 9, first, in_batch, 3,
                     [&](std::uint32_t i, const Splat& splat, std::uint32_t dimension) {
                       REQUIRE(i == visited++);
                       one.start(x, 9, first + i, 3);
                       reference.evaluate(one, [&](const Splat& expected, bool) {
                         REQUIRE(splat.pixel == expected.pixel);
                         REQUIRE(same_bits(splat.value, expected.value));
                       });
                       REQUIRE(dimension == one.dimension());
                       shortest = std::min(shortest, dimension);
                       longest = std::max(longest, dimension);
                     });
      REQUIRE(visited == in_batch);
    }
  }
  CHECK(shortest + 8 < longest);
}

TEST_CASE("a path of a batch is the path that it would be alone") {
  const CompiledScene room(kRoom, kSide, kSide);
  const CompiledScene plain(kPlainRoom, kSide, kSide);
  const CompiledScene open(kOpenCorner, kSide, kSide);
  constexpr FeatureMask kAll = kFeatureMaskCount - 1;
  for (const std::uint64_t count : {1U, 5U, 40U, 64U, 150U}) {
    INFO(count << " samples a pixel");
    check_batches<kAll>(room.world(), {12, 2}, count);
    check_batches<feature(FeatureBit::roulette)>(plain.world(), {40, 2}, count);
    check_batches<0>(open.world(), {8, 0}, count);
  }
}

}  // namespace
}  // namespace mlt::test
