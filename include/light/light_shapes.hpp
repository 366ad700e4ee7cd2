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
template <class F>
MLT_INLINE F density_or_zero(F numerator, F denominator) {
  const MaskOf<F> is_positive = denominator > 0.0f;
  const F pdf = numerator / nonzero(is_positive, denominator);
  return select(is_positive & (pdf <= std::numeric_limits<float>::max()), pdf, F{});
}

/// Density by solid angle of a point chosen uniformly on `area`, at squared distance and cosine on the light.
template <class F>
MLT_INLINE F area_pdf_solid_angle(F area, F distance_squared, F cosine) {
  return density_or_zero(distance_squared, magnitude(cosine) * area);
}

/// Density by solid angle within a cone, uniform.
template <class F>
MLT_INLINE F cone_pdf_solid_angle(F one_minus_cos_max) {
  return density_or_zero(broadcast_to<F>(1.0f), 2.0f * kPi * one_minus_cos_max);
}

/// Completes a sample at `point` of a surface with this normal, uniform by area.
template <class F>
MLT_INLINE LightSampleOf<F> area_sample(const LightOf<F>& light, const Vec3Of<F>& reference,
                                        const Vec3Of<F>& point, const Vec3Of<F>& normal) {
  const Vec3Of<F> to_light = point - reference;
  const F distance_squared = dot(to_light, to_light);
  const MaskOf<F> is_apart = distance_squared > 0.0f;
  const F distance = square_root(distance_squared);
  LightSampleOf<F> sample;
  sample.direction = to_light * (1.0f / nonzero(is_apart, distance));
  const F cosine = dot(normal, sample.direction);
  const F offset = light.offset_bound + kOffsetPerDistance * distance;
  sample.position = point + normal * select(cosine < 0.0f, offset, -offset);
  sample.radiance = emitted_radiance<F>(light, normal, sample.direction);
  sample.pdf_solid_angle = area_pdf_solid_angle(light.area, distance_squared, cosine);
  return select(is_apart, sample, LightSampleOf<F>{});
}

template <class F>
MLT_INLINE LightSampleOf<F> sample_polygon_light(const LightOf<F>& light, MaskOf<F> is_triangle,
                                                 const Vec3Of<F>& reference, const Vec2Of<F>& u) {
  Vec2Of<F> along = u;
  if (any(is_triangle)) {
    const Vec3Of<F> barycentric = uniform_triangle<F>(u);
    along = Vec2Of<F>{select(is_triangle, barycentric.x, u.x), select(is_triangle, barycentric.y, u.y)};
  }
  const Vec3Of<F> point = light.origin + (light.edge_u * along.x + light.edge_v * along.y);
  return area_sample<F>(light, reference, point, light.normal);
}

/// What a sphere subtends from outside. `sin_squared` is in (0,1) for the half angle of the cone.
template <class F>
struct SphereCone {
  Vec3Of<F> axis;  ///< unit, reference to centre
  F distance;      ///< reference to centre
  F sin_squared;
  F one_minus_cos_max;
  MaskOf<F> is_outside;  ///< elsewhere the rest is undefined
};

template <class F>
MLT_INLINE SphereCone<F> sphere_cone(const LightOf<F>& light, const Vec3Of<F>& reference) {
  const Vec3Of<F> to_center = light.origin - reference;
  SphereCone<F> cone;
  cone.distance = length(to_center);
  cone.is_outside = cone.distance > light.radius;
  const F distance = nonzero(cone.is_outside, cone.distance);
  cone.axis = to_center * (1.0f / distance);
  const F sine = light.radius / distance;
  cone.sin_squared = select(cone.is_outside, sine * sine, F{});
  cone.one_minus_cos_max = one_minus_cos(cone.sin_squared);
  return cone;
}

