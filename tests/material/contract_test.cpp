// The contract of every material: sampling follows its density, weights are values over densities, no energy
// appears, and light paths can be reversed. Loops over all kinds and parameters of cases.hpp.
#include <array>
#include <catch2/catch.hpp>
#include <limits>

#include "cases.hpp"
#include "direction_cells.hpp"

namespace mlt::test {
namespace {

/// From this roughness down, the directions around a lobe at grazing angles are fewer than the float vectors
/// that a cell needs: at z = 0.01 a lobe of alpha 1e-4 is 2e-6 wide across the plane of incidence, 33 units.
bool resolved_by_float(const Material& material, const Vec3& wo) {
  return material.kind != MaterialKind::conductor || material.roughness * std::fabs(wo.z) >= 1e-6f;
}

constexpr std::uint64_t kSamples = 20000;

struct Drawn {
  std::vector<Vec3> directions;  ///< of samples with a weight
  std::vector<double> weights;   ///< largest channel times eta_scale, 0 for absorbed samples
};

Drawn draw(const Material& material, const Vec3& wo, std::uint64_t stream) {
  Rng rng(7, StreamPurpose::kTest, stream);
  Drawn drawn;
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const float u_lobe = rng.next_float();
    const BsdfSample sample = sample_bsdf<false>(material, wo, u_lobe, random_pair(rng));
    drawn.weights.push_back(static_cast<double>(max_component(sample.weight)) * sample.eta_scale);
    // The density has no colour: a channel of reflectance 0 is drawn as well.
    if (sample.pdf_solid_angle > 0) drawn.directions.push_back(sample.wi);
  }
  return drawn;
}

}  // namespace

TEST_CASE("every material: sampled directions follow the density, chi-square", "[material][contract]") {
  std::size_t tests = 0;
  for (const MaterialCase& c : material_cases()) {
    if (c.material.is_delta()) continue;
    for (const Vec3& wo : viewing_directions()) tests += resolved_by_float(c.material, wo) ? 1 : 0;
  }
  REQUIRE(tests > 0);
  const double threshold = sidak_threshold(0.001, tests);
  std::uint64_t stream = 0;
  for (const MaterialCase& c : material_cases()) {
    if (c.material.is_delta()) continue;
    for (const Vec3& wo : viewing_directions()) {
      if (!resolved_by_float(c.material, wo)) continue;
      stream += 2;
      const Drawn pilot = draw(c.material, wo, stream);
      const Drawn drawn = draw(c.material, wo, stream + 1);
      const DirectionCells cells(pilot.directions, wo.z < 0 ? -1 : 1);
      std::vector<double> expected = cells.integrate(
          [&](const Vec3& wi) { return evaluate_bsdf<false>(c.material, wo, wi).pdf_solid_angle; });
      double inside = 0;
      for (double& e : expected) inside += e, e *= kSamples;
      INFO(c.name << " from z = " << wo.z << ", integral over cells " << inside);
      // The midpoint rule with 10 x 10 points a cell is good to about 1e-3 here; an excess is an error.
      CHECK(inside < 1.0 + 2e-3);
      expected.push_back(std::max(0.0, 1.0 - inside) * kSamples);
      std::vector<std::uint64_t> observed(DirectionCells::kCells + 1, 0);
      for (const Vec3& w : drawn.directions) ++observed[cells.cell_of(w)];
      observed[DirectionCells::kOutside] += kSamples - drawn.directions.size();
      const ChiSquareResult result = chi_square_test(observed, expected);
      INFO("chi-square " << result.statistic << ", dof " << result.dof);
      CHECK(result.dof > 20);
      CHECK(result.p_value > threshold);
    }
  }
}

TEST_CASE("every material: a sample's weight is value over density", "[material][contract]") {
  std::uint64_t stream = 1000;
  for (const MaterialCase& c : material_cases()) {
    for (const Vec3& wo : viewing_directions()) {
      Rng rng(8, StreamPurpose::kTest, ++stream);
      for (int i = 0; i < 200; ++i) {
        const float u_lobe = rng.next_float();
        const BsdfSample sample = sample_bsdf<false>(c.material, wo, u_lobe, random_pair(rng));
        const BsdfValue value = evaluate_bsdf<false>(c.material, wo, sample.wi);
        INFO(c.name << " from z = " << wo.z);
        REQUIRE(sample.is_delta == c.material.is_delta());
        if (sample.is_delta) {
          REQUIRE(sample.pdf_solid_angle == 0.0f);
          REQUIRE(is_zero(value.f_cos));
          REQUIRE(value.pdf_solid_angle == 0.0f);
          continue;
        }
        if (is_zero(sample.weight)) continue;
        REQUIRE(value.pdf_solid_angle == sample.pdf_solid_angle);
        for (int channel = 0; channel < 3; ++channel) {
          // Three roundings on each side.
          REQUIRE(value.f_cos[channel] ==
                  Approx(sample.weight[channel] * sample.pdf_solid_angle).epsilon(6 * 0x1p-24).margin(0));
        }
      }
    }
  }
}

