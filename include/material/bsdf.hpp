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

/// f(wo, wi) |cos theta_i| and the density of wi under sample_bsdf, both 0 for delta lobes, for directions in
/// the surface's plane, and where nothing is scattered. Unit directions, local; always finite. Nothing is
/// known of lanes outside `active`.
template <bool kDiffuseOnly, class F = float>
MLT_NOINLINE BsdfValueOf<F> evaluate_bsdf(const std::type_identity_t<MaterialRefOf<F>>& material,
                                          const Vec3Of<F>& wo, const Vec3Of<F>& wi,
                                          const MaskOf<F>& active = not_in(MaskOf<F>{})) {
  if constexpr (kDiffuseOnly) return diffuse_bsdf::evaluate<F>(material.load(), wo, wi);
  BsdfValueOf<F> value;
#define MLT_EVALUATE(name)                                                          \
  if (const MaskOf<F> mask = active & material.is(MaterialKind::name); any(mask)) { \
    value = select(mask, name##_bsdf::evaluate<F>(material.load(), wo, wi), value); \
  }
  MLT_MATERIAL_KINDS(MLT_EVALUATE)
#undef MLT_EVALUATE
  return value;
}

/// Draws wi for the unit direction wo. u_lobe and both u in [0,1); u_lobe is read by kinds with several lobes
/// only. Weight 0 (absorbed) when wo lies in the surface's plane; always finite. Nothing is known of lanes
/// outside `active`.
template <bool kDiffuseOnly, class F = float>
MLT_NOINLINE BsdfSampleOf<F> sample_bsdf(const std::type_identity_t<MaterialRefOf<F>>& material,
                                         const Vec3Of<F>& wo, const std::type_identity_t<F>& u_lobe,
                                         const Vec2Of<F>& u, const MaskOf<F>& active = not_in(MaskOf<F>{})) {
  if constexpr (kDiffuseOnly) return diffuse_bsdf::sample<F>(material.load(), wo, u_lobe, u);
  BsdfSampleOf<F> sample;
#define MLT_SAMPLE(name)                                                                   \
  if (const MaskOf<F> mask = active & material.is(MaterialKind::name); any(mask)) {        \
    sample = select(mask, name##_bsdf::sample<F>(material.load(), wo, u_lobe, u), sample); \
  }
  MLT_MATERIAL_KINDS(MLT_SAMPLE)
#undef MLT_SAMPLE
  return sample;
}

}  // namespace mlt
