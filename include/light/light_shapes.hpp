// Points on one light as seen from a reference point, by shape: polygons uniformly by area, spheres uniformly
// within the cone of directions that they subtend. Densities are by solid angle at the reference point, still
// without the choice of the light, and are 0 when there is no sample (a reference point on the light itself,
// or in the plane of a polygon).
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "light/light.hpp"
#include "math/elementary.hpp"
#include "math/vec.hpp"
#include "math/warp.hpp"

namespace mlt {

/// Shadow segments end before the light by offset_bound plus this fraction of their length: 16 units in the
/// last place, because an intersection's rounding error grows with the distance of the shape from the ray's
/// origin.
inline constexpr float kOffsetPerDistance = 0x1p-20f;

/// numerator / denominator as a density, or 0 ("no sample") where that is no positive finite number.
inline float density_or_zero(float numerator, float denominator) {
  if (!(denominator > 0.0f)) return 0.0f;
  const float pdf = numerator / denominator;
  return pdf <= std::numeric_limits<float>::max() ? pdf : 0.0f;
}

/// Density by solid angle of a point chosen uniformly on `area`, at squared distance and cosine on the light.
inline float area_pdf_solid_angle(float area, float distance_squared, float cosine) {
  return density_or_zero(distance_squared, std::fabs(cosine) * area);
}

/// Density by solid angle within a cone, uniform.
inline float cone_pdf_solid_angle(float one_minus_cos_max) {
  return density_or_zero(1.0f, 2.0f * kPi * one_minus_cos_max);
}

/// Completes a sample at `point` of a surface with this normal, uniform by area.
inline LightSample area_sample(const Light& light, const Vec3& reference, const Vec3& point,
                               const Vec3& normal) {
  const Vec3 to_light = point - reference;
  const float distance_squared = dot(to_light, to_light);
  if (!(distance_squared > 0.0f)) return {};
  const float distance = std::sqrt(distance_squared);
  LightSample sample;
  sample.direction = to_light * (1.0f / distance);
  const float cosine = dot(normal, sample.direction);
  const float offset = light.offset_bound + kOffsetPerDistance * distance;
  sample.position = point + normal * (cosine < 0.0f ? offset : -offset);
  sample.radiance = emitted_radiance(light, normal, sample.direction);
  sample.pdf_solid_angle = area_pdf_solid_angle(light.area, distance_squared, cosine);
  return sample;
}

inline LightSample sample_polygon_light(const Light& light, const Vec3& reference, const Vec2& u) {
  Vec2 along = u;
  if (light.shape == LightShape::kTriangle) {
    const Vec3 barycentric = uniform_triangle(u);
    along = Vec2{barycentric.x, barycentric.y};
  }
  const Vec3 point = light.origin + (light.edge_u * along.x + light.edge_v * along.y);
  return area_sample(light, reference, point, light.normal);
}

/// What a sphere subtends from outside. `sin_squared` is in (0,1) for the half angle of the cone.
struct SphereCone {
  Vec3 axis{0, 0, 1};  ///< unit, reference to centre
  float distance = 0;  ///< reference to centre
  float sin_squared = 0;
  float one_minus_cos_max = 0;
};

/// False when the reference point is not outside the sphere; the cone is then undefined.
inline bool sphere_cone(const Light& light, const Vec3& reference, SphereCone& cone) {
  const Vec3 to_center = light.origin - reference;
  cone.distance = length(to_center);
  if (!(cone.distance > light.radius)) return false;
  cone.axis = to_center * (1.0f / cone.distance);
  const float sine = light.radius / cone.distance;
  cone.sin_squared = sine * sine;
  cone.one_minus_cos_max = one_minus_cos(cone.sin_squared);
  return true;
}

/// Uniform in the cone; the point is found from the angle that it has at the sphere's centre [Pharr23 section
/// 6.2.4], which keeps it on the sphere where an intersection would lose all digits. All terms are formed
/// from 1 - cos of the small angles.
inline LightSample sample_sphere_cone(const Light& light, const SphereCone& cone, const Vec2& u) {
  float sine_phi = 0, cosine_phi = 0;
  sincos_2pi(u.y, sine_phi, cosine_phi);
  const float depth = u.x * cone.one_minus_cos_max;
  const float sin_theta = std::sqrt(depth * (2.0f - depth));
  const float cos_theta = 1.0f - depth;
  // (sin theta / sin theta_max)^2, without dividing two numbers that underflow for a far sphere.
  const float sin_max = std::sqrt(cone.sin_squared);
  const float cos_max = 1.0f - cone.one_minus_cos_max;
  const float relative = u.x * (2.0f - depth) / (1.0f + cos_max);
  const float relative_squared = relative < 1.0f ? relative : 1.0f;
  const float rim = std::sqrt(1.0f - relative_squared);
  const float cos_alpha = relative_squared * sin_max + cos_theta * rim;
  const float sin_alpha = std::sqrt(relative_squared) * (cos_theta - sin_max * rim);

  const Frame frame(cone.axis);
  const Vec3 normal = frame.to_world(Vec3{sin_alpha * cosine_phi, sin_alpha * sine_phi, -cos_alpha});
  const float offset = light.offset_bound + kOffsetPerDistance * cone.distance;
  LightSample sample;
  sample.position = light.origin + normal * (light.radius + offset);
  sample.direction = frame.to_world(Vec3{sin_theta * cosine_phi, sin_theta * sine_phi, cos_theta});
  sample.radiance = light.radiance;
  sample.pdf_solid_angle = cone_pdf_solid_angle(cone.one_minus_cos_max);
  return sample;
}

inline LightSample sample_sphere_light(const Light& light, const Vec3& reference, const Vec2& u) {
  SphereCone cone;
  if (sphere_cone(light, reference, cone)) return sample_sphere_cone(light, cone, u);
  const Vec3 normal = uniform_sphere(u);
  return area_sample(light, reference, light.origin + normal * light.radius, normal);
}

inline LightSample sample_one_light(const Light& light, const Vec3& reference, const Vec2& u) {
  switch (light.shape) {
    case LightShape::kQuad:
    case LightShape::kTriangle:
      return sample_polygon_light(light, reference, u);
    case LightShape::kSphere:
      return sample_sphere_light(light, reference, u);
  }
  return {};
}

/// The density of sample_one_light at `position`, which lies on the light in the unit direction wi.
inline float one_light_pdf_solid_angle(const Light& light, const Vec3& reference, const Vec3& position,
                                       const Vec3& wi) {
  const Vec3 to_light = position - reference;
  const float distance_squared = dot(to_light, to_light);
  switch (light.shape) {
    case LightShape::kQuad:
    case LightShape::kTriangle:
      return area_pdf_solid_angle(light.area, distance_squared, dot(light.normal, wi));
    case LightShape::kSphere: {
      SphereCone cone;
      if (sphere_cone(light, reference, cone)) {
        return cone_pdf_solid_angle(cone.one_minus_cos_max);
      }
      // The cosine is this product over the radius, which may be 0 for a light that is never chosen.
      const float cosine_radius = std::fabs(dot(position - light.origin, wi));
      return density_or_zero(distance_squared * light.radius, cosine_radius * light.area);
    }
  }
  return 0;
}

}  // namespace mlt
