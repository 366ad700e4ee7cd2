#include "render/scene_info.hpp"

#include <fmt/core.h>

namespace mlt {
namespace {

std::string list_materials(const WorldCounts& counts, bool used) {
  std::string text;
#define MLT_APPEND(name)                                                                              \
  {                                                                                                   \
    const std::uint32_t primitives = counts.used_kinds[static_cast<std::size_t>(MaterialKind::name)]; \
    if ((primitives > 0) == used) {                                                                   \
      text += (text.empty() ? "" : ", ") + std::string(#name);                                        \
      if (used) text += fmt::format(" ({} primitives)", primitives);                                  \
    }                                                                                                 \
  }
  MLT_MATERIAL_KINDS(MLT_APPEND)
#undef MLT_APPEND
  return text.empty() ? "none" : text;
}

std::string list_features(FeatureMask features, bool present_side) {
  std::string text;
#define MLT_APPEND(name, present, absent)                                              \
  if (has(features, FeatureBit::name) == present_side) {                               \
    text += (text.empty() ? "" : "; ") + std::string(present_side ? present : absent); \
  }
  MLT_FEATURES(MLT_APPEND)
#undef MLT_APPEND
  return text.empty() ? "none" : text;
}

}  // namespace

FeatureMask find_features(const WorldCounts& counts, const RenderJob& job) {
  const auto used = [&counts](MaterialKind kind) {
    return counts.used_kinds[static_cast<std::size_t>(kind)] > 0;
  };
  const auto bit = [](FeatureBit which, bool present) { return present ? feature(which) : FeatureMask{0}; };
  return kForcedFeatures | bit(FeatureBit::general_geometry, Geometry::is_general(counts.geometry)) |
         bit(FeatureBit::general_materials,
             used(MaterialKind::mirror) || used(MaterialKind::dielectric) || used(MaterialKind::conductor)) |
         bit(FeatureBit::lobe_choice, used(MaterialKind::dielectric)) |
         bit(FeatureBit::many_lights, counts.lights > 1) | bit(FeatureBit::roulette, job.roulette > 0);
}

std::vector<InfoLine> describe_scene(const SceneDescription& scene, const WorldCounts& counts,
                                     const RenderJob& job, FeatureMask features,
                                     std::uint32_t primary_samples) {
  std::vector<InfoLine> lines;
  lines.push_back({"scene", scene.path});
  lines.push_back({"film", fmt::format("{} x {} pixels", job.width, job.height)});
  lines.push_back({"depth", fmt::format("{} path edges from camera to light", job.depth)});
  lines.push_back({"quads", fmt::format("{}", counts.geometry.quads)});
  lines.push_back({"triangles", fmt::format("{}", counts.geometry.triangles)});
  lines.push_back({"spheres", fmt::format("{}", counts.geometry.spheres)});
  lines.push_back({"emitting primitives", fmt::format("{}", counts.lights)});
  lines.push_back({"materials declared", fmt::format("{}", counts.materials)});
  lines.push_back({"materials used", list_materials(counts, true)});
  lines.push_back({"materials skipped", list_materials(counts, false)});
  lines.push_back({"features found", list_features(features, true)});
  lines.push_back({"features skipped", list_features(features, false)});
  lines.push_back({"kernel", fmt::format("feature mask {:#x}, instruction set {}", features,
                                         instruction_set_name(job.instruction_set))});
  lines.push_back({"primary samples", fmt::format("at most {} a path", primary_samples)});
  if (job.integrator == IntegratorKind::pssmlt) {
    lines.push_back({"chains", fmt::format("{}", job.chains)});
    lines.push_back({"bootstrap", fmt::format("{} paths", job.bootstrap)});
  }
  return lines;
}

}  // namespace mlt
