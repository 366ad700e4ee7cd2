// Random numbers in blocks: eight interleaved generators of the kind of Rng, advanced together in SIMD lanes.
// Lane i of every block belongs to generator i, whatever the width of the registers, so the numbers are the
// same on every processor. For consumers of many numbers at once; the state is eight times that of Rng.
#pragma once

#include <cstdint>

#include "math/rng.hpp"
#include "math/simd.hpp"

namespace mlt {

inline constexpr int kBlockDraws = 8;

class BlockRng {
 public:
  BlockRng() = default;

  /// The lanes' states are hashed from the numbers of Rng(seed, purpose, index).
  BlockRng(std::uint64_t seed, StreamPurpose purpose, std::uint64_t index) {
    Rng source(seed, purpose, index);
    for (int lane = 0; lane < kBlockDraws; ++lane) {
      const std::uint64_t low = mix64(source.next_key());
      const std::uint64_t high = mix64(source.next_key());
      // The all-zero state is the generator's only fixed point.
      const bool is_zero = (low | high) == 0;
      state_[0][lane] = is_zero ? 1U : static_cast<std::uint32_t>(low);
      state_[1][lane] = static_cast<std::uint32_t>(low >> 32);
      state_[2][lane] = static_cast<std::uint32_t>(high);
      state_[3][lane] = static_cast<std::uint32_t>(high >> 32);
    }
  }

  /// Writes kBlockDraws numbers, uniform over all 2^32 values, to `draws`.
  void next_block(std::uint32_t* draws) {
    for (int first = 0; first < kBlockDraws; first += kLanes) {
      LaneUint s0 = load_lanes(state_[0] + first);
      LaneUint s1 = load_lanes(state_[1] + first);
      LaneUint s2 = load_lanes(state_[2] + first);
      LaneUint s3 = load_lanes(state_[3] + first);
      store_lanes(draws + first, rotate_left(s0 + s3, 7) + s0);
      const LaneUint shifted = s1 << 9;
      s2 ^= s0;
      s3 ^= s1;
      s1 ^= s2;
      s0 ^= s3;
      s2 ^= shifted;
      store_lanes(state_[0] + first, s0);
      store_lanes(state_[1] + first, s1);
      store_lanes(state_[2] + first, s2);
      store_lanes(state_[3] + first, rotate_left(s3, 11));
    }
  }

 private:
  MLT_INLINE static LaneUint rotate_left(LaneUint x, int k) { return (x << k) | (x >> (32 - k)); }

  alignas(16) std::uint32_t state_[4][kBlockDraws] = {};
};

}  // namespace mlt