/// Uniform in the cone; the point is found from the angle that it has at the sphere's centre [Pharr23 section
/// 6.2.4], which keeps it on the sphere where an intersection would lose all digits. All terms are formed
/// from 1 - cos of the small angles.
template <class F>
MLT_INLINE LightSampleOf<F> sample_sphere_cone(const LightOf<F>& light, const SphereCone<F>& cone,
                                               const Vec2Of<F>& u) {
  F sine_phi{}, cosine_phi{};
  sincos_2pi(u.y, sine_phi, cosine_phi);
  const F depth = u.x * cone.one_minus_cos_max;
  const F sin_theta = square_root(depth * (2.0f - depth));
  const F cos_theta = 1.0f - depth;
  // (sin theta / sin theta_max)^2, without dividing two numbers that underflow for a far sphere.
  const F sin_max = square_root(cone.sin_squared);
  const F cos_max = 1.0f - cone.one_minus_cos_max;
  const F relative = u.x * (2.0f - depth) / (1.0f + cos_max);
  const F relative_squared = select(relative < 1.0f, relative, broadcast_to<F>(1.0f));
  const F rim = square_root(1.0f - relative_squared);
  const F cos_alpha = relative_squared * sin_max + cos_theta * rim;
  const F sin_alpha = square_root(relative_squared) * (cos_theta - sin_max * rim);

  const FrameOf<F> frame(cone.axis);
  const Vec3Of<F> normal =
      frame.to_world(Vec3Of<F>{sin_alpha * cosine_phi, sin_alpha * sine_phi, -cos_alpha});
  const F offset = light.offset_bound + kOffsetPerDistance * cone.distance;
  LightSampleOf<F> sample;
  sample.position = light.origin + normal * (light.radius + offset);
  sample.direction = frame.to_world(Vec3Of<F>{sin_theta * cosine_phi, sin_theta * sine_phi, cos_theta});
  sample.radiance = light.radiance;
  sample.pdf_solid_angle = cone_pdf_solid_angle(cone.one_minus_cos_max);
  return sample;
}

template <class F>
MLT_INLINE LightSampleOf<F> sample_sphere_light(const LightOf<F>& light, const Vec3Of<F>& reference,
                                                const Vec2Of<F>& u, MaskOf<F> active) {
  const SphereCone<F> cone = sphere_cone<F>(light, reference);
  LightSampleOf<F> sample;
  if (any(active & cone.is_outside)) sample = sample_sphere_cone<F>(light, cone, u);
  if (any(active & not_in(cone.is_outside))) {
    const Vec3Of<F> normal = uniform_sphere<F>(u);
    const LightSampleOf<F> inside =
        area_sample<F>(light, reference, light.origin + normal * light.radius, normal);
    sample = select(cone.is_outside, sample, inside);
  }
  return sample;
}

/// Nothing is known of lanes outside `active`.
template <class F = float>
MLT_INLINE LightSampleOf<F> sample_one_light(const std::type_identity_t<LightRefOf<F>>& light,
                                             const Vec3Of<F>& reference, const Vec2Of<F>& u,
                                             MaskOf<F> active = not_in(MaskOf<F>{})) {
  LightSampleOf<F> sample;
  const MaskOf<F> is_sphere = light.is(LightShape::kSphere);
  if (any(active & not_in(is_sphere))) {
    sample = sample_polygon_light<F>(light.load(), light.is(LightShape::kTriangle), reference, u);
  }
  if (const MaskOf<F> mask = active & is_sphere; any(mask)) {
    sample = select(mask, sample_sphere_light<F>(light.load(), reference, u, mask), sample);
  }
  return sample;
}

/// The density of sample_one_light at `position`, which lies on the light in the unit direction wi. Nothing
/// is known of lanes outside `active`.
template <class F = float>
MLT_INLINE F one_light_pdf_solid_angle(const std::type_identity_t<LightRefOf<F>>& light_ref,
                                       const Vec3Of<F>& reference, const Vec3Of<F>& position,
                                       const Vec3Of<F>& wi, MaskOf<F> active = not_in(MaskOf<F>{})) {
  const Vec3Of<F> to_light = position - reference;
  const F distance_squared = dot(to_light, to_light);
  const MaskOf<F> is_sphere = light_ref.is(LightShape::kSphere);
  F pdf{};
  if (any(active & not_in(is_sphere))) {
    const LightOf<F> light = light_ref.load();
    pdf = area_pdf_solid_angle(light.area, distance_squared, dot(light.normal, wi));
  }
  if (const MaskOf<F> mask = active & is_sphere; any(mask)) {
    const LightOf<F> light = light_ref.load();
    const SphereCone<F> cone = sphere_cone<F>(light, reference);
    // The cosine is this product over the radius, which may be 0 for a light that is never chosen.
    const F cosine_radius = magnitude(dot(position - light.origin, wi));
    const F inside = density_or_zero(distance_squared * light.radius, cosine_radius * light.area);
    const F seen = select(cone.is_outside, cone_pdf_solid_angle(cone.one_minus_cos_max), inside);
    pdf = select(mask, seen, pdf);
  }
  return pdf;
}

}  // namespace mlt
