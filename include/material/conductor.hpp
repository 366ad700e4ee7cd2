// Material `conductor`: a metal, polished or rough.
//   eta, k     R G B  real (at least 0.001) and imaginary (at least 0) part of the refractive index, at most
//   100 roughness  GGX alpha itself (not its square root), 0 for a perfect mirror or in [1e-5, 1]
// Exact Fresnel reflectance per channel; GGX microfacets [Walter07] with height-correlated Smith masking
// [Heitz14 eq. 99]; visible normals are sampled, so a sample's weight is the Fresnel reflectance times
// G2/G1 <= 1. Both sides reflect alike. Left out: light that bounces between facets, so that a rough metal is
// darker than it should be (seen straight on by 1 % at roughness 0.1, 12 % at 0.3 and 69 % at 1), anisotropy,
// and polarisation. At roughness 0 the lobe is a delta function.
#pragma once

#include "material/fresnel.hpp"
#include "material/ggx.hpp"
#include "material/material.hpp"

namespace mlt::conductor_bsdf {

inline constexpr PrimarySampleUse kSampleUse{.lobe = false, .direction = true};

void compile(const MaterialDescription& description, Material& material);

/// Everything that evaluation and sampling share, so that both give the same bits for the same directions.
struct Reflection {
  Vec3 fresnel{0, 0, 0};
  float pdf_solid_angle = 0;
  float shadowing = 0;  ///< G2/G1, in [0,1]
};

/// Reflection between unit directions on the upper side (z > 0 for both).
inline Reflection reflect_rough(const Material& material, const Vec3& wo, const Vec3& wi) {
  const Vec3 sum = wo + wi;
  const float sum_length = length(sum);
  if (!(sum_length > 0.0f)) return {};
  const Vec3 h = sum * (1.0f / sum_length);
  const float alpha = material.roughness;
  const float length_o = ggx_stretched_length(alpha, wo);
  const float length_i = ggx_stretched_length(alpha, wi);

  Reflection result;
  // G1(wo) D(h) / (4 wo.z) [Heitz18 eq. 17], with wo.z cancelled: finite however grazing wo is.
  result.pdf_solid_angle = ggx_distribution(alpha, h) * (0.5f / (wo.z + length_o));
  // G2/G1 = (1 + Lambda(wo)) / (1 + Lambda(wo) + Lambda(wi)); a quotient that overflows to infinity rightly
  // gives 0.
  result.shadowing = (wo.z + length_o) / (length_o + wo.z * (length_i / wi.z));
  if (result.shadowing > 1.0f) result.shadowing = 1.0f;
  // The incident angle on the facet is half of that between wo and wi: its cosine is half the sum's length
  // and its sine half the difference's.
  const Vec3 difference = wo - wi;
  const float cos_facet = 0.5f * sum_length;
  result.fresnel = fresnel_conductor(cos_facet < 1.0f ? cos_facet : 1.0f, 0.25f * dot(difference, difference),
                                     material.eta, material.k);
  return result;
}

inline BsdfValue evaluate(const Material& material, const Vec3& wo, const Vec3& wi) {
  const bool same_side = (wo.z > 0.0f && wi.z > 0.0f) || (wo.z < 0.0f && wi.z < 0.0f);
  if (!same_side || material.roughness == 0.0f) return {};
  const Reflection reflection =
      reflect_rough(material, Vec3{wo.x, wo.y, std::fabs(wo.z)}, Vec3{wi.x, wi.y, std::fabs(wi.z)});
  if (!(reflection.pdf_solid_angle > 0.0f)) return {};
  return {reflection.fresnel * (reflection.shadowing * reflection.pdf_solid_angle),
          reflection.pdf_solid_angle};
}

inline BsdfSample sample(const Material& material, const Vec3& wo, float, const Vec2& u) {
  BsdfSample result;
  result.is_delta = material.roughness == 0.0f;
  if (!(std::fabs(wo.z) > 0.0f)) return result;
  if (result.is_delta) {
    result.wi = Vec3{-wo.x, -wo.y, wo.z};
    result.weight = fresnel_conductor(std::fabs(wo.z), wo.x * wo.x + wo.y * wo.y, material.eta, material.k);
    return result;
  }
  const Vec3 upper{wo.x, wo.y, std::fabs(wo.z)};
  const Vec3 h = ggx_sample_visible_normal(material.roughness, upper, u);
  Vec3 wi = h * (2.0f * dot(upper, h)) - upper;
  if (!(wi.z > 0.0f)) return result;
  const Reflection reflection = reflect_rough(material, upper, wi);
  if (!(reflection.pdf_solid_angle > 0.0f)) return result;
  if (wo.z < 0.0f) wi.z = -wi.z;
  result.wi = wi;
  result.weight = reflection.fresnel * reflection.shadowing;
  result.pdf_solid_angle = reflection.pdf_solid_angle;
  return result;
}

}  // namespace mlt::conductor_bsdf
