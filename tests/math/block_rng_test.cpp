// The generator in blocks: each lane is the published generator, and lanes of near streams are independent.
#include "math/block_rng.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "support/statistics.hpp"

using namespace mlt;
using namespace mlt::test;

namespace {

/// xoshiro128++ as its authors state it [Blackman21], one step.
std::uint32_t reference_step(std::array<std::uint32_t, 4>& s) {
  const std::uint32_t result = std::rotl(s[0] + s[3], 7) + s[0];
  const std::uint32_t t = s[1] << 9;
  s[2] ^= s[0];
  s[3] ^= s[1];
  s[1] ^= s[2];
  s[0] ^= s[3];
  s[2] ^= t;
  s[3] = std::rotl(s[3], 11);
  return result;
}

/// The lanes' first states, by the rule in the class's comment.
std::array<std::array<std::uint32_t, 4>, kBlockDraws> first_states(Rng source) {
  std::array<std::array<std::uint32_t, 4>, kBlockDraws> states{};
  for (auto& state : states) {
    for (std::size_t half = 0; half < 2; ++half) {
      const std::uint64_t hashed = mix64(source.next_key());
      state[2 * half] = static_cast<std::uint32_t>(hashed);
      state[2 * half + 1] = static_cast<std::uint32_t>(hashed >> 32);
    }
  }
  return states;
}

}  // namespace

TEST_CASE("each lane of the block generator is xoshiro128++") {
  for (const std::uint64_t index : {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{1} << 40}) {
    BlockRng rng(5, StreamPurpose::kSteps, index);
    auto states = first_states(Rng(5, StreamPurpose::kSteps, index));
    for (int block = 0; block < 1000; ++block) {
      std::uint32_t draws[kBlockDraws];
      rng.next_block(draws);
      for (std::size_t lane = 0; lane < kBlockDraws; ++lane)
        REQUIRE(draws[lane] == reference_step(states[lane]));
    }
  }
}

TEST_CASE("pitfall 22: lanes of near streams are uncorrelated") {
  constexpr std::size_t kDraws = 4096;
  std::vector<std::vector<float>> streams;
  for (const std::uint64_t seed : {0U, 1U}) {
    for (const std::uint64_t index :
         {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{2}, std::uint64_t{1} << 32}) {
      BlockRng rng(seed, StreamPurpose::kSteps, index);
      const std::size_t first = streams.size();
      streams.resize(first + kBlockDraws);
      for (std::size_t i = 0; i < kDraws; ++i) {
        std::uint32_t draws[kBlockDraws];
        rng.next_block(draws);
        for (std::size_t lane = 0; lane < kBlockDraws; ++lane) {
          streams[first + lane].push_back(unit_float(draws[lane]) - 0.5f);
        }
      }
    }
  }
  // As for Rng: sums of products of independent uniforms have mean 0 and variance n / 144.
  const double deviation = std::sqrt(kDraws / 144.0);
  std::vector<double> p_values;
  for (std::size_t a = 0; a < streams.size(); ++a) {
    for (std::size_t b = a + 1; b < streams.size(); ++b) {
      float sum = 0;
      for (std::size_t i = 0; i < kDraws; ++i) sum += streams[a][i] * streams[b][i];
      p_values.push_back(normal_p_value(static_cast<double>(sum) / deviation));
    }
  }
  CHECK(*std::min_element(p_values.begin(), p_values.end()) > sidak_threshold(0.01, p_values.size()));
  CHECK(ks_uniform_test(p_values).p_value > 0.001);
}
