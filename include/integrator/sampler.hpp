// Where integrators get their randomness: one primary sample after the other. A sampler has
//   uint32_t next_fixed()   the next primary sample, a 32-bit fixed-point number in [0,1)
//   float next()            the same as a float in [0, 1-2^-24]
//   Vec2 next_2d()          two at once, which a stratifying sampler distributes jointly
//   void skip(n)            passes over n primary samples that this path does not need, so that later ones
//                           keep their meaning
// and nothing else. Fixed point makes wrap-around exact and 1.0 impossible. The samplers are this file's
// IndependentSampler, the path tracer's PixelSampler and the Metropolis chain's PrimarySampleVector.
#pragma once

#include <cstdint>

#include "math/rng.hpp"
#include "math/vec.hpp"

namespace mlt {

/// Mixin: the float forms over a sampler's own next_fixed().
template <class Derived>
class FloatSamples {
 public:
  float next() { return unit_float(self().next_fixed()); }
  Vec2 next_2d() {
    const std::uint32_t first = self().next_fixed();
    const std::uint32_t second = self().next_fixed();
    return Vec2{unit_float(first), unit_float(second)};
  }

 private:
  Derived& self() { return static_cast<Derived&>(*this); }
};

/// Independent uniform samples from one stream; used by the bootstrap.
class IndependentSampler : public FloatSamples<IndependentSampler> {
 public:
  explicit IndependentSampler(Rng rng) : rng_(rng) {}
  std::uint32_t next_fixed() { return rng_.next_fixed(); }
  void skip(std::uint32_t) {}

 private:
  Rng rng_;
};

}  // namespace mlt
