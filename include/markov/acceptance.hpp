// The chain's decisions. The film credits a proposal with its acceptance probability, so the chain must
// accept with that probability and no other: a comparison with a 24-bit uniform number would round a
// probability of 1e-7 up by 19 % and could never be rarer than 6e-8, and a chain would leave its brightest
// states too soon.
#pragma once

#include <cstdint>

namespace mlt {

/// True with `probability` (in [0,1]), to an absolute 2^-64; always for 1, never for 0. Draws a second number
/// in one of 2^32 cases.
template <class Generator>
bool happens(Generator& rng, float probability) {
  const double scaled = static_cast<double>(probability) * 0x1p32;
  // Both bounds hold for every probability; written out because an out-of-range cast is undefined.
  const std::uint64_t threshold = scaled >= 0.0 && scaled <= 0x1p32 ? static_cast<std::uint64_t>(scaled) : 0U;
  const std::uint64_t drawn = rng.next_fixed();
  if (drawn != threshold) [[likely]]
    return drawn < threshold;
  const double fraction = scaled - static_cast<double>(threshold);
  return static_cast<double>(rng.next_fixed()) * 0x1p-32 < fraction;
}

}  // namespace mlt
