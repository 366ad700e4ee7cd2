// Whole paths whose primary samples lie at the ends of [0,1), where every warp, choice and roulette has its
// borders: scenes of the repository and of the sweeps.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "integrator/features.hpp"
#include "integrator/path.hpp"
#include "integrator/sampler.hpp"
#include "markov/contribution.hpp"
#include "math/rng.hpp"
#include "scenes.hpp"
#include "support/compiled_scene.hpp"
#include "sweep.hpp"

namespace mlt::test {
namespace {

constexpr FeatureMask kAllFeatures = kFeatureMaskCount - 1;
constexpr std::uint32_t kSide = 16;
constexpr std::uint32_t kDepth = 16;
constexpr std::uint32_t kNoRoulette = kDepth;  ///< it would begin behind the longest path

/// Primary samples as fixed point; a float sees the upper 24 bits. The ends, their neighbours as fixed point
/// and as float, and the borders of halves and quarters, where frames and wraps turn.
constexpr std::uint32_t kEnds[] = {0U,          1U,          0xffU,       0x100U,      0x101U,
                                   0x3fffffffU, 0x40000000U, 0x7fffff00U, 0x7fffffffU, 0x80000000U,
                                   0x80000001U, 0xbfffffffU, 0xc0000000U, 0xfffffeffU, 0xffffff00U,
                                   0xffffff01U, 0xffffffffU};

/// Draws from kEnds, and now and then from everywhere, so that paths reach all of the scene.
class EndSampler : public FloatSamples<EndSampler, float> {
 public:
  EndSampler(std::uint64_t path, std::uint32_t random_in_16)
      : rng_(1, StreamPurpose::kTest, path), random_in_16_(random_in_16) {}

  std::uint32_t next_fixed(bool = true) {
    const std::uint32_t choice = rng_.next_fixed();
    if ((choice & 15U) < random_in_16_) return rng_.next_fixed();
    return kEnds[(choice >> 4) % std::size(kEnds)];
  }
  void skip(std::uint32_t, bool = true) {}

 private:
  Rng rng_;
  std::uint32_t random_in_16_;
};

struct Extremes {
  DefectCounts defects;
  std::uint64_t lit = 0, outside = 0;
  float brightest = 0;
};

Extremes trace_extremes(const SceneDescription& scene, std::uint32_t roulette, std::uint64_t paths) {
  const CompiledScene compiled(scene, kSide, kSide);
  const PathIntegrator<kAllFeatures> integrator(compiled.world(), PathSettings{kDepth, roulette});
  Extremes result;
  for (std::uint64_t path = 0; path < paths; ++path) {
    EndSampler sampler(path, static_cast<std::uint32_t>(path % 12));
    integrator.evaluate(sampler, [&result](const Splat& splat, bool) {
      if (splat.pixel >= kSide * kSide) ++result.outside;
      if (result.defects.reject(splat.value)) return;
      if (!is_zero(splat.value)) ++result.lit;
      result.brightest = std::max(result.brightest, luminance(splat.value));
    });
  }
  return result;
}

void add_extremes(SweepTable& table, const std::string& name, const SceneDescription& scene,
                  std::uint64_t paths) {
  const Extremes found = trace_extremes(scene, 2, paths);
  const std::uint64_t defects = found.defects.nan + found.defects.infinite + found.defects.negative;
  table.add_fact(name,
                 std::to_string(paths) + " paths, " + std::to_string(found.lit) + " lit, brightest " +
                     text_of(static_cast<double>(found.brightest)) + ", " + std::to_string(defects) +
                     " defects",
                 defects == 0 && found.outside == 0 && found.lit > 0);
}

void sweep_extremes(std::uint64_t paths) {
  SweepTable table("primary samples at the ends of [0,1)", "scene",
                   "no defect, no pixel outside of the film");
  for (const char* name : {"CornellBox", "CornellBox2", "cornell_hidden", "corridor", "conductor", "furnace",
                           "furnace_glass", "furnace_shapes", "glass_slab", "glass_slab_oblique", "mirror",
                           "quad_light", "sphere_light", "spheres"}) {
    add_extremes(table, name, parse_scene_file("scenes/" + std::string(name) + ".txt"), paths);
  }
  add_extremes(table, "room of slivers and glass", parse_scene_text(room_at({}), "room"), paths);
  add_extremes(table, "the same, 1e-6 in size", parse_scene_text(room_at({1e-6, {1, 2, 3}}), "room"), paths);
  for (const char* roughness : {"1e-5", "0.01", "1"}) {
    const std::string metal = std::string("material metal conductor preset gold roughness ") + roughness +
                              "\nsphere 0 0 0 1 material metal\nsphere 3 3 3 1e-4 material black emit 1e12\n";
    add_extremes(table, "metal of roughness " + std::string(roughness),
                 parse_scene_text(
                     "camera eye 0 0 5 target 0 0 0 fov 40\n" + std::string(kUniformLight) + metal, "metal"),
                 paths);
  }
}

}  // namespace

TEST_CASE("pitfall 1: whole paths of primary samples at the ends of [0,1)") {
  sweep_extremes(2000);
}

TEST_CASE("pitfall 1: 3e5 whole paths of primary samples at the ends of [0,1), in each scene", "[.stress]") {
  sweep_extremes(300000);
}

TEST_CASE("pitfall 13: in a closed room no sample weighs more than light and BSDF sampling allow") {
  // With the power heuristic a light's sample counts f cos / (2 pdf_bsdf), half the albedo, at most, and a
  // BSDF's sample the albedo: without roulette at most 1 + sum of albedo^k (1 + 1/2) = 2.5 at albedo 1/2.
  const Extremes found = trace_extremes(parse_scene_text(furnace("0.5"), "furnace"), kNoRoulette, 30000);
  CHECK(found.brightest <= 2.5f);
  CHECK(found.lit == 30000);
}

}  // namespace mlt::test
