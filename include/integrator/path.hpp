// Unidirectional path tracing as a function of a primary-sample vector: next-event estimation and BSDF
// sampling, combined by the power heuristic [Veach97 section 9.2.4]. Depth counts path edges from camera to
// light. The same code serves the path tracer and, driven by a Metropolis chain, PSSMLT. One path yields one
// splat; the sink interface allows any number, at any pixel, for integrators to come.
#pragma once

#include <cstdint>

#include "integrator/features.hpp"
#include "integrator/splat.hpp"
#include "light/light_table.hpp"
#include "material/bsdf.hpp"
#include "math/vec.hpp"
#include "world/world.hpp"

namespace mlt {

struct PathSettings {
  std::uint32_t depth = 1;     ///< maximal number of path edges
  std::uint32_t roulette = 0;  ///< first edge after which roulette may end paths; read with the feature only
};

/// Veach's power heuristic with exponent 2, as a ratio: squares of densities would over- and underflow.
inline float power_heuristic(float pdf, float other_pdf) {
  const float ratio = other_pdf / pdf;
  return 1.0f / (1.0f + ratio * ratio);
}

template <FeatureMask kFeatures>
class PathIntegrator {
  static constexpr bool kGeneralGeometry = has(kFeatures, FeatureBit::general_geometry);
  static constexpr bool kDiffuseOnly = !has(kFeatures, FeatureBit::general_materials);
  static constexpr bool kLobeChoice = has(kFeatures, FeatureBit::lobe_choice);
  static constexpr bool kManyLights = has(kFeatures, FeatureBit::many_lights);
  static constexpr bool kRoulette = has(kFeatures, FeatureBit::roulette);

  static constexpr std::uint32_t kLightSamples = 2 + (kManyLights ? 1 : 0);
  static constexpr std::uint32_t kBsdfSamples = 2 + (kLobeChoice ? 1 : 0);

 public:
  static constexpr std::uint32_t kMaxSplats = 1;

  PathIntegrator(const World& world, const PathSettings& settings) : world_(world), settings_(settings) {}

  /// Primary samples that a path may consume: two for the film, then light, BSDF and roulette for each of the
  /// depth - 1 vertices that can scatter.
  static constexpr std::uint32_t primary_sample_capacity(std::uint32_t depth) {
    return 2 + (depth - 1) * (kLightSamples + kBsdfSamples + (kRoulette ? 1 : 0));
  }

  /// Evaluates one path; calls sink(Splat) once. The value may be zero.
  template <class Sampler, class Sink>
  void evaluate(Sampler& sampler, Sink&& sink) const {
    const std::uint32_t sample_x = sampler.next_fixed();
    const std::uint32_t sample_y = sampler.next_fixed();
    const FilmPosition film = world_.camera.film_position(sample_x, sample_y);
    const Ray ray{world_.camera.eye, world_.camera.direction(film), kInfinity};
    sink(Splat{film.y * world_.camera.width + film.x, trace(sampler, ray)});
  }

 private:
  static constexpr float kInfinity = __builtin_inff();
  static constexpr float kMinSurvival = 0.05f;

  /// What the next hit of a light must know of the vertex before it.
  struct Arrival {
    Vec3 from{0, 0, 0};
    float pdf_solid_angle = 0;
    bool is_delta = true;  ///< light sampling could not have produced this edge
  };

