// Material `diffuse`: an ideal matte surface [Lambert1760].
//   reflectance  R G B  albedo, each channel in [0,1]
// The radiance reflected is albedo / pi times the irradiance, in all directions of the side that it arrives
// on; both sides reflect alike and nothing passes through. Left out: retro-reflection of rough matte surfaces
// and a specular coat. wi is drawn in proportion to its cosine, so the weight of every sample is the albedo.
#pragma once

#include "material/material.hpp"
#include "math/warp.hpp"

namespace mlt::diffuse_bsdf {

inline constexpr PrimarySampleUse kSampleUse{.lobe = false, .direction = true};

void compile(const MaterialDescription& description, Material& material);

template <class F>
MLT_INLINE BsdfValueOf<F> evaluate(const MaterialOf<F>& material, const Vec3Of<F>& wo, const Vec3Of<F>& wi) {
  const F pdf = select(same_side(wo.z, wi.z), cosine_hemisphere_pdf_solid_angle(magnitude(wi.z)), F{});
  return {material.reflectance * pdf, pdf};
}

template <class F>
MLT_INLINE BsdfSampleOf<F> sample(const MaterialOf<F>& material, const Vec3Of<F>& wo, F, const Vec2Of<F>& u) {
  Vec3Of<F> wi = cosine_hemisphere<F>(u);
  const F pdf = cosine_hemisphere_pdf_solid_angle(wi.z);
  wi.z = negate_if<F>(wo.z < 0.0f, wi.z);
  BsdfSampleOf<F> drawn;
  drawn.wi = wi;
  drawn.weight = material.reflectance;
  drawn.pdf_solid_angle = pdf;
  return select((magnitude(wo.z) > 0.0f) & (pdf > 0.0f), drawn, BsdfSampleOf<F>{});
}

}  // namespace mlt::diffuse_bsdf
