// What a job finds in a scene: the feature mask that selects the kernel, and the lines of `mlt info`.
#pragma once

#include <vector>

#include "integrator/features.hpp"
#include "render/job.hpp"
#include "render/renderer.hpp"
#include "world/world.hpp"

namespace mlt {

FeatureMask find_features(const WorldCounts& counts, const RenderJob& job);

std::vector<InfoLine> describe_scene(const SceneDescription& scene, const WorldCounts& counts,
                                     const RenderJob& job, FeatureMask features,
                                     std::uint32_t primary_samples);

}  // namespace mlt
