// What is known of chains at their end, and how it is counted for those of a group, in lanes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "markov/bootstrap.hpp"
#include "markov/contribution.hpp"
#include "math/wide.hpp"

namespace mlt {

struct ChainStatistics {
  LuminanceMoments large_steps;  ///< uniform samples, which join the estimate of b
  double acceptance_large = 0;   ///< sum of acceptance probabilities
  double acceptance_small = 0;
  std::uint64_t small_steps = 0;
  std::uint64_t longest_rejection_run = 0;
  std::uint64_t mutations = 0;
  std::uint64_t primary_samples = 0;  ///< that the mutations' paths asked for
  DefectCounts defects;

  void add(const ChainStatistics& other);
};

/// The sums of ChainStatistics, of as many chains as F has lanes.
template <class F>
class LaneSums {
  using M = MaskOf<F>;
  using U = UintOf<F>;
  using D = DoubleOf<F>;

 public:
  /// So many mutations at most are counted between two moves: paths ask for some thousand samples at most.
  static constexpr std::uint64_t kMostCounts = 1U << 12;

  /// Counts one mutation of each lane of `active`, whose proposals have these targets and numbers of primary
  /// samples. Adding zero elsewhere changes no bit of a sum.
  MLT_INLINE void count(M active, M large_step, const F& acceptances, const F& targets, const U& dimensions) {
    const M large = active & large_step;
    primary_samples_ += select(active, dimensions, U{});
    mutations_ += mask_bits(active) & 1U;
    large_steps_ += mask_bits(large) & 1U;
    add(acceptance_small_, to_double(select(active & not_in(large_step), acceptances, F{})));
    add(acceptance_large_, to_double(select(large, acceptances, F{})));
    const D luminance = to_double(select(large, targets, F{}));
    add(sum_, luminance);
    add(sum_squares_, luminance * luminance);
  }

  /// Adds what was counted since the last time to the statistics of the first lanes.
  void move_to(std::span<ChainStatistics> statistics) {
    for (std::size_t i = 0; i < statistics.size(); ++i) {
      const int lane = static_cast<int>(i);
      ChainStatistics& chain = statistics[i];
      chain.large_steps.sum = sum_[i];
      chain.large_steps.sum_squares = sum_squares_[i];
      chain.large_steps.count += lane_of(large_steps_, lane);
      chain.acceptance_large = acceptance_large_[i];
      chain.acceptance_small = acceptance_small_[i];
      chain.small_steps += lane_of(mutations_, lane) - lane_of(large_steps_, lane);
      chain.primary_samples += lane_of(primary_samples_, lane);
    }
    primary_samples_ = mutations_ = large_steps_ = U{};
  }

 private:
  static constexpr int kCount = kLaneCount<F>;

  MLT_INLINE static void add(double (&sums)[kCount], const D& values) {
    store_wide(sums, load_wide<D>(sums) + values);
  }

  U primary_samples_{}, mutations_{}, large_steps_{};
  // Summed from the first mutation on: in parts the sums would be rounded otherwise.
  alignas(64) double acceptance_small_[kCount] = {};
  alignas(64) double acceptance_large_[kCount] = {};
  alignas(64) double sum_[kCount] = {};
  alignas(64) double sum_squares_[kCount] = {};
};

}  // namespace mlt
