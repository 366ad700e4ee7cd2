// Floats in lanes for code that treats many paths at once, each lane doing the IEEE operations of one float.
// Code is written once, as a template over F, which is float (one lane: the reference) or Wide<n>::Float.
// Masks choose lanes: bool for one lane, else lanes of all ones or all zeros. With these functions one source
// serves both: any() and all() guard what no lane needs, select() merges, gather() reads tables.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "math/simd.hpp"

namespace mlt {

template <int kCount>
struct Wide {
  using Float __attribute__((vector_size(kCount * sizeof(float)))) = float;
  using Mask __attribute__((vector_size(kCount * sizeof(float)))) = std::int32_t;
  using Uint __attribute__((vector_size(kCount * sizeof(float)))) = std::uint32_t;
  using Double __attribute__((vector_size(kCount * sizeof(double)))) = double;
  /// Half as many lanes of 64 bits.
  using Uint64 __attribute__((vector_size(kCount * sizeof(float)))) = std::uint64_t;
};

template <>
struct Wide<1> {
  using Float = float;
  using Mask = bool;
  using Uint = std::uint32_t;
  using Double = double;
};

template <class F>
inline constexpr int kLaneCount = static_cast<int>(sizeof(F) / sizeof(float));
template <class F>
using MaskOf = typename Wide<kLaneCount<F>>::Mask;
template <class F>
using UintOf = typename Wide<kLaneCount<F>>::Uint;
/// For sums and products alone: of twice a register's size, it is compared and selected lane by lane.
template <class F>
using DoubleOf = typename Wide<kLaneCount<F>>::Double;

/// Lanes of the chains and samples that one kernel advances together: those of one register.
#if defined(__AVX512F__) && defined(__AVX512VL__) && defined(__AVX512DQ__) && defined(__AVX512BW__)
inline constexpr int kWideLanes = 16;
#else
inline constexpr int kWideLanes = kLanes;
#endif
using WideFloat = Wide<kWideLanes>::Float;

/// Has lanes that [] reaches.
template <class T>
concept VectorType = !std::is_arithmetic_v<T>;

// ---- one lane

MLT_INLINE float select(bool mask, float a, float b) {
  return mask ? a : b;
}
MLT_INLINE std::uint32_t select(bool mask, std::uint32_t a, std::uint32_t b) {
  return mask ? a : b;
}
MLT_INLINE bool any(bool mask) {
  return mask;
}
MLT_INLINE bool all(bool mask) {
  return mask;
}
MLT_INLINE bool not_in(bool mask) {
  return !mask;
}
MLT_INLINE unsigned lanes_of(bool mask) {
  return mask ? 1U : 0U;
}
MLT_INLINE float square_root(float x) {
  return std::sqrt(x);
}
MLT_INLINE double square_root(double x) {
  return std::sqrt(x);
}
MLT_INLINE float magnitude(float x) {
  return std::fabs(x);
}
MLT_INLINE std::uint32_t as_bits(float x) {
  return std::bit_cast<std::uint32_t>(x);
}
MLT_INLINE float as_floats(std::uint32_t bits) {
  return std::bit_cast<float>(bits);
}
/// Of integers below 2^31.
MLT_INLINE float to_float(std::uint32_t value) {
  return static_cast<float>(static_cast<std::int32_t>(value));
}
MLT_INLINE double to_double(float value) {
  return static_cast<double>(value);
}
/// Integer part of a float in [0, 2^31).
MLT_INLINE std::uint32_t truncated(float value) {
  return static_cast<std::uint32_t>(value);
}
MLT_INLINE std::uint32_t mask_bits(bool mask) {
  return 0U - static_cast<std::uint32_t>(mask);
}

// ---- several lanes

/// `a` in the lanes of the mask, else `b`.
template <VectorType V, VectorType M>
MLT_INLINE V select(M mask, V a, V b) {
#if defined(__AVX512VL__)
  return mask ? a : b;
#elif defined(__AVX2__)
  if constexpr (sizeof(V) == 32) {
    return std::bit_cast<V>(
        _mm256_blendv_ps(std::bit_cast<__m256>(b), std::bit_cast<__m256>(a), std::bit_cast<__m256>(mask)));
  } else {
    return std::bit_cast<V>((mask & std::bit_cast<M>(a)) | (~mask & std::bit_cast<M>(b)));
  }
#else
  return std::bit_cast<V>((mask & std::bit_cast<M>(a)) | (~mask & std::bit_cast<M>(b)));
#endif
}

/// Bit i is lane i of a mask.
template <VectorType M>
MLT_INLINE unsigned lanes_of(M mask) {
#if defined(__AVX512DQ__)
  if constexpr (sizeof(M) == 64) return _mm512_movepi32_mask(std::bit_cast<__m512i>(mask));
#endif
#if defined(__AVX2__)
  if constexpr (sizeof(M) == 32)
    return static_cast<unsigned>(_mm256_movemask_ps(std::bit_cast<__m256>(mask)));
#endif
#if defined(__SSE2__)
  if constexpr (sizeof(M) == 16) return static_cast<unsigned>(_mm_movemask_ps(std::bit_cast<__m128>(mask)));
#endif
  unsigned bits = 0;
  for (unsigned i = 0; i < sizeof(M) / 4; ++i) bits |= static_cast<unsigned>(mask[i] < 0) << i;
  return bits;
}
template <VectorType M>
MLT_INLINE bool any(M mask) {
  return lanes_of(mask) != 0;
}
template <VectorType M>
MLT_INLINE bool all(M mask) {
  return lanes_of(mask) == (1U << (sizeof(M) / 4)) - 1;
}
template <VectorType M>
MLT_INLINE M not_in(M mask) {
  return ~mask;
}

template <VectorType F>
MLT_INLINE F square_root(F x) {
#if defined(__AVX512F__)
  if constexpr (sizeof(F) == 64) return std::bit_cast<F>(_mm512_sqrt_ps(std::bit_cast<__m512>(x)));
#endif
#if defined(__AVX2__)
  if constexpr (sizeof(F) == 32) return std::bit_cast<F>(_mm256_sqrt_ps(std::bit_cast<__m256>(x)));
#endif
#if defined(__SSE2__)
  if constexpr (sizeof(F) == 16) return std::bit_cast<F>(_mm_sqrt_ps(std::bit_cast<__m128>(x)));
#endif
  F roots{};
  for (unsigned i = 0; i < sizeof(F) / 4; ++i) roots[i] = __builtin_sqrtf(x[i]);
  return roots;
}

template <VectorType F>
MLT_INLINE F magnitude(F x) {
  return std::bit_cast<F>(std::bit_cast<MaskOf<F>>(x) & 0x7fffffff);
}
template <VectorType F>
MLT_INLINE UintOf<F> as_bits(F x) {
  return std::bit_cast<UintOf<F>>(x);
}
template <VectorType U>
MLT_INLINE auto as_floats(U bits) {
  return std::bit_cast<typename Wide<sizeof(U) / 4>::Float>(bits);
}
template <VectorType U>
MLT_INLINE auto to_float(U value) {
  using Lanes = Wide<sizeof(U) / 4>;
  return __builtin_convertvector(std::bit_cast<typename Lanes::Mask>(value), typename Lanes::Float);
}
template <VectorType F>
MLT_INLINE auto to_double(F value) {
  return __builtin_convertvector(value, DoubleOf<F>);
}
template <VectorType F>
MLT_INLINE auto truncated(F value) {
  return std::bit_cast<UintOf<F>>(__builtin_convertvector(value, MaskOf<F>));
}
template <VectorType M>
MLT_INLINE auto mask_bits(M mask) {
  return std::bit_cast<typename Wide<sizeof(M) / 4>::Uint>(mask);
}

// ---- any number of lanes

template <class V, class T>
MLT_INLINE V broadcast_value(T value) {
  if constexpr (!VectorType<V>) {
    return value;
  } else if constexpr (sizeof(V) == 16) {
    return V{value, value, value, value};
  } else if constexpr (sizeof(V) == 32) {
    return V{value, value, value, value, value, value, value, value};
  } else {
    static_assert(sizeof(V) == 64);
    return V{value, value, value, value, value, value, value, value,
             value, value, value, value, value, value, value, value};
  }
}
template <class F>
MLT_INLINE F broadcast_to(float value) {
  return broadcast_value<F>(value);
}
template <class U>
MLT_INLINE U broadcast_bits(std::uint32_t value) {
  return broadcast_value<U>(value);
}

/// a < b ? a : b in each lane, so b where either is NaN.
template <class F>
MLT_INLINE F smaller(F a, F b) {
#if defined(__AVX512F__)
  if constexpr (sizeof(F) == 64)
    return std::bit_cast<F>(_mm512_min_ps(std::bit_cast<__m512>(a), std::bit_cast<__m512>(b)));
#endif
  if constexpr (std::is_same_v<F, LaneFloat>) return min_lanes(a, b);
  return select(a < b, a, b);
}
/// a > b ? a : b in each lane, so b where either is NaN.
template <class F>
MLT_INLINE F larger(F a, F b) {
#if defined(__AVX512F__)
  if constexpr (sizeof(F) == 64)
    return std::bit_cast<F>(_mm512_max_ps(std::bit_cast<__m512>(a), std::bit_cast<__m512>(b)));
#endif
  if constexpr (std::is_same_v<F, LaneFloat>) return max_lanes(a, b);
  return select(a > b, a, b);
}

/// |magnitude| with the sign of `sign`.
template <class F>
MLT_INLINE F with_sign_of(F value, F sign) {
  return as_floats((as_bits(value) & 0x7fffffffU) | (as_bits(sign) & 0x80000000U));
}
/// -x in the lanes of the mask.
template <class F>
MLT_INLINE F negate_if(MaskOf<F> mask, F x) {
  return as_floats(as_bits(x) ^ (mask_bits(mask) & 0x80000000U));
}

/// `x` in the lanes of the mask, else 1: a divisor where one lane's division by zero would be undefined.
template <class F>
MLT_INLINE F nonzero(MaskOf<F> mask, F x) {
  return select(mask, x, broadcast_to<F>(1.0f));
}
/// Whether both are positive or both negative. Comparisons of signs: the product of two tiny numbers would
/// underflow.
template <class F>
MLT_INLINE MaskOf<F> same_side(F a, F b) {
  return ((a > 0.0f) & (b > 0.0f)) | ((a < 0.0f) & (b < 0.0f));
}

/// Lane i of a value, or the value where there is one lane.
template <class V>
MLT_INLINE auto lane_of(const V& value, int lane) {
  if constexpr (VectorType<V>) {
    return value[lane];
  } else {
    return value;
  }
}
template <class V, class T>
MLT_INLINE void set_lane_of(V& value, int lane, T to) {
  if constexpr (VectorType<V>) {
    value[lane] = to;
  } else {
    value = to;
  }
}

/// A lane of a mask that is set.
template <class F>
inline constexpr auto kLaneTrue = VectorType<F> ? -1 : 1;

/// Lane i alone.
template <class F>
MLT_INLINE MaskOf<F> one_lane(int lane) {
  MaskOf<F> mask{};
  set_lane_of(mask, lane, kLaneTrue<F>);
  return mask;
}

/// The first `count` lanes.
template <class F>
MLT_INLINE MaskOf<F> first_lanes(std::uint64_t count) {
  if constexpr (VectorType<F>) {
    MaskOf<F> mask{};
    for (int i = 0; i < kLaneCount<F>; ++i) mask[i] = static_cast<std::uint64_t>(i) < count ? -1 : 0;
    return mask;
  } else {
    return count > 0;
  }
}

/// Lane i holds i.
template <class U>
MLT_INLINE U lane_numbers() {
  U numbers{};
  for (int i = 0; i < static_cast<int>(sizeof(U) / 4); ++i)
    set_lane_of(numbers, i, static_cast<std::uint32_t>(i));
  return numbers;
}

/// Lane i is bit i: the inverse of lanes_of.
template <class F>
MLT_INLINE MaskOf<F> mask_of(unsigned bits) {
  if constexpr (VectorType<F>) {
#if defined(__AVX512DQ__)
    if constexpr (sizeof(F) == 64)
      return std::bit_cast<MaskOf<F>>(_mm512_movm_epi32(static_cast<__mmask16>(bits)));
#endif
    const UintOf<F> bit = broadcast_bits<UintOf<F>>(1) << lane_numbers<UintOf<F>>();
    return (broadcast_bits<UintOf<F>>(bits) & bit) != 0U;
  } else {
    return bits != 0;
  }
}

/// Calls visit(i) for each lane of the mask, in order.
template <class M, class Visit>
MLT_INLINE void for_lanes(M mask, Visit&& visit) {
  unsigned bits = lanes_of(mask);
  while (bits != 0) visit(take_lowest(bits));
}

/// As many floats or integers as there are lanes.
template <class V, class T>
MLT_INLINE V load_wide(const T* values) {
  V wide;
  std::memcpy(&wide, values, sizeof(V));
  return wide;
}
template <class V, class T>
MLT_INLINE void store_wide(T* values, const V& wide) {
  std::memcpy(values, &wide, sizeof(V));
}

}  // namespace mlt