  template <class Sampler>
  Vec3 trace(Sampler& sampler, Ray ray) const {
    Vec3 radiance{0, 0, 0};
    Vec3 throughput{1, 1, 1};
    Arrival arrival;
    float eta_scale = 1;
    for (std::uint32_t edge = 1;; ++edge) {
      const Hit hit = world_.geometry.template intersect<kGeneralGeometry>(ray);
      if (!hit.found()) return radiance;
      const SurfacePoint point = world_.geometry.template surface_point<kGeneralGeometry>(ray, hit);
      const PrimitiveRecord primitive = world_.primitives[hit.primitive];
      if (primitive.light != kNoLight) {
        radiance += throughput * emitted(primitive.light, point, ray.direction, arrival);
      }
      if (edge == settings_.depth) return radiance;

      const Material& material = world_.materials[primitive.material];
      const Frame frame(point.normal);
      const Vec3 wo = frame.to_local(-ray.direction);
      if (kDiffuseOnly || !material.is_delta()) {
        radiance += throughput * direct_light(sampler, material, frame, point, wo);
      } else {
        sampler.skip(kLightSamples);
      }

      const float u_lobe = kLobeChoice ? sampler.next() : 0.0f;
      const BsdfSample bsdf = sample_bsdf<kDiffuseOnly>(material, wo, u_lobe, sampler.next_2d());
      throughput *= bsdf.weight;
      if (is_zero(throughput)) return radiance;
      if constexpr (kRoulette) {
        eta_scale *= bsdf.eta_scale;
        if (!survives(sampler, edge, eta_scale, throughput)) return radiance;
      }
      arrival = Arrival{point.position, bsdf.pdf_solid_angle, bsdf.is_delta};
      const Vec3 direction = frame.to_world(bsdf.wi);
      ray = Ray{point.origin_towards(direction), direction, kInfinity};
    }
  }

  /// Radiance emitted against the ray, weighted against light sampling from the vertex before.
  Vec3 emitted(std::uint32_t light_index, const SurfacePoint& point, const Vec3& direction,
               const Arrival& arrival) const {
    if (dot(direction, point.normal) >= 0.0f) return Vec3{0, 0, 0};
    const Vec3 radiance = world_.lights.lights[light_index].radiance;
    if (arrival.is_delta) return radiance;
    const float pdf_light =
        light_pdf_solid_angle(world_.lights, light_index, arrival.from, point.position, direction);
    return radiance * power_heuristic(arrival.pdf_solid_angle, pdf_light);
  }

  /// Next-event estimation: one point on one light, weighted against BSDF sampling.
  template <class Sampler>
  Vec3 direct_light(Sampler& sampler, const Material& material, const Frame& frame, const SurfacePoint& point,
                    const Vec3& wo) const {
    const float u_choice = kManyLights ? sampler.next() : 0.0f;
    const LightSample light =
        sample_light<kManyLights>(world_.lights, point.position, u_choice, sampler.next_2d());
    if (!(light.pdf_solid_angle > 0.0f) || is_zero(light.radiance)) return Vec3{0, 0, 0};
    const BsdfValue bsdf = evaluate_bsdf<kDiffuseOnly>(material, wo, frame.to_local(light.direction));
    if (is_zero(bsdf.f_cos)) return Vec3{0, 0, 0};
    const Vec3 origin = point.origin_towards(light.direction);
    const Ray segment{origin, light.position - origin, 1.0f};
    if (world_.geometry.template occluded<kGeneralGeometry>(segment)) return Vec3{0, 0, 0};
    const float weight = power_heuristic(light.pdf_solid_angle, bsdf.pdf_solid_angle) / light.pdf_solid_angle;
    return bsdf.f_cos * light.radiance * weight;
  }

  /// Russian roulette: ends the path with the probability that its throughput, less the squeezing of radiance
  /// in denser media, falls short of 1.
  template <class Sampler>
  bool survives(Sampler& sampler, std::uint32_t edge, float eta_scale, Vec3& throughput) const {
    const float u = sampler.next();
    if (edge < settings_.roulette) return true;
    const float wanted = max_component(throughput) * eta_scale;
    if (!(wanted < 1.0f)) return true;
    const float survival = wanted > kMinSurvival ? wanted : kMinSurvival;
    if (u >= survival) return false;
    throughput *= 1.0f / survival;
    return true;
  }

  const World& world_;
  PathSettings settings_;
};

}  // namespace mlt
