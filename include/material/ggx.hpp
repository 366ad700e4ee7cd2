// The GGX (Trowbridge-Reitz) distribution of isotropic microfacet normals [Walter07 eq. 33], its masking by
// the Smith model, and sampling of visible normals. Right in float down to alpha = 1e-5: slopes come from the
// tangential components of a half vector, never from 1 - cos^2, which is all rounding error there.
#pragma once

#include <cmath>

#include "math/elementary.hpp"
#include "math/vec.hpp"
#include "math/warp.hpp"

namespace mlt {

/// D(h) per steradian for a unit half vector, h.z >= 0; alpha in [1e-5, 1]. At most 1/(pi alpha^2) = 3.2e9.
inline float ggx_distribution(float alpha, const Vec3& h) {
  const float x = h.x / alpha;
  const float y = h.y / alpha;
  const float stretched = h.z * h.z + (x * x + y * y);
  const float root = alpha * stretched;
  return kInversePi / (root * root);
}

/// |w.z| * sqrt(1 + alpha^2 tan^2 theta), the length of w after its tangential components are scaled by
/// alpha: 1 + 2 Lambda(w) is this over |w.z| [Heitz14 eq. 72]. Positive for every unit w.
inline float ggx_stretched_length(float alpha, const Vec3& w) {
  const float x = alpha * w.x;
  const float y = alpha * w.y;
  return std::sqrt(w.z * w.z + (x * x + y * y));
}

/// A microfacet normal seen from the unit direction wo (wo.z > 0) with density G1(wo) max(0, wo.h) D(h)/wo.z
/// by solid angle: uniform on a spherical cap in the space where the facets form a hemisphere [Dupuy23].
/// Unit, with h.z > 0.
inline Vec3 ggx_sample_visible_normal(float alpha, const Vec3& wo, const Vec2& u) {
  const Vec3 stretched = normalize(Vec3{alpha * wo.x, alpha * wo.y, wo.z});
  float sine = 0, cosine = 0;
  sincos_2pi(u.y, sine, cosine);
  // The cap's point has height z = (1 - u.x)(1 + stretched.z) - stretched.z. 1 - z and 1 + z are both formed
  // without the difference, and so is z + stretched.z.
  const float rise = (1.0f - u.x) * (1.0f + stretched.z);
  const float below_top = u.x * (1.0f + stretched.z);
  const float above_bottom = rise + (1.0f - stretched.z);
  const float radius = std::sqrt(below_top * above_bottom);
  return normalize(
      Vec3{alpha * (radius * cosine + stretched.x), alpha * (radius * sine + stretched.y), rise});
}

}  // namespace mlt
