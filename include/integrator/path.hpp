// Unidirectional path tracing as a function of a primary-sample vector: next-event estimation and BSDF
// sampling, combined by the power heuristic [Veach97 section 9.2.4]. Depth counts path edges from camera to
// light. The same code serves the path tracer and, driven by a Metropolis chain, PSSMLT. One path yields one
// splat; the sink interface allows any number, at any pixel, for integrators to come.
#pragma once

#include <cstdint>

#include "integrator/features.hpp"
#include "integrator/light_terms.hpp"
#include "integrator/sampler.hpp"
#include "integrator/splat.hpp"
#include "light/light_table.hpp"
#include "material/bsdf.hpp"
#include "math/gather.hpp"
#include "math/vec.hpp"
#include "world/world.hpp"

namespace mlt {

struct PathSettings {
  std::uint32_t depth = 1;     ///< maximal number of path edges
  std::uint32_t roulette = 0;  ///< first edge after which roulette may end paths; read with the feature only
};

/// Veach's power heuristic with exponent 2, as a ratio: squares of densities would over- and underflow.
template <class F>
MLT_INLINE F power_heuristic(F pdf, F other_pdf) {
  const F ratio = other_pdf / pdf;
  return 1.0f / (1.0f + ratio * ratio);
}

/// As many paths at once as F has lanes, edge by edge; a path that ends leaves its lane idle until all have.
template <FeatureMask kFeatures, class F = float>
class PathIntegrator {
  static constexpr bool kGeneralGeometry = has(kFeatures, FeatureBit::general_geometry);
  static constexpr bool kDiffuseOnly = !has(kFeatures, FeatureBit::general_materials);
  static constexpr bool kLobeChoice = has(kFeatures, FeatureBit::lobe_choice);
  static constexpr bool kManyLights = has(kFeatures, FeatureBit::many_lights);
  static constexpr bool kRoulette = has(kFeatures, FeatureBit::roulette);

  static constexpr std::uint32_t kLightSamples = 2 + (kManyLights ? 1 : 0);
  static constexpr std::uint32_t kBsdfSamples = 2 + (kLobeChoice ? 1 : 0);

  using V = Vec3Of<F>;
  using M = MaskOf<F>;

 public:
  using Float = F;
  static constexpr std::uint32_t kMaxSplats = 1;

  PathIntegrator(const World& world, const PathSettings& settings) : world_(world), settings_(settings) {}

  /// Primary samples that a path may consume: two for the film, then light, BSDF and roulette for each of the
  /// depth - 1 vertices that can scatter.
  static constexpr std::uint32_t primary_sample_capacity(std::uint32_t depth) {
    return 2 + (depth - 1) * (kLightSamples + kBsdfSamples + (kRoulette ? 1 : 0));
  }

  /// What the next hit of a light must know of the vertex before it.
  struct Arrival {
    ReceiverOf<F> from{V{F{}, F{}, F{}}};
    F pdf_solid_angle{};
    M is_delta = not_in(M{});  ///< light sampling could not have produced this edge
  };

  /// Paths on their way, of as many edges all.
  struct Paths {
    UintOf<F> pixel;
    RayOf<F> ray;               ///< the next edge
    M active;                   ///< those that go on
    V radiance{F{}, F{}, F{}};  ///< gathered so far
    V throughput = V{broadcast_to<F>(1), broadcast_to<F>(1), broadcast_to<F>(1)};
    Arrival arrival{};
    F eta_scale = broadcast_to<F>(1);
    UintOf<F> leaves = broadcast_bits<UintOf<F>>(kNoPrimitive);

    /// Gives a lane's path to an idle lane of paths that have come as far.
    void move_lane(int lane, Paths& to, int to_lane) {
      const auto move = [&](const auto& value, auto& place) {
        set_lane_of(place, to_lane, lane_of(value, lane));
      };
      move(pixel, to.pixel);
      move(ray.origin, to.ray.origin);
      move(ray.direction, to.ray.direction);
      move(radiance, to.radiance);
      move(throughput, to.throughput);
      move(arrival.from.position, to.arrival.from.position);
      move(arrival.from.normal, to.arrival.from.normal);
      move(arrival.pdf_solid_angle, to.arrival.pdf_solid_angle);
      move(arrival.is_delta, to.arrival.is_delta);
      move(eta_scale, to.eta_scale);
      move(leaves, to.leaves);
      set_lane_of(to.active, to_lane, kLaneTrue<F>);
      set_lane_of(active, lane, 0);
    }
  };

