// Points on one light as seen from a receiver, by shape: quads about in proportion to the cosine at the
// receiver and to solid angle, triangles uniformly by area, spheres uniformly within the cone of directions
// that they subtend. Densities are by solid angle at the receiver, still without the choice of the light, and
// are 0 when there is no sample (a receiver on the light itself, or in the plane of a polygon).
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

/// Density by solid angle of a point on `area`, at squared distance and cosine on the light, whose density by
/// area is `relative` times the uniform one.
template <class F>
MLT_INLINE F area_pdf_solid_angle(F area, F distance_squared, F cosine, F relative) {
  return density_or_zero(distance_squared * relative, magnitude(cosine) * area);
}

/// Density by solid angle within a cone, uniform.
template <class F>
MLT_INLINE F cone_pdf_solid_angle(F one_minus_cos_max) {
  return density_or_zero(broadcast_to<F>(1.0f), 2.0f * kPi * one_minus_cos_max);
}

/// Completes a sample at `point` of a surface with this normal, of `relative` times the uniform density.
template <class F>
MLT_INLINE LightSampleOf<F> area_sample(const LightOf<F>& light, const Vec3Of<F>& reference,
                                        const Vec3Of<F>& point, const Vec3Of<F>& normal, F relative) {
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
  sample.pdf_solid_angle = area_pdf_solid_angle(light.area, distance_squared, cosine, relative);
  return select(is_apart, sample, LightSampleOf<F>{});
}

/// What a corner of a quad contributes, on the scale of all of them: cosine at the receiver and cosine on the
/// light over squared distance are the distances from both planes over the fourth power of their own, and the
/// one from the light's plane is common to all corners. A sixteenth of the light's area bounds what a corner
/// close to the receiver, which the points around it do not follow, may have.
template <class F>
MLT_INLINE F corner_weight(const ReceiverOf<F>& receiver, const Vec3Of<F>& to_corner, F area) {
  const F height = dot(receiver.normal, to_corner);
  const F nearness = area / nonzero(area > 0x1p-100f, dot(to_corner, to_corner) + 0.0625f * area);
  const F weight = height * (nearness * nearness);
  return select(weight > 0.0f, weight, F{});
}

/// Density on a quad relative to the uniform one, bilinear between its corners [Hart20]. Inline: the light's
/// fields, one register each, would otherwise be written to memory for the call.
template <class F>
struct QuadDensity {
  F at_00, at_10, at_01, at_11;  ///< 4 in all; at_10 is at the end of edge_u

  /// Uniform where no corner counts.
  MLT_INLINE QuadDensity(const LightOf<F>& light, const ReceiverOf<F>& receiver) {
    const Vec3Of<F> near_u = light.origin - receiver.position;
    const Vec3Of<F> far_u = near_u + light.edge_u;
    const F w_00 = corner_weight<F>(receiver, near_u, light.area);
    const F w_10 = corner_weight<F>(receiver, far_u, light.area);
    const F w_01 = corner_weight<F>(receiver, near_u + light.edge_v, light.area);
    const F w_11 = corner_weight<F>(receiver, far_u + light.edge_v, light.area);
    const F sum = (w_00 + w_10) + (w_01 + w_11);
    const MaskOf<F> counts = sum > 0x1p-100f;
    const F scale = 4.0f / nonzero(counts, sum);
    const F one = broadcast_to<F>(1.0f);
    at_00 = select(counts, w_00 * scale, one);
    at_10 = select(counts, w_10 * scale, one);
    at_01 = select(counts, w_01 * scale, one);
    at_11 = select(counts, w_11 * scale, one);
  }
  MLT_INLINE F at(const Vec2Of<F>& along) const {
    const F at_0 = at_00 + along.y * (at_01 - at_00);
    const F at_1 = at_10 + along.y * (at_11 - at_10);
    return at_0 + along.x * (at_1 - at_0);
  }
  MLT_INLINE Vec2Of<F> sample(const Vec2Of<F>& u) const {
    const F y = linear_density<F>(u.y, at_00 + at_10, at_01 + at_11);
    return {linear_density<F>(u.x, at_00 + y * (at_01 - at_00), at_10 + y * (at_11 - at_10)), y};
  }
};