TEST_CASE("every material: white furnace, no more energy leaves than arrives", "[material][contract]") {
  std::uint64_t stream = 2000;
  for (const MaterialCase& c : material_cases()) {
    for (const Vec3& wo : viewing_directions()) {
      INFO(c.name << " from z = " << wo.z);
      const Drawn drawn = draw(c.material, wo, ++stream);
      const Moments mean = moments(drawn.weights);
      // A weight of 1 for every sample has no variance: only the rounding of one weight then.
      CHECK(mean.mean <= 1.0 + 1e-6 + 4 * mean.standard_error());
      if (c.material.is_delta()) {
        double sum = 0;
        for (const DeltaLobe& lobe : delta_lobes(c.material, wo)) {
          const double brightest = lobe.probability * static_cast<double>(max_component(lobe.sample.weight));
          sum += brightest * lobe.sample.eta_scale;
        }
        CHECK(sum <= 1.0 + 1e-6);
        continue;
      }
      if (!resolved_by_float(c.material, wo)) continue;
      const DirectionCells cells(drawn.directions, wo.z < 0 ? -1 : 1);
      double quadrature = 0;
      for (const double part : cells.integrate([&](const Vec3& wi) {
             return max_component(evaluate_bsdf<false>(c.material, wo, wi).f_cos);
           })) {
        quadrature += part;
      }
      CHECK(quadrature <= 1.0 + 2e-3);
      double sampled = 0;
      for (std::size_t i = 0, hit = 0; i < drawn.weights.size(); ++i) {
        if (drawn.weights[i] == 0.0) continue;
        if (cells.cell_of(drawn.directions[hit++]) != DirectionCells::kOutside) sampled += drawn.weights[i];
      }
      // The same integral by sampling: weights are at most 1, so its deviation is at most 0.5 / sqrt(n);
      // 2e-3 is the midpoint rule's error.
      CHECK(std::fabs(sampled / kSamples - quadrature) < 4 * 0.5 / std::sqrt(double{kSamples}) + 2e-3);
    }
  }
}

TEST_CASE("every material: light paths can be reversed", "[material][contract]") {
  std::uint64_t stream = 3000;
  for (const MaterialCase& c : material_cases()) {
    Rng rng(9, StreamPurpose::kTest, ++stream);
    INFO(c.name);
    for (int i = 0; i < 200; ++i) {
      const Vec3 wo = random_direction(rng);
      const float u_lobe = rng.next_float();
      const BsdfSample sample = sample_bsdf<false>(c.material, wo, u_lobe, random_pair(rng));
      if (c.material.is_delta()) {
        for (const DeltaLobe& forth : delta_lobes(c.material, wo)) {
          if (is_zero(forth.sample.weight)) continue;
          double best = 0;
          for (const DeltaLobe& back : delta_lobes(c.material, forth.sample.wi)) {
            const Vec3 error = back.sample.wi - wo;
            // Snell's law loses up to 1/cos of the digits; at these random angles 1e-3 tells lobes apart.
            if (dot(error, error) > 1e-6f) continue;
            for (int channel = 0; channel < 3; ++channel) {
              best = back.coefficient(channel) * back.sample.eta_scale;
              // Near grazing and critical angles the Fresnel reflectance is steep: 1e-7 of rounding in a
              // cosine of 1e-3 becomes 1e-3.
              const double tolerance = 1e-5 + 1e-6 / std::fabs(wo.z) + 1e-6 / std::fabs(forth.sample.wi.z);
              CHECK(std::fabs(forth.coefficient(channel) * forth.sample.eta_scale - best) < tolerance);
            }
            best = 1;
          }
          if (forth.probability > 0.01) CHECK(best > 0);
        }
        continue;
      }
      // One pair from the lobe, one anywhere: delta-like lobes are tested on and off their peak.
      for (const Vec3& wi : {sample.wi, random_direction(rng)}) {
        const BsdfValue forth = evaluate_bsdf<false>(c.material, wo, wi);
        const BsdfValue back = evaluate_bsdf<false>(c.material, wi, wo);
        for (int channel = 0; channel < 3; ++channel) {
          const double f = static_cast<double>(forth.f_cos[channel]) / std::fabs(wi.z);
          const double reversed = static_cast<double>(back.f_cos[channel]) / std::fabs(wo.z);
          // About ten roundings on either side.
          CHECK(f == Approx(reversed).epsilon(20 * 0x1p-24).margin(1e-30));
        }
      }
    }
  }
}

