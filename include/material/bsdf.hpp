// Evaluation and sampling of any material: a switch over MaterialKind, generated from MLT_MATERIAL_KINDS, to
// the functions of the kind's own header. For a scene of diffuse surfaces alone the switch is compiled away
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
/// the surface's plane, and where nothing is scattered. Unit directions, local; always finite.
template <bool kDiffuseOnly>
inline BsdfValue evaluate_bsdf(const Material& material, const Vec3& wo, const Vec3& wi) {
  if constexpr (kDiffuseOnly) {
    return diffuse_bsdf::evaluate(material, wo, wi);
  } else {
    switch (material.kind) {
#define MLT_CASE(name)     \
  case MaterialKind::name: \
    return name##_bsdf::evaluate(material, wo, wi);
      MLT_MATERIAL_KINDS(MLT_CASE)
#undef MLT_CASE
    }
    return {};
  }
}

/// Draws wi for the unit direction wo. u_lobe and both u in [0,1); u_lobe is read by kinds with several lobes
/// only. Weight 0 (absorbed) when wo lies in the surface's plane; always finite.
template <bool kDiffuseOnly>
inline BsdfSample sample_bsdf(const Material& material, const Vec3& wo, float u_lobe, const Vec2& u) {
  if constexpr (kDiffuseOnly) {
    return diffuse_bsdf::sample(material, wo, u_lobe, u);
  } else {
    switch (material.kind) {
#define MLT_CASE(name)     \
  case MaterialKind::name: \
    return name##_bsdf::sample(material, wo, u_lobe, u);
      MLT_MATERIAL_KINDS(MLT_CASE)
#undef MLT_CASE
    }
    return {};
  }
}

}  // namespace mlt
