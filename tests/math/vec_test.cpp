#include "math/vec.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "math/rng.hpp"
#include "math/warp.hpp"

using namespace mlt;

namespace {

/// Unit vectors: the axes with zeros of both signs, the neighbourhood of both poles, random ones.
std::vector<Vec3> unit_vectors() {
  std::vector<Vec3> result;
  for (const float s : {1.0f, -1.0f}) {
    for (const float zero : {0.0f, -0.0f}) {
      result.push_back({s, zero, zero});
      result.push_back({zero, s, zero});
      result.push_back({zero, zero, s});
    }
    for (const float tilt : {1e-30f, 1e-20f, 1e-8f, 1e-4f, 1e-2f}) {
      result.push_back(normalize(Vec3{tilt, -tilt, s}));
      result.push_back(normalize(Vec3{s, tilt, -tilt}));
    }
  }
  Rng rng(5, StreamPurpose::kTest, 0);
  for (int i = 0; i < 2000; ++i) {
    const Vec2 u{rng.next_float(), rng.next_float()};
    result.push_back(normalize(uniform_sphere(u)));
  }
  return result;
}

}  // namespace

TEST_CASE("dot, cross and length follow their definitions") {
  const Vec3 a{1, 2, 3};
  const Vec3 b{-4, 5, 0.5f};
  CHECK(dot(a, b) == 7.5f);
  CHECK(cross(a, b) == Vec3{-14, -12.5f, 13});
  CHECK(cross(Vec3{1, 0, 0}, Vec3{0, 1, 0}) == Vec3{0, 0, 1});
  CHECK(length(Vec3{2, 3, 6}) == 7.0f);
  CHECK(length(DVec3{2, 3, 6}) == 7.0);
  CHECK(max_component({1, 3, 2}) == 3.0f);
  CHECK(max_component({4, 3, 2}) == 4.0f);
  CHECK(max_component({1, 3, 5}) == 5.0f);
  CHECK(luminance({1, 1, 1}) == Approx(1.0).epsilon(1e-7));
  CHECK(luminance({0, 1, 0}) == 0.7152f);
}

TEST_CASE("dot adds x and y before z") {
  // 2^24 + 1 is no float: the order of the additions shows.
  CHECK(dot(Vec3{0x1p+24f, 1, 1}, Vec3{1, 1, 1}) == 0x1p+24f);
  CHECK(dot(Vec3{1, 1, 0x1p+24f}, Vec3{1, 1, 1}) == 0x1p+24f + 2.0f);
}

TEST_CASE("is_finite and is_zero see every component") {
  for (const float bad : {std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
                          std::numeric_limits<float>::quiet_NaN()}) {
    CHECK_FALSE(is_finite({bad, 0, 0}));
    CHECK_FALSE(is_finite({0, bad, 0}));
    CHECK_FALSE(is_finite({0, 0, bad}));
  }
  CHECK(is_finite({1e38f, -1e38f, 0}));
  CHECK(is_zero({0, -0.0f, 0}));
  CHECK_FALSE(is_zero({0, 0, std::numeric_limits<float>::denorm_min()}));
}

TEST_CASE("normalize gives unit vectors over its range of lengths") {
  // Rounding: 3 squares and 2 sums (each 2^-24 at most, halved by the root), root, quotient and product give
  // a relative error of at most 4.5 * 2^-24 in the length.
  for (const Vec3& v : unit_vectors()) {
    for (const float scale : {1e-17f, 1e-3f, 1.0f, 1e3f, 1e19f}) {
      const Vec3 n = normalize(v * scale);
      const double square =
          static_cast<double>(n.x) * n.x + static_cast<double>(n.y) * n.y + static_cast<double>(n.z) * n.z;
      if (std::fabs(std::sqrt(square) - 1.0) > 4.5 * 0x1p-24) FAIL("length " << std::sqrt(square));
    }
  }
}

TEST_CASE("a frame is orthonormal, right-handed and keeps its normal, poles included") {
  // Entries are sums of a few products of numbers in [-1,1], normals are unit to 4.5 * 2^-24: errors of the
  // nine products stay below 16 * 2^-24 = 1e-6.
  constexpr double kLimit = 1e-6;
  for (const Vec3& n : unit_vectors()) {
    const Frame frame(n);
    INFO(n.x << " " << n.y << " " << n.z);
    REQUIRE(frame.z == n);
    REQUIRE(std::fabs(static_cast<double>(dot(frame.x, frame.x)) - 1.0) < kLimit);
    REQUIRE(std::fabs(static_cast<double>(dot(frame.y, frame.y)) - 1.0) < kLimit);
    REQUIRE(std::fabs(static_cast<double>(dot(frame.x, frame.y))) < kLimit);
    REQUIRE(std::fabs(static_cast<double>(dot(frame.x, n))) < kLimit);
    REQUIRE(std::fabs(static_cast<double>(dot(frame.y, n))) < kLimit);
    REQUIRE(static_cast<double>(length(cross(frame.x, frame.y) - n)) < kLimit);
    const Vec3 v{0.3f, -0.8f, 0.5f};
    REQUIRE(static_cast<double>(length(frame.to_local(frame.to_world(v)) - v)) < kLimit);
    REQUIRE(static_cast<double>(length(frame.to_world(Vec3{0, 0, 1}) - n)) == 0.0);
  }
}
