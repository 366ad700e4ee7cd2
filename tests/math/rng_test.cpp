// Random streams: the generator against its published outputs, uniformity, and independence of streams whose
// keys differ little. Seeds are fixed, so every result is deterministic; thresholds are Sidak-corrected for
// the number of tests in a case at a significance of 1 %, which the shipped seeds pass.
#include "math/rng.hpp"

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

struct Key {
  std::uint64_t seed;
  StreamPurpose purpose;
  std::uint64_t index;
};

/// Keys that differ in few bits: seed 0 and each of its bits, index 0 and each of its bits, the neighbourhood
/// of 2^32, the ends of the range, every purpose.
std::vector<Key> near_keys() {
  std::vector<Key> keys;
  keys.push_back({0, StreamPurpose::kChain, 0});
  for (int bit = 0; bit < 64; ++bit) {
    keys.push_back({1ULL << bit, StreamPurpose::kChain, 0});
    keys.push_back({0, StreamPurpose::kChain, 1ULL << bit});
  }
  for (const std::uint64_t index : {0xffffffffULL, 0x100000001ULL, 0x1ffffffffULL, ~0ULL, ~0ULL - 1}) {
    keys.push_back({0, StreamPurpose::kChain, index});
    keys.push_back({index, StreamPurpose::kChain, 0});
    keys.push_back({index, StreamPurpose::kChain, index});
  }
  for (const StreamPurpose purpose : {StreamPurpose::kBootstrap, StreamPurpose::kSeedSelection,
                                      StreamPurpose::kPixel, StreamPurpose::kTest}) {
    keys.push_back({0, purpose, 0});
    keys.push_back({1, purpose, 0});
    keys.push_back({0, purpose, 1});
  }
  return keys;
}

}  // namespace

TEST_CASE("mix64 is SplitMix64's finaliser") {
  // First outputs of SplitMix64 from state 0, whose state advances by the golden ratio.
  CHECK(mix64(0x9e3779b97f4a7c15ULL) == 0xe220a8397b1dcdafULL);
  CHECK(mix64(0x9e3779b97f4a7c15ULL * 2) == 0x6e789e6aa1b965f4ULL);
  CHECK(mix64(0x9e3779b97f4a7c15ULL * 3) == 0x06c45d188009454fULL);
}

TEST_CASE("the generator is xoshiro128++") {
  // Outputs of the authors' program from state {1, 2, 3, 4}.
  static_assert(sizeof(Rng) == 16);
  Rng rng = std::bit_cast<Rng>(std::array<std::uint32_t, 4>{1, 2, 3, 4});
  for (const std::uint32_t expected : {641U, 1573767U, 3222811527U, 3517856514U, 836907274U, 4247214768U,
                                       3867114732U, 1355841295U, 495546011U, 621204420U}) {
    CHECK(rng.next_fixed() == expected);
  }
}

TEST_CASE("next_key joins two draws, the first as the low half") {
  Rng rng = std::bit_cast<Rng>(std::array<std::uint32_t, 4>{1, 2, 3, 4});
  CHECK(rng.next_key() == ((1573767ULL << 32) | 641ULL));
  CHECK(rng.next_fixed() == 3222811527U);
}

TEST_CASE("pitfall 1: unit_float stays below 1 and is exact") {
  CHECK(unit_float(0) == 0.0f);
  CHECK(unit_float(255) == 0.0f);
  CHECK(unit_float(256) == 0x1p-24f);
  CHECK(unit_float(0x80000000U) == 0.5f);
  CHECK(unit_float(0xffffff00U) == 1.0f - 0x1p-24f);
  CHECK(unit_float(0xffffffffU) == 1.0f - 0x1p-24f);
  // Every one of the 2^24 values is its own multiple of 2^-24.
  std::uint32_t wrong = 0;
  for (std::uint32_t i = 0; i < (1U << 24); ++i) {
    const float u = unit_float((i << 8) | (i & 0xffU));
    if (!(u >= 0.0f && u < 1.0f) || static_cast<double>(u) * 0x1p24 != static_cast<double>(i)) ++wrong;
  }
  CHECK(wrong == 0);
}

