#include "material/conductor.hpp"

#include "material/parameters.hpp"

namespace mlt::conductor_bsdf {

namespace {
/// The smallest real part: positive, and its square is still a normal float.
constexpr double kMinEta = 1e-15;
constexpr double kMinRoughness = 1e-5;
}  // namespace

void compile(const MaterialDescription& description, Material& material) {
  require_in_range(description, "eta", description.eta, kMinEta, kMaxRefractiveIndex);
  require_in_range(description, "k", description.k, 0.0, kMaxRefractiveIndex);
  if (description.roughness != 0.0) {
    require_in_range(description, "roughness", description.roughness, kMinRoughness, 1.0);
  }
  material.eta = Vec3{description.eta};
  material.k = Vec3{description.k};
  material.roughness = static_cast<float>(description.roughness);
  material.delta = description.roughness == 0.0;
}

}  // namespace mlt::conductor_bsdf
