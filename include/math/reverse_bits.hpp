// The bits of a 32-bit integer in reverse order, for one or as many as there are lanes.
#pragma once

#include <bit>
#include <cstdint>

#include "math/wide.hpp"

namespace mlt {

MLT_INLINE constexpr std::uint32_t swap_bytes(std::uint32_t x) {
  return __builtin_bswap32(x);
}
template <VectorType U>
MLT_INLINE U swap_bytes(U x) {
  x = (x >> 16) | (x << 16);
  return ((x >> 8) & 0x00ff00ffU) | ((x & 0x00ff00ffU) << 8);
}

#if defined(__AVX2__)
namespace detail {
/// 16 bytes, in each 128 bits of the register.
template <class Register>
MLT_INLINE Register repeated(std::uint64_t low, std::uint64_t high) {
  const __m128i bytes = _mm_set_epi64x(static_cast<long long>(high), static_cast<long long>(low));
#if defined(__AVX512F__)
  if constexpr (sizeof(Register) == 64) return _mm512_broadcast_i32x4(bytes);
#endif
  if constexpr (sizeof(Register) == 32) return _mm256_broadcastsi128_si256(bytes);
}
/// The bytes at `places`, below 16, of a table.
MLT_INLINE __m256i look_up(__m256i table, __m256i places) {
  return _mm256_shuffle_epi8(table, places);
}
#if defined(__AVX512BW__)
MLT_INLINE __m512i look_up(__m512i table, __m512i places) {
  return _mm512_shuffle_epi8(table, places);
}
#endif

/// By half bytes, which tables reverse, one of them in the other half of the byte.
template <class Register, class U>
MLT_INLINE U reverse_by_tables(U x) {
  const auto low_half = repeated<Register>(0xe060a020c0408000U, 0xf070b030d0509010U);
  const auto high_half = repeated<Register>(0x0e060a020c040800U, 0x0f070b030d050901U);
  const auto swapped = repeated<Register>(0x0405060700010203U, 0x0c0d0e0f08090a0bU);
  const auto low = std::bit_cast<Register>(x & 0x0f0f0f0fU);
  const auto high = std::bit_cast<Register>((x >> 4) & 0x0f0f0f0fU);
  const U bytes = std::bit_cast<U>(look_up(low_half, low)) | std::bit_cast<U>(look_up(high_half, high));
  return std::bit_cast<U>(look_up(std::bit_cast<Register>(bytes), swapped));
}
}  // namespace detail
#endif

template <class Bits>
MLT_INLINE constexpr Bits reverse_bits(Bits x) {
#if defined(__AVX2__)
  if constexpr (sizeof(Bits) == 32) return detail::reverse_by_tables<__m256i>(x);
#endif
#if defined(__AVX512BW__)
  if constexpr (sizeof(Bits) == 64) return detail::reverse_by_tables<__m512i>(x);
#endif
  x = swap_bytes(x);
  x = ((x >> 4) & 0x0f0f0f0fU) | ((x & 0x0f0f0f0fU) << 4);
  x = ((x >> 2) & 0x33333333U) | ((x & 0x33333333U) << 2);
  return ((x >> 1) & 0x55555555U) | ((x & 0x55555555U) << 1);
}

}  // namespace mlt
