// Chosen lanes moved together.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "math/wide.hpp"

namespace mlt {

#if defined(__AVX2__)
namespace detail {
/// By mask, eight bytes with the numbers of the lanes that are set, in order.
consteval std::array<std::uint64_t, 256> chosen_of_8_lanes() {
  std::array<std::uint64_t, 256> orders{};
  for (unsigned mask = 0; mask < 256; ++mask) {
    unsigned place = 0;
    for (std::uint64_t lane = 0; lane < 8; ++lane) {
      if ((mask >> lane & 1U) != 0) orders[mask] |= lane << (8 * place++);
    }
  }
  return orders;
}
inline constexpr std::array<std::uint64_t, 256> kChosenOf8Lanes = chosen_of_8_lanes();
}  // namespace detail
#endif

/// Moves the lanes of a mask, of any number of values, to the first lanes, in order. What the other lanes
/// hold means nothing.
template <VectorType F>
class LanePacking {
  using U = UintOf<F>;

 public:
  MLT_INLINE explicit LanePacking(MaskOf<F> lanes) : bits_(lanes_of(lanes)), order_(chosen()) {}

  MLT_INLINE std::uint32_t count() const { return static_cast<std::uint32_t>(std::popcount(bits_)); }

  template <class V>
  MLT_INLINE V operator()(V values) const {
    return permuted(values, order_);
  }

 private:
  /// The numbers of the lanes that are set.
  MLT_INLINE U chosen() const {
#if defined(__AVX512F__)
    if constexpr (sizeof(F) == 64) {
      return std::bit_cast<U>(_mm512_maskz_compress_epi32(static_cast<__mmask16>(bits_),
                                                          std::bit_cast<__m512i>(lane_numbers<U>())));
    }
#endif
#if defined(__AVX2__)
    if constexpr (sizeof(F) == 32) {
      const auto order = static_cast<long long>(detail::kChosenOf8Lanes[bits_]);
      return std::bit_cast<U>(_mm256_cvtepu8_epi32(_mm_cvtsi64_si128(order)));
    }
#endif
    U order{};
    int place = 0;
    for (unsigned bits = bits_; bits != 0; ++place)
      order[place] = static_cast<std::uint32_t>(take_lowest(bits));
    return order;
  }

  /// Lane order[i] in lane i.
  template <class V>
  MLT_INLINE static V permuted(V values, U order) {
    static_assert(sizeof(V) == sizeof(U));
#if defined(__AVX512F__)
    if constexpr (sizeof(F) == 64) {
      return std::bit_cast<V>(
          _mm512_permutexvar_epi32(std::bit_cast<__m512i>(order), std::bit_cast<__m512i>(values)));
    }
#endif
#if defined(__AVX2__)
    if constexpr (sizeof(F) == 32) {
      return std::bit_cast<V>(
          _mm256_permutevar8x32_epi32(std::bit_cast<__m256i>(values), std::bit_cast<__m256i>(order)));
    }
#endif
    V moved{};
    for (int i = 0; i < kLaneCount<F>; ++i) moved[i] = values[order[i]];
    return moved;
  }

  unsigned bits_;
  U order_;
};

}  // namespace mlt
