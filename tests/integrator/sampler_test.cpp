#include "integrator/sampler.hpp"

#include <catch2/catch.hpp>
#include <cstdint>

namespace mlt::test {
namespace {

/// Hands out one value.
struct FixedSampler : FloatSamples<FixedSampler, float> {
  std::uint32_t value = 0;
  std::uint32_t next_fixed(bool = true) { return value; }
};

TEST_CASE("pitfall 1: no primary sample reaches 1 as a float") {
  FixedSampler sampler;
  for (const std::uint32_t value :
       {0U, 1U, 0xffU, 0x100U, 0x7fffffffU, 0x80000000U, 0xffffff00U, 0xffffffffU}) {
    sampler.value = value;
    CHECK(sampler.next() >= 0.0f);
    CHECK(sampler.next() <= 1.0f - 0x1p-24f);
    CHECK(sampler.next_2d().y <= 1.0f - 0x1p-24f);
    // Rounded down, to 24 bits.
    CHECK(static_cast<double>(sampler.next()) <= value * 0x1p-32);
    CHECK(static_cast<double>(sampler.next()) > value * 0x1p-32 - 0x1p-24);
  }
}

TEST_CASE("the independent sampler hands out its stream in order; skipping consumes nothing") {
  const Rng stream(1, StreamPurpose::kBootstrap, 2);
  Rng reference = stream;
  IndependentSampler sampler(stream);
  CHECK(sampler.next_fixed() == reference.next_fixed());
  CHECK(sampler.next() == reference.next_float());
  sampler.skip(7);
  const Vec2 pair = sampler.next_2d();
  CHECK(pair.x == reference.next_float());
  CHECK(pair.y == reference.next_float());
}

}  // namespace
}  // namespace mlt::test
