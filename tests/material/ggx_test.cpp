#include "material/ggx.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "cases.hpp"
#include "support/statistics.hpp"

namespace mlt::test {
namespace {

constexpr double kPiDouble = 3.141592653589793;
constexpr double kAlphas[] = {1e-5, 1e-4, 1e-3, 1e-2, 0.1, 0.5, 1};

/// Slopes in units of alpha in polar form: azimuth and 1/sqrt(1+s^2), the cosine in the space where the
/// facets form a hemisphere.
Point2 slope_coordinates(const DVec3& h, double alpha) {
  const double x = h.x / h.z / alpha;
  const double y = h.y / h.z / alpha;
  return {std::atan2(y, x), 1 / std::sqrt(1 + (x * x + y * y))};
}

/// Density of visible slopes in these coordinates. The slopes of all facets have density w/pi (D is the
/// projection of a uniform hemisphere); G1 max(0, wo.h) / (wo.z h.z) of them are seen.
double visible_slope_density(const DVec3& wo, double alpha, double azimuth, double w) {
  const double tan2 = (wo.x * wo.x + wo.y * wo.y) / (wo.z * wo.z);
  const double g1 = 2 / (1 + std::sqrt(1 + alpha * alpha * tan2));
  const double across = wo.x * std::cos(azimuth) + wo.y * std::sin(azimuth);
  const double projected = w * wo.z + alpha * std::sqrt(1 - w * w) * across;
  return g1 * std::max(0.0, projected / wo.z) / kPiDouble;
}

/// D in double for a half vector that need not be normalised.
double reference_distribution(double alpha, const DVec3& half) {
  const DVec3 h = normalize(half);
  const double tan2 = (h.x * h.x + h.y * h.y) / (h.z * h.z);
  const double t = 1 + tan2 / (alpha * alpha);
  return 1 / (kPiDouble * alpha * alpha * std::pow(h.z, 4) * t * t);
}

}  // namespace

TEST_CASE("pitfall 12: GGX D integrates to one down to alpha 1e-5, in float", "[ggx]") {
  for (const double alpha : kAlphas) {
    const auto alpha_float = static_cast<float>(alpha);
    const double a = alpha_float;
    double sum = 0;
    constexpr int kSteps = 2000;
    for (int i = 0; i < kSteps; ++i) {
      // v = t/(1+t) with t = tan^2(theta)/alpha^2; cos(theta) domega = pi alpha^2 cos^4 (1+t)^2 dv.
      const double v = (i + 0.5) / kSteps;
      const double t = v / (1 - v);
      const double cos_theta = 1 / std::sqrt(1 + t * a * a);
      const double sin_theta = a * std::sqrt(t) * cos_theta;
      const Vec3 h{static_cast<float>(0.6 * sin_theta), static_cast<float>(-0.8 * sin_theta),
                   static_cast<float>(cos_theta)};
      const double integrand =
          ggx_distribution(alpha_float, h) * kPiDouble * a * a * std::pow(cos_theta, 4) * (1 + t) * (1 + t);
      INFO("alpha " << alpha << " t " << t);
      // The integrand is 1 everywhere; D has the fourth power of h.z and a square of a square, about 12
      // roundings in all.
      REQUIRE(integrand == Approx(1.0).epsilon(12 * 0x1p-24).margin(0));
      sum += integrand / kSteps;
    }
    CHECK(sum == Approx(1.0).epsilon(12 * 0x1p-24).margin(0));
    // The peak, whose naive form is infinite at 1e-4.
    CHECK(ggx_distribution(alpha_float, Vec3{0, 0, 1}) ==
          Approx(1 / (kPiDouble * a * a)).epsilon(4 * 0x1p-24).margin(0));
  }
}

TEST_CASE("pitfall 12: visible normals follow D in slope space for alpha 1e-5 to 1, chi-square", "[ggx]") {
  const double threshold = sidak_threshold(0.001, std::size(kAlphas) * 4 * 2);
  std::uint64_t stream = 100;
  for (const double alpha : kAlphas) {
    for (const double cos_o : {1.0, 0.7, 0.2, 0.02}) {
      Rng rng(11, StreamPurpose::kTest, ++stream);
      const auto alpha_float = static_cast<float>(alpha);
      const Vec3 wo = direction_from(cos_o, 0.4);
      const Grid2D grid{-kPiDouble, kPiDouble, 10, 0, 1, 10};
      const Density2D density = [&](double azimuth, double w) {
        return visible_slope_density(DVec3{wo}, alpha_float, azimuth, w);
      };
      INFO("alpha " << alpha << ", cos of wo " << cos_o);
      const ChiSquareResult normals = chi_square_2d(
          grid, 20000,
          [&]() -> std::optional<Point2> {
            const Vec3 h = ggx_sample_visible_normal(alpha_float, wo, random_pair(rng));
            return slope_coordinates(DVec3{h}, alpha_float);
          },
          density);
      CHECK(normals.p_value > threshold);

      // The half vector found again from the sampled direction, as evaluation does. Across the plane of
      // incidence the lobe is 2 alpha cos wide; below 2e-6 (34 units in the last place of 1) rounding of wi
      // shows in a histogram.
      if (alpha * cos_o < 1e-6) continue;
      MaterialDescription description;
      description.kind = MaterialKind::conductor;
      description.roughness = alpha;
      const Material material = compile_material(description);
      std::uint64_t absorbed = 0;
      const ChiSquareResult reflected = chi_square_2d(
          grid, 20000,
          [&]() -> std::optional<Point2> {
            const Vec2 u = random_pair(rng);
            const BsdfSample sample = sample_bsdf<false>(material, wo, 0, u);
            if (sample.pdf_solid_angle > 0)
              return slope_coordinates(DVec3{wo} + DVec3{sample.wi}, alpha_float);
            // Reflected below the horizon: its normal is what was sampled.
            ++absorbed;
            return slope_coordinates(DVec3{ggx_sample_visible_normal(alpha_float, wo, u)}, alpha_float);
          },
          density);
      CHECK(reflected.p_value > threshold);
      // From straight on, alpha 1 tilts half of the facets by more than 45 degrees: 10000 +- 71.
      CHECK(absorbed < 10300);
    }
  }
}

TEST_CASE("pitfall 12: the density of a rough reflection agrees with double precision", "[ggx]") {
  for (const double alpha : kAlphas) {
    MaterialDescription description;
    description.kind = MaterialKind::conductor;
    description.roughness = alpha;
    const Material material = compile_material(description);
    Rng rng(12, StreamPurpose::kTest, 0);
    for (int i = 0; i < 2000; ++i) {
      const Vec3 wo = direction_from(0.05 + 0.95 * rng.next_float(), 6.28 * rng.next_float());
      const BsdfSample sample = sample_bsdf<false>(material, wo, 0, random_pair(rng));
      if (!(sample.pdf_solid_angle > 0)) continue;
      const DVec3 o{wo};
      const DVec3 in{sample.wi};
      const double a = material.roughness;
      const double tan2 = (o.x * o.x + o.y * o.y) / (o.z * o.z);
      const double g1 = 2 / (1 + std::sqrt(1 + a * a * tan2));
      const double expected = g1 * reference_distribution(a, o + in) / (4 * o.z);
      INFO("alpha " << alpha << ", wo.z " << wo.z << ", wi.z " << sample.wi.z);
      // The sum of nearly opposite tangential components is exact; what is left are about 30 roundings.
      REQUIRE(sample.pdf_solid_angle == Approx(expected).epsilon(30 * 0x1p-24).margin(0));
    }
  }
}

TEST_CASE("GGX masking is the share of visible facets", "[ggx]") {
  // The projected area of all visible facets must be that of the surface: the integral of G1 max(0, wo.h) D
  // over h is wo.z [Heitz14 eq. 16], by quadrature in double with the float G1.
  for (const double alpha : {0.05, 0.3, 1.0}) {
    for (const double cos_o : {1.0, 0.6, 0.1}) {
      const Vec3 wo = direction_from(cos_o, 0.0);
      const double g1 =
          2.0 * wo.z / (wo.z + static_cast<double>(ggx_stretched_length(static_cast<float>(alpha), wo)));
      double sum = 0;
      constexpr int kSteps = 400;
      for (int i = 0; i < kSteps; ++i) {
        for (int j = 0; j < kSteps; ++j) {
          // v = 1 - w^2, dv = 2 w dw, which takes out the singularity of s at v = 1.
          const double w = (i + 0.5) / kSteps;
          const double azimuth = 2 * kPiDouble * (j + 0.5) / kSteps;
          const double s = std::sqrt(1 - w * w) / w;
          const double visible = std::max(0.0, wo.z + alpha * s * wo.x * std::cos(azimuth));
          sum += visible * 2 * w / (kSteps * kSteps);
        }
      }
      // The midpoint rule on an integrand with a kink along the border of visibility: second order in 1/400,
      // times a factor of order 10.
      CHECK(g1 * sum == Approx(wo.z).margin(1e-4));
    }
  }
}

TEST_CASE("a white metal of roughness 1 seen straight on reflects 1 - ln 2", "[ggx]") {
  // sin^2 of the facet's angle is v, uniform in [0,1); light leaves at twice that angle, with cosine 1 - 2v,
  // if v < 1/2; G2/G1 is G1 = 2c/(1+c) there. The integral of (1-2v)/(1-v) over [0,1/2] is 1 - ln 2.
  MaterialDescription description;
  description.kind = MaterialKind::conductor;
  description.roughness = 1;
  description.eta = {0.001, 0.001, 0.001};
  description.k = {100, 100, 100};
  const Material material = compile_material(description);
  Rng rng(13, StreamPurpose::kTest, 0);
  std::vector<double> weights;
  for (int i = 0; i < 50000; ++i) {
    weights.push_back(sample_bsdf<false>(material, Vec3{0, 0, 1}, 0, random_pair(rng)).weight.x);
  }
  const Moments mean = moments(weights);
  // 1e-5: at this index the Fresnel reflectance falls short of 1 by at most 1e-5 at the angles that occur.
  CHECK(std::fabs(mean.mean - (1 - std::log(2.0))) < 4 * mean.standard_error() + 1e-5);
}

}  // namespace mlt::test
