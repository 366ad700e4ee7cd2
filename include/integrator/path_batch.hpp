// A block of samples, of one pixel or several, edge by edge: their paths fill as many groups of lanes as
// needed, and those that go on are moved together as others end, so that few lanes are idle. Each path is
// what it would be alone.
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
  explicit PathBatch(const Integrator& integrator) : integrator_(integrator), terms_(integrator.terms()) {}

  /// Calls visit(PixelSample, SplatOf<float>, primary samples used) for the sampler's block, in order.
  template <class Visit>
  void evaluate(Sampler& sampler, Visit&& visit) {
    begin(sampler);
    for (std::uint32_t edge = 1; group_count_ > 0; ++edge) {
      for (std::uint32_t g = 0; g < group_count_; ++g) advance(sampler, edge, groups_[g]);
      terms_.finish();
      for (std::uint32_t g = 0; g < group_count_; ++g) collect(groups_[g]);
      gather();
    }
    sampler.for_samples([&](std::uint32_t slot, const PixelSample& sample) {
      visit(sample, ended_[slot].splat, ended_[slot].dimension);
    });
  }

 private:
  struct Group {
    Paths paths;
    M begun;  ///< the lanes whose paths have gone on to this edge
    typename Sampler::Position position;
  };
  struct Ended {
    Splat splat;
    std::uint32_t dimension = 0;
  };

  void begin(Sampler& sampler) {
    active_count_ = sampler.count();
    group_count_ = (active_count_ + kWidth - 1) / kWidth;
    for (std::uint32_t g = 0; g < group_count_; ++g) {
      sampler.start(g * kWidth);
      groups_[g].paths = integrator_.begin(sampler, first_lanes<F>(active_count_ - g * kWidth));
      groups_[g].position = sampler.position();
    }
  }

  MLT_NOINLINE void advance(Sampler& sampler, std::uint32_t edge, Group& group) {
    group.begun = group.paths.active;
    sampler.resume(group.position);
    integrator_.advance(sampler, edge, group.paths, terms_);
    group.position = sampler.position();
  }

  /// Keeps what the paths bring that have ended at this edge.
  void collect(const Group& group) {
    const UintOf<F> dimensions = group.position.progress.reached();
    for_lanes(M(group.begun & not_in(group.paths.active)), [&](int lane) {
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
  typename Integrator::Terms terms_;
  std::uint32_t active_count_ = 0;  ///< paths that go on
  std::uint32_t group_count_ = 0;
  Group groups_[kGroups];
  Ended ended_[Sampler::kBlock];  ///< by slot
};

}  // namespace mlt
