#include "material/conductor.hpp"

#include "material/parameters.hpp"
#include "scene/limits.hpp"

namespace mlt::conductor_bsdf {

void compile(const MaterialDescription& description, Material& material) {
  require_in_range(description, "eta", description.eta, kMinConductorEta, kMaxConductorEta);
  require_in_range(description, "k", description.k, 0.0, kMaxConductorEta);
  if (description.roughness != 0.0) {
    require_in_range(description, "roughness", description.roughness, kMinRoughness, 1.0);
  }
  material.eta = Vec3{description.eta};
  material.k = Vec3{description.k};
  material.roughness = static_cast<float>(description.roughness);
  material.delta = description.roughness == 0.0 ? 1 : 0;
}

}  // namespace mlt::conductor_bsdf
