#include "material/fresnel.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <complex>

namespace mlt::test {
namespace {

using Complex = std::complex<long double>;

/// The textbook form with complex numbers, s and p amplitudes at a boundary from index 1 to `index`.
double reference_reflectance(long double cos_i, long double sin2_i, Complex index) {
  const Complex squared = index * index;
  const Complex cos_t = std::sqrt(Complex{1} - sin2_i / squared);
  const Complex s = (cos_i - index * cos_t) / (cos_i + index * cos_t);
  const Complex p = (index * cos_i - cos_t) / (index * cos_i + cos_t);
  return static_cast<double>(0.5L * (std::norm(s) + std::norm(p)));
}

struct Angle {
  float cos_i;
  long double sin2_i;
};

Angle angle_at(int step, int steps) {
  const auto cos_i = static_cast<float>(static_cast<double>(step) / steps);
  return {cos_i, (1.0L - cos_i) * (1.0L + cos_i)};
}

}  // namespace

TEST_CASE("Fresnel reflectance of a dielectric agrees with the complex closed form", "[fresnel]") {
  for (const float ior : {1.0001f, 1.1f, 1.33f, 1.5f, 2.4f, 3.0f}) {
    for (int step = 1; step <= 1000; ++step) {
      const Angle angle = angle_at(step, 1000);
      for (const float eta : {ior, 1.0f / ior}) {
        const long double cos2_t = 1.0L - angle.sin2_i / (static_cast<long double>(eta) * eta);
        if (cos2_t <= 1e-6L) continue;
        const auto cos_t = static_cast<float>(std::sqrt(cos2_t));
        const double expected = reference_reflectance(angle.cos_i, angle.sin2_i, Complex{eta, 0});
        // An amplitude is a difference of two terms over their sum, so rounding adds a few units in the last
        // place of 1 to it, which for small amplitudes is an absolute error.
        const double amplitude_error = 8 * 0x1p-24;
        const double tolerance =
            2 * std::sqrt(expected) * amplitude_error + amplitude_error * amplitude_error;
        INFO("eta " << eta << " cos " << angle.cos_i);
        REQUIRE(std::fabs(fresnel_dielectric(angle.cos_i, cos_t, eta) - expected) <= tolerance);
      }
    }
  }
}

TEST_CASE("Fresnel reflectance of a conductor agrees with the complex closed form", "[fresnel]") {
  for (const float eta : {0.001f, 0.1f, 0.47f, 1.0f, 1.5f, 7.0f, 100.0f}) {
    for (const float k : {0.0f, 1e-4f, 0.1f, 1.0f, 2.83f, 6.0f, 100.0f}) {
      for (int step = 0; step <= 500; ++step) {
        const Angle angle = angle_at(step, 500);
        const double expected = reference_reflectance(angle.cos_i, angle.sin2_i, Complex{eta, k});
        const float found = fresnel_conductor(angle.cos_i, static_cast<float>(angle.sin2_i), eta, k);
        INFO("eta " << eta << " k " << k << " cos " << angle.cos_i);
        if (eta == 1.0f && k == 0.0f && step == 0) continue;  // 0/0 without an interface
        REQUIRE(found >= 0.0f);
        REQUIRE(found <= 1.0f);
        // eta^2 - k^2 - sin^2 has the absolute error of its largest term; near total reflection without
        // absorption the reflectance depends on the square root of that: sqrt(4 * 2^-24) = 5e-4.
        const bool critical = k < 0.01f && eta < 1.0f;
        REQUIRE(std::fabs(found - expected) < (critical ? 1e-3 : 4e-6));
      }
    }
  }
}

TEST_CASE("Fresnel reflectances of the literature", "[fresnel]") {
  // Normal incidence, ((n-1)/(n+1))^2: 4 % for glass of 1.5, 2 % for water, 17.2 % for diamond.
  CHECK(fresnel_dielectric(1.0f, 1.0f, 1.5f) == Approx(0.04).epsilon(1e-6));
  CHECK(fresnel_dielectric(1.0f, 1.0f, 1.333f) == Approx(0.020373).epsilon(1e-4));
  CHECK(fresnel_dielectric(1.0f, 1.0f, 2.417f) == Approx(0.17198).epsilon(1e-4));
  // Brewster's angle, tan = n: only the s polarisation is left, (n^2-1)^2/(n^2+1)^2.
  const auto cos_b = static_cast<float>(1 / std::sqrt(1 + 1.5 * 1.5));
  const auto sin_b = static_cast<float>(1.5 / std::sqrt(1 + 1.5 * 1.5));
  CHECK(fresnel_dielectric(cos_b, sin_b, 1.5f) == Approx(0.5 * (1.25 * 1.25) / (3.25 * 3.25)).epsilon(1e-6));
  // Metals in sodium light [Born99 table 14.1]: gold, n = 0.47 and n kappa = 2.83, reflects 81.5 %; silver,
  // 0.20 and 3.44, 94 %.
  CHECK(fresnel_conductor(1.0f, 0.0f, 0.47f, 2.83f) == Approx(0.815).margin(5e-4));
  CHECK(fresnel_conductor(1.0f, 0.0f, 0.20f, 3.44f) == Approx(0.94).margin(5e-3));
  // Everything is reflected at grazing incidence.
  CHECK(fresnel_conductor(0.0f, 1.0f, 0.47f, 2.83f) == 1.0f);
  CHECK(fresnel_conductor(0.0f, 1.0f, 1.0f, 0.0f) == 1.0f);
}

TEST_CASE("a conductor without absorption is a dielectric", "[fresnel]") {
  for (int step = 1; step <= 100; ++step) {
    const Angle angle = angle_at(step, 100);
    const auto cos_t = static_cast<float>(std::sqrt(1 - angle.sin2_i / 2.25L));
    const float dielectric = fresnel_dielectric(angle.cos_i, cos_t, 1.5f);
    const float conductor = fresnel_conductor(angle.cos_i, static_cast<float>(angle.sin2_i), 1.5f, 0.0f);
    // Ten roundings of amplitudes below 1.
    CHECK(conductor == Approx(dielectric).margin(20 * 0x1p-24));
  }
}

}  // namespace mlt::test
