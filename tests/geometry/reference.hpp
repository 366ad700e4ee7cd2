// Two references for the geometry, both plain loops over all shapes. The first states the definition of a hit
// (polygon.hpp) for one primitive in scalar code, and must agree bit for bit. The second is another method in
// double, and must agree wherever the answer does not hang on rounding.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "scene_fixture.hpp"

namespace mlt::test {

inline constexpr float kMiss = -1.0f;

/// What all primitives share of a ray.
struct ScalarRay {
  ScalarRay(const Ray& r, float extent) : ray(r) {
    float reach = 0, largest = 0;
    for (int k = 0; k < 3; ++k) reach = std::max(reach, std::fabs(ray.origin[k]));
    for (int k = 0; k < 3; ++k) largest = std::max(largest, std::fabs(ray.direction[k]));
    for (int k = 1; k < 3; ++k) kz = std::fabs(ray.direction[k]) > std::fabs(ray.direction[kz]) ? k : kz;
    kx = (kz + 1) % 3;
    ky = (kz + 2) % 3;
    sx = ray.direction[kx] / ray.direction[kz];
    sy = ray.direction[ky] / ray.direction[kz];
    sz = 1.0f / ray.direction[kz];
    const float padding = (reach + extent) * 0x1p-19f;
    for (int k = 0; k < 3; ++k) {
      down[k] = std::signbit(ray.direction[k]);
      const float slope = std::max(std::fabs(ray.direction[k]), largest * 0x1p-30f);
      inverse[k] = 1.0f / (down[k] ? -slope : slope);
      padded[k] = down[k] ? ray.origin[k] - padding : ray.origin[k] + padding;
    }
  }
  Ray ray;
  int kx = 0, ky = 0, kz = 0;
  float sx, sy, sz;
  bool down[3];
  float inverse[3], padded[3];
};

/// Where the ray enters the box of `corners`, padded as ray_frame.hpp says.
inline float scalar_box_entry(const ScalarRay& r, const Vec3* corners, int count) {
  float entry = 0;
  for (int k = 0; k < 3; ++k) {
    float plane = corners[0][k];
    for (int i = 1; i < count; ++i) {
      plane = r.down[k] ? std::max(plane, corners[i][k]) : std::min(plane, corners[i][k]);
    }
    entry = std::max(entry, (plane - r.padded[k]) * r.inverse[k]);
  }
  return entry;
}

/// Distance of the definition's hit, or kMiss.
inline float scalar_polygon_t(const ScalarRay& r, const Vec3* corners, int count) {
  float x[4] = {}, y[4] = {}, z[4] = {};
  for (int i = 0; i < count; ++i) {
    z[i] = corners[i][r.kz] - r.ray.origin[r.kz];
    x[i] = (corners[i][r.kx] - r.ray.origin[r.kx]) - r.sx * z[i];
    y[i] = (corners[i][r.ky] - r.ray.origin[r.ky]) - r.sy * z[i];
  }
  for (int m = 1; m < count; m += 2) {
    const int order[5] = {0, m, 2, 0, m};
    double exact[3];
    float weight[3];
    for (int i = 0; i < 3; ++i) {
      const int p = order[i + 1], q = order[i + 2];
      exact[i] = double{x[p]} * y[q] - double{y[p]} * x[q];
      weight[i] = x[p] * y[q] - y[p] * x[q];
    }
    const bool positive = exact[0] >= 0 && exact[1] >= 0 && exact[2] >= 0;
    const bool negative = exact[0] <= 0 && exact[1] <= 0 && exact[2] <= 0;
    // Sums in the order of corners a, middle, c.
    const double exact_sum = (exact[0] + exact[1]) + exact[2];
    if (!(positive || negative) || exact_sum == 0) continue;
    float widest_x = 0, widest_y = 0;
    for (int i = 0; i < count; ++i) widest_x = std::max(widest_x, std::fabs(x[i]));
    for (int i = 0; i < count; ++i) widest_y = std::max(widest_y, std::fabs(y[i]));
    const float t[3] = {z[0] * r.sz, z[m] * r.sz, z[2] * r.sz};
    const float depth = (weight[0] * t[0] + weight[1] * t[1]) + weight[2] * t[2];
    const float reach = std::max({std::fabs(t[0]), std::fabs(t[1]), std::fabs(t[2])});
    const float error = (widest_x * widest_y) * (reach * (40 * 0x1p-24f));
    const bool ahead = std::min({t[0], t[1], t[2]}) > 0;
    const bool sure = weight[0] != 0 && weight[1] != 0 && weight[2] != 0;
    float result = sure ? depth * (1.0f / ((weight[0] + weight[1]) + weight[2])) : 0.0f;
    if (!sure || (!ahead && std::fabs(depth) <= error)) {
      const double exact_depth = (exact[0] * z[0] + exact[1] * z[m]) + exact[2] * z[2];
      result = static_cast<float>(exact_depth / exact_sum * double{r.sz});
    }
    if (!(result > 0)) return kMiss;
    return std::max(result, scalar_box_entry(r, corners, count));
  }
  return kMiss;
}

inline bool has_area(const Vec3& a, const Vec3& b, const Vec3& c) {
  return cross(DVec3{b} - DVec3{a}, DVec3{c} - DVec3{a}) != DVec3{0, 0, 0};
}

/// The first hit by the definition. Shapes are polygons only.
inline Hit brute_force(const Shapes& shapes, const Ray& ray, float extent) {
  const ScalarRay scalar_ray(ray, extent);
  Hit best;
  float limit = ray.t_max;
  std::uint32_t primitive = 0;
  const auto consider = [&](float t) {
    // In order of primitive index, so that only smaller distances replace.
    if (t != kMiss && t < limit) {
      limit = t;
      best = Hit{t, primitive};
    }
    ++primitive;
  };
  for (const Quad& q : shapes.quads) {
    const Vec3 corners[4] = {q.a, q.b, q.c, q.d};
    consider(has_area(q.a, q.b, q.c) ? scalar_polygon_t(scalar_ray, corners, 4) : kMiss);
  }
  for (const Triangle& t : shapes.triangles) {
    const Vec3 corners[3] = {t.a, t.b, t.c};
    consider(has_area(t.a, t.b, t.c) ? scalar_polygon_t(scalar_ray, corners, 3) : kMiss);
  }
  return best;
}

/// Answer of the independent reference for one ray and a set of polygons.
struct DoubleHit {
  double t = std::numeric_limits<double>::infinity();
  double t_error = 0;     ///< what float rounding may do to t
  bool doubtful = false;  ///< an edge, a tie or a grazing angle lies within float rounding
};

/// [Moeller97] in double on one triangle.
inline void moeller_trumbore(const Ray& ray, const Triangle& triangle, DoubleHit& hit) {
  const DVec3 o{ray.origin}, d{ray.direction}, a{triangle.a};
  const DVec3 e1 = DVec3{triangle.b} - a, e2 = DVec3{triangle.c} - a;
  const DVec3 p = cross(d, e2);
  const double determinant = dot(e1, p);
  const DVec3 s = o - a;
  const double u = dot(s, p), v = dot(d, cross(s, e1)), t = dot(e2, cross(s, e1));
  // Coordinates relative to the origin are off by about 8u of the largest; so are edge functions, times the
  // lengths of ray and corners.
  const double reach = length(s) + length(e1) + length(e2);
  const double slack = 16 * 0x1p-24 * length(d) * reach * (length(e1) + length(e2) + 0x1p-24 * reach);
  const double w = determinant - u - v;
  // Edge functions of clearly different signs exclude the triangle, whatever its orientation.
  if (std::min({u, v, w}) < -slack && std::max({u, v, w}) > slack) return;
  if (std::fabs(determinant) <= 64 * slack ||
      (std::min({u, v, w}) <= slack && std::max({u, v, w}) >= -slack)) {
    hit.doubtful = true;
    return;
  }
  const double at = t / determinant;
  const double error = 64 * slack * reach / std::fabs(determinant) / length(d);
  if (std::fabs(at) <= error) hit.doubtful = true;
  if (at <= 0) return;
  if (std::fabs(at - hit.t) <= error + hit.t_error) hit.doubtful = true;
  if (at < hit.t) {
    hit.t = at;
    hit.t_error = error;
  }
}

}  // namespace mlt::test