TEST_CASE("every material: finite and consistent at the edges of the inputs", "[material][contract]") {
  const float denormal = std::numeric_limits<float>::denorm_min();
  const float below_one = 1.0f - 0x1p-24f;
  const std::array<float, 6> edges = {0.0f, denormal, 0x1p-24f, 0.25f, 0.5f, below_one};
  std::vector<Vec3> directions = viewing_directions();
  for (const float z : {0.0f, denormal, 1e-38f, 1e-30f, 1e-20f, 1e-10f, 1e-7f, 1e-4f}) {
    for (const float sign : {1.0f, -1.0f}) {
      directions.push_back(Vec3{1, 0, sign * z});
      directions.push_back(Vec3{0.6f, -0.8f, sign * z});
      directions.push_back(Vec3{-1, z, sign * z});
    }
  }
  for (const MaterialCase& c : material_cases()) {
    INFO(c.name);
    for (const Vec3& wo : directions) {
      for (const float u_lobe : edges) {
        for (const float u : edges) {
          for (const float v : edges) {
            const BsdfSample s = sample_bsdf<false>(c.material, wo, u_lobe, Vec2{u, v});
            const bool sound = is_finite(s.wi) && is_finite(s.weight) && std::isfinite(s.pdf_solid_angle) &&
                               std::isfinite(s.eta_scale) && s.weight.x >= 0 && s.weight.y >= 0 &&
                               s.weight.z >= 0 && s.pdf_solid_angle >= 0 && s.eta_scale > 0;
            const bool weighted = !is_zero(s.weight);
            const bool unit = std::fabs(length(DVec3{s.wi}) - 1.0) < 1e-6;
            // A refracted sample is scaled by at most the square of the index, all others by at most 1.
            const bool bounded = max_component(s.weight) <= c.material.ior * c.material.ior;
            if (!sound || !bounded || (weighted && !unit) || (weighted && wo.z == 0.0f) ||
                (weighted && !s.is_delta && s.pdf_solid_angle == 0.0f)) {
              INFO("wo " << wo.x << " " << wo.y << " " << wo.z << ", u " << u_lobe << " " << u << " " << v);
              INFO("wi " << s.wi.x << " " << s.wi.y << " " << s.wi.z << " weight " << s.weight.x << " pdf "
                         << s.pdf_solid_angle << " length error " << length(DVec3{s.wi}) - 1.0);
              FAIL_CHECK("sample not consistent");
            }
          }
        }
      }
      for (const Vec3& wi : directions) {
        const BsdfValue value = evaluate_bsdf<false>(c.material, wo, wi);
        const bool sound = is_finite(value.f_cos) && std::isfinite(value.pdf_solid_angle) &&
                           value.f_cos.x >= 0 && value.f_cos.y >= 0 && value.f_cos.z >= 0 &&
                           value.pdf_solid_angle >= 0;
        const bool in_plane = wo.z == 0.0f || wi.z == 0.0f;
        if (!sound || (in_plane && !(is_zero(value.f_cos) && value.pdf_solid_angle == 0.0f))) {
          FAIL_CHECK("wo.z " << wo.z << " wi.z " << wi.z << " f " << value.f_cos.x << " pdf "
                             << value.pdf_solid_angle);
        }
      }
    }
  }
}

TEST_CASE("every material: primary samples that are declared unused have no influence",
          "[material][contract]") {
  for (const MaterialCase& c : material_cases()) {
    const PrimarySampleUse use = primary_sample_use(c.material.kind);
    INFO(c.name);
    for (const Vec3& wo : viewing_directions()) {
      const BsdfSample base = sample_bsdf<false>(c.material, wo, 0.3f, Vec2{0.2f, 0.7f});
      const BsdfSample other_lobe = sample_bsdf<false>(c.material, wo, 0.9999f, Vec2{0.2f, 0.7f});
      const BsdfSample other_pair = sample_bsdf<false>(c.material, wo, 0.3f, Vec2{0.6f, 0.1f});
      if (!use.lobe) CHECK(other_lobe.wi == base.wi);
      if (!use.direction) CHECK(other_pair.wi == base.wi);
    }
  }
}

TEST_CASE("the kernel for diffuse surfaces alone gives the bits of the general one", "[material]") {
  MaterialDescription description;
  description.reflectance = {0.2, 0.5, 0.8};
  const Material material = compile_material(description);
  Rng rng(3, StreamPurpose::kTest, 0);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 wo = random_direction(rng);
    const Vec3 wi = random_direction(rng);
    const Vec2 u = random_pair(rng);
    const BsdfSample a = sample_bsdf<true>(material, wo, 0.0f, u);
    const BsdfSample b = sample_bsdf<false>(material, wo, 0.0f, u);
    REQUIRE(a.wi == b.wi);
    REQUIRE(a.weight == b.weight);
    REQUIRE(a.pdf_solid_angle == b.pdf_solid_angle);
    REQUIRE(evaluate_bsdf<true>(material, wo, wi).f_cos == evaluate_bsdf<false>(material, wo, wi).f_cos);
  }
}

}  // namespace mlt::test
