// Lanes as bits and back, and lanes moved together: all masks, against a loop.
#include "math/pack.hpp"

#include <catch2/catch.hpp>
#include <cstdint>

namespace mlt::test {
namespace {

template <int kCount>
void check_masks() {
  using F = typename Wide<kCount>::Float;
  for (unsigned bits = 0; bits < 1U << kCount; ++bits) {
    const MaskOf<F> mask = mask_of<F>(bits);
    for (int lane = 0; lane < kCount; ++lane)
      REQUIRE(lane_of(mask, lane) == ((bits >> lane & 1U) != 0 ? -1 : 0));
    REQUIRE(lanes_of(mask) == bits);
  }
}

template <int kCount>
void check_packing() {
  using F = typename Wide<kCount>::Float;
  using U = UintOf<F>;
  const U values = lane_numbers<U>() * 7U + 3U;
  for (unsigned bits = 0; bits < 1U << kCount; ++bits) {
    const LanePacking<F> packing(mask_of<F>(bits));
    const U packed = packing(values);
    const F packed_floats = packing(as_floats(values));
    int place = 0;
    for (int lane = 0; lane < kCount; ++lane) {
      if ((bits >> lane & 1U) == 0) continue;
      REQUIRE(lane_of(packed, place) == lane_of(values, lane));
      REQUIRE(as_bits(lane_of(packed_floats, place)) == lane_of(values, lane));
      ++place;
    }
    REQUIRE(packing.count() == static_cast<unsigned>(place));
  }
}

TEST_CASE("a mask is its bits and back") {
  check_masks<kLanes>();
  check_masks<kWideLanes>();
  CHECK(mask_of<float>(1));
  CHECK_FALSE(mask_of<float>(0));
}

TEST_CASE("packing moves the lanes of any mask together") {
  check_packing<kLanes>();
  check_packing<kWideLanes>();
}

}  // namespace
}  // namespace mlt::test
