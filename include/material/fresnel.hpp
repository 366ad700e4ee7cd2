// Fresnel reflectances for unpolarised light at a smooth interface, the mean of both polarisations. The
// forms are chosen so that float rounding can neither leave [0,1] nor give NaN.
#pragma once

#include <cmath>

#include "math/vec.hpp"

namespace mlt {

/// Reflectance between two transparent media [Born99 section 1.5.2]. Cosines of the angles of incidence and
/// refraction, both in (0,1] and related by Snell's law; eta = eta_t / eta_i > 0.
template <class F>
inline F fresnel_dielectric(F cos_i, F cos_t, F eta) {
  const F parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  const F perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
  return 0.5f * (parallel * parallel + perpendicular * perpendicular);
}

/// Reflectance of a metal of index eta + i k in vacuum for one channel [Born99 section 14.2]; cos_i in [0,1],
/// sin2_i = 1 - cos_i^2 handed in because callers have it without cancellation; eta >= 0, k >= 0, both at
/// most kMaxRefractiveIndex. With a + i b = sqrt((eta + i k)^2 - sin^2), each amplitude ratio is a quotient
/// of complex numbers whose squared moduli are sums of squares: no difference is left to cancel.
template <class F>
inline F fresnel_conductor(F cos_i, F sin2_i, F eta, F k) {
  // eta^2 - k^2 - sin^2, without cancellation for an index near 1.
  const F real = ((eta - 1.0f) * (eta + 1.0f) - k * k) + cos_i * cos_i;
  const F imaginary = 2.0f * eta * k;
  const F modulus = square_root(real * real + imaginary * imaginary);
  // The larger of a^2 and b^2 directly, the smaller one from a * b = imaginary / 2.
  const F greater = 0.5f * (modulus + magnitude(real));
  const MaskOf<F> has_greater = greater > 0.0f;
  const F lesser = select(has_greater, 0.25f * imaginary * imaginary / nonzero(has_greater, greater), F{});
  const MaskOf<F> is_clear = real >= 0.0f;
  const F a2 = select(is_clear, greater, lesser);
  const F b2 = select(is_clear, lesser, greater);
  const F a = square_root(a2);

  const F denominator_s = (cos_i + a) * (cos_i + a) + b2;
  const MaskOf<F> has_s = denominator_s > 0.0f;
  const F reflectance_s = ((cos_i - a) * (cos_i - a) + b2) / nonzero(has_s, denominator_s);

  const F a_cos = a * cos_i;
  const F b2_cos2 = b2 * cos_i * cos_i;
  const F denominator_p = (a_cos + sin2_i) * (a_cos + sin2_i) + b2_cos2;
  const MaskOf<F> has_p = denominator_p > 0.0f;
  const F ratio_p = ((a_cos - sin2_i) * (a_cos - sin2_i) + b2_cos2) / nonzero(has_p, denominator_p);
  const F mean = select(has_p, 0.5f * reflectance_s * (1.0f + ratio_p), reflectance_s);
  return select(has_s, mean, broadcast_to<F>(1.0f));
}

template <class F>
inline Vec3Of<F> fresnel_conductor_rgb(F cos_i, F sin2_i, const Vec3Of<F>& eta, const Vec3Of<F>& k) {
  return Vec3Of<F>{fresnel_conductor(cos_i, sin2_i, eta.x, k.x), fresnel_conductor(cos_i, sin2_i, eta.y, k.y),
                   fresnel_conductor(cos_i, sin2_i, eta.z, k.z)};
}

}  // namespace mlt
