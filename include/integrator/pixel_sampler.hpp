// The path tracer's samples: within each pixel, every pair of dimensions is an Owen-scrambled Sobol' (0,2)
// sequence, and pairs are decorrelated from each other and from other pixels by nested uniform shuffles
// [Burley20]. A pure function of (seed, pixel, sample index, dimension). Samples are consumed in blocks, of
// one pixel or several, so a dimension is computed for a block at once, in SIMD lanes, when the first asks
// for it.
#pragma once

#include <bit>
#include <cstdint>
#include <type_traits>

#include "base/assert.hpp"
#include "integrator/sampler.hpp"
#include "math/gather.hpp"
#include "math/reverse_bits.hpp"
#include "math/rng.hpp"
#include "math/simd.hpp"
#include "math/vec.hpp"

namespace mlt {

// The functions below take std::uint32_t or a vector, whose lanes they treat alike.

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

/// A sample of a pixel; sequences are independent.
struct PixelSample {
  std::uint32_t x = 0, y = 0;
  std::uint64_t sequence = 0;
  std::uint32_t index = 0;  ///< in the sequence
};

/// A block of samples of any pixels has a slot for each, and lanes take slots.
template <class F>
class PixelSamplerOf : public FloatSamples<PixelSamplerOf<F>, F> {
  using U = UintOf<F>;
  /// As numbers are made.
  using Lanes = std::conditional_t<VectorType<F>, U, LaneUint>;
  static constexpr std::uint32_t kStep = kLaneCount<Lanes>;

 public:
  /// Samples whose numbers are made together.
  static constexpr std::uint32_t kBlock = VectorType<F> ? 64 : 8;

  /// Which samples of the block the lanes have, and how far these have come.
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
      : stream_(seed, StreamPurpose::kPixel), width_(width), height_(height) {
    // Index bits above the sample count would only add a constant digital shift, which the scramble adds
    // anyway.
    while (index_mask_ < sample_count - 1 && index_mask_ != 0xffffffffU)
      index_mask_ = (index_mask_ << 1) | 1U;
  }

  /// Empties the block.
  void clear() {
    run_count_ = 0;
    count_ = 0;
    block_stamp_ += 1;
  }

  /// Adds `first` and the samples after it, `count` (>= 1) in all, to a block with room for one or more;
  /// returns how many it had room for. Must be called before the block's first start().
  std::uint32_t place(const PixelSample& first, std::uint64_t count) {
    MLT_CHECK_OP(count, >, 0U);
    MLT_CHECK_OP(count_, <, kBlock);
    const std::uint32_t room = kBlock - count_;
    const std::uint32_t placed = count < room ? static_cast<std::uint32_t>(count) : room;
    keys_[run_count_ % 2][run_count_ / 2] = key_of(first);
    runs_[run_count_++] = {first, count_};
    // As with all arrays of the slots: what is written beyond a run's own, the next one writes later.
    for (std::uint32_t i = 0; i < placed; i += kStep)
      store_wide(reversed_samples_ + count_ + i, reverse_bits(lane_numbers<Lanes>() + (first.index + i)));
    count_ += placed;
    return placed;
  }

  std::uint32_t count() const { return count_; }

  /// The samples of `slot`, a multiple of the number of lanes, and the slots after it.
  void start(std::uint32_t slot) {
    position_.first = slot;
    position_.is_consecutive = true;
    position_.slots = lane_numbers<U>() + slot;
    position_.progress.restart();
  }

  /// Leaves samples for others of the same block; resume() goes on where they were left.
  const Position& position() const { return position_; }
  void resume(const Position& position) { position_ = position; }

  /// Calls visit(slot, PixelSample) for the block's samples in order.
  template <class Visit>
  void for_samples(Visit&& visit) const {
    for (std::uint32_t r = 0; r < run_count_; ++r) {
      PixelSample sample = runs_[r].sample;
      for (std::uint32_t slot = runs_[r].slot; slot < end_of(r); ++slot, ++sample.index) visit(slot, sample);
    }
  }

  U next_fixed(MaskOf<F> active = not_in(MaskOf<F>{})) {
    const std::uint32_t dimension = position_.progress.advance(1, active);
    return at_slots(samples_of(dimension, Kind::single).first);
  }

  Vec2Of<F> next_2d(MaskOf<F> active = not_in(MaskOf<F>{})) {
    const std::uint32_t dimension = position_.progress.advance(2, active);
    const Samples& samples = samples_of(dimension, Kind::pair);
    return Vec2Of<F>{unit_float(at_slots(samples.first)), unit_float(at_slots(samples.second))};
  }

