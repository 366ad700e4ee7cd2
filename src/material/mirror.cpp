#include "material/mirror.hpp"

#include "material/parameters.hpp"

namespace mlt::mirror_bsdf {

void compile(const MaterialDescription& description, Material& material) {
  require_in_range(description, "reflectance", description.reflectance, 0.0, 1.0);
  material.reflectance = Vec3{description.reflectance};
  material.delta = 1;
}

}  // namespace mlt::mirror_bsdf
