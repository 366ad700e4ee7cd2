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

template <class F>
MLT_INLINE BsdfValueOf<F> evaluate(const MaterialOf<F>&, const Vec3Of<F>&, const Vec3Of<F>&) {
  return {};
}

template <class F>
MLT_INLINE BsdfSampleOf<F> sample(const MaterialOf<F>& material, const Vec3Of<F>& wo, F u_lobe,
                                  const Vec2Of<F>&) {
  const F one = broadcast_to<F>(1.0f);
  BsdfSampleOf<F> absorbed;
  absorbed.is_delta = not_in(MaskOf<F>{});
  const F cos_i = magnitude(wo.z);
  const MaskOf<F> scatters = cos_i > 0.0f;
  if (!any(scatters)) return absorbed;

  const MaskOf<F> from_front = wo.z > 0.0f;
  const F eta = select(from_front, material.ior, 1.0f / material.ior);
  const F inverse_eta = 1.0f / eta;
  // The sine from the tangential components: 1 - cos^2 would lose all digits near normal incidence.
  const F sin2_t = (wo.x * wo.x + wo.y * wo.y) * (inverse_eta * inverse_eta);
  const F cos2_t = 1.0f - sin2_t;
  const MaskOf<F> can_pass = cos2_t > 0.0f;
  const F cos_t = square_root(select(can_pass, cos2_t, F{}));
  const F reflected = select(can_pass, fresnel_dielectric(cos_i, nonzero<F>(can_pass, cos_t), eta), one);
  const MaskOf<F> reflects = u_lobe < reflected;
  // No interface: exactly straight on, without the rounding that Snell's law would add.
  const MaskOf<F> is_invisible = material.ior == 1.0f;

  BsdfSampleOf<F> mirrored = absorbed;
  mirrored.wi = Vec3Of<F>{-wo.x, -wo.y, wo.z};
  mirrored.weight = Vec3Of<F>{one, one, one};
  BsdfSampleOf<F> refracted = absorbed;
  refracted.wi = Vec3Of<F>{-wo.x * inverse_eta, -wo.y * inverse_eta, negate_if<F>(from_front, cos_t)};
  const F squeezing = inverse_eta * inverse_eta;
  refracted.weight = Vec3Of<F>{squeezing, squeezing, squeezing};
  refracted.eta_scale = eta * eta;
  BsdfSampleOf<F> straight = mirrored;
  straight.wi = -wo;

  const BsdfSampleOf<F> passed = select(can_pass, refracted, absorbed);
  const BsdfSampleOf<F> split = select(reflects, mirrored, passed);
  return select(scatters, select(is_invisible, straight, split), absorbed);
}

}  // namespace mlt::dielectric_bsdf
