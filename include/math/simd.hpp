// Vectors of float lanes, in the compilers' portable vector extensions. Every lane does the IEEE operations
// of the scalar code, so results do not depend on the number of lanes; that number follows the instruction
// set, because types wider than its registers are lowered to slow code. All objects of one program must be
// compiled for the same instruction set: the layout of blocks and nodes depends on it.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace mlt {

// AVX without AVX2 has no 8-lane integers, which masks are. AVX-512 stays at 8 lanes: blocks of 16 are
// emptier than the wider registers are fast.
#if defined(__AVX2__)
inline constexpr int kLanes = 8;
#else
inline constexpr int kLanes = 4;
#endif

using LaneFloat __attribute__((vector_size(kLanes * sizeof(float)))) = float;
/// Also the type of masks: a lane is all ones (true) or all zeros (false).
using LaneInt __attribute__((vector_size(kLanes * sizeof(float)))) = std::int32_t;
using LaneUint __attribute__((vector_size(kLanes * sizeof(float)))) = std::uint32_t;

#define MLT_INLINE [[gnu::always_inline]] inline
/// For the larger functions over lanes: a call costs little against their work for all lanes, and every
/// inlined copy costs a user of the compiler much.
/// g++ would also make clones, which are local, so that the program had one from each source that uses them.
#if defined(__clang__)
#define MLT_NOINLINE [[gnu::noinline]]
#else
#define MLT_NOINLINE [[gnu::noinline, gnu::noclone]]
#endif

MLT_INLINE LaneFloat broadcast(float value) {
#if defined(__AVX2__)
  return LaneFloat{value, value, value, value, value, value, value, value};
#else
  return LaneFloat{value, value, value, value};
#endif
}

MLT_INLINE LaneInt bits_of(LaneFloat lanes) {
  return std::bit_cast<LaneInt>(lanes);
}
MLT_INLINE LaneFloat floats_of(LaneInt lanes) {
  return std::bit_cast<LaneFloat>(lanes);
}

MLT_INLINE LaneUint load_lanes(const std::uint32_t* values) {
  LaneUint lanes;
  std::memcpy(&lanes, values, sizeof(lanes));
  return lanes;
}
MLT_INLINE void store_lanes(std::uint32_t* values, LaneUint lanes) {
  std::memcpy(values, &lanes, sizeof(lanes));
}

/// `when_true` in the lanes where `mask` is set, else `when_false`.
MLT_INLINE LaneFloat select(LaneInt mask, LaneFloat when_true, LaneFloat when_false) {
#if defined(__AVX2__)
  return std::bit_cast<LaneFloat>(_mm256_blendv_ps(
      std::bit_cast<__m256>(when_false), std::bit_cast<__m256>(when_true), std::bit_cast<__m256>(mask)));
#else
  return floats_of((mask & bits_of(when_true)) | (~mask & bits_of(when_false)));
#endif
}

/// a * b + c with one rounding or two, whichever the instruction set makes cheaper: for bounds alone, as the
/// bits depend on it.
template <class F>
MLT_INLINE F mul_add_bound(F a, F b, F c) {
#if defined(__AVX512F__) && defined(__FMA__)
  if constexpr (sizeof(F) == 64)
    return std::bit_cast<F>(
        _mm512_fmadd_ps(std::bit_cast<__m512>(a), std::bit_cast<__m512>(b), std::bit_cast<__m512>(c)));
#endif
#if defined(__AVX2__) && defined(__FMA__)
  if constexpr (sizeof(F) == 32)
    return std::bit_cast<F>(
        _mm256_fmadd_ps(std::bit_cast<__m256>(a), std::bit_cast<__m256>(b), std::bit_cast<__m256>(c)));
#endif
  return a * b + c;
}

/// `mask` set in lanes gives NaN there. The operator | on a comparison becomes a blend of three operations in
/// g++.
MLT_INLINE LaneFloat or_lanes(LaneInt mask, LaneFloat lanes) {
#if defined(__AVX2__)
  return std::bit_cast<LaneFloat>(_mm256_or_ps(std::bit_cast<__m256>(mask), std::bit_cast<__m256>(lanes)));
#else
  return floats_of(mask | bits_of(lanes));
#endif
}

