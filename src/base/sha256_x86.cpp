// The compression function of SHA-256 by the SHA extensions of x86 [Intel SDM volume 2, SHA256RNDS2,
// SHA256MSG1, SHA256MSG2]: ten times as fast, without which a large film's hash would take longer than a
// short render by many threads.
#include "base/sha256_compress.hpp"

#if defined(__x86_64__)
#include <cpuid.h>
#include <immintrin.h>

namespace mlt {
namespace {

#define MLT_SHA __attribute__((target("sha,sse4.1,ssse3")))

/// Four words of the message schedule from the 16 before them.
MLT_SHA inline __m128i next_words(__m128i oldest, __m128i second, __m128i third, __m128i newest) {
  const __m128i partial = _mm_sha256msg1_epu32(oldest, second);
  // Not by an intrinsic with an immediate: -O0 refuses it where __OPTIMIZE__ stays defined by a precompiled
  // pragma.
  using Words = int __attribute__((vector_size(16)));
  const auto seventh_last = reinterpret_cast<__m128i>(
      __builtin_shufflevector(reinterpret_cast<Words>(third), reinterpret_cast<Words>(newest), 1, 2, 3, 4));
  return _mm_sha256msg2_epu32(_mm_add_epi32(partial, seventh_last), newest);
}

MLT_SHA void compress(Sha256State& state, const std::uint8_t* block) {
  const auto load = [](const void* from) { return _mm_loadu_si128(static_cast<const __m128i*>(from)); };
  // The instructions want a, b, e, f in one register and c, d, g, h in the other, the first in the highest
  // lane.
  const auto word = [&](std::size_t i) { return static_cast<int>(state[i]); };
  const __m128i abef = _mm_set_epi32(word(0), word(1), word(4), word(5));
  const __m128i cdgh = _mm_set_epi32(word(2), word(3), word(6), word(7));
  const __m128i big_endian = _mm_set_epi64x(0x0c0d0e0f08090a0bLL, 0x0405060700010203LL);

  __m128i first = abef, second = cdgh;
  __m128i words[4];
  for (std::size_t t = 0; t < 16; ++t) {
    __m128i& added = words[t % 4];
    if (t < 4) {
      added = _mm_shuffle_epi8(load(block + 16 * t), big_endian);
    } else {
      added = next_words(added, words[(t + 1) % 4], words[(t + 2) % 4], words[(t + 3) % 4]);
    }
    // Four rounds, two at a time: each pair turns a, b, e, f into the next c, d, g, h.
    const __m128i keyed = _mm_add_epi32(added, load(kSha256RoundConstants.data() + 4 * t));
    second = _mm_sha256rnds2_epu32(second, first, keyed);
    first = _mm_sha256rnds2_epu32(first, second, _mm_unpackhi_epi64(keyed, keyed));
  }

  alignas(16) std::uint32_t low[4], high[4];
  _mm_store_si128(reinterpret_cast<__m128i*>(low), _mm_add_epi32(first, abef));
  _mm_store_si128(reinterpret_cast<__m128i*>(high), _mm_add_epi32(second, cdgh));
  state = {low[3], low[2], high[3], high[2], low[1], low[0], high[1], high[0]};
}
#undef MLT_SHA

}  // namespace

Sha256Compress sha256_by_instructions() {
  unsigned a = 0, b = 0, c = 0, d = 0;
  if (__get_cpuid(1, &a, &b, &c, &d) == 0 || (c & bit_SSE4_1) == 0 || (c & bit_SSSE3) == 0) return nullptr;
  if (__get_cpuid_count(7, 0, &a, &b, &c, &d) == 0 || (b & bit_SHA) == 0) return nullptr;
  return &compress;
}

}  // namespace mlt

#else

namespace mlt {

Sha256Compress sha256_by_instructions() {
  return nullptr;
}

}  // namespace mlt

#endif
