// Material `mirror`: an ideal mirror of one reflectance for all angles.
//   reflectance  R G B  fraction reflected, each channel in [0,1]
// Both sides reflect alike. Left out: the rise of reflectance towards grazing angles; a `conductor` of
// roughness 0 has it. The lobe is a delta function: evaluation gives 0 and sampling needs no primary sample.
#pragma once

#include "material/material.hpp"

namespace mlt::mirror_bsdf {

inline constexpr PrimarySampleUse kSampleUse{.lobe = false, .direction = false};

void compile(const MaterialDescription& description, Material& material);

template <class F>
MLT_INLINE BsdfValueOf<F> evaluate(const MaterialOf<F>&, const Vec3Of<F>&, const Vec3Of<F>&) {
  return {};
}

template <class F>
MLT_INLINE BsdfSampleOf<F> sample(const MaterialOf<F>& material, const Vec3Of<F>& wo, F, const Vec2Of<F>&) {
  BsdfSampleOf<F> absorbed;
  absorbed.is_delta = not_in(MaskOf<F>{});
  BsdfSampleOf<F> mirrored = absorbed;
  mirrored.wi = Vec3Of<F>{-wo.x, -wo.y, wo.z};
  mirrored.weight = material.reflectance;
  return select(magnitude(wo.z) > 0.0f, mirrored, absorbed);
}

}  // namespace mlt::mirror_bsdf
