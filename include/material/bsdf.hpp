// Evaluation and sampling of any material: for each MaterialKind that some lane has, by MLT_MATERIAL_KINDS,
// the functions of the kind's own header. For a scene of diffuse surfaces alone there is no choice
// (kDiffuseOnly). To add a material: its name in MLT_MATERIAL_KINDS, a header <name>.hpp that defines
// kSampleUse, compile, evaluate and sample in namespace mlt::<name>_bsdf, and its line below. The contract
// tests then apply to it.
#pragma once

#include "material/conductor.hpp"
#include "material/dielectric.hpp"
#include "material/diffuse.hpp"
#include "material/material.hpp"
#include "material/mirror.hpp"
#include "math/vec.hpp"

namespace mlt {

/// Which primary samples materials of this kind read.
constexpr PrimarySampleUse primary_sample_use(MaterialKind kind) {
  switch (kind) {
#define MLT_CASE(name)     \
  case MaterialKind::name: \
    return name##_bsdf::kSampleUse;
    MLT_MATERIAL_KINDS(MLT_CASE)
#undef MLT_CASE
  }
  return {};
}

/// What is known of the materials at points before their functions are called: all of it where there are
/// diffuse ones alone, which read little and are read twice; else where they lie.
template <bool kDiffuseOnly, class F>
using ScattererOf = std::conditional_t<kDiffuseOnly, MaterialOf<F>, MaterialRefOf<F>>;

template <bool kDiffuseOnly, class F>
MLT_INLINE ScattererOf<kDiffuseOnly, F> scatterer(const MaterialRefOf<F>& material) {
  if constexpr (kDiffuseOnly) {
    return material.load();
  } else {
    return material;
  }
}

/// evaluate_bsdf and sample_bsdf of any kind.
template <class F>
MLT_NOINLINE BsdfValueOf<F> evaluate_any_bsdf(const MaterialRefOf<F>& material, const Vec3Of<F>& wo,
                                              const Vec3Of<F>& wi, const MaskOf<F>& active) {
  BsdfValueOf<F> value;
#define MLT_EVALUATE(name)                                                          \
  if (const MaskOf<F> mask = active & material.is(MaterialKind::name); any(mask)) { \
    value = select(mask, name##_bsdf::evaluate<F>(material.load(), wo, wi), value); \
  }
  MLT_MATERIAL_KINDS(MLT_EVALUATE)
#undef MLT_EVALUATE
  return value;
}

template <class F>
MLT_NOINLINE BsdfSampleOf<F> sample_any_bsdf(const MaterialRefOf<F>& material, const Vec3Of<F>& wo,
                                             const F& u_lobe, const Vec2Of<F>& u, const MaskOf<F>& active) {
  BsdfSampleOf<F> sample;
#define MLT_SAMPLE(name)                                                                   \
  if (const MaskOf<F> mask = active & material.is(MaterialKind::name); any(mask)) {        \
    sample = select(mask, name##_bsdf::sample<F>(material.load(), wo, u_lobe, u), sample); \
  }
  MLT_MATERIAL_KINDS(MLT_SAMPLE)
#undef MLT_SAMPLE
  return sample;
}

/// f(wo, wi) |cos theta_i| and the density of wi under sample_bsdf, both 0 for delta lobes, for directions in
/// the surface's plane, and where nothing is scattered. Unit directions, local; always finite. Nothing is
/// known of lanes outside `active`.
template <bool kDiffuseOnly, class F = float>
MLT_INLINE BsdfValueOf<F> evaluate_bsdf(const std::type_identity_t<ScattererOf<kDiffuseOnly, F>>& material,
                                        const Vec3Of<F>& wo, const Vec3Of<F>& wi,
                                        const MaskOf<F>& active = not_in(MaskOf<F>{})) {
  if constexpr (kDiffuseOnly) {
    return diffuse_bsdf::evaluate<F>(material, wo, wi);
  } else {
    return evaluate_any_bsdf<F>(material, wo, wi, active);
  }
}

/// Draws wi for the unit direction wo. u_lobe and both u in [0,1); u_lobe is read by kinds with several lobes
/// only. Weight 0 (absorbed) when wo lies in the surface's plane; always finite. Nothing is known of lanes
/// outside `active`.
template <bool kDiffuseOnly, class F = float>
MLT_INLINE BsdfSampleOf<F> sample_bsdf(const std::type_identity_t<ScattererOf<kDiffuseOnly, F>>& material,
                                       const Vec3Of<F>& wo, const std::type_identity_t<F>& u_lobe,
                                       const Vec2Of<F>& u, const MaskOf<F>& active = not_in(MaskOf<F>{})) {
  if constexpr (kDiffuseOnly) {
    return diffuse_bsdf::sample<F>(material, wo, u_lobe, u);
  } else {
    return sample_any_bsdf<F>(material, wo, u_lobe, u, active);
  }
}

}  // namespace mlt
