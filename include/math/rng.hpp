// Random streams. A stream is a pure function of (seed, purpose, index): which thread draws from it, and
// when, has no influence. The generator is xoshiro128++ [Blackman21]; its 128-bit state is derived from the
// three keys by 64-bit finalisers, bijective in the index for a fixed seed and purpose, so no two units of
// one job share a stream.
#pragma once

#include <cstdint>

namespace mlt {

/// What a stream is for; part of its key.
enum class StreamPurpose : std::uint32_t {
  kBootstrap = 1,
  kChain = 2,
  kSeedSelection = 3,
  kPixel = 4,
  kTest = 5,
  kSteps = 6,
  kResampling = 7,
  kRelabelling = 16  ///< of replicates, in a permutation test
};

/// Bijective 64-bit finaliser, Stafford's mix 13 as used in SplitMix64 [Steele14].
constexpr std::uint64_t mix64(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// A 32-bit fixed-point number in [0,1) as a float in [0, 1-2^-24]: 24 bits are kept, so it never rounds
/// to 1.
inline float unit_float(std::uint32_t fixed) {
  return static_cast<float>(fixed >> 8) * 0x1p-24f;
}

class Rng {
 public:
  Rng() : Rng(0, StreamPurpose::kTest, 0) {}

  Rng(std::uint64_t seed, StreamPurpose purpose, std::uint64_t index) {
    const std::uint64_t key = mix64(mix64(seed + 0x9e3779b97f4a7c15ULL) +
                                    0xd1b54a32d192ed03ULL * static_cast<std::uint64_t>(purpose));
    const std::uint64_t low = mix64(index + key);
    const std::uint64_t high = mix64(low ^ mix64(key + 0x8cb92ba72f3d8dd7ULL));
    state_[0] = static_cast<std::uint32_t>(low);
    state_[1] = static_cast<std::uint32_t>(low >> 32);
    state_[2] = static_cast<std::uint32_t>(high);
    state_[3] = static_cast<std::uint32_t>(high >> 32);
    // The all-zero state is the generator's only fixed point.
    if ((state_[0] | state_[1] | state_[2] | state_[3]) == 0) state_[0] = 0x9e3779b9U;
  }

  /// Uniform over all 2^32 values.
  std::uint32_t next_fixed() {
    const std::uint32_t result = rotate_left(state_[0] + state_[3], 7) + state_[0];
    const std::uint32_t shifted = state_[1] << 9;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= shifted;
    state_[3] = rotate_left(state_[3], 11);
    return result;
  }

  /// 64 bits at once, as a key of further hashes.
  std::uint64_t next_key() {
    const std::uint64_t low = next_fixed();
    return std::uint64_t{next_fixed()} << 32 | low;
  }

  /// Uniform in [0, 1-2^-24], a multiple of 2^-24.
  float next_float() { return unit_float(next_fixed()); }

 private:
  static constexpr std::uint32_t rotate_left(std::uint32_t x, int k) { return (x << k) | (x >> (32 - k)); }
  std::uint32_t state_[4];
};

}  // namespace mlt
