// All lights of a scene, and the choice among them in proportion to emitted power. The choice takes one
// primary sample when there are several lights (kManyLights) and none otherwise. Memory belongs to the arena.
#pragma once

#include <cstdint>
#include <span>

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
    UintOf<F> index{};
    for_lanes(active,
              [&](int lane) { set_lane_of(index, lane, choose_light(table.cdf, lane_of(u_choice, lane))); });
    const auto count = static_cast<std::uint32_t>(table.lights.size());
    // No light is chosen where none has power.
    const MaskOf<F> is_chosen = index < count;
    index = select(is_chosen, index, UintOf<F>{});
    const LightRefOf<F> light(table.lights.data(), index);
    LightSampleOf<F> sample = sample_one_light<F>(light, receiver, u, active);
    sample.pdf_solid_angle *= light.load().choice_probability;
    sample.light = index;
    return select(is_chosen, sample, LightSampleOf<F>{});
  } else {
    const LightRefOf<F> light(table.lights[0]);
    LightSampleOf<F> sample = sample_one_light<F>(light, receiver, u, active);
    sample.pdf_solid_angle *= light.load().choice_probability;
    sample.light = UintOf<F>{};
    return sample;
  }
}

/// The density by solid angle with which sample_light for `receiver` produces `position`, a point of light
/// number `light` in the unit direction wi; 0 where it cannot.
template <class F = float>
MLT_NOINLINE F light_pdf_solid_angle(const LightTable& table, const UintOf<F>& light,
                                     const std::type_identity_t<ReceiverOf<F>>& receiver,
                                     const Vec3Of<F>& position, const Vec3Of<F>& wi,
                                     const MaskOf<F>& active = not_in(MaskOf<F>{})) {
  const LightRefOf<F> chosen(table.lights.data(), light);
  return one_light_pdf_solid_angle<F>(chosen, receiver, position, wi, active) *
         chosen.load().choice_probability;
}

}  // namespace mlt
