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
#include <type_traits>

#include "math/wide.hpp"

namespace mlt {

using Vec2 = glm::vec2;    ///< float
using Vec3 = glm::vec3;    ///< float; values start uninitialised, so always brace-initialise
using DVec3 = glm::dvec3;  ///< double, for scene description and compilation

/// Vectors in lanes, with the operators of GLM's.
template <class F>
struct WideVec2 {
  F x, y;
};

template <class F>
struct WideVec3 {
  F x, y, z;

  MLT_INLINE WideVec3& operator+=(const WideVec3& b) { return *this = *this + b; }
  MLT_INLINE WideVec3& operator*=(const WideVec3& b) { return *this = *this * b; }
  MLT_INLINE friend WideVec3 operator-(const WideVec3& a) { return {-a.x, -a.y, -a.z}; }
  MLT_INLINE friend WideVec3 operator+(const WideVec3& a, const WideVec3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  MLT_INLINE friend WideVec3 operator-(const WideVec3& a, const WideVec3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  MLT_INLINE friend WideVec3 operator*(const WideVec3& a, const WideVec3& b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
  }
  MLT_INLINE friend WideVec3 operator*(const WideVec3& a, const F& b) { return {a.x * b, a.y * b, a.z * b}; }
};

template <class F>
using Vec2Of = std::conditional_t<std::is_same_v<F, float>, Vec2, WideVec2<F>>;
template <class F>
using Vec3Of = std::conditional_t<std::is_same_v<F, float>, Vec3, WideVec3<F>>;

/// The same vector in all lanes.
template <class F>
MLT_INLINE Vec3Of<F> broadcast_to(const Vec3& v) {
  if constexpr (VectorType<F>) {
    return {broadcast_to<F>(v.x), broadcast_to<F>(v.y), broadcast_to<F>(v.z)};
  } else {
    return v;
  }
}

MLT_INLINE Vec3 select(bool mask, const Vec3& a, const Vec3& b) {
  return mask ? a : b;
}
template <class M, class F>
MLT_INLINE WideVec3<F> select(M mask, const WideVec3<F>& a, const WideVec3<F>& b) {
  return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
}

/// Lane i of a vector.
MLT_INLINE Vec3 lane_of(const Vec3& v, int) {
  return v;
}
template <class F>
MLT_INLINE Vec3 lane_of(const WideVec3<F>& v, int lane) {
  return Vec3{v.x[lane], v.y[lane], v.z[lane]};
}
MLT_INLINE void set_lane_of(Vec3& v, int, const Vec3& to) {
  v = to;
}
template <class F>
MLT_INLINE void set_lane_of(WideVec3<F>& v, int lane, const Vec3& to) {
  v.x[lane] = to.x;
  v.y[lane] = to.y;
  v.z[lane] = to.z;
}

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
  return square_root(dot(v, v));
}

/// Unit vector of `v`, whose length must lie in [1e-17, 1e19]: within it no square of the length over- or
/// underflows (float; for double [1e-150, 1e150]). A zero vector gives NaN.
template <class V>
inline V normalize(const V& v) {
  return v * (1.0f / length(v));
}

inline bool is_finite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
/// Where all components are 0, as a mask.
template <class F = float>
inline MaskOf<F> is_zero(const Vec3Of<F>& v) {
  return MaskOf<F>((v.x == 0.0f) & (v.y == 0.0f) & (v.z == 0.0f));
}

template <class F = float>
inline F max_component(const Vec3Of<F>& v) {
  const F xy = select(v.x > v.y, v.x, v.y);
  return select(xy > v.z, xy, v.z);
}

/// Rec. 709 luminance of linear RGB [ITU-R BT.709].
template <class F = float>
inline F luminance(const Vec3Of<F>& rgb) {
  return (0.2126f * rgb.x + 0.7152f * rgb.y) + 0.0722f * rgb.z;
}

/// An orthonormal frame whose z axis is a surface normal [Duff17, listing 3].
template <class F>
struct FrameOf {
  using V = Vec3Of<F>;
  V x, y, z;

  MLT_INLINE explicit FrameOf(const V& normal) : z{normal} {
    const F sign = with_sign_of(broadcast_to<F>(1.0f), normal.z);
    const F a = -1.0f / (sign + normal.z);
    const F b = normal.x * normal.y * a;
    x = V{1.0f + sign * normal.x * normal.x * a, sign * b, -sign * normal.x};
    y = V{b, sign + normal.y * normal.y * a, -normal.y};
  }
  MLT_INLINE V to_local(const V& v) const { return V{dot(v, x), dot(v, y), dot(v, z)}; }
  MLT_INLINE V to_world(const V& v) const { return (x * v.x + y * v.y) + z * v.z; }
};
using Frame = FrameOf<float>;

}  // namespace mlt
