// Samples of a pixel one after the other, of which the sampler makes blocks.
#pragma once

#include "integrator/pixel_sampler.hpp"

namespace mlt::test {

/// Starts one sample alone.
inline void start_sample(PixelSampler& sampler, std::uint32_t x, std::uint32_t y, std::uint32_t index,
                         std::uint64_t sequence = 0) {
  sampler.clear();
  sampler.place({x, y, sequence, index}, 1);
  sampler.start(0);
}

}  // namespace mlt::test
