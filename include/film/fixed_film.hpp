// The Metropolis film: 64-bit fixed point, in one or several copies that are summed at the end. Integer
// addition commutes, so the sum has the same bits for any schedule, any number of workers, and any division
// of the workers over copies; workers that share a copy add atomically. Values are F / (I + p w) with weights
// in [0,1] per mutation, so a channel of one splat is at most 1 / 0.0722 < 14, whatever the scene's
// brightness; the fraction bits follow from the job's number of mutations so that no sum can overflow.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>

#include "base/assert.hpp"
#include "math/vec.hpp"

namespace mlt {

struct FilmPixel {
  std::int64_t metropolis[3] = {0, 0, 0};  ///< developed with the final b
  /// Both sums of the chains of one half less those of the other half (error_estimate.hpp).
  std::int64_t difference[3] = {0, 0, 0};
  std::int64_t uniform[3] = {0, 0, 0};  ///< large steps; developed with the frozen b of the weights
};

inline constexpr std::uint32_t kMinFractionBits = 28;
inline constexpr std::uint32_t kMaxFractionBits = 40;

/// Fraction bits for a film that takes `mutations` mutations (>= 1) in all; below kMinFractionBits when there
/// is no headroom for so many. With 2^k >= mutations, all of them in one pixel sum to at most
/// 14 * 2^(k + bits). Chains splat at most 2^(k + 1) states; rounding adds half a unit for each of their s
/// splats, s * 2^k in all. With k + bits <= 59 the sum is below 2^63 as long as s * 2^k <= 2^60
/// (docs/ESTIMATOR.md).
constexpr std::uint32_t film_fraction_bits(std::uint64_t mutations) {
  std::uint32_t count_bits = 0;
  while (count_bits < 59 && (std::uint64_t{1} << count_bits) < mutations) ++count_bits;
  const std::uint32_t bits = 59 - count_bits;
  return bits < kMaxFractionBits ? bits : kMaxFractionBits;
}

/// A double in [0, 14 * 2^59] to the nearest integer (ties up); to the nearest double from 2^53 on.
inline std::int64_t to_fixed(double scaled) {
  MLT_CHECK_OP(scaled, >=, 0.0);
  MLT_CHECK_OP(scaled, <=, 14.0 * 0x1p59);
  return static_cast<std::int64_t>(scaled + 0.5);
}

/// Who splats to the same pixels at the same time.
enum class FilmWriters : std::uint8_t { one, several };

class FixedFilm {
 public:
  FixedFilm() = default;
  /// `half` is 1 or -1 for the half that the splats belong to, 0 for neither.
  FixedFilm(std::span<FilmPixel> pixels, std::uint32_t fraction_bits, int half = 0,
            FilmWriters writers = FilmWriters::one)
      : pixels_(pixels),
        scale_(static_cast<double>(std::uint64_t{1} << fraction_bits)),
        half_(half),
        writers_(writers) {}

  /// Inline whatever else the source holds: left to the compiler, that depends on the number of its kernels.
  [[gnu::always_inline]] inline void splat(std::uint32_t pixel, const Vec3& value, double metropolis_weight,
                                           double uniform_weight) {
    FilmPixel& target = this->pixel(pixel);
    if (metropolis_weight != 0.0) add(target.metropolis, target.difference, value, metropolis_weight);
    if (uniform_weight != 0.0) add(target.uniform, target.difference, value, uniform_weight);
  }

  /// The same in the lanes of `lanes`, each to a film of its own; the films are of one job. Uniform weights
  /// are 1 in the lanes of `uniform` and 0 elsewhere.
  template <VectorType F>
  MLT_INLINE static void splat_lanes(std::span<FixedFilm> films, MaskOf<F> lanes, const UintOf<F>& pixels,
                                     const Vec3Of<F>& values, const double* metropolis_weights,
                                     MaskOf<F> uniform) {
    const double scale = films[0].scale_;
    add_lanes<F>(films, lanes, pixels, values, load_wide<DoubleOf<F>>(metropolis_weights) * scale,
                 &FilmPixel::metropolis);
    uniform &= lanes;
    if (any(uniform))
      add_lanes<F>(films, uniform, pixels, values, DoubleOf<F>{} + scale, &FilmPixel::uniform);
  }

