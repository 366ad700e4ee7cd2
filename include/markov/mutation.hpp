// Small steps: how one primary sample moves. A mutation kind is one struct here and one line in
// MLT_MUTATION_KINDS; each must be a symmetric distribution of steps on the circle of 2^32 fixed-point
// numbers, where wrap-around is integer overflow and therefore exact. steps() makes one for each lane from a
// draw that the lane has made, uniform over all 2^32 values; a kind that takes more draws them itself. There
// is a factor on step sizes: at 1 the bits are those of no factor, and at kMaxStepSize the largest step of
// every kind is still below the circle's length, in 32 bits.
#pragma once

#include <cmath>
#include <cstdint>

#include "math/elementary.hpp"
#include "math/rng.hpp"

namespace mlt {

/// name, help text.
#define MLT_MUTATION_KINDS(X)                                          \
  X(kelemen, "log-uniform step sizes from 1/1024 to 1/64 [Kelemen02]") \
  X(gaussian, "normally distributed steps of standard deviation 1/128")

inline constexpr float kMinStepSize = 0x1p-10f;  ///< Kelemen's shortest step is 2^12 units of 2^-32
inline constexpr float kMaxStepSize = 16;        ///< and the longest a quarter of the circle, 2^30 units

enum class MutationKind : std::uint8_t {
#define MLT_ENUMERATE(name, help) name,
  MLT_MUTATION_KINDS(MLT_ENUMERATE)
#undef MLT_ENUMERATE
};

template <MutationKind kKind>
struct Mutation;

template <>
struct Mutation<MutationKind::kelemen> {
  /// Steps of 2^-(6 + 4u), u uniform: two bits of a draw are the whole part of 4u, 24 its fraction, one the
  /// direction.
  template <class F, class Generator>
  MLT_INLINE static UintOf<F> steps(const UintOf<F>& draws, Generator&, const MaskOf<F>&, float step_size) {
    const F f = to_float((draws >> 6) & 0xffffffU) * 0x1p-24f;
    // 2^-f, interpolated at Chebyshev's nodes, to a relative error of 1e-7; at most 1.
    const F f2 = f * f;
    const F power = ((0x1.fffffep-1f + f * -0x1.62e3a8p-1f) + f2 * (0x1.ebe2f2p-3f + f * -0x1.c5009p-5f)) +
                    (f2 * f2) * (0x1.2dc434p-7f + f * -0x1.f06faep-11f);
    // Times 2^(32 - 6 - whole part) and the factor: at most 2^30, so the cast is in range.
    const F scale = as_floats((153U - (draws >> 30)) << 23) * step_size;
    const UintOf<F> backwards = 0U - (draws & 1U);
    return (truncated(power * scale) ^ backwards) - backwards;
  }
};

template <>
struct Mutation<MutationKind::gaussian> {
  static constexpr float kSigma = 1.0f / 128.0f;

  /// Box and Muller's transform; the radius takes a uniform number in (0,1], so the logarithm is finite.
  template <class F, class Generator>
  MLT_NOINLINE static UintOf<F> steps(const UintOf<F>& draws, Generator& rng, const MaskOf<F>& active,
                                      float step_size) {
    const UintOf<F> angles = rng.next_fixed(active);
    UintOf<F> steps{};
    for_lanes(active, [&](int lane) {
      set_lane_of(steps, lane, step(lane_of(draws, lane), lane_of(angles, lane), kSigma * step_size));
    });
    return steps;
  }

 private:
  static std::uint32_t step(std::uint32_t draw, std::uint32_t angle, float sigma) {
    const float u = unit_float(draw) + 0x1p-24f;
    float sine = 0, cosine = 0;
    sincos_2pi(unit_float(angle), sine, cosine);
    const float distance = sigma * std::sqrt(-2.0f * log_f(u)) * cosine;
    const float scaled = std::fabs(distance) * 0x1p32f;
    // The radius is at most 5.8 sigma, 0.73 of the circle; written out because an out-of-range cast is
    // undefined.
    const std::uint32_t length = scaled < 0x1p32f ? static_cast<std::uint32_t>(scaled) : 0U;
    return distance < 0.0f ? 0U - length : length;
  }
};

/// Steps of one kind, for the lanes of the mask.
template <class F>
using MakeSteps = UintOf<F> (*)(const UintOf<F>& draws, RngOf<F>& rng, const MaskOf<F>& active,
                                float step_size);

template <class F>
MakeSteps<F> make_steps_of(MutationKind kind) {
  switch (kind) {
#define MLT_CASE(name, help) \
  case MutationKind::name:   \
    return &Mutation<MutationKind::name>::template steps<F, RngOf<F>>;
    MLT_MUTATION_KINDS(MLT_CASE)
#undef MLT_CASE
  }
  return nullptr;
}

}  // namespace mlt
