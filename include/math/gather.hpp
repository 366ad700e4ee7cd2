// Loads from tables, each lane from its own place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "math/wide.hpp"

namespace mlt {

/// The float, or else the 32 bits, `offset`[i] bytes after `base`, in lane i.
template <class F, class T>
MLT_INLINE auto gather_bytes(const T* base, UintOf<F> offset) {
  static_assert(sizeof(T) == 4);
  using V = std::conditional_t<std::is_same_v<T, float>, F, UintOf<F>>;
  const auto* bytes = reinterpret_cast<const std::byte*>(base);
  std::byte array[sizeof(V)];
  for (int i = 0; i < kLaneCount<F>; ++i) std::memcpy(array + 4 * i, bytes + lane_of(offset, i), 4);
  return load_wide<V>(array);
}

/// Four floats in a row of memory, for each lane.
template <class F>
struct Rows {
  F column[4];
};

#if defined(__SSE2__)
namespace detail {
MLT_INLINE __m128 unpack_low(__m128 a, __m128 b) {
  return _mm_unpacklo_ps(a, b);
}
MLT_INLINE __m128 unpack_high(__m128 a, __m128 b) {
  return _mm_unpackhi_ps(a, b);
}
MLT_INLINE __m128 low_pairs(__m128 a, __m128 b) {
  return _mm_movelh_ps(a, b);
}
MLT_INLINE __m128 high_pairs(__m128 a, __m128 b) {
  return _mm_movehl_ps(b, a);
}
MLT_INLINE __m128 load_row(const std::byte* const* rows, __m128) {
  return _mm_loadu_ps(reinterpret_cast<const float*>(rows[0]));
}
#if defined(__AVX2__)
MLT_INLINE __m256 unpack_low(__m256 a, __m256 b) {
  return _mm256_unpacklo_ps(a, b);
}
MLT_INLINE __m256 unpack_high(__m256 a, __m256 b) {
  return _mm256_unpackhi_ps(a, b);
}
MLT_INLINE __m256 low_pairs(__m256 a, __m256 b) {
  return _mm256_shuffle_ps(a, b, 0x44);
}
MLT_INLINE __m256 high_pairs(__m256 a, __m256 b) {
  return _mm256_shuffle_ps(a, b, 0xee);
}
MLT_INLINE __m256 load_row(const std::byte* const* rows, __m256) {
  const __m256 low = _mm256_castps128_ps256(load_row(rows, __m128{}));
  return _mm256_insertf128_ps(low, load_row(rows + 4, __m128{}), 1);
}
#endif
#if defined(__AVX512F__) && defined(__AVX512DQ__)
MLT_INLINE __m512 unpack_low(__m512 a, __m512 b) {
  return _mm512_unpacklo_ps(a, b);
}
MLT_INLINE __m512 unpack_high(__m512 a, __m512 b) {
  return _mm512_unpackhi_ps(a, b);
}
MLT_INLINE __m512 low_pairs(__m512 a, __m512 b) {
  return _mm512_shuffle_ps(a, b, 0x44);
}
MLT_INLINE __m512 high_pairs(__m512 a, __m512 b) {
  return _mm512_shuffle_ps(a, b, 0xee);
}
MLT_INLINE __m512 load_row(const std::byte* const* rows, __m512) {
  const __m512 low = _mm512_castps256_ps512(load_row(rows, __m256{}));
  return _mm512_insertf32x8(low, load_row(rows + 8, __m256{}), 1);
}
#endif

/// Rows i, i + 4, ... of the lanes lie in one register; transposing within its quarters sorts them by column.
template <class Register, class F>
MLT_INLINE void transpose_rows(const std::byte* const* rows, Rows<F>& result) {
  const Register a = load_row(rows, Register{}), b = load_row(rows + 1, Register{});
  const Register c = load_row(rows + 2, Register{}), d = load_row(rows + 3, Register{});
  const Register low_ab = unpack_low(a, b), low_cd = unpack_low(c, d);
  const Register high_ab = unpack_high(a, b), high_cd = unpack_high(c, d);
  result.column[0] = std::bit_cast<F>(low_pairs(low_ab, low_cd));
  result.column[1] = std::bit_cast<F>(high_pairs(low_ab, low_cd));
  result.column[2] = std::bit_cast<F>(low_pairs(high_ab, high_cd));
  result.column[3] = std::bit_cast<F>(high_pairs(high_ab, high_cd));
}
}  // namespace detail
#endif

/// Whether table_entries is faster than loads lane by lane.
template <class F>
inline constexpr bool kHasTables = kWideLanes == 16 && kLaneCount<F> == 16;

/// Entry index[i] (its lowest 6 bits) of an aligned table of 64 floats, in lane i; the lowest 5 of 32 unless
/// `beyond_32`.
template <class F>
MLT_INLINE F table_entries(const float* table, UintOf<F> index, bool beyond_32) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  if constexpr (kHasTables<F>) {
    const auto indices = std::bit_cast<__m512i>(index);
    const auto entries_of = [&](const float* half) __attribute__((always_inline)) {
      return _mm512_permutex2var_ps(_mm512_load_ps(half), indices, _mm512_load_ps(half + 16));
    };
    const __m512 low = entries_of(table);
    if (!beyond_32) return std::bit_cast<F>(low);
    const __mmask16 is_high = _mm512_test_epi32_mask(indices, _mm512_set1_epi32(32));
    return std::bit_cast<F>(_mm512_mask_blend_ps(is_high, low, entries_of(table + 32)));
  }
#endif
  F result{};
  for (int i = 0; i < kLaneCount<F>; ++i)
    set_lane_of(result, i, table[lane_of(index, i) % (beyond_32 ? 64U : 32U)]);
  return result;
}

