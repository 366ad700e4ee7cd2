// The path integrator as a function of primary samples: what it draws, what its kernels have in common, what
// depth means. Pictures against closed forms are tests of stage render.
#include "integrator/path.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "integrator/sampler.hpp"
#include "support/compiled_scene.hpp"
#include "support/statistics.hpp"

namespace mlt::test {
namespace {

// A closed room of every material kind, with two lamps.
constexpr const char* kRoom = R"(
camera eye 0 0 3.5 target 0 0 0 fov 60
material grey diffuse reflectance 0.6 0.5 0.4
material silver mirror reflectance 0.9
material glass dielectric ior 1.5
material gold conductor preset gold roughness 0.3
box -2 -2 -2  2 2 4  inward  material grey
quad -0.5 1.9 -0.5  0.5 1.9 -0.5  0.5 1.9 0.5  -0.5 1.9 0.5  material grey emit 6 5 4
triangle -1.9 -0.5 0  -1.9 0 1  -1.9 0.5 0  material grey emit 1 2 3
sphere -0.8 -1.2 0 0.7  material glass
sphere 0.9 -1.2 0.3 0.6  material gold
quad -1 -1 -1.9  1 -1 -1.9  1 1 -1.9  -1 1 -1.9  material silver
)";

// Quads, one lamp, diffuse surfaces: no feature at all.
constexpr const char* kPlainRoom = R"(
camera eye 0 0 3.5 target 0 0 0 fov 60
material grey diffuse reflectance 0.6 0.5 0.4
box -2 -2 -2  2 2 4  inward  material grey
quad -0.5 1.9 -0.5  0.5 1.9 -0.5  0.5 1.9 0.5  -0.5 1.9 0.5  material grey emit 6 5 4
)";

constexpr std::uint32_t kSide = 16;
constexpr FeatureMask kAllFeatures = kFeatureMaskCount - 1;
constexpr FeatureMask kNoRoulette = kAllFeatures & ~feature(FeatureBit::roulette);

Rng stream(std::uint64_t index) {
  return Rng(11, StreamPurpose::kTest, index);
}

/// Counts the positions that a path passes, drawn or skipped, and what it drew.
class CountingSampler : public FloatSamples<CountingSampler, float> {
 public:
  explicit CountingSampler(Rng rng) : rng_(rng) {}
  std::uint32_t next_fixed(bool = true) {
    position_ += 1;
    drawn_ += 1;
    return rng_.next_fixed();
  }
  void skip(std::uint32_t count, bool = true) { position_ += count; }
  std::uint32_t position() const { return position_; }
  std::uint32_t drawn() const { return drawn_; }

 private:
  Rng rng_;
  std::uint32_t position_ = 0;
  std::uint32_t drawn_ = 0;
};

/// Replays a fixed list of primary samples; skip() passes over them as a chain's vector does.
class ListSampler : public FloatSamples<ListSampler, float> {
 public:
  explicit ListSampler(std::uint64_t index) {
    Rng rng = stream(index);
    for (std::uint32_t& value : values_) value = rng.next_fixed();
  }
  std::uint32_t next_fixed(bool = true) { return values_[position_++]; }
  void skip(std::uint32_t count, bool = true) { position_ += count; }

 private:
  std::uint32_t values_[256] = {};
  std::uint32_t position_ = 0;
};

template <FeatureMask kFeatures, class Sampler>
Vec3 radiance(const World& world, const PathSettings& settings, Sampler& sampler) {
  const PathIntegrator<kFeatures> integrator(world, settings);
  Vec3 value{-1, -1, -1};
  int splats = 0;
  integrator.evaluate(sampler, [&](const Splat& splat, bool) {
    value = splat.value;
    splats += 1;
    CHECK(splat.pixel < kSide * kSide);
  });
  CHECK(splats == 1);
  return value;
}

template <FeatureMask kFeatures>
Vec3 radiance(const World& world, const PathSettings& settings, std::uint64_t index) {
  ListSampler sampler(index);
  return radiance<kFeatures>(world, settings, sampler);
}

template <FeatureMask kFeatures>
Moments luminance_moments(const World& world, const PathSettings& settings, std::uint64_t first,
                          std::size_t paths) {
  const PathIntegrator<kFeatures> integrator(world, settings);
  std::vector<double> values;
  values.reserve(paths);
  for (std::size_t i = 0; i < paths; ++i) {
    IndependentSampler sampler(stream(first + i));
    integrator.evaluate(sampler, [&](const Splat& splat, bool) { values.push_back(luminance(splat.value)); });
  }
  return moments(values);
}

}  // namespace

TEST_CASE("the power heuristic shares out exactly one, from equal densities to the ends of float") {
  CHECK(power_heuristic(3.0f, 3.0f) == 0.5f);
  CHECK(power_heuristic(1.0f, 0.0f) == 1.0f);
  CHECK(power_heuristic(2.0f, 1.0f) == Approx(0.8).epsilon(1e-6));
  // Squares of these densities over- or underflow; their ratios do not, or rightly give 0 and 1.
  for (const float a : {1e-30f, 1e-3f, 1.0f, 1e20f, 1e30f}) {
    for (const float b : {1e-30f, 1e-3f, 1.0f, 1e20f, 1e30f}) {
      const float sum = power_heuristic(a, b) + power_heuristic(b, a);
      CHECK(std::fabs(sum - 1.0f) <= 0x1p-22f);  // two quotients, each off by at most 2 units
    }
  }
}

