// Parameters of materials over their whole ranges, under uniform light, against Fresnel's equations and
// quadrature; and closed rooms of any albedo and depth.
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <cstdint>
#include <string>
#include <vector>

#include "scenes.hpp"
#include "sweep.hpp"

namespace mlt::test {
namespace {

/// Samples a pixel.
constexpr std::uint64_t kFew = 16;
constexpr std::uint64_t kMany = 512;

// ---- roughness ----

constexpr std::complex<double> kMetal{0.2, 3.9};

/// What a GGX surface of this metal shows of a uniform field of radiance 1: the integral of F D G2 (wo.h) /
/// cos_o over half vectors. By the substitution D cos_h dh = du dphi / (2 pi) with slopes alpha
/// sqrt(u/(1-u)), which the renderer, sampling visible normals, does not use; midpoints in u and phi.
double rough_reflectance(double alpha, double cos_o, int points) {
  const double sin_o = std::sqrt(1 - cos_o * cos_o);
  const auto lambda = [alpha](double cosine) {
    return (std::sqrt(1 + alpha * alpha * (1 - cosine * cosine) / (cosine * cosine)) - 1) / 2;
  };
  const double lambda_o = lambda(cos_o);
  double sum = 0;
  for (int i = 0; i < points; ++i) {
    // u = 1 - (1 - v)^2 crowds points where slopes go to infinity.
    const double left = 1 - (i + 0.5) / points;
    const double u = 1 - left * left;
    const double slope = alpha * std::sqrt(u / (1 - u));
    const double cos_h = 1 / std::sqrt(1 + slope * slope);
    for (int k = 0; k < points; ++k) {
      const double phi = 2 * kPiExact * (k + 0.5) / points;
      const double o_dot_h = (sin_o * slope * std::cos(phi) + cos_o) * cos_h;
      const double cos_i = 2 * o_dot_h * cos_h - cos_o;
      if (o_dot_h <= 0 || cos_i <= 0) continue;
      const double masking = 1 / (1 + lambda_o + lambda(cos_i));
      sum += 2 * left * reflectance(kMetal, o_dot_h) * masking * o_dot_h / (cos_o * cos_h);
    }
  }
  return sum / points / points;
}

void sweep_roughness(SweepTable& table, const std::vector<double>& alphas, std::uint64_t samples) {
  for (const double alpha : alphas) {
    for (const double degrees : {0.0, 60.0, 85.0}) {
      const double cos_o = std::cos(degrees * kPiExact / 180);
      const double expected = rough_reflectance(alpha, cos_o, 400);
      const double quadrature = std::fabs(rough_reflectance(alpha, cos_o, 200) - expected) / expected;
      const std::string scene = narrow_view(degrees) + kUniformLight +
                                "material metal conductor eta 0.2 k 3.9 roughness " + exact_text_of(alpha) +
                                "\nquad -1 -1 0  1 -1 0  1 1 0  -1 1 0 material metal\n";
      add_film_means(table, text_of(alpha) + " at " + text_of(degrees) + " deg", scene, 4, samples, 2,
                     expected, quadrature + 1e-5);
    }
  }
}

constexpr const char* kRoughnessBasis =
    "a GGX metal under uniform light: quadrature in double; Student's test over 16 seeds, plus its error";

// ---- index of refraction ----

void sweep_ior(SweepTable& table, const std::vector<double>& indices, std::uint64_t samples) {
  for (const double ior : indices) {
    for (const double degrees : {0.0, 60.0, 89.0}) {
      const double cos_i = std::cos(degrees * kPiExact / 180);
      const std::string scene = narrow_view(degrees) + kUniformLight + "material glass dielectric ior " +
                                exact_text_of(ior) + "\nbox -20 -20 -0.1  20 20 0 material glass\n";
      for (const std::uint32_t depth : {2U, 3U, 16U}) {
        const double expected = slab_radiance(ior, cos_i, depth);
        // What is seen too rarely to be measured has no row.
        if (expected < 1e-2) continue;
        // At 89 degrees the cosine, 0.017, is rounded to 4e-6 of itself, which reflectances take up.
        add_film_means(table,
                       text_of(ior) + " at " + text_of(degrees) + " deg, depth " + std::to_string(depth),
                       scene, 4, samples, depth, expected, 2e-5);
      }
    }
  }
}

constexpr const char* kIorBasis =
    "a slab under uniform light: Fresnel's series of inner reflections; Student's test over 16 seeds";

// ---- albedo and depth ----

void sweep_furnace(SweepTable& table, const std::vector<double>& albedos,
                   const std::vector<std::uint32_t>& depths, std::uint64_t samples) {
  for (const double albedo : albedos) {
    for (const std::uint32_t depth : depths) {
      const double expected = furnace_radiance(albedo, depth);
      // One rounding an edge, and one for the albedo itself, which the k-th edge takes to the power k.
      const double rounding = (2.0 * depth + 8) * 0x1p-24;
      add_film_means(table, text_of(albedo) + " depth " + std::to_string(depth),
                     furnace(exact_text_of(albedo)), 4, samples, depth, expected, rounding);
    }
  }
}

void sweep_mirrors(SweepTable& table, const std::vector<std::uint32_t>& depths) {
  for (const std::uint32_t depth : depths) {
    const std::string scene =
        "camera eye 0.2 -0.1 0.3 target 1 0.4 -0.6 fov 70\nmaterial wall mirror reflectance 0.9\n"
        "box -1 -1 -1 1 1 1 inward material wall emit 1\n";
    add_film_means(table, "mirrors 0.9 depth " + std::to_string(depth), scene, 4, 64, depth,
                   furnace_radiance(0.9, depth), (2.0 * depth + 8) * 0x1p-24);
  }
}

constexpr const char* kFurnaceBasis =
    "a closed room that emits 1: the sum of albedo^k over its edges; Student's test over 16 seeds, plus "
    "rounding";

}  // namespace

TEST_CASE("pitfalls 12 and 15: roughness, index and albedo, some points") {
  {
    SweepTable table("roughness", "alpha", kRoughnessBasis);
    sweep_roughness(table, {1e-5}, kFew);
  }
  {
    SweepTable table("index of refraction", "ior", kIorBasis);
    sweep_ior(table, {1, 3}, kFew);
  }
  SweepTable table("albedo and depth", "albedo", kFurnaceBasis);
  sweep_furnace(table, {0, 1}, {1, 8}, 32);
  sweep_furnace(table, {1}, {32}, 4);
}

TEST_CASE("pitfall 12: roughness 1e-5 to 1", "[.stress]") {
  SweepTable table("roughness", "alpha", kRoughnessBasis);
  sweep_roughness(table, {1e-5, 1e-4, 1e-3, 0.01, 0.1, 0.3, 0.6, 1}, kMany);
}

TEST_CASE("pitfall 15: index of refraction 1 to 3, and exactly 1", "[.stress]") {
  SweepTable table("index of refraction", "ior", kIorBasis);
  sweep_ior(table, {1, 1 + 0x1p-23, 1.000001, 1.0001, 1.01, 1.1, 1.333, 1.5, 2, 2.5, 3}, kMany);
}

TEST_CASE("pitfall 14: albedo 0 to 1 and depth 1 to 256", "[.stress]") {
  SweepTable table("albedo and depth", "albedo", kFurnaceBasis);
  sweep_furnace(table, {0, 1e-30, 1e-6, 0.5, 0.999999, 1}, {1, 2, 8, 64, 256}, 32);
  sweep_furnace(table, {0.1, 0.9}, {1, 2, 3, 4, 8, 16, 32, 64, 128, 256}, 64);
  sweep_mirrors(table, {1, 2, 3, 16, 256});
}

TEST_CASE("materials out of their ranges end in a message") {
  SweepTable table("outside of the range of materials", "what", "the message");
  const auto metal = [](const std::string& roughness) {
    return narrow_view(0) + kUniformLight + "material metal conductor preset gold roughness " + roughness +
           "\nsphere 0 0 0 1 material metal\n";
  };
  const auto glass = [](const std::string& ior) {
    return narrow_view(0) + kUniformLight + "material glass dielectric ior " + ior +
           "\nsphere 0 0 0 1 material glass\n";
  };
  add_message(table, "roughness 9e-6", metal("9e-6"), "1e-05");
  add_message(table, "roughness 1.1", metal("1.1"), "1e-05");
  add_message(table, "roughness 1e-5", metal("1e-5"), "");
  add_message(table, "ior 0.99", glass("0.99"), "[1, 3]");
  add_message(table, "ior 3.01", glass("3.01"), "[1, 3]");
  add_message(table, "ior nan", glass("nan"), "number");
  add_message(table, "albedo 1.000001", furnace("1.000001"), "[0, 1]");
  add_message(table, "albedo -1e-9", furnace("-1e-9"), "[0, 1]");
  add_message(table, "depth 257", "depth 257\n" + furnace("0.5"), "from 1 to 256");
}

}  // namespace mlt::test
