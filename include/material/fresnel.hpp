// Fresnel reflectances for unpolarised light at a smooth interface, the mean of both polarisations. The
// forms are chosen so that float rounding can neither leave [0,1] nor give NaN.
#pragma once

#include <cmath>

#include "math/vec.hpp"

namespace mlt {

/// Reflectance between two transparent media [Born99 section 1.5.2]. Cosines of the angles of incidence and
/// refraction, both in (0,1] and related by Snell's law; eta = eta_t / eta_i > 0.
inline float fresnel_dielectric(float cos_i, float cos_t, float eta) {
  const float parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  const float perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
  return 0.5f * (parallel * parallel + perpendicular * perpendicular);
}

/// Reflectance of a metal of index eta + i k in vacuum for one channel [Born99 section 14.2]; cos_i in [0,1],
/// sin2_i = 1 - cos_i^2 handed in because callers have it without cancellation; eta >= 0, k >= 0, both at
/// most kMaxRefractiveIndex. With a + i b = sqrt((eta + i k)^2 - sin^2), each amplitude ratio is a quotient
/// of complex numbers whose squared moduli are sums of squares: no difference is left to cancel.
inline float fresnel_conductor(float cos_i, float sin2_i, float eta, float k) {
  // eta^2 - k^2 - sin^2, without cancellation for an index near 1.
  const float real = ((eta - 1.0f) * (eta + 1.0f) - k * k) + cos_i * cos_i;
  const float imaginary = 2.0f * eta * k;
  const float modulus = std::sqrt(real * real + imaginary * imaginary);
  // The larger of a^2 and b^2 directly, the smaller one from a * b = imaginary / 2.
  const float larger = 0.5f * (modulus + std::fabs(real));
  const float smaller = larger > 0.0f ? 0.25f * imaginary * imaginary / larger : 0.0f;
  const float a2 = real >= 0.0f ? larger : smaller;
  const float b2 = real >= 0.0f ? smaller : larger;
  const float a = std::sqrt(a2);

  const float denominator_s = (cos_i + a) * (cos_i + a) + b2;
  if (!(denominator_s > 0.0f)) return 1.0f;
  const float reflectance_s = ((cos_i - a) * (cos_i - a) + b2) / denominator_s;

  const float a_cos = a * cos_i;
  const float b2_cos2 = b2 * cos_i * cos_i;
  const float denominator_p = (a_cos + sin2_i) * (a_cos + sin2_i) + b2_cos2;
  if (!(denominator_p > 0.0f)) return reflectance_s;
  const float ratio_p = ((a_cos - sin2_i) * (a_cos - sin2_i) + b2_cos2) / denominator_p;
  return 0.5f * reflectance_s * (1.0f + ratio_p);
}

inline Vec3 fresnel_conductor(float cos_i, float sin2_i, const Vec3& eta, const Vec3& k) {
  return Vec3{fresnel_conductor(cos_i, sin2_i, eta.x, k.x), fresnel_conductor(cos_i, sin2_i, eta.y, k.y),
              fresnel_conductor(cos_i, sin2_i, eta.z, k.z)};
}

}  // namespace mlt
