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
template <class F = float>
inline F ggx_distribution(F alpha, const Vec3Of<F>& h) {
  const F x = h.x / alpha;
  const F y = h.y / alpha;
  const F stretched = h.z * h.z + (x * x + y * y);
  const F root = alpha * stretched;
  return kInversePi / (root * root);
}

/// |w.z| * sqrt(1 + alpha^2 tan^2 theta), the length of w after its tangential components are scaled by
/// alpha: 1 + 2 Lambda(w) is this over |w.z| [Heitz14 eq. 72]. Positive for every unit w.
template <class F = float>
inline F ggx_stretched_length(F alpha, const Vec3Of<F>& w) {
  const F x = alpha * w.x;
  const F y = alpha * w.y;
  return square_root(w.z * w.z + (x * x + y * y));
}

/// A microfacet normal seen from the unit direction wo (wo.z > 0) with density G1(wo) max(0, wo.h) D(h)/wo.z
/// by solid angle: uniform on a spherical cap in the space where the facets form a hemisphere [Dupuy23].
/// Unit, with h.z > 0.
template <class F = float>
inline Vec3Of<F> ggx_sample_visible_normal(F alpha, const Vec3Of<F>& wo, const Vec2Of<F>& u) {
  const Vec3Of<F> stretched = normalize(Vec3Of<F>{alpha * wo.x, alpha * wo.y, wo.z});
  F sine{}, cosine{};
  sincos_2pi(u.y, sine, cosine);
  // The cap's point has height z = (1 - u.x)(1 + stretched.z) - stretched.z. 1 - z and 1 + z are both formed
  // without the difference, and so is z + stretched.z.
  const F rise = (1.0f - u.x) * (1.0f + stretched.z);
  const F below_top = u.x * (1.0f + stretched.z);
  const F above_bottom = rise + (1.0f - stretched.z);
  const F radius = square_root(below_top * above_bottom);
  return normalize(
      Vec3Of<F>{alpha * (radius * cosine + stretched.x), alpha * (radius * sine + stretched.y), rise});
}

}  // namespace mlt
