// Paths in lanes against the same paths one by one: the same bits, whatever the lanes beside them do.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <vector>

#include "integrator/path.hpp"
#include "integrator/path_batch.hpp"
#include "integrator/pixel_sampler.hpp"
#include "integrator/sampler.hpp"
#include "support/compiled_scene.hpp"
#include "support/pixel_samples.hpp"

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

/// Calls visit() for each block of `count` samples of each of a row's pixels, in two sequences of some of
/// them and not from the first sample on in others; the sampler holds the block. All samples, in order.
template <class Sampler, class Visit>
std::vector<PixelSample> fill_blocks(Sampler& sampler, std::uint32_t count, Visit&& visit) {
  std::vector<PixelSample> samples;
  for (std::uint32_t x = 0; x < kSide; ++x) {
    for (std::uint64_t sequence = 2; sequence < (x % 4 == 0 ? 4 : 3); ++sequence) {
      PixelSample next{x, 9, sequence, 0};
      if (x % 3 == 2) next.index = count / 2;
      while (next.index < count) {
        const std::uint32_t placed = sampler.place(next, count - next.index);
        for (std::uint32_t i = 0; i < placed; ++i, ++next.index) samples.push_back(next);
        if (sampler.count() < sampler.kBlock) continue;
        visit();
        sampler.clear();
      }
    }
  }
  if (sampler.count() > 0) visit();
  return samples;
}

constexpr std::uint32_t kCounts[] = {1, 2, 3, 5, 8, 16, 24, 40, 63, 64, 65, 150};

bool same(const PixelSample& a, const PixelSample& b) {
  return a.x == b.x && a.y == b.y && a.sequence == b.sequence && a.index == b.index;
}

TEST_CASE("a sample in a block of several pixels is the sample that it would be alone") {
  using F = WideFloat;
  using Sampler = PixelSamplerOf<F>;
  for (const std::uint32_t count : kCounts) {
    INFO(count << " samples a pixel");
    PixelSampler one(7, kSide, kSide, count);
    Sampler many(7, kSide, kSide, count);
    std::vector<PixelSample> visited;
    const std::vector<PixelSample> samples = fill_blocks(many, count, [&] {
      std::vector<PixelSample> block;
      many.for_samples([&](std::uint32_t slot, const PixelSample& sample) {
        REQUIRE(slot == block.size());
        block.push_back(sample);
      });
      REQUIRE(block.size() == many.count());
      // Groups take turns, and dimensions come to places that others had.
      Sampler::Position positions[Sampler::kBlock / kWideLanes];
      for (std::uint32_t edge = 0; edge < 40; ++edge) {
        for (std::uint32_t first = 0; first < block.size(); first += kWideLanes) {
          typename Sampler::Position& position = positions[first / kWideLanes];
          if (edge == 0) {
            many.start(first);
          } else {
            many.resume(position);
          }
          const UintOf<F> single = many.next_fixed();
          const UintOf<F> other = many.next_fixed();
          const Vec2Of<F> pair = many.next_2d();
          many.skip(3);
          position = many.position();
          for (std::uint32_t slot = first; slot < std::min<std::size_t>(first + kWideLanes, block.size());
               ++slot) {
            const auto lane = static_cast<int>(slot - first);
            start_sample(one, block[slot].x, block[slot].y, block[slot].index, block[slot].sequence);
            one.skip(7 * edge);
            REQUIRE(one.next_fixed() == lane_of(single, lane));
            REQUIRE(one.next_fixed() == lane_of(other, lane));
            const Vec2 own = one.next_2d();
            REQUIRE(own.x == lane_of(pair.x, lane));
            REQUIRE(own.y == lane_of(pair.y, lane));
          }
        }
      }
      visited.insert(visited.end(), block.begin(), block.end());
    });
    CHECK(std::equal(visited.begin(), visited.end(), samples.begin(), samples.end(), same));
  }
}

/// All samples of some pixels, in batches whose paths end at different edges.
template <FeatureMask kFeatures>
void check_batches(const World& world, const PathSettings& settings, std::uint32_t count) {
  using F = WideFloat;
  using Integrator = PathIntegrator<kFeatures, F>;
  const PathIntegrator<kFeatures> reference(world, settings);
  const Integrator integrator(world, settings);
  PathBatch<Integrator> batch(integrator);
  PixelSampler one(7, kSide, kSide, count);
  PixelSamplerOf<F> many(7, kSide, kSide, count);
  std::uint32_t shortest = ~0U, longest = 0;
  std::vector<PixelSample> visited;
  const std::vector<PixelSample> samples = fill_blocks(many, count, [&] {
    batch.evaluate(many, [&](const PixelSample& sample, const Splat& splat, std::uint32_t dimension) {
      visited.push_back(sample);
      start_sample(one, sample.x, sample.y, sample.index, sample.sequence);
      reference.evaluate(one, [&](const Splat& expected, bool) {
        REQUIRE(splat.pixel == expected.pixel);
        REQUIRE(same_bits(splat.value, expected.value));
      });
      REQUIRE(dimension == one.dimension());
      shortest = std::min(shortest, dimension);
      longest = std::max(longest, dimension);
    });
  });
  CHECK(std::equal(visited.begin(), visited.end(), samples.begin(), samples.end(), same));
  if (samples.size() > 100) CHECK(shortest + 8 < longest);
}

TEST_CASE("a path of a batch is the path that it would be alone") {
  const CompiledScene room(kRoom, kSide, kSide);
  const CompiledScene plain(kPlainRoom, kSide, kSide);
  const CompiledScene open(kOpenCorner, kSide, kSide);
  constexpr FeatureMask kAll = kFeatureMaskCount - 1;
  for (const std::uint32_t count : kCounts) {
    INFO(count << " samples a pixel");
    check_batches<kAll>(room.world(), {12, 2}, count);
    check_batches<feature(FeatureBit::roulette)>(plain.world(), {40, 2}, count);
    check_batches<0>(open.world(), {8, 0}, count);
  }
}

}  // namespace
}  // namespace mlt::test
