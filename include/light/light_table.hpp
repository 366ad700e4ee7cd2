// All lights of a scene, and the choice among them: of few in proportion to about what they send to the
// receiver when nothing is in the way, of many in proportion to emitted power. The choice takes one primary
// sample when there are several lights (kManyLights) and none otherwise. Memory belongs to the arena.
#pragma once

#include <cstdint>
#include <span>

#include "base/assert.hpp"
#include "light/light.hpp"
#include "light/light_shapes.hpp"
#include "math/vec.hpp"

namespace mlt {

struct LightTable {
  std::span<const Light> lights;
  /// Upper end of each light's interval of [0,1), ascending, multiples of 2^-24: as primary samples are such
  /// multiples too, the probability of a choice is exactly the length of its interval.
  std::span<const float> cdf;
};

/// Most lights of positive power that a table can hold: each has an interval of at least 2^-24.
inline constexpr std::uint32_t kMaxLights = 1U << 22;

/// Emitted power by luminance in W: pi * area * luminance(radiance); 0 for a light without area.
double light_power(const Light& light);

/// Sets each light's choice probability and fills `cdf` (of equal length). Each of n lights of positive power
/// gets a share of 2^-24 and a part of the remaining 1 - n 2^-24 in proportion to its power, rounded to a
/// multiple of 2^-24; a light of zero power gets 0. Returns the table of both spans. Throws ResourceError for
/// n > kMaxLights. Sums run in index order.
LightTable build_light_table(std::span<Light> lights, std::span<float> cdf);

/// Index of the light whose interval holds u in [0,1); the number of lights when none has power.
inline std::uint32_t choose_light(std::span<const float> cdf, float u) {
  std::uint32_t first = 0;
  std::uint32_t count = static_cast<std::uint32_t>(cdf.size());
  while (count > 0) {
    const std::uint32_t half = count / 2;
    // The first interval whose end lies above u: an empty interval is never chosen.
    if (cdf[first + half] <= u) {
      first += half + 1;
      count -= half + 1;
    } else {
      count = half;
    }
  }
  return first;
}

/// Tables of more lights are chosen from by power alone, for the weights of all would take longer than a
/// path.
inline constexpr std::uint32_t kMaxWeighedLights = 128;

/// The part of the choice that is by power also where lights are weighed, since nothing is known of what is
/// in a light's way.
inline constexpr float kPowerPart = 0.0625f;

/// About the light that arrives from a light, up to a common factor: power times the cosines on both sides
/// over squared distance, for its middle, none of them less than its size allows. 0 from behind, and where
/// the receiver has no normal.
template <class F>
MLT_INLINE F light_weight(const Light& light, const ReceiverOf<F>& receiver, MaskOf<F> has_normal) {
  const float part = light.shape == LightShape::kTriangle ? 1.0f / 3.0f : 0.5f;
  const Vec3 middle = light.origin + (light.edge_u + light.edge_v) * part;
  const Vec3Of<F> to_light = broadcast_to<F>(middle) - receiver.position;
  const F distance_squared = dot(to_light, to_light) + light.radius * light.radius;
  const MaskOf<F> is_apart = distance_squared > 0x1p-100f;
  const F inverse = 1.0f / nonzero(is_apart, distance_squared);
  const F above = dot(receiver.normal, to_light) + light.radius;
  F before{};
  if (light.shape == LightShape::kSphere) {
    // The same power in four times the solid angle of a polygon's cosine.
    before = 0.25f * square_root(distance_squared);
  } else {
    const F height = dot(broadcast_to<F>(light.normal), to_light);
    before = select(height < 0.0f, light.radius - height, F{});
  }
  const F weight = (above * inverse) * (before * inverse) * light.choice_probability;
  return select(has_normal & is_apart & (weight > 0.0f), weight, F{});
}

/// Factors of weights and of shares of power in the probabilities of lights.
template <class F>
struct LightChoice {
  F of_weight, of_power;

