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

inline BsdfValue evaluate(const Material& material, const Vec3& wo, const Vec3& wi) {
  // Comparisons of signs: the product of two tiny cosines would underflow.
  const bool same_side = (wo.z > 0.0f && wi.z > 0.0f) || (wo.z < 0.0f && wi.z < 0.0f);
  if (!same_side) return {};
  const float pdf = cosine_hemisphere_pdf_solid_angle(std::fabs(wi.z));
  return {material.reflectance * pdf, pdf};
}

inline BsdfSample sample(const Material& material, const Vec3& wo, float, const Vec2& u) {
  BsdfSample result;
  if (!(std::fabs(wo.z) > 0.0f)) return result;
  Vec3 wi = cosine_hemisphere(u);
  const float pdf = cosine_hemisphere_pdf_solid_angle(wi.z);
  if (!(pdf > 0.0f)) return result;
  if (wo.z < 0.0f) wi.z = -wi.z;
  result.wi = wi;
  result.weight = material.reflectance;
  result.pdf_solid_angle = pdf;
  return result;
}

}  // namespace mlt::diffuse_bsdf
