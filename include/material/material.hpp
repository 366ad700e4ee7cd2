// Materials as the integrators see them: evaluate, sample, and say whether a lobe is a delta function. All
// directions are unit vectors in the local frame of the surface (z is the front normal) and point away from
// it. Densities are with respect to solid angle. No virtual call: a switch over MaterialKind, which for a
// scene of diffuse surfaces alone is compiled away (kDiffuseOnly).
#pragma once

#include <cstdint>

#include "math/vec.hpp"
#include "scene/description.hpp"

namespace mlt {

/// Compiled parameters; which are meaningful depends on the kind.
struct Material {
  MaterialKind kind = MaterialKind::diffuse;
  float roughness = 0;         ///< GGX alpha; 0 makes the conductor a delta lobe
  float ior = 1;               ///< inside over outside
  Vec3 reflectance{0, 0, 0};
  Vec3 eta{0, 0, 0};
  Vec3 k{0, 0, 0};

  /// True when all its lobes are delta functions, so that light sampling is pointless.
  bool is_delta() const {
    return kind == MaterialKind::mirror || kind == MaterialKind::dielectric ||
           (kind == MaterialKind::conductor && roughness == 0.0f);
  }
};

/// f * |cos theta_i| and the density with which sample_bsdf draws wi; both 0 for delta lobes.
struct BsdfValue {
  Vec3 f_cos{0, 0, 0};
  float pdf_solid_angle = 0;
};

/// `weight` is f * |cos theta_i| / pdf (for a delta lobe: its reflectance over its probability). An absorbed
/// sample has weight 0. `pdf_solid_angle` is 0 for a delta lobe.
struct BsdfSample {
  Vec3 wi{0, 0, 1};
  Vec3 weight{0, 0, 0};
  float pdf_solid_angle = 0;
  float eta_scale = 1;  ///< (eta_t/eta_i)^2 on refraction, which Russian roulette takes out of the throughput
  bool is_delta = false;
};

}  // namespace mlt