  explicit LightChoice(F total) {
    const MaskOf<F> counts = total > 0x1p-100f;
    of_weight = select(counts, (1.0f - kPowerPart) / nonzero(counts, total), F{});
    of_power = select(counts, broadcast_to<F>(kPowerPart), broadcast_to<F>(1.0f));
  }
  MLT_INLINE F probability(F weight, F power) const { return weight * of_weight + power * of_power; }
};

/// Chooses one of at most kMaxWeighedLights for each lane; its index, or their number where there is none,
/// and its probability.
template <class F>
MLT_NOINLINE UintOf<F> choose_weighed_light(const LightTable& table, const ReceiverOf<F>& receiver,
                                            const F& u, F& probability) {
  const auto count = static_cast<std::uint32_t>(table.lights.size());
  MLT_CHECK_OP(count, <=, kMaxWeighedLights);
  const MaskOf<F> has_normal = not_in(is_zero<F>(receiver.normal));
  F weights[kMaxWeighedLights];
  F total{};
  for (std::uint32_t i = 0; i < count; ++i) {
    weights[i] = light_weight<F>(table.lights[i], receiver, has_normal);
    total += weights[i];
  }
  const LightChoice<F> choice(total);
  UintOf<F> index = broadcast_bits<UintOf<F>>(count);
  MaskOf<F> open = not_in(MaskOf<F>{});
  F cumulative{};
  for (std::uint32_t i = 0; i < count; ++i) {
    const F own = choice.probability(weights[i], broadcast_to<F>(table.lights[i].choice_probability));
    cumulative += own;
    const MaskOf<F> chosen = open & (cumulative > u);
    index = select(chosen, broadcast_bits<UintOf<F>>(i), index);
    probability = select(chosen, own, probability);
    open &= not_in(chosen);
  }
  return index;
}

/// The probability with which choose_weighed_light chooses `light`, whose share of power is `power`.
template <class F>
MLT_NOINLINE F weighed_light_probability(const LightTable& table, const ReceiverOf<F>& receiver,
                                         const UintOf<F>& light, const F& power) {
  const MaskOf<F> has_normal = not_in(is_zero<F>(receiver.normal));
  F total{}, own{};
  for (std::uint32_t i = 0; i < table.lights.size(); ++i) {
    const F weight = light_weight<F>(table.lights[i], receiver, has_normal);
    total += weight;
    own = select(light == i, weight, own);
  }
  return LightChoice<F>(total).probability(own, power);
}

/// Light number `index`, or, unless kManyLights, the only one; there must be one.
template <bool kManyLights, class F>
MLT_INLINE LightRefOf<F> light_of(const LightTable& table, const UintOf<F>& index) {
  if constexpr (kManyLights) return {table.lights.data(), index};
  return table.lights[0];
}

/// Chooses a light by u_choice (read only if kManyLights; otherwise the table holds at most one light) and a
/// point on it by u, all in [0,1). A density of 0 means: no sample. Nothing is known of lanes outside
/// `active`.
template <bool kManyLights, class F = float>
MLT_NOINLINE LightSampleOf<F> sample_light(const LightTable& table,
                                           const std::type_identity_t<ReceiverOf<F>>& receiver,
                                           const std::type_identity_t<F>& u_choice, const Vec2Of<F>& u,
                                           const MaskOf<F>& active = not_in(MaskOf<F>{})) {
  if (table.lights.empty()) return {};
  if constexpr (kManyLights) {
    const auto count = static_cast<std::uint32_t>(table.lights.size());
    UintOf<F> index{};
    F probability{};
    const bool is_weighed = count <= kMaxWeighedLights;
    if (is_weighed) {
      index = choose_weighed_light<F>(table, receiver, u_choice, probability);
    } else {
      for_lanes(active, [&](int lane) {
        set_lane_of(index, lane, choose_light(table.cdf, lane_of(u_choice, lane)));
      });
    }
    // No light is chosen where none has power.
    const MaskOf<F> is_chosen = index < count;
    index = select(is_chosen, index, UintOf<F>{});
    const LightRefOf<F> light = light_of<kManyLights, F>(table, index);
    LightSampleOf<F> sample = sample_one_light<F>(light, receiver, u, active);
    sample.pdf_solid_angle *= is_weighed ? probability : light.load().choice_probability;
    sample.light = index;
    return select(is_chosen, sample, LightSampleOf<F>{});
  } else {
    const LightRefOf<F> light = light_of<kManyLights, F>(table, UintOf<F>{});
    LightSampleOf<F> sample = sample_one_light<F>(light, receiver, u, active);
    sample.pdf_solid_angle *= light.load().choice_probability;
    sample.light = UintOf<F>{};
    return sample;
  }
}

/// The density by solid angle with which sample_light<kManyLights> for `receiver` produces `position`, a
/// point of light number `light` in the unit direction wi; 0 where it cannot.
template <bool kManyLights, class F = float>
MLT_NOINLINE F light_pdf_solid_angle(const LightTable& table, const UintOf<F>& light,
                                     const std::type_identity_t<ReceiverOf<F>>& receiver,
                                     const Vec3Of<F>& position, const Vec3Of<F>& wi,
                                     const MaskOf<F>& active = not_in(MaskOf<F>{})) {
  const LightRefOf<F> chosen = light_of<kManyLights, F>(table, light);
  F probability = chosen.load().choice_probability;
  if constexpr (kManyLights) {
    if (table.lights.size() <= kMaxWeighedLights)
      probability = weighed_light_probability<F>(table, receiver, light, probability);
  }
  return one_light_pdf_solid_angle<F>(chosen, receiver, position, wi, active) * probability;
}

}  // namespace mlt