  /// Asks for the memory of a pixel that is about to be splatted, for writing: what nearly all splats add to
  /// lies in one or two cache lines.
  [[gnu::always_inline]] inline void prefetch(std::uint32_t pixel) const {
    const FilmPixel& target = this->pixel(pixel);
    __builtin_prefetch(&target.metropolis[0], 1);
    __builtin_prefetch(&target.difference[2], 1);
  }

  std::span<FilmPixel> pixels() const { return pixels_; }

 private:
  MLT_INLINE FilmPixel& pixel(std::uint32_t index) const {
    MLT_CHECK_OP(index, <, pixels_.size());
    return pixels_[index];
  }

  using Sums = std::int64_t[3];

  /// Products are formed in all lanes together.
  template <class F>
  MLT_INLINE static void add_lanes(std::span<FixedFilm> films, MaskOf<F> lanes, const UintOf<F>& pixels,
                                   const Vec3Of<F>& values, const DoubleOf<F>& scaled_weights,
                                   Sums FilmPixel::*sums) {
    alignas(64) double scaled[3][kLaneCount<F>];
    store_wide(scaled[0], to_double(values.x) * scaled_weights);
    store_wide(scaled[1], to_double(values.y) * scaled_weights);
    store_wide(scaled[2], to_double(values.z) * scaled_weights);
    for_lanes(lanes, [&](int lane) {
      FixedFilm& film = films[static_cast<std::size_t>(lane)];
      FilmPixel& target = film.pixel(lane_of(pixels, lane));
      for (int c = 0; c < 3; ++c) film.add((target.*sums)[c], target.difference[c], scaled[c][lane]);
    });
  }

  void add(std::int64_t* sums, std::int64_t* differences, const Vec3& value, double weight) {
    const double scaled = weight * scale_;
    for (int c = 0; c < 3; ++c) add(sums[c], differences[c], static_cast<double>(value[c]) * scaled);
  }

  MLT_INLINE void add(std::int64_t& sum, std::int64_t& difference, double scaled) {
    const std::int64_t fixed = to_fixed(scaled);
    increase(sum, fixed);
    increase(difference, half_ * fixed);
  }

  /// The sums are read only after the threads have met, which orders all additions before the reading.
  void increase(std::int64_t& sum, std::int64_t addend) {
    if (writers_ == FilmWriters::one) [[likely]] {
      sum += addend;
    } else {
      std::atomic_ref<std::int64_t>(sum).fetch_add(addend, std::memory_order_relaxed);
    }
  }

  std::span<FilmPixel> pixels_;
  double scale_ = 0;
  std::int64_t half_ = 0;
  FilmWriters writers_ = FilmWriters::one;
};

/// Adds pixels [first, last) of `source` to `sum`.
void add_films(std::span<FilmPixel> sum, std::span<const FilmPixel> source, std::size_t first,
               std::size_t last);

/// What turns the sums into radiance: pixels * (b * metropolis + w * uniform) / (mutations * 2^bits).
struct FilmNormalisation {
  double b = 0;
  double weight_b = 0;
  std::uint64_t mutations = 0;
  std::uint32_t fraction_bits = 0;
};

/// What one unit of a film's sums is worth, before b or weight_b.
inline double film_scale(const FilmNormalisation& normalisation, std::size_t pixels) {
  const double unit = static_cast<double>(std::uint64_t{1} << normalisation.fraction_bits);
  return static_cast<double>(pixels) / (static_cast<double>(normalisation.mutations) * unit);
}

/// Develops pixels [first, last) of a summed film.
void develop_film(std::span<const FilmPixel> film, const FilmNormalisation& normalisation,
                  std::span<Vec3> image, std::size_t first, std::size_t last);

}  // namespace mlt
