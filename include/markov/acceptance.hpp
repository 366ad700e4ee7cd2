// The chain's decisions. The film credits a proposal with its acceptance probability, so the chain must
// accept with that probability and no other: a comparison with a 24-bit uniform number would round a
// probability of 1e-7 up by 19 % and could never be rarer than 6e-8, and a chain would leave its brightest
// states too soon.
#pragma once

#include <cstdint>

#include "math/wide.hpp"

namespace mlt {

/// In the lanes of `active`, true with `probability` (in [0,1]), to an absolute 2^-64; always for 1, never
/// for 0. Draws a second number in one of 2^32 cases.
template <class F, class Generator>
MLT_INLINE MaskOf<F> happens(Generator& rng, F probability, MaskOf<F> active = not_in(MaskOf<F>{})) {
  using U = UintOf<F>;
  const U drawn = rng.next_fixed(active);
  // The probability's first 32 bits in two halves, and the rest; all of it exact. Written out for numbers
  // outside [0,1), too, as an out-of-range cast is undefined.
  const MaskOf<F> in_range = (probability >= 0.0f) & (probability < 1.0f);
  const F scaled = select(in_range, probability, F{}) * 0x1p16f;
  const U high = truncated(scaled);
  const F rest = (scaled - to_float(high)) * 0x1p16f;
  const U low = truncated(rest);
  const U threshold = high << 16 | low;
  MaskOf<F> result = (drawn < threshold) | (probability == 1.0f);
  if (const MaskOf<F> equal = active & in_range & (drawn == threshold); any(equal)) [[unlikely]] {
    const U second = rng.next_fixed(equal);
    const F fraction = rest - to_float(low);
    for_lanes(equal, [&](int lane) {
      if (static_cast<double>(lane_of(second, lane)) * 0x1p-32 < static_cast<double>(lane_of(fraction, lane)))
        set_lane_of(result, lane, kLaneTrue<F>);
    });
  }
  return result;
}

}  // namespace mlt
