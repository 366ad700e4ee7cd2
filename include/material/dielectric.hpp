// Material `dielectric`: a smooth interface between two clear media, such as glass or water.
//   ior  index of refraction inside (behind the surface) over outside, in [1,3]; 1 is invisible
// Reflects and refracts by the Fresnel equations for unpolarised light; works from both sides, with total
// internal reflection. One lobe is chosen with its Fresnel probability, so reflection has weight 1. Radiance
// that is carried across the interface is scaled by (eta_i/eta_t)^2 against the path's direction [Veach97
// section 5.2]; light subpaths of bidirectional integrators must multiply by eta_scale to undo it. Left out:
// absorption inside, dispersion, rough interfaces, polarisation. Both lobes are delta functions.
#pragma once

#include "material/fresnel.hpp"
#include "material/material.hpp"

namespace mlt::dielectric_bsdf {

inline constexpr PrimarySampleUse kSampleUse{.lobe = true, .direction = false};

void compile(const MaterialDescription& description, Material& material);

inline BsdfValue evaluate(const Material&, const Vec3&, const Vec3&) {
  return {};
}

inline BsdfSample sample(const Material& material, const Vec3& wo, float u_lobe, const Vec2&) {
  BsdfSample result;
  result.is_delta = true;
  const float cos_i = std::fabs(wo.z);
  if (!(cos_i > 0.0f)) return result;
  if (material.ior == 1.0f) {
    // No interface: exactly straight on, without the rounding that Snell's law would add.
    result.wi = -wo;
    result.weight = Vec3{1, 1, 1};
    return result;
  }
  const float eta = wo.z > 0.0f ? material.ior : 1.0f / material.ior;
  const float inverse_eta = 1.0f / eta;
  // The sine from the tangential components: 1 - cos^2 would lose all digits near normal incidence.
  const float sin2_t = (wo.x * wo.x + wo.y * wo.y) * (inverse_eta * inverse_eta);
  const float cos2_t = 1.0f - sin2_t;
  const float cos_t = cos2_t > 0.0f ? std::sqrt(cos2_t) : 0.0f;
  const float reflected = cos_t > 0.0f ? fresnel_dielectric(cos_i, cos_t, eta) : 1.0f;
  if (u_lobe < reflected) {
    result.wi = Vec3{-wo.x, -wo.y, wo.z};
    result.weight = Vec3{1, 1, 1};
    return result;
  }
  if (!(cos_t > 0.0f)) return result;
  result.wi = Vec3{-wo.x * inverse_eta, -wo.y * inverse_eta, wo.z > 0.0f ? -cos_t : cos_t};
  const float squeezing = inverse_eta * inverse_eta;
  result.weight = Vec3{squeezing, squeezing, squeezing};
  result.eta_scale = eta * eta;
  return result;
}

}  // namespace mlt::dielectric_bsdf
