// The bootstrap's primary samples. Paths take one stratum of the film each, of equal areas: a number in [0,1)
// is a place on a Z-order curve [Morton66], whose bits in turn are those of x and y, so that equal parts of
// the interval are equal areas, and n paths divide it into n parts. Neighbouring paths lie side by side, and
// starts that are spread evenly over the paths are so over the film. All other samples are independent. A
// path's stratum is fixed and only all paths together are uniform: their mean is without bias, for any n.
#pragma once

#include <cstdint>

#include "base/assert.hpp"
#include "integrator/sampler.hpp"
#include "math/rng.hpp"

namespace mlt {

/// Every second bit of `x`, beginning with the lowest.
constexpr std::uint32_t even_bits(std::uint64_t x) {
  x &= 0x5555555555555555ULL;
  x = (x | x >> 1) & 0x3333333333333333ULL;
  x = (x | x >> 2) & 0x0f0f0f0f0f0f0f0fULL;
  x = (x | x >> 4) & 0x00ff00ff00ff00ffULL;
  x = (x | x >> 8) & 0x0000ffff0000ffffULL;
  return static_cast<std::uint32_t>(x | x >> 16);
}

/// A place on the film, 32-bit fixed point in [0,1).
struct FilmPlace {
  std::uint32_t x, y;
};

/// The place of path `index` of `paths` (<= 2^36), whose own uniform place `within` becomes the place within
/// its stratum: to 56 bits, (index + within) / paths, by division in two steps; the four lowest bits of x and
/// y stay. A shift of the film's bits, of the whole job, decides where the curve begins.
constexpr FilmPlace stratified_place(FilmPlace within, std::uint64_t index, std::uint64_t paths,
                                     FilmPlace shift) {
  const std::uint64_t high = index << 28 | within.x >> 4;
  const std::uint64_t low = (high % paths) << 28 | within.y >> 4;
  const std::uint64_t on_curve = (high / paths) << 28 | low / paths;
  return {(even_bits(on_curve) << 4 | (within.x & 15U)) ^ shift.x,
          (even_bits(on_curve >> 1) << 4 | (within.y & 15U)) ^ shift.y};
}

/// What all paths of a bootstrap have in common.
struct BootstrapStreams {
  StreamKey key;
  std::uint64_t paths;
  FilmPlace shift;

  BootstrapStreams(std::uint64_t seed, std::uint64_t path_count)
      : key(seed, StreamPurpose::kBootstrap), paths(path_count) {
    Rng shifts(seed, StreamPurpose::kBootstrapFilm, 0);
    shift.x = shifts.next_fixed();
    shift.y = shifts.next_fixed();
  }
};

/// A pure function of (seed, index, number of paths); of one path for each lane that is set.
template <class F>
class BootstrapSamplerOf : public FloatSamples<BootstrapSamplerOf<F>, F> {
 public:
  void set_lane(int lane, const BootstrapStreams& streams, std::uint64_t index) {
    MLT_CHECK_OP(index, <, streams.paths);
    Rng rng(streams.key, index);
    const FilmPlace within{rng.next_fixed(), rng.next_fixed()};
    const FilmPlace place = stratified_place(within, index, streams.paths, streams.shift);
    set_lane_of(film_[0], lane, place.x);
    set_lane_of(film_[1], lane, place.y);
    rng_.set_lane(lane, rng);
  }

  MLT_INLINE UintOf<F> next_fixed(MaskOf<F> active = not_in(MaskOf<F>{})) {
    if (film_samples_ < 2) [[unlikely]]
      return film_[film_samples_++];
    return rng_.next_fixed(active);
  }
  void skip(std::uint32_t, MaskOf<F> = not_in(MaskOf<F>{})) {}

 private:
  RngOf<F> rng_;
  UintOf<F> film_[2] = {};
  std::uint32_t film_samples_ = 0;
};

/// A sampler of one path alone.
inline BootstrapSamplerOf<float> bootstrap_sampler(std::uint64_t seed, std::uint64_t index,
                                                   std::uint64_t paths) {
  BootstrapSamplerOf<float> sampler;
  sampler.set_lane(0, BootstrapStreams(seed, paths), index);
  return sampler;
}

}  // namespace mlt
