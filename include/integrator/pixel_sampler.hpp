// The path tracer's samples: within each pixel, every pair of dimensions is an Owen-scrambled Sobol' (0,2)
// sequence, and pairs are decorrelated from each other and from other pixels by nested uniform shuffles
// [Burley20]. A pure function of (seed, pixel, sample index, dimension). Samples are consumed in blocks, so a
// dimension is computed for a block at once, in SIMD lanes, when the first asks for it.
#pragma once

#include <cstdint>

#include "integrator/sampler.hpp"
#include "math/gather.hpp"
#include "math/reverse_bits.hpp"
#include "math/rng.hpp"
#include "math/simd.hpp"
#include "math/vec.hpp"

namespace mlt {

// The functions below take std::uint32_t or integers in lanes, which they treat alike.

/// Hash in which each bit is influenced by lower bits only [Laine11]; on bit-reversed numbers it is an Owen
/// scramble. The constants are those of [Vegdahl21], which pass its statistical comparison with true
/// scrambling better than the original ones.
template <class Bits, class Seed>
MLT_INLINE constexpr Bits laine_karras(Bits x, Seed seed) {
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
template <class Bits>
MLT_INLINE constexpr Bits reversed_sobol_second(Bits index) {
  index ^= (index & 0xffff0000U) >> 16;
  index ^= (index & 0xff00ff00U) >> 8;
  index ^= (index & 0xf0f0f0f0U) >> 4;
  index ^= (index & 0xccccccccU) >> 2;
  return index ^ (index & 0xaaaaaaaaU) >> 1;
}

/// Lanes have samples of one block of a pixel's, whose numbers are made together and kept, or, where pixels
/// have fewer samples than there are lanes, each a sample of any pixel.
template <class F>
class PixelSamplerOf : public FloatSamples<PixelSamplerOf<F>, F> {
  using U = UintOf<F>;

 public:
  /// Samples of a pixel whose numbers are made together.
  static constexpr std::uint32_t kBlock = VectorType<F> ? 64 : 8;

  /// Which samples of a block the lanes have, and how far these have come.
  struct Position {
    U slots{};
    std::uint32_t first = 0;     ///< slot of lane 0
    bool is_consecutive = true;  ///< whether other lanes' slots follow it
    Progress<F> progress;

    /// Gives a lane's sample to a lane of other samples that have come as far.
    void move_lane(int lane, Position& to, int to_lane) const {
      set_lane_of(to.slots, to_lane, lane_of(slots, lane));
      to.is_consecutive = false;
      progress.move_lane(lane, to.progress, to_lane);
    }
  };

  /// For `sample_count` samples (>= 1) of a sequence in each pixel of a film of width x height pixels.
  PixelSamplerOf(std::uint64_t seed, std::uint32_t width, std::uint32_t height, std::uint64_t sample_count)
      : seed_(seed), width_(width), height_(height), sample_count_(sample_count) {
    // Index bits above the sample count would only add a constant digital shift, which the scramble adds
    // anyway.
    while (index_mask_ < sample_count - 1 && index_mask_ != 0xffffffffU)
      index_mask_ = (index_mask_ << 1) | 1U;
  }

  /// Sample `sample`, a multiple of the number of lanes, and those after it of the pixel's sequence number
  /// `sequence`; sequences are independent.
  void start(std::uint32_t x, std::uint32_t y, std::uint32_t sample, std::uint64_t sequence = 0) {
    const bool is_new = sequence_stamp_ == 0 || x != x_ || y != y_ || sequence != sequence_;
    if (is_new) start_sequence(x, y, sequence);
    if (is_new || sample / kBlock != block_) start_block(sample / kBlock);
    position_.first = sample % kBlock;
    position_.is_consecutive = true;
    for (int lane = 0; lane < kLaneCount<F>; ++lane)
      set_lane_of(position_.slots, lane, position_.first + static_cast<std::uint32_t>(lane));
    is_scattered_ = false;
    position_.progress.restart();
  }

  /// Leaves samples for others of the same block; resume() goes on where they were left.
  const Position& position() const { return position_; }
  void resume(const Position& position) { position_ = position; }

  /// Instead: for each lane, then start_scattered().
  void place(int lane, std::uint32_t x, std::uint32_t y, std::uint32_t sample, std::uint64_t sequence) {
    scattered_[lane] = {x, y, key_of(x, y, sequence)};
    set_lane_of(reversed_, lane, reverse_bits(sample));
  }
  void start_scattered() {
    is_scattered_ = true;
    position_.progress.restart();
  }

  U next_fixed(MaskOf<F> active = not_in(MaskOf<F>{})) {
    const std::uint32_t dimension = position_.progress.advance(1, active);
    if (is_scattered_) return scattered_samples(dimension);
    if (dimension == 0) return film_coordinates(x_, width_, last_x_, film_.first);
    if (dimension == 1) return film_coordinates(y_, height_, last_y_, film_.second);
    return at_slots(samples_of(dimension, Kind::single).first);
  }

  Vec2Of<F> next_2d(MaskOf<F> active = not_in(MaskOf<F>{})) {
    const std::uint32_t dimension = position_.progress.advance(2, active);
    if (is_scattered_) {
      U first, second;
      scatter(first, second, Kind::pair, dimension + 1);
      return Vec2Of<F>{unit_float(first), unit_float(second)};
    }
    const Samples& samples = samples_of(dimension, Kind::pair);
    return Vec2Of<F>{unit_float(at_slots(samples.first)), unit_float(at_slots(samples.second))};
  }

  void skip(std::uint32_t count, MaskOf<F> active = not_in(MaskOf<F>{})) {
    position_.progress.advance(count, active);
  }

  /// How far the paths have come since start().
  U dimension() const { return position_.progress.reached(); }

 private:
  /// Dimensions beyond it, which few paths reach, share one place.
  static constexpr std::uint32_t kRemembered = 128;
  /// Numbers that are made at a time.
  using Step = std::conditional_t<(sizeof(F) > sizeof(LaneUint)), U, LaneUint>;
  static constexpr std::uint32_t kStep = sizeof(Step) / 4;
  static_assert(kBlock % kStep == 0 && kBlock % kLaneCount<F> == 0);

  enum class Kind : std::uint8_t { single, pair };

  /// A dimension of a block of samples, or a pair of them.
  struct Samples {
    alignas(64) std::uint32_t first[kBlock];
    std::uint32_t second[kBlock];      ///< of a pair
    std::uint64_t key = 0;             ///< hash of the dimension, the same for all blocks of a sequence
    std::uint64_t sequence_stamp = 0;  ///< that `key` belongs to
    std::uint64_t tag = 0;             ///< of the block and the kind that the samples belong to
  };

  void start_sequence(std::uint32_t x, std::uint32_t y, std::uint64_t sequence) {
    x_ = x;
    y_ = y;
    sequence_ = sequence;
    sequence_stamp_ += 1;
    last_x_ = last_coordinate(x, width_);
    last_y_ = last_coordinate(y, height_);
    sequence_key_ = key_of(x, y, sequence);
  }

  std::uint64_t key_of(std::uint32_t x, std::uint32_t y, std::uint64_t sequence) const {
    const std::uint64_t key = Rng(seed_, StreamPurpose::kPixel, std::uint64_t{y} << 32 | x).next_key();
    return sequence == 0 ? key : mix64(key + 0xd1b54a32d192ed03ULL * sequence);
  }

  MLT_INLINE U at_slots(const std::uint32_t* samples) const {
    if (position_.is_consecutive) return load_wide<U>(samples + position_.first);
    return gather_bytes<F>(samples, position_.slots * 4U);
  }

  /// compute() for lanes of several pixels; number 0 stands for the film's dimensions.
  [[gnu::noinline]] void scatter(U& first, U& second, Kind kind, std::uint32_t number) const {
    U keys{}, low{}, high{};
    for (int lane = 0; lane < kLaneCount<F>; ++lane) {
      const std::uint64_t key = mix64(scattered_[lane].key + 0x9e3779b97f4a7c15ULL * number);
      const std::uint64_t scrambles = kind == Kind::pair ? mix64(key) : key >> 32;
      set_lane_of(keys, lane, static_cast<std::uint32_t>(key));
      set_lane_of(low, lane, static_cast<std::uint32_t>(scrambles));
      set_lane_of(high, lane, static_cast<std::uint32_t>(scrambles >> 32));
    }
    const U index = reverse_bits(laine_karras(reversed_, keys)) & index_mask_;
    first = reverse_bits(laine_karras(index, low));
    second = reverse_bits(laine_karras(reversed_sobol_second(index), high));
  }

  [[gnu::noinline]] U scattered_samples(std::uint32_t dimension) const {
    U first, second;
    if (dimension > 1) {
      scatter(first, second, Kind::single, dimension + 1);
      return first;
    }
    scatter(first, second, Kind::pair, 0);
    for (int lane = 0; lane < kLaneCount<F>; ++lane) {
      const auto [x, y, key] = scattered_[lane];
      const std::uint32_t coordinate =
          dimension == 0 ? film_coordinate(x, width_, last_coordinate(x, width_), lane_of(first, lane))
                         : film_coordinate(y, height_, last_coordinate(y, height_), lane_of(second, lane));
      set_lane_of(first, lane, coordinate);
    }
    return first;
  }

  void start_block(std::uint32_t block) {
    block_ = block;
    block_stamp_ += 1;
    const std::uint64_t first = std::uint64_t{block} * kBlock;
    const std::uint64_t left = first < sample_count_ ? sample_count_ - first : kBlock;
    used_ = left < kBlock ? (static_cast<std::uint32_t>(left) + kStep - 1) / kStep * kStep : kBlock;
    for (std::uint32_t slot = 0; slot < used_; ++slot)
      reversed_samples_[slot] = reverse_bits(block * kBlock + slot);
    film_.key = mix64(sequence_key_);
    compute(film_, Kind::pair);
  }

  std::uint64_t tag_of(Kind kind) const { return block_stamp_ << 1 | static_cast<std::uint64_t>(kind); }

  const Samples& samples_of(std::uint32_t dimension, Kind kind) {
    const bool is_remembered = dimension < kRemembered;
    Samples& samples = remembered_[is_remembered ? dimension : kRemembered];
    if (samples.tag != tag_of(kind) || !is_remembered) [[unlikely]]
      compute_dimension(samples, dimension, kind);
    return samples;
  }

  [[gnu::noinline]] void compute_dimension(Samples& samples, std::uint32_t dimension, Kind kind) {
    if (samples.sequence_stamp != sequence_stamp_ || dimension >= kRemembered) {
      samples.sequence_stamp = sequence_stamp_;
      samples.key = mix64(sequence_key_ + 0x9e3779b97f4a7c15ULL * (dimension + 1));
    }
    compute(samples, kind);
  }

  void compute(Samples& samples, Kind kind) const {
    samples.tag = tag_of(kind);
    const std::uint64_t scrambles = kind == Kind::pair ? mix64(samples.key) : samples.key >> 32;
    for (std::uint32_t i = 0; i < used_; i += kStep) {
      const Step shuffled =
          laine_karras(load_wide<Step>(reversed_samples_ + i), static_cast<std::uint32_t>(samples.key));
      const Step index = reverse_bits(shuffled) & index_mask_;
      store_wide(samples.first + i, reverse_bits(laine_karras(index, static_cast<std::uint32_t>(scrambles))));
      if (kind == Kind::pair) {
        store_wide(samples.second + i,
                   reverse_bits(laine_karras(reversed_sobol_second(index),
                                             static_cast<std::uint32_t>(scrambles >> 32))));
      }
    }
  }

  U film_coordinates(std::uint32_t pixel, std::uint32_t side, std::uint32_t last,
                     const std::uint32_t* jitters) const {
    U coordinates{};
    for (int lane = 0; lane < kLaneCount<F>; ++lane) {
      set_lane_of(coordinates, lane,
                  film_coordinate(pixel, side, last, jitters[lane_of(position_.slots, lane)]));
    }
    return coordinates;
  }

  /// Dimensions 0 and 1 are film coordinates in [0,1) of the whole film: the smallest fixed-point number at
  /// or after pixel + jitter, so that multiplying by the side gives back exactly this pixel.
  static std::uint32_t film_coordinate(std::uint32_t pixel, std::uint32_t side, std::uint32_t last,
                                       std::uint32_t jitter) {
    // At the film's end it may be 2^32.
    const std::uint64_t rounded_up = quotient((std::uint64_t{pixel} << 32 | jitter) + side - 1, side);
    return rounded_up < last ? static_cast<std::uint32_t>(rounded_up) : last;
  }

  static std::uint32_t last_coordinate(std::uint32_t pixel, std::uint32_t side) {
    return static_cast<std::uint32_t>(quotient(((std::uint64_t{pixel} + 1) << 32) - 1, side));
  }

  /// The integer part of a / b for a < 2^49 and b <= 2^16, by the division of doubles. A quotient that is no
  /// integer is at least 2^-16 below the next one, and below 2^33, where doubles are 2^-20 apart: rounding
  /// does not reach it.
  static std::uint64_t quotient(std::uint64_t a, std::uint32_t b) {
    const double ratio = static_cast<double>(static_cast<std::int64_t>(a)) / static_cast<double>(b);
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(ratio));
  }

  std::uint64_t seed_;
  std::uint32_t width_, height_;
  std::uint64_t sample_count_;
  std::uint32_t index_mask_ = 0;
  std::uint32_t x_ = 0, y_ = 0, last_x_ = 0, last_y_ = 0;
  std::uint32_t block_ = 0, used_ = 0;  ///< of whose numbers so many are made
  Position position_;
  std::uint64_t sequence_ = 0, sequence_key_ = 0;
  std::uint64_t sequence_stamp_ = 0, block_stamp_ = 0;  ///< numbers of sequences and blocks started
  alignas(64) std::uint32_t reversed_samples_[kBlock] = {};
  /// Where a lane's sample lies, and the key of its sequence.
  struct Place {
    std::uint32_t x, y;
    std::uint64_t key;
  };
  Place scattered_[kLaneCount<F>] = {};
  U reversed_{};  ///< indices of scattered samples
  bool is_scattered_ = false;
  Samples film_;
  Samples remembered_[kRemembered + 1];
};
using PixelSampler = PixelSamplerOf<float>;

}  // namespace mlt
