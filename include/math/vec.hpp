// Vectors. GLM gives the types and the component-wise operators, which leave no choice of rounding; every
// operation whose result depends on an order of additions (dot, cross, length, normalize) is written out
// here, so that the order is the project's and not a library version's.
#pragma once

#if defined(GLM_FORCE_INTRINSICS) || defined(GLM_FORCE_DEFAULT_ALIGNED_GENTYPES) || \
    defined(GLM_FORCE_ALIGNED_GENTYPES)
#error "GLM intrinsics and aligned types change the bits of results; build GLM plain"
#endif
#if defined(__FAST_MATH__)
#error "fast-math breaks the floating-point contract (docs/ARCHITECTURE.md)"
#endif

#include <cmath>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace mlt {

using Vec2 = glm::vec2;    ///< float
using Vec3 = glm::vec3;    ///< float; values start uninitialised, so always brace-initialise
using DVec3 = glm::dvec3;  ///< double, for scene description and compilation

template <class V>
inline auto dot(const V& a, const V& b) {
  return (a.x * b.x + a.y * b.y) + a.z * b.z;
}

template <class V>
inline V cross(const V& a, const V& b) {
  return V{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <class V>
inline auto length(const V& v) {
  return std::sqrt(dot(v, v));
}

/// Unit vector of `v`, whose length must lie in [1e-17, 1e19]: within it no square of the length over- or
/// underflows (float; for double [1e-150, 1e150]). A zero vector gives NaN.
template <class V>
inline V normalize(const V& v) {
  return v * (decltype(v.x)(1) / length(v));
}

inline bool is_finite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
inline bool is_zero(const Vec3& v) {
  return v.x == 0.0f && v.y == 0.0f && v.z == 0.0f;
}

inline float max_component(const Vec3& v) {
  const float xy = v.x > v.y ? v.x : v.y;
  return xy > v.z ? xy : v.z;
}

/// Rec. 709 luminance of linear RGB [ITU-R BT.709].
inline float luminance(const Vec3& rgb) {
  return (0.2126f * rgb.x + 0.7152f * rgb.y) + 0.0722f * rgb.z;
}

/// An orthonormal frame whose z axis is a surface normal [Duff17, listing 3].
struct Frame {
  Vec3 x, y, z;

  explicit Frame(const Vec3& normal) : x{0, 0, 0}, y{0, 0, 0}, z{normal} {
    const float sign = std::copysign(1.0f, normal.z);
    const float a = -1.0f / (sign + normal.z);
    const float b = normal.x * normal.y * a;
    x = Vec3{1.0f + sign * normal.x * normal.x * a, sign * b, -sign * normal.x};
    y = Vec3{b, sign + normal.y * normal.y * a, -normal.y};
  }
  Vec3 to_local(const Vec3& v) const { return Vec3{dot(v, x), dot(v, y), dot(v, z)}; }
  Vec3 to_world(const Vec3& v) const { return (x * v.x + y * v.y) + z * v.z; }
};

}  // namespace mlt
