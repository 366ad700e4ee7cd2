// Where integrators get their randomness: one primary sample after the other, for the lanes of a mask. A
// sampler has
//   Uint next_fixed(active)   the next primary sample, a 32-bit fixed-point number in [0,1)
//   Float next(active)        the same as a float in [0, 1-2^-24]
//   Vec2 next_2d(active)      two at once, which a stratifying sampler distributes jointly
//   VertexSamples next_vertex(lit, active)   all that a vertex of a path needs but for roulette
//   void skip(n, active)      passes over n primary samples that no lane needs, so that later ones keep their
//                             meaning; lanes outside a mask pass over its samples as well
//   Uint dimension()          how far the path of each lane has come: samples asked for or skipped by it
// and nothing else. Fixed point makes wrap-around exact and 1.0 impossible. The samplers are this file's
// IndependentSampler, the path tracer's PixelSampler and the Metropolis chain's PrimarySampleVector.
#pragma once

#include <cstdint>

#include "math/rng.hpp"
#include "math/vec.hpp"

namespace mlt {

/// What a vertex of a path asks for, in this order: for the choice of a light and a point on it, for the
/// choice of a lobe and a direction.
template <class F>
struct VertexSamples {
  F light_choice{};
  Vec2Of<F> light{};
  F lobe{};
  Vec2Of<F> bsdf{};
};

/// Mixin: the float forms over a sampler's own next_fixed().
template <class Derived, class F>
class FloatSamples {
 public:
  MLT_INLINE F next(MaskOf<F> active = not_in(MaskOf<F>{})) { return unit_float(self().next_fixed(active)); }
  MLT_INLINE Vec2Of<F> next_2d(MaskOf<F> active = not_in(MaskOf<F>{})) {
    const UintOf<F> first = self().next_fixed(active);
    const UintOf<F> second = self().next_fixed(active);
    return Vec2Of<F>{unit_float(first), unit_float(second)};
  }

  /// Light is sampled for in the lanes of `lit`, which are active. Not inline: between one sample and the
  /// next nothing else of the path could stay in registers.
  template <bool kLightChoice, bool kLobeChoice>
  MLT_NOINLINE VertexSamples<F> next_vertex(MaskOf<F> lit, MaskOf<F> active) {
    VertexSamples<F> samples;
    if (any(lit)) {
      if constexpr (kLightChoice) samples.light_choice = self().next(lit);
      samples.light = self().next_2d(lit);
    } else {
      self().skip(2 + (kLightChoice ? 1 : 0), active);
    }
    if constexpr (kLobeChoice) samples.lobe = self().next(active);
    samples.bsdf = self().next_2d(active);
    return samples;
  }

 private:
  Derived& self() { return static_cast<Derived&>(*this); }
};

/// How far the paths of all lanes have come.
template <class F>
class Progress {
 public:
  MLT_INLINE void restart() {
    cursor_ = 0;
    reached_ = UintOf<F>{};
  }
  /// Passes over samples and returns the index of the first.
  MLT_INLINE std::uint32_t advance(std::uint32_t count, MaskOf<F> active) {
    const std::uint32_t first = cursor_;
    cursor_ += count;
    reached_ = select(active, broadcast_bits<UintOf<F>>(cursor_), reached_);
    return first;
  }
  /// Makes a lane of `to`, whose active lanes have come as far, one more of these.
  void move_lane(int lane, Progress& to, int to_lane) const {
    to.cursor_ = cursor_;
    set_lane_of(to.reached_, to_lane, lane_of(reached_, lane));
  }
  std::uint32_t cursor() const { return cursor_; }
  UintOf<F> reached() const { return reached_; }

 private:
  std::uint32_t cursor_ = 0;
  UintOf<F> reached_{};
};

/// Independent uniform samples from a stream for each lane; used by the bootstrap.
template <class F>
class IndependentSamplerOf : public FloatSamples<IndependentSamplerOf<F>, F> {
 public:
  explicit IndependentSamplerOf(const RngOf<F>& rng) : rng_(rng) {}
  MLT_INLINE UintOf<F> next_fixed(MaskOf<F> active = not_in(MaskOf<F>{})) { return rng_.next_fixed(active); }
  void skip(std::uint32_t, MaskOf<F> = not_in(MaskOf<F>{})) {}

 private:
  RngOf<F> rng_;
};
using IndependentSampler = IndependentSamplerOf<float>;

}  // namespace mlt
