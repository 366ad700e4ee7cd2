// Small steps: how one primary sample moves. A mutation kind is one struct here and one line in
// MLT_MUTATION_KINDS; each must be a symmetric distribution of steps on the circle of 2^32 fixed-point
// numbers, where wrap-around is integer overflow and therefore exact. Steps are made in blocks, before anyone
// asks for them, since SIMD lanes make eight in the time of one. fill() takes any generator with BlockRng's
// next_block, and a factor on its step sizes: at 1 the bits are those of no factor, and at kMaxStepSize the
// largest step of every kind is still below the circle's length, in 32 bits.
#pragma once

#include <cmath>
#include <cstdint>

#include "math/block_rng.hpp"
#include "math/elementary.hpp"
#include "math/rng.hpp"
#include "math/simd.hpp"

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

/// Writes kBlockDraws independent steps, `step_size` (from kMinStepSize to kMaxStepSize) times as long as
/// those of 1.
using FillSteps = void (*)(BlockRng& rng, std::uint32_t* steps, float step_size);

template <>
struct Mutation<MutationKind::kelemen> {
  /// Steps of 2^-(6 + 4u), u uniform: two bits of a draw are the whole part of 4u, 24 its fraction, one the
  /// direction.
  template <class Generator>
  static void fill(Generator& rng, std::uint32_t* steps, float step_size) {
    rng.next_block(steps);
    for (int first = 0; first < kBlockDraws; first += kLanes) {
      const LaneUint draws = load_lanes(steps + first);
      const auto fraction = __builtin_convertvector((draws >> 6) & 0xffffffU, LaneInt);
      const LaneFloat f = __builtin_convertvector(fraction, LaneFloat) * 0x1p-24f;
      // 2^-f, interpolated at Chebyshev's nodes, to a relative error of 1e-7; at most 1.
      const LaneFloat f2 = f * f;
      const LaneFloat power =
          ((0x1.fffffep-1f + f * -0x1.62e3a8p-1f) + f2 * (0x1.ebe2f2p-3f + f * -0x1.c5009p-5f)) +
          (f2 * f2) * (0x1.2dc434p-7f + f * -0x1.f06faep-11f);
      // Times 2^(32 - 6 - whole part) and the factor: at most 2^30, so the cast is in range.
      const LaneFloat scale = std::bit_cast<LaneFloat>((153U - (draws >> 30)) << 23) * step_size;
      const auto distance = __builtin_convertvector(power * scale, LaneInt);
      const LaneUint backwards = 0U - (draws & 1U);
      store_lanes(steps + first, (__builtin_convertvector(distance, LaneUint) ^ backwards) - backwards);
    }
  }
};

template <>
struct Mutation<MutationKind::gaussian> {
  static constexpr float kSigma = 1.0f / 128.0f;

  /// Box and Muller's transform; the radius takes a uniform number in (0,1], so the logarithm is finite.
  template <class Generator>
  static void fill(Generator& rng, std::uint32_t* steps, float step_size) {
    const float sigma = kSigma * step_size;
    std::uint32_t angles[kBlockDraws];
    rng.next_block(steps);
    rng.next_block(angles);
    for (int i = 0; i < kBlockDraws; ++i) {
      const float u = unit_float(steps[i]) + 0x1p-24f;
      float sine = 0, cosine = 0;
      sincos_2pi(unit_float(angles[i]), sine, cosine);
      const float distance = sigma * std::sqrt(-2.0f * log_f(u)) * cosine;
      const float scaled = std::fabs(distance) * 0x1p32f;
      // The radius is at most 5.8 sigma, 0.73 of the circle; written out because an out-of-range cast is
      // undefined.
      const std::uint32_t step = scaled < 0x1p32f ? static_cast<std::uint32_t>(scaled) : 0U;
      steps[i] = distance < 0.0f ? 0U - step : step;
    }
  }
};

}  // namespace mlt
