// Bits in reverse order, in lanes and alone, against a loop over bits.
#include "math/reverse_bits.hpp"

#include <catch2/catch.hpp>
#include <cstdint>

#include "math/rng.hpp"

namespace mlt::test {
namespace {

std::uint32_t reversed_by_bit(std::uint32_t x) {
  std::uint32_t reversed = 0;
  for (unsigned bit = 0; bit < 32; ++bit) reversed |= (x >> bit & 1U) << (31 - bit);
  return reversed;
}

template <class U>
void check_lanes(Rng& rng) {
  U values{};
  for (int lane = 0; lane < static_cast<int>(sizeof(U) / 4); ++lane)
    set_lane_of(values, lane, rng.next_fixed());
  const U reversed = reverse_bits(values);
  for (int lane = 0; lane < static_cast<int>(sizeof(U) / 4); ++lane)
    REQUIRE(lane_of(reversed, lane) == reversed_by_bit(lane_of(values, lane)));
}

TEST_CASE("reverse_bits turns each bit and random integers around, in lanes as alone") {
  for (unsigned bit = 0; bit < 32; ++bit) {
    REQUIRE(reverse_bits(1U << bit) == 1U << (31 - bit));
    const auto lanes = broadcast_bits<LaneUint>(1U << bit);
    REQUIRE(lane_of(reverse_bits(lanes), kLanes - 1) == 1U << (31 - bit));
  }
  Rng rng(51, StreamPurpose::kTest, 0);
  for (int i = 0; i < 10000; ++i) {
    check_lanes<std::uint32_t>(rng);
    check_lanes<LaneUint>(rng);
    check_lanes<UintOf<WideFloat>>(rng);
  }
}

}  // namespace
}  // namespace mlt::test