/// a < b ? a : b, so b where either is NaN. The intrinsics compute exactly this.
MLT_INLINE LaneFloat min_lanes(LaneFloat a, LaneFloat b) {
#if defined(__AVX2__)
  return std::bit_cast<LaneFloat>(_mm256_min_ps(std::bit_cast<__m256>(a), std::bit_cast<__m256>(b)));
#elif defined(__SSE2__)
  return std::bit_cast<LaneFloat>(_mm_min_ps(std::bit_cast<__m128>(a), std::bit_cast<__m128>(b)));
#else
  return select(a < b, a, b);
#endif
}

/// a > b ? a : b, so b where either is NaN.
MLT_INLINE LaneFloat max_lanes(LaneFloat a, LaneFloat b) {
#if defined(__AVX2__)
  return std::bit_cast<LaneFloat>(_mm256_max_ps(std::bit_cast<__m256>(a), std::bit_cast<__m256>(b)));
#elif defined(__SSE2__)
  return std::bit_cast<LaneFloat>(_mm_max_ps(std::bit_cast<__m128>(a), std::bit_cast<__m128>(b)));
#else
  return select(a > b, a, b);
#endif
}

MLT_INLINE LaneFloat abs_lanes(LaneFloat lanes) {
  return floats_of(bits_of(lanes) & 0x7fffffff);
}

/// Square root of each lane, correctly rounded.
MLT_INLINE LaneFloat sqrt_lanes(LaneFloat lanes) {
#if defined(__AVX2__)
  return std::bit_cast<LaneFloat>(_mm256_sqrt_ps(std::bit_cast<__m256>(lanes)));
#elif defined(__SSE2__)
  return std::bit_cast<LaneFloat>(_mm_sqrt_ps(std::bit_cast<__m128>(lanes)));
#else
  LaneFloat roots{};
  for (int i = 0; i < kLanes; ++i) roots[i] = __builtin_sqrtf(lanes[i]);
  return roots;
#endif
}

/// Bit i is the sign bit of lane i, thus lane i of a mask.
MLT_INLINE unsigned lane_bits(LaneInt mask) {
#if defined(__AVX2__)
  return static_cast<unsigned>(_mm256_movemask_ps(std::bit_cast<__m256>(mask)));
#elif defined(__SSE2__)
  return static_cast<unsigned>(_mm_movemask_ps(std::bit_cast<__m128>(mask)));
#else
  unsigned bits = 0;
  for (int i = 0; i < kLanes; ++i) bits |= (static_cast<unsigned>(mask[i]) >> 31) << i;
  return bits;
#endif
}

/// Four floats, such as the corners of one shape; as wide on every machine.
using Float4 __attribute__((vector_size(4 * sizeof(float)))) = float;
using Int4 __attribute__((vector_size(4 * sizeof(float)))) = std::int32_t;

MLT_INLINE Float4 load_float4(const float* values) {
  Float4 lanes;
  std::memcpy(&lanes, values, sizeof(lanes));
  return lanes;
}
MLT_INLINE Float4 broadcast4(float value) {
  return Float4{value, value, value, value};
}
MLT_INLINE Float4 max4(Float4 a, Float4 b) {
#if defined(__SSE2__)
  return std::bit_cast<Float4>(_mm_max_ps(std::bit_cast<__m128>(a), std::bit_cast<__m128>(b)));
#else
  return std::bit_cast<Float4>(((a > b) & std::bit_cast<Int4>(a)) | (~(a > b) & std::bit_cast<Int4>(b)));
#endif
}
/// As select.
MLT_INLINE Float4 select4(Int4 mask, Float4 when_true, Float4 when_false) {
  return std::bit_cast<Float4>((mask & std::bit_cast<Int4>(when_true)) |
                               (~mask & std::bit_cast<Int4>(when_false)));
}
/// As lane_bits.
MLT_INLINE unsigned lane_bits4(Int4 mask) {
#if defined(__SSE2__)
  return static_cast<unsigned>(_mm_movemask_ps(std::bit_cast<__m128>(mask)));
#else
  unsigned bits = 0;
  for (int i = 0; i < 4; ++i) bits |= (static_cast<unsigned>(mask[i]) >> 31) << i;
  return bits;
#endif
}

/// Index of the lowest set bit, which is then cleared. `bits` must not be 0.
MLT_INLINE int take_lowest(unsigned& bits) {
  const int index = std::countr_zero(bits);
  bits &= bits - 1;
  return index;
}

}  // namespace mlt
