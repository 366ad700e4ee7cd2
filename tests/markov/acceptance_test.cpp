#include "markov/acceptance.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>

#include "math/rng.hpp"
#include "support/statistics.hpp"

namespace mlt::test {
namespace {

/// Two draws, of which the second may not be asked for.
struct TwoDraws {
  std::uint32_t first = 0, second = 0;
  int drawn = 0;
  std::uint32_t next_fixed(bool) { return drawn++ == 0 ? first : second; }
};

bool happens_for(std::uint32_t first, std::uint32_t second, float probability) {
  TwoDraws draws{first, second};
  const bool happened = happens(draws, probability);
  REQUIRE(draws.drawn <= 2);
  return happened;
}

TEST_CASE("probability 1 always happens, 0 never") {
  for (const std::uint32_t first : {0U, 1U, 0x80000000U, 0xffffffffU}) {
    for (const std::uint32_t second : {0U, 1U, 0xffffffffU}) {
      CHECK(happens_for(first, second, 1.0f));
      CHECK_FALSE(happens_for(first, second, 0.0f));
    }
  }
}

TEST_CASE("a decision compares 64 random bits with the probability") {
  // 2^64 p = 2^32 threshold + fraction: the draws below it happen, the others do not.
  for (const float probability : {0.2f, 0x1.8p-24f, 1e-7f, 0x1.8p-32f, 1e-12f, 0x1p-64f}) {
    const double scaled = std::ldexp(static_cast<double>(probability), 32);
    const auto threshold = static_cast<std::uint32_t>(scaled);
    const double fraction = std::ldexp(scaled - std::floor(scaled), 32);
    INFO(probability);
    if (threshold > 0) CHECK(happens_for(threshold - 1, 0xffffffffU, probability));
    CHECK_FALSE(happens_for(threshold + 1, 0, probability));
    if (fraction > 0) {
      const auto last = static_cast<std::uint32_t>(std::ceil(fraction) - 1);
      CHECK(happens_for(threshold, last, probability));
      CHECK_FALSE(happens_for(threshold, last + 1, probability));
    } else {
      CHECK_FALSE(happens_for(threshold, 0, probability));
    }
  }
}

/// Numbers below 2^-16 only: events of a smaller probability p happen with p * 2^16 instead, often enough to
/// be counted.
struct SmallNumbers {
  Rng rng{1, StreamPurpose::kTest, 0};
  std::uint32_t next_fixed(bool) { return rng.next_fixed() & 0xffffU; }
};

TEST_CASE("small probabilities happen as often as they should") {
  SmallNumbers numbers;
  for (const float probability : {0x1.4p-24f, 0x1p-26f, 0x1p-29f}) {
    constexpr int kDraws = 2000000;
    int count = 0;
    for (int i = 0; i < kDraws; ++i) count += happens(numbers, probability) ? 1 : 0;
    const double expected = kDraws * static_cast<double>(probability) * 0x1p16;
    INFO(probability << " happened " << count << " times instead of " << expected);
    CHECK(normal_p_value((count - expected) / std::sqrt(expected)) > sidak_threshold(1e-4, 3));
  }
}

}  // namespace
}  // namespace mlt::test
