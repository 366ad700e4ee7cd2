// Small steps: how one primary sample moves. A mutation kind is one struct here and one line in
// MLT_MUTATION_KINDS; each must be a symmetric distribution of steps on the circle of 2^32 fixed-point
// numbers, where wrap-around is integer overflow and therefore exact. step() takes any generator with Rng's
// drawing functions.
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

enum class MutationKind : std::uint8_t {
#define MLT_ENUMERATE(name, help) name,
  MLT_MUTATION_KINDS(MLT_ENUMERATE)
#undef MLT_ENUMERATE
};

template <MutationKind kKind>
struct Mutation;

/// A step of `distance` (in [0, 0.5), a fraction of the circle) forwards or backwards.
inline std::uint32_t fixed_step(float distance, bool backwards) {
  const float scaled = distance * 0x1p32f;
  // Both bounds hold for every finite input above; written out because an out-of-range cast is undefined.
  const std::uint32_t step = scaled >= 0.0f && scaled < 0x1p31f ? static_cast<std::uint32_t>(scaled) : 0U;
  return backwards ? 0U - step : step;
}

template <>
struct Mutation<MutationKind::kelemen> {
  static constexpr float kLargest = 1.0f / 64.0f;
  static constexpr float kMinusLogRatio = -2.7725887222397812f;  ///< -ln(largest / smallest) = -ln 16

  template <class Generator>
  static std::uint32_t step(Generator& rng) {
    const std::uint32_t bits = rng.next_fixed();
    return fixed_step(kLargest * exp_f(kMinusLogRatio * unit_float(bits)), (bits & 1U) != 0);
  }
};

template <>
struct Mutation<MutationKind::gaussian> {
  static constexpr float kSigma = 1.0f / 128.0f;

  /// Box and Muller's transform; the radius takes a uniform number in (0,1], so the logarithm is finite.
  template <class Generator>
  static std::uint32_t step(Generator& rng) {
    const float u = rng.next_float() + 0x1p-24f;
    const std::uint32_t angle = rng.next_fixed();
    float sine = 0, cosine = 0;
    sincos_2pi(unit_float(angle), sine, cosine);
    const float distance = kSigma * std::sqrt(-2.0f * log_f(u)) * cosine;
    return fixed_step(std::fabs(distance), distance < 0.0f);
  }
};

}  // namespace mlt
