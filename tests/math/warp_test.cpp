// Warps against their densities (chi-square, fixed seeds), and at the ends of the unit square.
#include "math/warp.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "math/rng.hpp"
#include "support/statistics.hpp"

using namespace mlt;
using namespace mlt::test;

namespace {

constexpr double kPiDouble = 3.14159265358979323846;
constexpr std::uint64_t kSamples = 200000;
constexpr std::size_t kTests = 10;  // chi-square tests in this file, for Sidak's correction
const double kThreshold = sidak_threshold(0.01, kTests);

Vec2 draw(Rng& rng) {
  return Vec2{rng.next_float(), rng.next_float()};
}

/// Every pair of the values at which samplers break (pitfall 1).
std::vector<Vec2> edge_inputs() {
  const float values[] = {0.0f,
                          std::numeric_limits<float>::denorm_min(),
                          0x1p-126f,
                          0x1p-24f,
                          0.25f,
                          0.5f,
                          0.75f,
                          1.0f - 0x1p-23f,
                          std::nextafter(1.0f, 0.0f)};
  static_assert(1.0f - 0x1p-24f == 0x1.fffffep-1f, "2^-24 below 1 lies the largest float below 1");
  std::vector<Vec2> result;
  for (const float x : values) {
    for (const float y : values) result.push_back({x, y});
  }
  return result;
}

double squared_length(const Vec3& v) {
  const DVec3 w{v.x, v.y, v.z};
  return dot(w, w);
}

}  // namespace

TEST_CASE("cosine_hemisphere has density cos / pi") {
  Rng rng(1, StreamPurpose::kTest, 0);
  const ChiSquareResult result = chi_square_directions(
      direction_grid(24, 24, 0, 1), kSamples,
      [&]() -> std::optional<Vec3> { return cosine_hemisphere(draw(rng)); },
      [](const Vec3& w) { return cosine_hemisphere_pdf_solid_angle(w.z); });
  CHECK(result.dof > 500);
  CHECK(result.p_value > kThreshold);
  CHECK(cosine_hemisphere_pdf_solid_angle(0.0f) == 0.0f);
  CHECK(cosine_hemisphere_pdf_solid_angle(-0.5f) == 0.0f);
}

TEST_CASE("uniform_sphere has density 1 / (4 pi)") {
  Rng rng(2, StreamPurpose::kTest, 0);
  const ChiSquareResult result = chi_square_directions(
      direction_grid(24, 24), kSamples, [&]() -> std::optional<Vec3> { return uniform_sphere(draw(rng)); },
      [](const Vec3&) { return uniform_sphere_pdf_solid_angle(); });
  CHECK(result.dof == 24 * 24 - 1);
  CHECK(result.p_value > kThreshold);
}

TEST_CASE("uniform_triangle has density 2 in barycentric coordinates") {
  Rng rng(3, StreamPurpose::kTest, 0);
  const ChiSquareResult result = chi_square_2d(
      unit_grid(20, 20), kSamples,
      [&]() -> std::optional<Point2> {
        const Vec3 b = uniform_triangle(draw(rng));
        return Point2{b.x, b.y};
      },
      [](double b0, double b1) { return b0 + b1 < 1.0 ? 2.0 : 0.0; });
  CHECK(result.p_value > kThreshold);
  CHECK(uniform_triangle_pdf_area(0.5f) == 2.0f);
}

TEST_CASE("uniform_cone has density 1 / (2 pi (1 - cos)) for wide and for tiny cones") {
  for (const float depth : {2.0f, 1.0f, 0.3f, 1e-3f, 1e-6f, 1e-12f}) {
    Rng rng(4, StreamPurpose::kTest, 0);
    INFO("1 - cos = " << depth);
    const double d = depth;
    // 1 - z is taken from x^2 + y^2 = (1 - z)(1 + z), since z itself holds only multiples of 2^-24.
    const Grid2D grid{-kPiDouble, kPiDouble, 20, 0, 1, 20};
    const ChiSquareResult result = chi_square_2d(
        grid, kSamples,
        [&]() -> std::optional<Point2> {
          const Vec3 w = uniform_cone(draw(rng), depth);
          const double x = w.x;
          const double y = w.y;
          const double share = (x * x + y * y) / (1.0 + static_cast<double>(w.z)) / d;
          return Point2{std::atan2(y, x), depth < 1.9f ? std::fmin(share, 1.0) : (1.0 - w.z) / d};
        },
        [&](double, double) { return uniform_cone_pdf_solid_angle(depth) * d; });
    CHECK(result.dof == 399);
    CHECK(result.p_value > kThreshold);
  }
}