  void skip(std::uint32_t count, MaskOf<F> active = not_in(MaskOf<F>{})) {
    position_.progress.advance(count, active);
  }

  /// How far the paths have come since start().
  U dimension() const { return position_.progress.reached(); }

 private:
  /// Dimensions that are so far apart share a place. Paths of a block go on together, so those that are asked
  /// for in turn are close.
  static constexpr std::uint32_t kRemembered = 128;
  static_assert(kBlock % kStep == 0);

  enum class Kind : std::uint8_t { single, pair };

  using HalfLanes = typename Wide<kStep>::Uint64;

  /// Slots whose samples follow each other in a sequence.
  struct Run {
    PixelSample sample;  ///< the first
    std::uint32_t slot;
  };

  /// A dimension of a block of samples, or a pair of them.
  struct Samples {
    alignas(sizeof(Lanes)) std::uint32_t first[kBlock];
    std::uint32_t second[kBlock];  ///< of a pair
    std::uint64_t tag = 0;         ///< tells the block, the dimension and the kind
  };

  /// Of the shuffle and of the scrambles of one dimension or two: one of each, or one a lane.
  template <class Bits>
  struct Seeds {
    Bits shuffle, first, second;
  };
  struct SeedArrays {
    std::uint32_t shuffle[kBlock + kStep], first[kBlock + kStep], second[kBlock + kStep];

    MLT_INLINE void store(std::uint32_t at, const Seeds<Lanes>& seeds) {
      store_wide(shuffle + at, seeds.shuffle);
      store_wide(first + at, seeds.first);
      store_wide(second + at, seeds.second);
    }
    MLT_INLINE Seeds<Lanes> load(std::uint32_t at) const {
      return {load_wide<Lanes>(shuffle + at), load_wide<Lanes>(first + at), load_wide<Lanes>(second + at)};
    }
    MLT_INLINE Seeds<Lanes> broadcast(std::uint32_t at) const {
      return {broadcast_bits<Lanes>(shuffle[at]), broadcast_bits<Lanes>(first[at]),
              broadcast_bits<Lanes>(second[at])};
    }
  };

  std::uint64_t key_of(const PixelSample& sample) const {
    const std::uint64_t pixel = std::uint64_t{sample.y} << 32 | sample.x;
    const std::uint64_t key = Rng(stream_, pixel).next_key();
    return sample.sequence == 0 ? key : mix64(key + 0xd1b54a32d192ed03ULL * sample.sequence);
  }

  MLT_INLINE U at_slots(const std::uint32_t* samples) const {
    if (position_.is_consecutive) return load_wide<U>(samples + position_.first);
    return gather_bytes<F>(samples, position_.slots * 4U);
  }

  /// Of fewer than 2^15 dimensions; paths have some thousand at most.
  std::uint64_t tag_of(std::uint32_t dimension, Kind kind) const {
    return block_stamp_ << 16 | dimension << 1 | static_cast<std::uint64_t>(kind);
  }

  MLT_INLINE const Samples& samples_of(std::uint32_t dimension, Kind kind) {
    Samples& samples = remembered_[dimension % kRemembered];
    if (samples.tag != tag_of(dimension, kind)) [[unlikely]] {
      if (dimension < 2 && kind == Kind::single) {
        compute_film();
      } else {
        compute(samples, dimension + 1, kind);
        samples.tag = tag_of(dimension, kind);
      }
    }
    return samples;
  }

  /// Where the slots of a run end.
  std::uint32_t end_of(std::uint32_t run) const {
    return run + 1 < run_count_ ? runs_[run + 1].slot : count_;
  }

  /// Slots that are filled, and those that start together with the last of them.
  std::uint32_t used() const { return (count_ + kStep - 1) / kStep * kStep; }

  static constexpr std::uint64_t kNumberFactor = 0x9e3779b97f4a7c15ULL;

  /// Of a block's only run.
  MLT_INLINE Seeds<std::uint32_t> seeds_of_run(std::uint32_t number, Kind kind) const {
    const std::uint64_t key = mix64(keys_[0][0] + kNumberFactor * number);
    const std::uint64_t scrambles = kind == Kind::pair ? mix64(key) : key >> 32;
    return {static_cast<std::uint32_t>(key), static_cast<std::uint32_t>(scrambles),
            static_cast<std::uint32_t>(scrambles >> 32)};
  }

