#include "material/dielectric.hpp"

#include "material/parameters.hpp"
#include "scene/limits.hpp"

namespace mlt::dielectric_bsdf {

void compile(const MaterialDescription& description, Material& material) {
  require_in_range(description, "ior", description.ior, 1.0, kMaxIor);
  material.ior = static_cast<float>(description.ior);
  material.delta = 1;
}

}  // namespace mlt::dielectric_bsdf