/// Entry index[i] (its lowest 3 bits) of an aligned table of 8 words, whose memory is that of 16, in lane i.
template <class F>
MLT_INLINE UintOf<F> small_table_entries(const std::uint32_t* table, UintOf<F> index) {
#if defined(__AVX512F__)
  if constexpr (sizeof(F) == 64) {
    return std::bit_cast<UintOf<F>>(
        _mm512_permutexvar_epi32(std::bit_cast<__m512i>(index), _mm512_load_si512(table)));
  }
#endif
#if defined(__AVX2__)
  if constexpr (sizeof(F) == 32) {
    const __m256i entries = _mm256_load_si256(reinterpret_cast<const __m256i*>(table));
    return std::bit_cast<UintOf<F>>(_mm256_permutevar8x32_epi32(entries, std::bit_cast<__m256i>(index)));
  }
#endif
  return gather_bytes<F>(table, (index & 7U) * 4U);
}

/// The four floats at `base` + offset[i] bytes, in lane i.
template <class F>
MLT_INLINE Rows<F> gather_rows(const float* base, UintOf<F> offset) {
  Rows<F> result;
  const auto* bytes = reinterpret_cast<const std::byte*>(base);
#if defined(__SSE2__)
  if constexpr (VectorType<F>) {
    const std::byte* rows[kLaneCount<F>];
    for (int i = 0; i < kLaneCount<F>; ++i) rows[i] = bytes + offset[i];
    if constexpr (sizeof(F) == 16) {
      detail::transpose_rows<__m128>(rows, result);
      return result;
    }
#if defined(__AVX2__)
    if constexpr (sizeof(F) == 32) {
      detail::transpose_rows<__m256>(rows, result);
      return result;
    }
#endif
#if defined(__AVX512F__) && defined(__AVX512DQ__)
    if constexpr (sizeof(F) == 64) {
      detail::transpose_rows<__m512>(rows, result);
      return result;
    }
#endif
  }
#endif
  for (int i = 0; i < kLaneCount<F>; ++i) {
    float row[4];
    std::memcpy(row, bytes + lane_of(offset, i), sizeof(row));
    for (int column = 0; column < 4; ++column) set_lane_of(result.column[column], i, row[column]);
  }
  return result;
}

}  // namespace mlt
