// Random streams. A stream is a pure function of (seed, purpose, index): which thread draws from it, and
// when, has no influence. The generator is xoshiro128++ [Blackman21]; its 128-bit state is derived from the
// three keys by 64-bit finalisers, bijective in the index for a fixed seed and purpose, so no two units of
// one job share a stream.
#pragma once

#include <cstdint>

#include "math/wide.hpp"

namespace mlt {

/// What a stream is for; part of its key.
enum class StreamPurpose : std::uint32_t {
  kBootstrap = 1,
  kChain = 2,
  kSeedSelection = 3,
  kPixel = 4,
  kTest = 5,
  kResampling = 7,
  kBootstrapFilm = 8,
  kRelabelling = 16  ///< of replicates, in a permutation test
};

/// Bijective 64-bit finaliser, Stafford's mix 13 as used in SplitMix64 [Steele14].
constexpr std::uint64_t mix64(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// The same in each lane of 64 bits.
template <VectorType V>
MLT_INLINE V mix64(V x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// A 32-bit fixed-point number in [0,1) as a float in [0, 1-2^-24]: 24 bits are kept, so it never rounds
/// to 1.
template <class U>
MLT_INLINE auto unit_float(U fixed) {
  return to_float(fixed >> 8) * 0x1p-24f;
}

/// What the streams of one purpose in a job have in common.
struct StreamKey {
  std::uint64_t low, high;

  StreamKey(std::uint64_t seed, StreamPurpose purpose)
      : low(mix64(mix64(seed + 0x9e3779b97f4a7c15ULL) +
                  0xd1b54a32d192ed03ULL * static_cast<std::uint64_t>(purpose))),
        high(mix64(low + 0x8cb92ba72f3d8dd7ULL)) {}
};

/// One generator for each lane of F.
template <class F>
class RngOf {
  using U = UintOf<F>;

 public:
  RngOf() = default;

  /// Of the stream's first numbers, in all lanes.
  RngOf(std::uint64_t seed, StreamPurpose purpose, std::uint64_t index)
      : RngOf(StreamKey(seed, purpose), index) {}
  RngOf(const StreamKey& key, std::uint64_t index) {
    const std::uint64_t low = mix64(index + key.low);
    const std::uint64_t high = mix64(low ^ key.high);
    state_[0] = broadcast_bits<U>(static_cast<std::uint32_t>(low));
    state_[1] = broadcast_bits<U>(static_cast<std::uint32_t>(low >> 32));
    state_[2] = broadcast_bits<U>(static_cast<std::uint32_t>(high));
    state_[3] = broadcast_bits<U>(static_cast<std::uint32_t>(high >> 32));
    // The all-zero state is the generator's only fixed point.
    if ((low | high) == 0) state_[0] = broadcast_bits<U>(0x9e3779b9U);
  }

  void set_lane(int lane, const RngOf<float>& rng) {
    for (int i = 0; i < 4; ++i) set_lane_of(state_[i], lane, rng.state_[i]);
  }

  /// Uniform over all 2^32 values. Lanes outside `active` do not draw.
  MLT_INLINE U next_fixed(MaskOf<F> active = not_in(MaskOf<F>{})) {
    const U result = rotate_left(state_[0] + state_[3], 7) + state_[0];
    const U s2 = state_[2] ^ state_[0];
    const U s3 = state_[3] ^ state_[1];
    const U s1 = state_[1] ^ s2;
    const U s0 = state_[0] ^ s3;
    state_[2] = select(active, s2 ^ (state_[1] << 9), state_[2]);
    state_[3] = select(active, rotate_left(s3, 11), state_[3]);
    state_[1] = select(active, s1, state_[1]);
    state_[0] = select(active, s0, state_[0]);
    return result;
  }

  /// 64 bits at once, as a key of further hashes.
  std::uint64_t next_key() {
    static_assert(!VectorType<F>);
    const std::uint64_t low = next_fixed();
    return std::uint64_t{next_fixed()} << 32 | low;
  }

  /// Uniform in [0, 1-2^-24], a multiple of 2^-24.
  F next_float() { return unit_float(next_fixed()); }

 private:
  template <class>
  friend class RngOf;

  MLT_INLINE static U rotate_left(U x, int k) { return (x << k) | (x >> (32 - k)); }
  U state_[4] = {};
};
using Rng = RngOf<float>;

}  // namespace mlt
