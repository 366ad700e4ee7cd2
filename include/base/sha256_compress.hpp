// The compression function of SHA-256 [FIPS180-4 section 6.2.2], which takes all of its time: portable, and
// by the instructions that most processors have for it. Used by base/sha256.hpp.
#pragma once

#include <array>
#include <cstdint>

namespace mlt {

using Sha256State = std::array<std::uint32_t, 8>;

/// Works one block of 64 bytes into the state.
using Sha256Compress = void (*)(Sha256State& state, const std::uint8_t* block);

void compress_sha256_portably(Sha256State& state, const std::uint8_t* block);

/// By the SHA extensions of x86; null where the processor lacks them.
Sha256Compress sha256_by_instructions();

/// Fractional parts of the cube roots of the first 64 primes [FIPS180-4 section 4.2.2].
extern const std::array<std::uint32_t, 64> kSha256RoundConstants;

}  // namespace mlt
