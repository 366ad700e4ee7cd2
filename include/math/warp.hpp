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
inline Vec3 cosine_hemisphere(const Vec2& u) {
  float s;
  float c;
  sincos_2pi(u.y, s, c);
  const float r = std::sqrt(u.x);
  return Vec3{r * c, r * s, std::sqrt(1.0f - u.x)};
}

/// Density per solid angle of cosine_hemisphere(); 0 on and below the horizon.
inline float cosine_hemisphere_pdf_solid_angle(float cos_theta) {
  return cos_theta > 0.0f ? cos_theta * kInversePi : 0.0f;
}

/// Uniform barycentric coordinates (their sum is 1 within rounding, none is negative) by the map of
/// [Heitz19], which needs no square root and keeps neighbouring samples together.
inline Vec3 uniform_triangle(const Vec2& u) {
  const bool below = u.x >= u.y;
  const float half = 0.5f * (below ? u.y : u.x);
  const float rest = (below ? u.x : u.y) - half;
  return Vec3{below ? rest : half, below ? half : rest, 1.0f - (below ? u.x : u.y)};
}

/// Density per area of a point chosen by uniform_triangle() on a triangle of this area (> 0).
inline float uniform_triangle_pdf_area(float area) {
  return 1.0f / area;
}

/// Uniform unit vector of the sphere.
inline Vec3 uniform_sphere(const Vec2& u) {
  float s;
  float c;
  sincos_2pi(u.y, s, c);
  const float r = 2.0f * std::sqrt(u.x * (1.0f - u.x));
  return Vec3{r * c, r * s, 1.0f - 2.0f * u.x};
}

/// Density per solid angle of uniform_sphere().
inline float uniform_sphere_pdf_solid_angle() {
  return kInverse4Pi;
}

/// 1 - cos(alpha) from sin^2(alpha) in [0,1], alpha in [0, pi/2], without the cancellation for small cones:
/// what a sphere of radius R at distance d subtends has sin^2 = R^2/d^2.
inline float one_minus_cos(float sin_squared) {
  return sin_squared / (1.0f + std::sqrt(1.0f - sin_squared));
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
