// A block of a pixel's samples, edge by edge: their paths fill as many groups of lanes as needed, and those
// that go on are moved together as others end, so that few lanes are idle. Each path is what it would be
// alone.
#pragma once

#include <cstdint>

#include "integrator/path.hpp"
#include "integrator/pixel_sampler.hpp"

namespace mlt {

template <class Integrator>
class PathBatch {
  using F = typename Integrator::Float;
  using M = MaskOf<F>;
  using Paths = typename Integrator::Paths;
  using Sampler = PixelSamplerOf<F>;
  static constexpr std::uint32_t kWidth = kLaneCount<F>;
  static constexpr std::uint32_t kGroups = Sampler::kBlock / kWidth;

 public:
  static constexpr std::uint32_t kCapacity = Sampler::kBlock;

  explicit PathBatch(const Integrator& integrator) : integrator_(integrator) {}

  /// Samples [first, first + count) of pixel (x, y) in its sequence number `sequence`; `first` is a multiple
  /// of kCapacity, and `count` at most that. Calls visit(i, SplatOf<float>, primary samples used) for sample
  /// first + i, in order.
  template <class Visit>
  void evaluate(Sampler& sampler, std::uint32_t x, std::uint32_t y, std::uint32_t first, std::uint32_t count,
                std::uint64_t sequence, Visit&& visit) {
    begin(sampler, x, y, first, count, sequence);
    for (std::uint32_t edge = 1; group_count_ > 0; ++edge) {
      for (std::uint32_t g = 0; g < group_count_; ++g) advance(sampler, edge, groups_[g]);
      gather();
    }
    for (std::uint32_t i = 0; i < count; ++i) visit(i, ended_[i].splat, ended_[i].dimension);
  }

 private:
  struct Group {
    Paths paths;
    typename Sampler::Position position;
  };
  struct Ended {
    Splat splat;
    std::uint32_t dimension = 0;
  };

  void begin(Sampler& sampler, std::uint32_t x, std::uint32_t y, std::uint32_t first, std::uint32_t count,
             std::uint64_t sequence) {
    active_count_ = count;
    group_count_ = (count + kWidth - 1) / kWidth;
    for (std::uint32_t g = 0; g < group_count_; ++g) {
      sampler.start(x, y, first + g * kWidth, sequence);
      groups_[g].paths = integrator_.begin(sampler, first_lanes<F>(count - g * kWidth));
      groups_[g].position = sampler.position();
    }
  }

  MLT_NOINLINE void advance(Sampler& sampler, std::uint32_t edge, Group& group) {
    const M before = group.paths.active;
    sampler.resume(group.position);
    typename Integrator::Terms terms = integrator_.terms();
    integrator_.advance(sampler, edge, group.paths, terms);
    terms.finish();
    group.position = sampler.position();
    const UintOf<F> dimensions = sampler.dimension();
    for_lanes(M(before & not_in(group.paths.active)), [&](int lane) {
      --active_count_;
      ended_[lane_of(group.position.slots, lane)] = {
          {lane_of(group.paths.pixel, lane), lane_of(group.paths.radiance, lane)}, lane_of(dimensions, lane)};
    });
  }

  /// Empties the last group as long as the others have room for its paths.
  void gather() {
    std::uint32_t to = 0;
    while (group_count_ > 0 && active_count_ <= (group_count_ - 1) * kWidth) {
      Group& last = groups_[--group_count_];
      for_lanes(M(last.paths.active), [&](int lane) {
        while (all(groups_[to].paths.active)) ++to;
        unsigned idle = ~lanes_of(groups_[to].paths.active);
        const int to_lane = take_lowest(idle);
        last.position.move_lane(lane, groups_[to].position, to_lane);
        last.paths.move_lane(lane, groups_[to].paths, to_lane);
      });
    }
  }

  const Integrator& integrator_;
  std::uint32_t active_count_ = 0;  ///< paths that go on
  std::uint32_t group_count_ = 0;
  Group groups_[kGroups];
  Ended ended_[kCapacity];
};

}  // namespace mlt