TEST_CASE("next_float is uniform on the line and in the square") {
  Rng rng(3, StreamPurpose::kTest, 0);
  constexpr int kSamples = 1 << 18;
  std::vector<std::uint64_t> cells(256, 0);
  std::vector<double> values;
  for (int i = 0; i < kSamples; ++i) {
    const float u = rng.next_float();
    REQUIRE(u < 1.0f);
    ++cells[static_cast<std::size_t>(u * 256.0f)];
    if (i < 20000) values.push_back(u);
  }
  const double threshold = sidak_threshold(0.01, 4);
  CHECK(chi_square_test(cells, std::vector<double>(256, kSamples / 256.0)).p_value > threshold);
  CHECK(ks_uniform_test(values).p_value > threshold);

  const auto pairs = [&]() -> std::optional<Point2> { return Point2{rng.next_float(), rng.next_float()}; };
  CHECK(chi_square_2d(unit_grid(32, 32), kSamples, pairs, [](double, double) { return 1.0; }).p_value >
        threshold);
  // First two numbers of consecutive streams: what a renderer draws most.
  std::uint64_t index = 0;
  const auto starts = [&]() -> std::optional<Point2> {
    Rng stream(0, StreamPurpose::kPixel, index++);
    return Point2{stream.next_float(), stream.next_float()};
  };
  CHECK(chi_square_2d(unit_grid(32, 32), kSamples, starts, [](double, double) { return 1.0; }).p_value >
        threshold);
}

TEST_CASE("every bit of next_fixed is fair") {
  Rng rng(0, StreamPurpose::kTest, 0);
  constexpr int kSamples = 1 << 16;
  std::array<int, 32> ones{};
  for (int i = 0; i < kSamples; ++i) {
    const std::uint32_t word = rng.next_fixed();
    for (std::size_t bit = 0; bit < 32; ++bit) ones[bit] += static_cast<int>((word >> bit) & 1U);
  }
  const double deviation = 0.5 * std::sqrt(static_cast<double>(kSamples));
  for (std::size_t bit = 0; bit < 32; ++bit) {
    INFO("bit " << bit);
    CHECK(normal_p_value((ones[bit] - kSamples / 2.0) / deviation) > sidak_threshold(0.01, 32));
  }
}

TEST_CASE("pitfall 22: streams of keys that differ in one bit, of 0 and beyond 2^32 are uncorrelated") {
  const std::vector<Key> keys = near_keys();
  constexpr std::size_t kDraws = 1024;
  std::vector<std::vector<float>> streams;
  for (const Key& key : keys) {
    Rng rng(key.seed, key.purpose, key.index);
    std::vector<float> draws(kDraws);
    for (float& x : draws) x = rng.next_float() - 0.5f;
    streams.push_back(draws);
  }
  // The sum of n products of independent uniforms on [-1/2, 1/2) has mean 0 and variance n / 144.
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

TEST_CASE("pitfall 22: changing one bit of a key changes half of the first output's bits") {
  // Changed bits over all keys are Binomial(32 n, 1/2).
  double changed = 0;
  double words = 0;
  for (std::uint64_t base = 0; base < 64; ++base) {
    const std::uint32_t origin = Rng(base, StreamPurpose::kChain, base).next_fixed();
    for (int bit = 0; bit < 64; ++bit) {
      const std::uint64_t flip = 1ULL << bit;
      changed += std::popcount(origin ^ Rng(base ^ flip, StreamPurpose::kChain, base).next_fixed());
      changed += std::popcount(origin ^ Rng(base, StreamPurpose::kChain, base ^ flip).next_fixed());
      words += 2;
    }
  }
  const double z = (changed - 16.0 * words) / (0.5 * std::sqrt(32.0 * words));
  CHECK(normal_p_value(z) > 0.01);
}

TEST_CASE("pitfall 22: no stream is shared and none runs into another") {
  // Two draws in a row give 64 bits; among n = 6e5 of them a chance repetition has probability
  // n^2 / 2^65 = 1e-8, but a stream that starts inside another repeats hundreds.
  std::vector<std::uint64_t> seen;
  const auto take = [&](const Key& key, int draws) {
    Rng rng(key.seed, key.purpose, key.index);
    std::uint64_t previous = rng.next_fixed();
    for (int i = 0; i < draws; ++i) {
      const std::uint64_t next = rng.next_fixed();
      seen.push_back(previous << 32 | next);
      previous = next;
    }
  };
  for (const Key& key : near_keys()) take(key, 500);
  for (std::uint64_t i = 0; i < 100; ++i) take({9, StreamPurpose::kTest, i}, 1000);
  for (std::uint64_t i = 0; i < 100000; ++i) {
    take({77, StreamPurpose::kChain, i}, 1);
    take({78, StreamPurpose::kChain, i}, 1);
    take({77, StreamPurpose::kBootstrap, i}, 1);
    take({77, StreamPurpose::kChain, i + (1ULL << 32)}, 1);
  }
  std::sort(seen.begin(), seen.end());
  CHECK(std::adjacent_find(seen.begin(), seen.end()) == seen.end());
}
