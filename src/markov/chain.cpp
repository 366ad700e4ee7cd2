#include "markov/chain.hpp"

namespace mlt {

void ChainStatistics::add(const ChainStatistics& other) {
  large_steps.add(other.large_steps);
  acceptance_large += other.acceptance_large;
  acceptance_small += other.acceptance_small;
  small_steps += other.small_steps;
  if (other.longest_rejection_run > longest_rejection_run)
    longest_rejection_run = other.longest_rejection_run;
  mutations += other.mutations;
  primary_samples += other.primary_samples;
  defects.add(other.defects);
}

}  // namespace mlt