  /// Evaluates one path in each lane of `active`; calls sink(SplatOf<F>, active) once. Values may be zero.
  /// A sink with expect(pixels, active) is told before tracing where they will be splatted.
  template <class Sampler, class Sink>
  void evaluate(Sampler& sampler, Sink&& sink, M active = not_in(M{})) const {
    Paths paths = begin(sampler, active);
    if constexpr (requires { sink.expect(paths.pixel, active); }) sink.expect(paths.pixel, active);
    sink(SplatOf<F>{paths.pixel, trace(sampler, paths)}, active);
  }

  /// Paths without an edge.
  template <class Sampler>
  MLT_INLINE Paths begin(Sampler& sampler, M active) const {
    const UintOf<F> sample_x = sampler.next_fixed(active);
    const UintOf<F> sample_y = sampler.next_fixed(active);
    const FilmPositionOf<F> film = world_.camera.film_position<F>(sample_x, sample_y);
    return {
        film.y * world_.camera.width + film.x,
        {broadcast_to<F>(world_.camera.eye), world_.camera.direction<F>(film), broadcast_to<F>(kInfinity)},
        active};
  }

  using Terms = LightTerms<kGeneralGeometry, F>;
  Terms terms() const { return Terms(world_.geometry); }

  /// Adds edge number `edge`, counted from 1. The radiance that it brings is `terms` to add.
  template <class Sampler>
  MLT_INLINE void advance(Sampler& sampler, std::uint32_t edge, Paths& paths, Terms& terms) const {
    terms.begin_edge();
    M& active = paths.active;
    const RayOf<F>& ray = paths.ray;
    const HitOf<F> hit = world_.geometry.template intersect_lanes<kGeneralGeometry, F>(
        ray, paths.leaves, active, world_.primitives.data());
    active &= hit.found();
    if (!any(active)) return;
    const SurfacePointOf<F> point =
        world_.geometry.template surface_points<kGeneralGeometry, F>(ray, hit, active);
    const UintOf<F> primitive = select(active, hit.primitive, UintOf<F>{}) * kPrimitiveBytes;
    const UintOf<F> light = light_on(hit.primitive, primitive);
    if (const M lit = active & (light != kNoLight); any(lit)) {
      const V gathered = paths.throughput *
                         emitted(select(lit, light, UintOf<F>{}), point, ray.direction, paths.arrival, lit);
      terms.add(paths.radiance, gathered, lit);
    }
    if (edge == settings_.depth) {
      active = M{};
      return;
    }
    scatter(sampler, edge, point, hit.primitive, primitive, paths, terms);
  }

 private:
  static constexpr float kInfinity = __builtin_inff();
  static constexpr float kMinSurvival = 0.05f;

  template <class Sampler>
  MLT_NOINLINE V trace(Sampler& sampler, Paths& paths) const {
    Terms terms = this->terms();
    for (std::uint32_t edge = 1; any(paths.active); ++edge) advance(sampler, edge, paths, terms);
    terms.finish();
    return paths.radiance;
  }

  /// The number of the light on a primitive whose record lies at `offset`, or kNoLight.
  MLT_INLINE UintOf<F> light_on(const UintOf<F>& primitive, const UintOf<F>& offset) const {
    using U = UintOf<F>;
    if constexpr (kManyLights) return gather_bytes<F>(&world_.primitives[0].light, offset);
    if (world_.lights.lights.empty()) return broadcast_bits<U>(kNoLight);
    return select(primitive == world_.lights.lights[0].primitive, U{}, broadcast_bits<U>(kNoLight));
  }

  /// Light sampling at the points hit, and the direction of the next edge. What the next edge needs is
  /// written where it stays: in lanes each component of a copy is a register to be stored and loaded.
  template <class Sampler>
  MLT_INLINE void scatter(Sampler& sampler, std::uint32_t edge, const SurfacePointOf<F>& point,
                          const UintOf<F>& hit, UintOf<F> primitive_offset, Paths& paths,
                          Terms& terms) const {
    M& active = paths.active;
    const MaterialRefOf<F> material_ref(world_.materials.data(),
                                        gather_bytes<F>(&world_.primitives[0].material, primitive_offset));
    const auto material = scatterer<kDiffuseOnly>(material_ref);
    const FrameOf<F> frame(point.normal);
    const V wo = frame.to_local(-paths.ray.direction);
    // Materials that light is sampled for gather it on the side that is looked at.
    ReceiverOf<F>& receiver = paths.arrival.from;
    receiver.position = point.position;
    receiver.normal = select(wo.z < 0.0f, -point.normal, point.normal);
    const M rough = kDiffuseOnly ? active : M(active & not_in(material_ref.is_delta()));
    const VertexSamples<F> samples = sampler.template next_vertex<kManyLights, kLobeChoice>(rough, active);
    if (any(rough))
      direct_light(samples, material, Vertex{point, frame, wo, hit, receiver}, rough, paths, terms);
    const BsdfSampleOf<F> bsdf =
        sample_bsdf<kDiffuseOnly, F>(material, wo, samples.lobe, samples.bsdf, active);
    paths.throughput *= bsdf.weight;
    active &= not_in(is_zero<F>(paths.throughput));
    if (!any(active)) return;
    if constexpr (kRoulette) {
      paths.eta_scale *= bsdf.eta_scale;
      active &= survives(sampler, edge, paths.eta_scale, paths.throughput, active);
      if (!any(active)) return;
    }
    paths.arrival.pdf_solid_angle = bsdf.pdf_solid_angle;
    paths.arrival.is_delta = bsdf.is_delta;
    paths.leaves = hit;
    paths.ray.direction = frame.to_world(bsdf.wi);
    paths.ray.origin = point.origin_towards(paths.ray.direction);
    // The last edge brings nothing unless it ends on a light.
    if (edge + 1 == settings_.depth) active &= world_.light_box.may_be_met_by<F>(paths.ray);
  }

