// Material `mirror`: an ideal mirror of one reflectance for all angles.
//   reflectance  R G B  fraction reflected, each channel in [0,1]
// Both sides reflect alike. Left out: the rise of reflectance towards grazing angles; a `conductor` of
// roughness 0 has it. The lobe is a delta function: evaluation gives 0 and sampling needs no primary sample.
#pragma once

#include "material/material.hpp"

namespace mlt::mirror_bsdf {

inline constexpr PrimarySampleUse kSampleUse{.lobe = false, .direction = false};

void compile(const MaterialDescription& description, Material& material);

inline BsdfValue evaluate(const Material&, const Vec3&, const Vec3&) {
  return {};
}

inline BsdfSample sample(const Material& material, const Vec3& wo, float, const Vec2&) {
  BsdfSample result;
  result.is_delta = true;
  if (!(std::fabs(wo.z) > 0.0f)) return result;
  result.wi = Vec3{-wo.x, -wo.y, wo.z};
  result.weight = material.reflectance;
  return result;
}

}  // namespace mlt::mirror_bsdf
