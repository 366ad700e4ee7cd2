// Materials as the world stores them and integrators see them: the compiled parameters, and what evaluating
// and sampling return. All directions are unit vectors in the local frame of the surface (z is the front
// normal) and point away from it; wo leads to where the path comes from (the camera), wi to where radiance
// comes from. Densities are with respect to solid angle. The functions are in material/bsdf.hpp.
#pragma once

#include <cstdint>

#include "math/vec.hpp"
#include "scene/description.hpp"

namespace mlt {

/// Compiled parameters; which are meaningful depends on the kind.
struct Material {
  MaterialKind kind = MaterialKind::diffuse;
  bool delta = false;   ///< all lobes are delta functions
  float roughness = 0;  ///< GGX alpha; 0 makes the conductor a delta lobe
  float ior = 1;        ///< inside over outside index of refraction
  Vec3 reflectance{0, 0, 0};
  Vec3 eta{0, 0, 0};
  Vec3 k{0, 0, 0};

  /// True when all its lobes are delta functions, so that light sampling is pointless.
  bool is_delta() const { return delta; }
};

/// f * |cos theta_i| and the density with which sample_bsdf draws wi; both 0 for delta lobes.
struct BsdfValue {
  Vec3 f_cos{0, 0, 0};
  float pdf_solid_angle = 0;
};

/// `weight` is f * |cos theta_i| / pdf (for a delta lobe: its reflectance over its probability). An absorbed
/// sample has weight 0. `pdf_solid_angle` is 0 for a delta lobe and for an absorbed sample.
struct BsdfSample {
  Vec3 wi{0, 0, 1};
  Vec3 weight{0, 0, 0};
  float pdf_solid_angle = 0;
  float eta_scale = 1;  ///< (eta_t/eta_i)^2 on refraction, which Russian roulette takes out of the throughput
  bool is_delta = false;
};

/// Which primary samples sample_bsdf reads: the choice of a lobe, and the pair for the direction.
struct PrimarySampleUse {
  bool lobe = false;
  bool direction = false;
};

/// Checks the parameters of the description's kind against their ranges and converts them; allocates nothing
/// unless it fails. Throws InputError at the description's location.
Material compile_material(const MaterialDescription& description);

}  // namespace mlt