TEST_CASE("one_minus_cos keeps its relative accuracy for small cones") {
  for (float sin_squared = 1.0f; sin_squared > 1e-38f; sin_squared *= 0.37f) {
    const double s = sin_squared;
    // In double 1 - sqrt(1 - s) cancels as well; s / (1 + sqrt(1 - s)) does not. Four float roundings.
    const double expected = s / (1.0 + std::sqrt(1.0 - s));
    CHECK(one_minus_cos(sin_squared) == Approx(expected).epsilon(4 * 0x1p-24).margin(0));
  }
  CHECK(one_minus_cos(0.0f) == 0.0f);
  CHECK(one_minus_cos(0.36f) == Approx(0.2).epsilon(1e-6));
}

TEST_CASE("pitfall 1: warps are finite and of positive density at the ends of the unit square") {
  for (const Vec2& u : edge_inputs()) {
    INFO("u = " << u.x << ", " << u.y);
    // Squares add up to 1 within the roundings of root, sine and cosine: 8 * 2^-24.
    constexpr double kLimit = 8 * 0x1p-24;
    const Vec3 hemisphere = cosine_hemisphere(u);
    CHECK(std::fabs(squared_length(hemisphere) - 1.0) < kLimit);
    CHECK(hemisphere.z >= 0x1p-12f);
    CHECK(cosine_hemisphere_pdf_solid_angle(hemisphere.z) > 0.0f);

    CHECK(std::fabs(squared_length(uniform_sphere(u)) - 1.0) < kLimit);
    for (const float depth : {2.0f, 0.5f, 1e-6f, 1e-30f}) {
      const Vec3 w = uniform_cone(u, depth);
      CHECK(std::fabs(squared_length(w) - 1.0) < kLimit);
      CHECK(w.z >= 1.0f - depth);
    }

    const Vec3 b = uniform_triangle(u);
    CHECK(b.x >= 0.0f);
    CHECK(b.y >= 0.0f);
    CHECK(b.z > 0.0f);
    CHECK(std::fabs(static_cast<double>(b.x) + b.y + b.z - 1.0) <= 0x1p-24);
  }
}

TEST_CASE("linear densities: the integral up to the number is the uniform one, and ends stay in [0,1)") {
  for (const auto& [at_0, at_1] :
       {std::pair{1.0f, 1.0f}, {0.0f, 3.0f}, {2.0f, 0.0f}, {1e-6f, 4.0f}, {4.0f, 1e-6f}}) {
    for (int i = 0; i < 1000; ++i) {
      const float u = static_cast<float>(i) / 1000;
      const double x = linear_density(u, at_0, at_1);
      const double a = at_0, b = at_1;
      // Roundings of u and of the square root's argument, a few units in the last place of the whole.
      CHECK((a * x + 0.5 * (b - a) * x * x) / (0.5 * (a + b)) == Approx(u).margin(5 * 0x1p-24));
    }
    for (const Vec2& u : edge_inputs()) {
      const float x = linear_density(u.x, at_0, at_1);
      CHECK(x >= 0.0f);
      CHECK(x < 1.0f);
    }
  }
  CHECK(linear_density(0.5f, 0.0f, 0.0f) == 0.0f);
}

TEST_CASE("pitfall 13: cosine-hemisphere samples keep f cos / pdf bounded over the rim") {
  // At the rim z^2 must be 1 - u.x to the rounding of a square root, not twice that; f = 1/pi then gives
  // f cos / pdf = 1 to the rounding of two constants.
  double worst_z = 0;
  double worst_ratio = 0;
  for (int i = 1; i <= 100000; ++i) {
    const float u = 1.0f - static_cast<float>(i) * 0x1p-24f;
    const Vec3 w = cosine_hemisphere(Vec2{u, 0.3f});
    const double exact = 1.0 - static_cast<double>(u);
    worst_z = std::fmax(worst_z, std::fabs(static_cast<double>(w.z) * w.z / exact - 1.0));
    const double ratio = static_cast<double>(w.z) / kPiDouble / cosine_hemisphere_pdf_solid_angle(w.z);
    worst_ratio = std::fmax(worst_ratio, std::fabs(ratio - 1.0));
  }
  CHECK(worst_z <= 2.1 * 0x1p-24);
  CHECK(worst_ratio <= 3 * 0x1p-24);
}
