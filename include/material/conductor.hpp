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
template <class F>
struct Reflection {
  Vec3Of<F> fresnel;
  F pdf_solid_angle;  ///< 0 where there is no reflection
  F shadowing;        ///< G2/G1, in [0,1]
};

/// Reflection between unit directions on the upper side (z > 0 for both), in the lanes of `valid`.
template <class F>
MLT_INLINE Reflection<F> reflect_rough(const MaterialOf<F>& material, const Vec3Of<F>& wo,
                                       const Vec3Of<F>& wi, MaskOf<F> valid) {
  const F one = broadcast_to<F>(1.0f);
  const Vec3Of<F> sum = wo + wi;
  const F sum_length = length(sum);
  valid = valid & (sum_length > 0.0f);
  if (!any(valid)) return {Vec3Of<F>{F{}, F{}, F{}}, F{}, F{}};
  const Vec3Of<F> h = sum * (1.0f / nonzero(valid, sum_length));
  const F alpha = nonzero(valid, material.roughness);
  const F length_o = ggx_stretched_length<F>(alpha, wo);
  const F length_i = ggx_stretched_length<F>(alpha, wi);

  Reflection<F> result;
  // G1(wo) D(h) / (4 wo.z) [Heitz18 eq. 17], with wo.z cancelled: finite however grazing wo is.
  const F pdf = ggx_distribution<F>(alpha, h) * (0.5f / (wo.z + length_o));
  result.pdf_solid_angle = select(valid, pdf, F{});
  // G2/G1 = (1 + Lambda(wo)) / (1 + Lambda(wo) + Lambda(wi)); a quotient that overflows to infinity rightly
  // gives 0.
  const F shadowing = (wo.z + length_o) / (length_o + wo.z * (length_i / nonzero(valid, wi.z)));
  result.shadowing = select(shadowing > 1.0f, one, shadowing);
  // The incident angle on the facet is half of that between wo and wi: its cosine is half the sum's length
  // and its sine half the difference's.
  const Vec3Of<F> difference = wo - wi;
  const F cos_facet = 0.5f * sum_length;
  result.fresnel = fresnel_conductor_rgb<F>(select(cos_facet < 1.0f, cos_facet, one),
                                            0.25f * dot(difference, difference), material.eta, material.k);
  return result;
}

template <class F>
MLT_INLINE BsdfValueOf<F> evaluate(const MaterialOf<F>& material, const Vec3Of<F>& wo, const Vec3Of<F>& wi) {
  const MaskOf<F> is_smooth = material.roughness == 0.0f;
  const MaskOf<F> same = same_side(wo.z, wi.z);
  const MaskOf<F> is_rough = not_in(is_smooth);
  const MaskOf<F> valid = same & is_rough;
  if (!any(valid)) return {};
  const Reflection<F> reflection = reflect_rough<F>(material, Vec3Of<F>{wo.x, wo.y, magnitude(wo.z)},
                                                    Vec3Of<F>{wi.x, wi.y, magnitude(wi.z)}, valid);
  const BsdfValueOf<F> value{reflection.fresnel * (reflection.shadowing * reflection.pdf_solid_angle),
                             reflection.pdf_solid_angle};
  return select(reflection.pdf_solid_angle > 0.0f, value, BsdfValueOf<F>{});
}

template <class F>
MLT_INLINE BsdfSampleOf<F> sample(const MaterialOf<F>& material, const Vec3Of<F>& wo, F, const Vec2Of<F>& u) {
  BsdfSampleOf<F> result;
  const MaskOf<F> inclined = magnitude(wo.z) > 0.0f;
  const MaskOf<F> is_smooth = material.roughness == 0.0f;
  result.is_delta = is_smooth;
  if (any(inclined & is_smooth)) {
    BsdfSampleOf<F> mirrored = result;
    mirrored.wi = Vec3Of<F>{-wo.x, -wo.y, wo.z};
    mirrored.weight =
        fresnel_conductor_rgb<F>(magnitude(wo.z), wo.x * wo.x + wo.y * wo.y, material.eta, material.k);
    result = select(inclined & is_smooth, mirrored, result);
  }
  MaskOf<F> valid = inclined & not_in(is_smooth);
  if (!any(valid)) return result;
  const Vec3Of<F> upper{wo.x, wo.y, magnitude(wo.z)};
  const Vec3Of<F> h = ggx_sample_visible_normal<F>(material.roughness, upper, u);
  Vec3Of<F> wi = h * (2.0f * dot(upper, h)) - upper;
  valid = valid & (wi.z > 0.0f);
  if (!any(valid)) return result;
  const Reflection<F> reflection = reflect_rough<F>(material, upper, wi, valid);
  wi.z = negate_if<F>(wo.z < 0.0f, wi.z);
  BsdfSampleOf<F> drawn = result;
  drawn.wi = wi;
  drawn.weight = reflection.fresnel * reflection.shadowing;
  drawn.pdf_solid_angle = reflection.pdf_solid_angle;
  return select(valid & (reflection.pdf_solid_angle > 0.0f), drawn, result);
}

}  // namespace mlt::conductor_bsdf
