// Maps from the unit square to the domains that the renderer samples uniformly or by a cosine, each with its
// density. Every map accepts all floats in [0,1) and yields finite points whose density is positive; none
// subtracts nearly equal numbers, so rims and poles keep their relative accuracy.
#pragma once

#include "math/constants.hpp"
#include "math/elementary.hpp"
#include "math/vec.hpp"

namespace mlt {

/// Unit vector of the hemisphere around +z with density cos(theta)/pi per solid angle. z >= 2^-12, and z^2 is
/// 1 - u.x exactly up to the rounding of two operations, because it is computed from u.x and not from x and
/// y.
template <class F = float>
inline Vec3Of<F> cosine_hemisphere(const Vec2Of<F>& u) {
  F s;
  F c;
  sincos_2pi(u.y, s, c);
  const F r = square_root(u.x);
  return Vec3Of<F>{r * c, r * s, square_root(1.0f - u.x)};
}

/// Density per solid angle of cosine_hemisphere(); 0 on and below the horizon.
template <class F>
inline F cosine_hemisphere_pdf_solid_angle(F cos_theta) {
  return select(cos_theta > 0.0f, cos_theta * kInversePi, F{});
}

/// Uniform barycentric coordinates (their sum is 1 within rounding, none is negative) by the map of
/// [Heitz19], which needs no square root and keeps neighbouring samples together.
template <class F = float>
inline Vec3Of<F> uniform_triangle(const Vec2Of<F>& u) {
  const MaskOf<F> below = u.x >= u.y;
  const F greater = select(below, u.x, u.y);
  const F half = 0.5f * select(below, u.y, u.x);
  const F rest = greater - half;
  return Vec3Of<F>{select(below, rest, half), select(below, half, rest), 1.0f - greater};
}

/// A number in [0,1) with density proportional to at_0 (1 - x) + at_1 x; both ends >= 0, finite, with finite
/// squares. Where both are 0 it is 0.
template <class F>
MLT_INLINE F linear_density(F u, F at_0, F at_1) {
  const F root = square_root(at_0 * at_0 + u * (at_1 * at_1 - at_0 * at_0));
  const F denominator = at_0 + root;
  const F x = u * (at_0 + at_1) / nonzero(denominator > 0.0f, denominator);
  return select(x < 1.0f, x, broadcast_to<F>(0x1.fffffep-1f));
}

/// Density per area of a point chosen by uniform_triangle() on a triangle of this area (> 0).
inline float uniform_triangle_pdf_area(float area) {
  return 1.0f / area;
}

/// Uniform unit vector of the sphere.
template <class F = float>
inline Vec3Of<F> uniform_sphere(const Vec2Of<F>& u) {
  F s;
  F c;
  sincos_2pi(u.y, s, c);
  const F r = 2.0f * square_root(u.x * (1.0f - u.x));
  return Vec3Of<F>{r * c, r * s, 1.0f - 2.0f * u.x};
}

/// Density per solid angle of uniform_sphere().
inline float uniform_sphere_pdf_solid_angle() {
  return kInverse4Pi;
}

/// 1 - cos(alpha) from sin^2(alpha) in [0,1], alpha in [0, pi/2], without the cancellation for small cones:
/// what a sphere of radius R at distance d subtends has sin^2 = R^2/d^2.
template <class F>
inline F one_minus_cos(F sin_squared) {
  return sin_squared / (1.0f + square_root(1.0f - sin_squared));
}

/// Uniform unit vector of the cone (spherical cap) around +z whose half angle has 1 - cos =
/// `one_minus_cos_max` in (0, 2].
inline Vec3 uniform_cone(const Vec2& u, float one_minus_cos_max) {
  float s;
  float c;
  sincos_2pi(u.y, s, c);
  const float depth = u.x * one_minus_cos_max;
  const float r = std::sqrt(depth * (2.0f - depth));
  return Vec3{r * c, r * s, 1.0f - depth};
}

/// Density per solid angle of uniform_cone(), inside the cone.
inline float uniform_cone_pdf_solid_angle(float one_minus_cos_max) {
  return 1.0f / (kTwoPi * one_minus_cos_max);
}

}  // namespace mlt