  /// Of `run`, an even number, and those after it, one in each lane.
  MLT_INLINE Seeds<Lanes> seeds_of_runs(std::uint32_t run, std::uint32_t number, Kind kind) const {
    constexpr std::uint64_t kLow = 0xffffffffU;
    const auto low = [](HalfLanes even, HalfLanes odd) __attribute__((always_inline)) {
      return std::bit_cast<Lanes>((even & kLow) | (odd << 32));
    };
    const auto high = [](HalfLanes even, HalfLanes odd) __attribute__((always_inline)) {
      return std::bit_cast<Lanes>((even >> 32) | (odd & ~kLow));
    };
    const std::uint64_t offset = kNumberFactor * number;
    HalfLanes even = mix64(load_wide<HalfLanes>(keys_[0] + run / 2) + offset);
    HalfLanes odd = mix64(load_wide<HalfLanes>(keys_[1] + run / 2) + offset);
    const Lanes shuffle = low(even, odd);
    if (kind == Kind::single) return {shuffle, high(even, odd), Lanes{}};
    even = mix64(even);
    odd = mix64(odd);
    return {shuffle, low(even, odd), high(even, odd)};
  }

  /// Number 0 stands for the film's dimensions, others for the dimension before.
  [[gnu::noinline]] void compute(Samples& samples, std::uint32_t number, Kind kind) {
    if (run_count_ == 1) {
      const auto seeds = seeds_of_run(number, kind);
      return compute_slots(samples, kind, [&](std::uint32_t) { return seeds; });
    }
    for (std::uint32_t r = 0; r < run_count_; r += kStep)
      seeds_of_runs_.store(r, seeds_of_runs(r, number, kind));
    if (run_count_ < count_) {
      for (std::uint32_t r = 0; r < run_count_; ++r) {
        const auto seeds = seeds_of_runs_.broadcast(r);
        for (std::uint32_t i = runs_[r].slot; i < end_of(r); i += kStep) seeds_of_slots_.store(i, seeds);
      }
    }
    const SeedArrays& seeds = run_count_ < count_ ? seeds_of_slots_ : seeds_of_runs_;
    compute_slots(samples, kind, [&](std::uint32_t i) { return seeds.load(i); });
  }

  template <class SeedsAt>
  MLT_INLINE void compute_slots(Samples& samples, Kind kind, SeedsAt&& seeds_at) const {
    for (std::uint32_t i = 0, end = used(); i < end; i += kStep) {
      const auto seeds = seeds_at(i);
      const Lanes shuffled = laine_karras(load_wide<Lanes>(reversed_samples_ + i), seeds.shuffle);
      const Lanes index = reverse_bits(shuffled) & index_mask_;
      store_wide(samples.first + i, reverse_bits(laine_karras(index, seeds.first)));
      if (kind == Kind::single) continue;
      store_wide(samples.second + i, reverse_bits(laine_karras(reversed_sobol_second(index), seeds.second)));
    }
  }

  /// Dimensions 0 and 1 are film coordinates in [0,1) of the whole film: the smallest fixed-point number at
  /// or after pixel + jitter, so that multiplying by the side gives back exactly this pixel.
  [[gnu::noinline]] void compute_film() {
    Samples& x = remembered_[0];
    Samples& y = remembered_[1];
    // Lanes beyond the block's samples have places, too.
    for (std::uint32_t i = count_; i < used(); ++i) x.first[i] = y.first[i] = 0;
    Samples jitters;
    compute(jitters, 0, Kind::pair);
    for (std::uint32_t r = 0; r < run_count_; ++r) {
      const auto [pixel_x, pixel_y, sequence, index] = runs_[r].sample;
      const std::uint32_t last_x = last_coordinate(pixel_x, width_);
      const std::uint32_t last_y = last_coordinate(pixel_y, height_);
      for (std::uint32_t i = runs_[r].slot; i < end_of(r); ++i) {
        x.first[i] = film_coordinate(pixel_x, width_, last_x, jitters.first[i]);
        y.first[i] = film_coordinate(pixel_y, height_, last_y, jitters.second[i]);
      }
    }
    x.tag = tag_of(0, Kind::single);
    y.tag = tag_of(1, Kind::single);
  }

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

  StreamKey stream_;
  std::uint32_t width_, height_;
  std::uint32_t index_mask_ = 0;
  std::uint32_t run_count_ = 0, count_ = 0;  ///< runs and samples of the block
  std::uint64_t block_stamp_ = 1;            ///< number of the block
  Position position_;
  Run runs_[kBlock];
  alignas(sizeof(Lanes)) std::uint32_t reversed_samples_[kBlock + kStep] = {};
  std::uint64_t keys_[2][kBlock / 2] = {};  ///< hashes of the sequences of runs of even and odd number
  SeedArrays seeds_of_runs_ = {}, seeds_of_slots_ = {};
  Samples remembered_[kRemembered];
};
using PixelSampler = PixelSamplerOf<float>;

}  // namespace mlt