  /// Radiance emitted against the ray in the lanes of `lit`, weighted against light sampling from the vertex
  /// before.
  MLT_INLINE V emitted(UintOf<F> light_index, const SurfacePointOf<F>& point, const V& direction,
                       const Arrival& arrival, M lit) const {
    const M is_front = dot(direction, point.normal) < 0.0f;
    const LightRefOf<F> light = light_of<kManyLights, F>(world_.lights, light_index);
    const V radiance = select(is_front, light.load().radiance, V{F{}, F{}, F{}});
    const M weighted = lit & is_front & not_in(arrival.is_delta);
    if (!any(weighted)) return radiance;
    const F pdf_light = light_pdf_solid_angle<kManyLights, F>(world_.lights, light_index, arrival.from,
                                                              point.position, direction, weighted);
    const F weight = power_heuristic(nonzero(weighted, arrival.pdf_solid_angle), pdf_light);
    return select(weighted, radiance * weight, radiance);
  }

  /// Where the light that paths scatter is gathered.
  struct Vertex {
    const SurfacePointOf<F>& point;
    const FrameOf<F>& frame;
    const V& wo;
    const UintOf<F>& primitive;
    const ReceiverOf<F>& receiver;
  };

  /// Next-event estimation: one point on one light for each lane of `active`, weighted against BSDF sampling.
  MLT_INLINE void direct_light(const VertexSamples<F>& samples, const ScattererOf<kDiffuseOnly, F>& material,
                               const Vertex& vertex, M active, Paths& paths, Terms& terms) const {
    const LightSampleOf<F> light = sample_light<kManyLights, F>(world_.lights, vertex.receiver,
                                                                samples.light_choice, samples.light, active);
    M seen = active & (light.pdf_solid_angle > 0.0f) & not_in(is_zero<F>(light.radiance));
    if (!any(seen)) return;
    const BsdfValueOf<F> bsdf =
        evaluate_bsdf<kDiffuseOnly, F>(material, vertex.wo, vertex.frame.to_local(light.direction), seen);
    seen &= not_in(is_zero<F>(bsdf.f_cos));
    if (!any(seen)) return;
    const V origin = vertex.point.origin_towards(light.direction);
    const RayOf<F> segment{origin, light.position - origin, broadcast_to<F>(1.0f)};
    const auto target = light_of<kManyLights, F>(world_.lights, select(seen, light.light, UintOf<F>{}));
    const SegmentEnds<F> ends{vertex.primitive, target.primitive()};
    const F pdf = nonzero(seen, light.pdf_solid_angle);
    const F weight = power_heuristic(pdf, bsdf.pdf_solid_angle) / pdf;
    terms.add_if_free(paths.radiance, paths.throughput * (bsdf.f_cos * light.radiance * weight), segment,
                      ends, seen);
  }

  /// Russian roulette: ends paths with the probability that their throughput, less the squeezing of radiance
  /// in denser media, falls short of 1.
  template <class Sampler>
  MLT_INLINE M survives(Sampler& sampler, std::uint32_t edge, F eta_scale, V& throughput, M active) const {
    const F u = sampler.next(active);
    if (edge < settings_.roulette) return active;
    const F wanted = max_component<F>(throughput) * eta_scale;
    const M at_risk = wanted < 1.0f;
    const F survival = larger(wanted, broadcast_to<F>(kMinSurvival));
    throughput = select(at_risk, throughput * (1.0f / survival), throughput);
    return not_in(M(at_risk & (u >= survival)));
  }

  static constexpr auto kPrimitiveBytes = static_cast<std::uint32_t>(sizeof(PrimitiveRecord));

  const World& world_;
  PathSettings settings_;
};

}  // namespace mlt
