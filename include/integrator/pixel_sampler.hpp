// The path tracer's samples: within each pixel, every pair of dimensions is an Owen-scrambled Sobol' (0,2)
// sequence, and pairs are decorrelated from each other and from other pixels by nested uniform shuffles
// [Burley20]. A pure function of (seed, pixel, sample index, dimension).
#pragma once

#include <cstdint>

#include "integrator/sampler.hpp"
#include "math/rng.hpp"
#include "math/vec.hpp"

namespace mlt {

constexpr std::uint32_t reverse_bits(std::uint32_t x) {
  x = __builtin_bswap32(x);
  x = ((x >> 4) & 0x0f0f0f0fU) | ((x & 0x0f0f0f0fU) << 4);
  x = ((x >> 2) & 0x33333333U) | ((x & 0x33333333U) << 2);
  return ((x >> 1) & 0x55555555U) | ((x & 0x55555555U) << 1);
}

/// Hash in which each bit is influenced by lower bits only [Laine11]; on bit-reversed numbers it is an Owen
/// scramble. The constants are those of [Vegdahl21], which pass its statistical comparison with true
/// scrambling better than the original ones.
constexpr std::uint32_t laine_karras(std::uint32_t x, std::uint32_t seed) {
  x ^= x * 0x3d20adeaU;
  x += seed;
  x *= (seed >> 16) | 1U;
  x ^= x * 0x05526c56U;
  x ^= x * 0x53a22864U;
  return x;
}

/// The second dimension of the Sobol' sequence with its 32 fraction bits reversed; the first, so reversed, is
/// the index itself [Kollig02]. The generator matrix is Pascal's triangle modulo 2, the product of five
/// sparse matrices.
constexpr std::uint32_t reversed_sobol_second(std::uint32_t index) {
  index ^= (index & 0xffff0000U) >> 16;
  index ^= (index & 0xff00ff00U) >> 8;
  index ^= (index & 0xf0f0f0f0U) >> 4;
  index ^= (index & 0xccccccccU) >> 2;
  return index ^ (index & 0xaaaaaaaaU) >> 1;
}

class PixelSampler : public FloatSamples<PixelSampler> {
 public:
  /// For `sample_count` samples (>= 1) of a sequence in each pixel of a film of width x height pixels.
  PixelSampler(std::uint64_t seed, std::uint32_t width, std::uint32_t height, std::uint64_t sample_count)
      : seed_(seed), width_(width), height_(height) {
    // Index bits above the sample count would only add a constant digital shift, which the scramble adds
    // anyway.
    while (index_mask_ < sample_count - 1 && index_mask_ != 0xffffffffU)
      index_mask_ = (index_mask_ << 1) | 1U;
  }

  /// Sample `sample` of the pixel's sequence number `sequence`; sequences are independent.
  void start(std::uint32_t x, std::uint32_t y, std::uint32_t sample, std::uint64_t sequence = 0) {
    x_ = x;
    y_ = y;
    reversed_sample_ = reverse_bits(sample);
    dimension_ = 0;
    pixel_key_ = Rng(seed_, StreamPurpose::kPixel, std::uint64_t{y} << 32 | x).next_key();
    if (sequence != 0) pixel_key_ = mix64(pixel_key_ + 0xd1b54a32d192ed03ULL * sequence);
  }

  std::uint32_t next_fixed() {
    if (dimension_ < 2) return next_film_coordinate();
    const std::uint64_t key = dimension_key();
    dimension_ += 1;
    return reverse_bits(laine_karras(shuffled_index(key), static_cast<std::uint32_t>(key >> 32)));
  }

  Vec2 next_2d() {
    const std::uint64_t key = dimension_key();
    dimension_ += 2;
    const PairSample pair = sobol_pair(key);
    return Vec2{unit_float(pair.first), unit_float(pair.second)};
  }

  void skip(std::uint32_t count) { dimension_ += count; }

  /// How far the path has come: samples asked for or skipped since start().
  std::uint32_t dimension() const { return dimension_; }

 private:
  struct PairSample {
    std::uint32_t first, second;
  };

  std::uint64_t dimension_key() const { return mix64(pixel_key_ + 0x9e3779b97f4a7c15ULL * (dimension_ + 1)); }

  std::uint32_t shuffled_index(std::uint64_t key) const {
    return reverse_bits(laine_karras(reversed_sample_, static_cast<std::uint32_t>(key))) & index_mask_;
  }

  PairSample sobol_pair(std::uint64_t key) const {
    const std::uint32_t index = shuffled_index(key);
    const std::uint64_t scrambles = mix64(key);
    return {reverse_bits(laine_karras(index, static_cast<std::uint32_t>(scrambles))),
            reverse_bits(
                laine_karras(reversed_sobol_second(index), static_cast<std::uint32_t>(scrambles >> 32)))};
  }

  /// Dimensions 0 and 1 are film coordinates in [0,1) of the whole film: the smallest fixed-point number at
  /// or after pixel + jitter, so that multiplying by the width gives back exactly this pixel.
  std::uint32_t next_film_coordinate() {
    const std::uint64_t key = mix64(pixel_key_);
    const PairSample jitter = sobol_pair(key);
    const std::uint64_t pixel = dimension_ == 0 ? x_ : y_;
    const std::uint64_t side = dimension_ == 0 ? width_ : height_;
    const std::uint64_t position = pixel << 32 | (dimension_ == 0 ? jitter.first : jitter.second);
    dimension_ += 1;
    const std::uint64_t rounded_up = (position + side - 1) / side;
    const std::uint64_t last = (((pixel + 1) << 32) - 1) / side;
    return static_cast<std::uint32_t>(rounded_up < last ? rounded_up : last);
  }

  std::uint64_t seed_;
  std::uint32_t width_, height_;
  std::uint32_t index_mask_ = 0;
  std::uint32_t x_ = 0, y_ = 0, reversed_sample_ = 0;
  std::uint32_t dimension_ = 0;
  std::uint64_t pixel_key_ = 0;
};

}  // namespace mlt
