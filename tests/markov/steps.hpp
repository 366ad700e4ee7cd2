// Small steps one at a time, from the blocks in which mutations make them.
#pragma once

#include <cstdint>

#include "markov/mutation.hpp"

namespace mlt::test {

template <MutationKind kKind, class Generator = BlockRng>
class Steps {
 public:
  explicit Steps(Generator rng, float step_size = 1) : rng_(rng), step_size_(step_size) {}

  std::uint32_t next() {
    if (used_ == kBlockDraws) {
      Mutation<kKind>::fill(rng_, steps_, step_size_);
      used_ = 0;
    }
    return steps_[used_++];
  }

 private:
  Generator rng_;
  float step_size_;
  alignas(16) std::uint32_t steps_[kBlockDraws];
  int used_ = kBlockDraws;
};

}  // namespace mlt::test