TEST_CASE("a path draws no more primary samples than its capacity, and a closed room reaches it") {
  const CompiledScene room(kRoom, kSide, kSide);
  for (const std::uint32_t depth : {1U, 2U, 5U, 9U}) {
    std::uint32_t most = 0;
    for (std::uint64_t i = 0; i < 2000; ++i) {
      CountingSampler sampler(stream(i));
      radiance<kNoRoulette>(room.world(), {depth, 0}, sampler);
      most = sampler.position() > most ? sampler.position() : most;
      REQUIRE(sampler.drawn() <= sampler.position());
    }
    CHECK(most == PathIntegrator<kNoRoulette>::primary_sample_capacity(depth));
    CHECK(PathIntegrator<kAllFeatures>::primary_sample_capacity(depth) ==
          PathIntegrator<kNoRoulette>::primary_sample_capacity(depth) + depth - 1);
  }
  // Absent features take no primary sample: two for the film, two for the light, two for the direction.
  CHECK(PathIntegrator<0>::primary_sample_capacity(1) == 2);
  CHECK(PathIntegrator<0>::primary_sample_capacity(5) == 2 + 4 * 4);
}

TEST_CASE("kernels for features that the scene lacks, but that take no primary sample, give the same bits") {
  const CompiledScene room(kPlainRoom, kSide, kSide);
  const PathSettings settings{6, 0};
  constexpr FeatureMask kGeometry = feature(FeatureBit::general_geometry);
  constexpr FeatureMask kMaterials = feature(FeatureBit::general_materials);
  for (std::uint64_t i = 0; i < 3000; ++i) {
    const Vec3 plain = radiance<0>(room.world(), settings, i);
    REQUIRE(radiance<kGeometry>(room.world(), settings, i) == plain);
    REQUIRE(radiance<kMaterials>(room.world(), settings, i) == plain);
    REQUIRE(radiance<kGeometry | kMaterials>(room.world(), settings, i) == plain);
  }
}

TEST_CASE("kernels for features that the scene lacks have the same expectation") {
  const CompiledScene room(kPlainRoom, kSide, kSide);
  constexpr std::size_t kPaths = 40000;
  const Moments plain = luminance_moments<0>(room.world(), {6, 0}, 0, kPaths);
  const Moments all = luminance_moments<kNoRoulette>(room.world(), {6, 0}, kPaths, kPaths);
  CHECK(welch_t_test(plain, all).p_value > 1e-4);
}

TEST_CASE("depth counts the edges from camera to light") {
  // A lamp in view, a wall that it lights, nothing else. One edge: the lamp itself. Two: the lit wall. The
  // lamp is black and the wall cannot see itself, so there is nothing at three.
  const CompiledScene scene(R"(
camera eye 0 1 5 target 0 1 0 fov 40
material black diffuse reflectance 0
material grey diffuse reflectance 0.5
quad -2 0 0  2 0 0  2 3 0  -2 3 0  material grey
quad -0.3 0.7 1  -0.3 1.3 1  0.3 1.3 1  0.3 0.7 1  material black emit 4
quad -0.3 0.7 1.01  0.3 0.7 1.01  0.3 1.3 1.01  -0.3 1.3 1.01  material black emit 4
)",
                            kSide, kSide);
  const World& world = scene.world();
  int lamp = 0, wall = 0;
  for (std::uint64_t i = 0; i < 4000; ++i) {
    const float one = radiance<kNoRoulette>(world, {1, 0}, i).x;
    const float two = radiance<kNoRoulette>(world, {2, 0}, i).x;
    const float three = radiance<kNoRoulette>(world, {3, 0}, i).x;
    REQUIRE((one == 0.0f || one == 4.0f));
    if (one > 0.0f) REQUIRE(two == one);
    REQUIRE(three == two);
    lamp += one > 0.0f ? 1 : 0;
    wall += one == 0.0f && two > 0.0f ? 1 : 0;
  }
  CHECK(lamp > 0);
  CHECK(wall > 0);
}

TEST_CASE("a longer limit adds to a path and takes nothing from it") {
  const CompiledScene room(kRoom, kSide, kSide);
  for (std::uint64_t i = 0; i < 1000; ++i) {
    Vec3 shorter{0, 0, 0};
    for (std::uint32_t depth = 1; depth <= 12; ++depth) {
      const Vec3 value = radiance<kNoRoulette>(room.world(), {depth, 0}, i);
      REQUIRE(is_finite(value));
      REQUIRE((value.x >= shorter.x && value.y >= shorter.y && value.z >= shorter.z));
      shorter = value;
    }
  }
}

TEST_CASE("Russian roulette leaves the expectation alone, wherever it starts, and shortens paths") {
  const CompiledScene room(kRoom, kSide, kSide);
  constexpr std::size_t kPaths = 60000;
  constexpr std::uint32_t kDepth = 12;
  const Moments without = luminance_moments<kNoRoulette>(room.world(), {kDepth, 0}, 0, kPaths);
  std::uint64_t first = kPaths;
  for (const std::uint32_t edge : {1U, 2U, 5U, 11U}) {
    const Moments with = luminance_moments<kAllFeatures>(room.world(), {kDepth, edge}, first, kPaths);
    first += kPaths;
    INFO("roulette from edge " << edge << ": " << with.mean << " and " << without.mean << " without");
    CHECK(welch_t_test(with, without).p_value > sidak_threshold(1e-3, 4));
  }
  std::uint64_t with = 0, all = 0;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    CountingSampler shortened(stream(i)), whole(stream(i));
    radiance<kAllFeatures>(room.world(), {kDepth, 1}, shortened);
    radiance<kAllFeatures>(room.world(), {kDepth, kDepth}, whole);
    with += shortened.position();
    all += whole.position();
  }
  CHECK(with < all / 2);
}

}  // namespace mlt::test
