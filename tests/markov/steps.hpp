// Small steps of one kind, one at a time.
#pragma once

#include <cstdint>

#include "markov/mutation.hpp"

namespace mlt::test {

/// By a Generator with next_fixed(mask).
template <MutationKind kKind, class Generator = Rng>
class Steps {
 public:
  explicit Steps(Generator rng, float step_size = 1) : rng_(rng), step_size_(step_size) {}

  std::uint32_t next() {
    const std::uint32_t draw = rng_.next_fixed(true);
    return Mutation<kKind>::template steps<float>(draw, rng_, true, step_size_);
  }

 private:
  Generator rng_;
  float step_size_;
};

}  // namespace mlt::test