template <class F>
MLT_INLINE LightSampleOf<F> sample_polygon_light(const LightOf<F>& light, MaskOf<F> is_triangle,
                                                 const ReceiverOf<F>& receiver, const Vec2Of<F>& u,
                                                 MaskOf<F> active) {
  Vec2Of<F> along = u;
  F relative = broadcast_to<F>(1.0f);
  if (any(active & not_in(is_triangle))) {
    const QuadDensity<F> density(light, receiver);
    along = density.sample(u);
    relative = density.at(along);
  }
  if (any(active & is_triangle)) {
    const Vec3Of<F> barycentric = uniform_triangle<F>(u);
    along =
        Vec2Of<F>{select(is_triangle, barycentric.x, along.x), select(is_triangle, barycentric.y, along.y)};
    relative = select(is_triangle, broadcast_to<F>(1.0f), relative);
  }
  const Vec3Of<F> point = light.origin + (light.edge_u * along.x + light.edge_v * along.y);
  return area_sample<F>(light, receiver.position, point, light.normal, relative);
}

/// The density of sample_polygon_light at `position` relative to the uniform one.
template <class F>
MLT_INLINE F relative_polygon_density(const LightOf<F>& light, MaskOf<F> is_triangle,
                                      const ReceiverOf<F>& receiver, const Vec3Of<F>& position,
                                      MaskOf<F> active) {
  const F one = broadcast_to<F>(1.0f);
  if (!any(active & not_in(is_triangle))) return one;
  // Areas between the point and an edge tell how far it is along the other edge; either sign of the normal
  // will do.
  const Vec3Of<F> to_point = position - light.origin;
  const F area = nonzero(light.area > 0.0f, light.area);
  const F along_u = magnitude(dot(light.normal, cross(to_point, light.edge_v))) / area;
  const F along_v = magnitude(dot(light.normal, cross(light.edge_u, to_point))) / area;
  const Vec2Of<F> along{select(along_u < 1.0f, along_u, one), select(along_v < 1.0f, along_v, one)};
  return select(is_triangle, one, QuadDensity<F>(light, receiver).at(along));
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
        area_sample<F>(light, reference, light.origin + normal * light.radius, normal, broadcast_to<F>(1.0f));
    sample = select(cone.is_outside, sample, inside);
  }
  return sample;
}

/// Nothing is known of lanes outside `active`.
template <class F = float>
MLT_INLINE LightSampleOf<F> sample_one_light(const std::type_identity_t<LightRefOf<F>>& light,
                                             const std::type_identity_t<ReceiverOf<F>>& receiver,
                                             const Vec2Of<F>& u, MaskOf<F> active = not_in(MaskOf<F>{})) {
  LightSampleOf<F> sample;
  const MaskOf<F> is_sphere = light.is(LightShape::kSphere);
  if (any(active & not_in(is_sphere))) {
    sample = sample_polygon_light<F>(light.load(), light.is(LightShape::kTriangle), receiver, u,
                                     active & not_in(is_sphere));
  }
  if (const MaskOf<F> mask = active & is_sphere; any(mask)) {
    sample = select(mask, sample_sphere_light<F>(light.load(), receiver.position, u, mask), sample);
  }
  return sample;
}

/// The density of sample_one_light at `position`, which lies on the light in the unit direction wi. Nothing
/// is known of lanes outside `active`.
template <class F = float>
MLT_INLINE F one_light_pdf_solid_angle(const std::type_identity_t<LightRefOf<F>>& light_ref,
                                       const std::type_identity_t<ReceiverOf<F>>& receiver,
                                       const Vec3Of<F>& position, const Vec3Of<F>& wi,
                                       MaskOf<F> active = not_in(MaskOf<F>{})) {
  const Vec3Of<F> to_light = position - receiver.position;
  const F distance_squared = dot(to_light, to_light);
  const MaskOf<F> is_sphere = light_ref.is(LightShape::kSphere);
  F pdf{};
  if (const MaskOf<F> mask = active & not_in(is_sphere); any(mask)) {
    const LightOf<F> light = light_ref.load();
    const F relative =
        relative_polygon_density<F>(light, light_ref.is(LightShape::kTriangle), receiver, position, mask);
    pdf = area_pdf_solid_angle(light.area, distance_squared, dot(light.normal, wi), relative);
  }
  if (const MaskOf<F> mask = active & is_sphere; any(mask)) {
    const LightOf<F> light = light_ref.load();
    const SphereCone<F> cone = sphere_cone<F>(light, receiver.position);
    // The cosine is this product over the radius, which may be 0 for a light that is never chosen.
    const F cosine_radius = magnitude(dot(position - light.origin, wi));
    const F inside = density_or_zero(distance_squared * light.radius, cosine_radius * light.area);
    const F seen = select(cone.is_outside, cone_pdf_solid_angle(cone.one_minus_cos_max), inside);
    pdf = select(mask, seen, pdf);
  }
  return pdf;
}

}  // namespace mlt
