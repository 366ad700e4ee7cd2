// What is particular to single materials: limits, closed forms, refusals.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "cases.hpp"
#include "support/statistics.hpp"

namespace mlt::test {
namespace {

Material make(MaterialKind kind, const std::function<void(MaterialDescription&)>& change) {
  MaterialDescription description;
  description.kind = kind;
  change(description);
  return compile_material(description);
}

Material gold(double roughness) {
  return make(MaterialKind::conductor, [&](MaterialDescription& m) {
    m.eta = {0.143, 0.375, 1.442};
    m.k = {3.983, 2.386, 1.603};
    m.roughness = roughness;
  });
}

}  // namespace

TEST_CASE("parameters out of range are refused with their place", "[material]") {
  const auto refused = [](MaterialKind kind, const std::function<void(MaterialDescription&)>& change) {
    MaterialDescription description;
    description.name = "odd";
    description.kind = kind;
    description.location = {"scene.txt", 12, 3};
    change(description);
    try {
      compile_material(description);
    } catch (const InputError& error) {
      const Diagnostic& d = error.diagnostics().at(0);
      return d.file == "scene.txt" && d.line == 12 && d.column == 3 &&
             d.message.find("'odd'") != std::string::npos;
    }
    return false;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {-0.001, 1.001, nan, inf}) {
    CHECK(refused(MaterialKind::diffuse, [&](MaterialDescription& m) { m.reflectance.y = bad; }));
    CHECK(refused(MaterialKind::mirror, [&](MaterialDescription& m) { m.reflectance.z = bad; }));
    CHECK(refused(MaterialKind::conductor, [&](MaterialDescription& m) { m.roughness = bad; }));
  }
  for (const double bad : {0.999, 3.001, nan, inf}) {
    CHECK(refused(MaterialKind::dielectric, [&](MaterialDescription& m) { m.ior = bad; }));
  }
  for (const double bad : {-1.0, 1e9, nan, inf}) {
    CHECK(refused(MaterialKind::conductor, [&](MaterialDescription& m) { m.eta.x = bad; }));
    CHECK(refused(MaterialKind::conductor, [&](MaterialDescription& m) { m.k.x = bad; }));
  }
  CHECK(refused(MaterialKind::conductor, [](MaterialDescription& m) { m.eta.x = 0; }));
  CHECK(refused(MaterialKind::conductor, [](MaterialDescription& m) { m.roughness = 1e-6; }));
}

TEST_CASE("pitfall 13: the rim of the cosine hemisphere", "[material]") {
  const Material white = make(MaterialKind::diffuse, [](MaterialDescription& m) {
    m.reflectance = {1, 1, 1};
  });
  const Vec3 wo{0, 0.6f, 0.8f};
  for (int unit = 1; unit <= 4096; ++unit) {
    // The 4096 primary samples nearest to 1: z^2 is what is left to 1.
    const float u = 1.0f - static_cast<float>(unit) * 0x1p-24f;
    const BsdfSample sample = sample_bsdf<false>(white, wo, 0, Vec2{u, 0.3f});
    REQUIRE(sample.weight == Vec3(1, 1, 1));
    // Two roundings, of the root and of the square.
    const double z2 = static_cast<double>(sample.wi.z) * sample.wi.z;
    REQUIRE(z2 == Approx(1.0 - static_cast<double>(u)).epsilon(2 * 0x1p-24).margin(0));
    const BsdfValue value = evaluate_bsdf<false>(white, wo, sample.wi);
    REQUIRE(value.pdf_solid_angle > 0.0f);
    REQUIRE(value.f_cos.x / value.pdf_solid_angle <= 1.0f + 0x1p-23f);
  }
  // The outermost 2^-8 of the primary samples, in 32 x 8 cells of azimuth and z^2, are uniform there.
  Rng rng(21, StreamPurpose::kTest, 0);
  const Grid2D grid{-3.141592653589793, 3.141592653589793, 32, 0, 0x1p-8, 8};
  const ChiSquareResult result = chi_square_2d(
      grid, 50000,
      [&]() -> std::optional<Point2> {
        const Vec2 u = random_pair(rng);
        const BsdfSample sample =
            sample_bsdf<false>(white, wo, 0, Vec2{1.0f - 0x1p-8f * (u.x + 0x1p-24f), u.y});
        return Point2{std::atan2(static_cast<double>(sample.wi.y), static_cast<double>(sample.wi.x)),
                      static_cast<double>(sample.wi.z) * sample.wi.z};
      },
      [](double, double) { return 256 / 6.283185307179586; });
  CHECK(result.p_value > 0.001);
}

TEST_CASE("pitfall 15: a rough conductor tends to the delta conductor as alpha goes to 0", "[material]") {
  const Material mirror = gold(0);
  REQUIRE(mirror.is_delta());
  const auto scene = [](const Vec3& w) { return 1.0 + 0.5 * w.x - 0.3 * w.y + 0.2 * w.z; };
  std::uint64_t stream = 0;
  for (const double cos_o : {1.0, 0.8, 0.3}) {
    const Vec3 wo = direction_from(cos_o, 1.0);
    const BsdfSample ideal = sample_bsdf<false>(mirror, wo, 0, Vec2{0, 0});
    for (const double alpha : {1e-2, 1e-3, 1e-4, 1e-5}) {
      const Material rough = gold(alpha);
      REQUIRE_FALSE(rough.is_delta());
      Rng rng(22, StreamPurpose::kTest, ++stream);
      for (int channel = 0; channel < 3; ++channel) {
        constexpr int kSamples = 4000;
        double sum = 0;
        for (int i = 0; i < kSamples; ++i) {
          const BsdfSample sample = sample_bsdf<false>(rough, wo, 0, random_pair(rng));
          sum += sample.weight[channel] * scene(sample.wi);
        }
        const double expected = ideal.weight[channel] * scene(ideal.wi);
        INFO("cos " << cos_o << ", alpha " << alpha << ", channel " << channel);
        // The mean slope of the heavy-tailed lobe is about alpha pi/2, a direction moves by twice that, the
        // function and the Fresnel reflectance have slopes below 1 there, and noise is below 4 alpha; 1e-6 is
        // for roundings.
        CHECK(std::fabs(sum / kSamples - expected) < 8 * alpha + 1e-6);
      }
    }
  }
}

TEST_CASE("a mirror reflects its reflectance at the mirror angle, on both sides", "[material]") {
  const Material material = make(MaterialKind::mirror, [](MaterialDescription& m) {
    m.reflectance = {0.25, 0.5, 1};
  });
  for (const Vec3& wo : viewing_directions()) {
    const BsdfSample sample = sample_bsdf<false>(material, wo, 0.9f, Vec2{0.1f, 0.2f});
    CHECK(sample.wi == Vec3(-wo.x, -wo.y, wo.z));
    CHECK(sample.weight == Vec3(0.25f, 0.5f, 1.0f));
    CHECK(sample.eta_scale == 1.0f);
  }
}

TEST_CASE("a dielectric of index 1 is invisible", "[material]") {
  const Material air = make(MaterialKind::dielectric, [](MaterialDescription& m) { m.ior = 1; });
  for (const Vec3& wo : viewing_directions()) {
    for (const float u_lobe : {0.0f, 0.5f, 1.0f - 0x1p-24f}) {
      const BsdfSample sample = sample_bsdf<false>(air, wo, u_lobe, Vec2{0, 0});
      CHECK(sample.wi == -wo);
      CHECK(sample.weight == Vec3(1, 1, 1));
      CHECK(sample.eta_scale == 1.0f);
    }
  }
}

TEST_CASE("a dielectric refracts by Snell's law and scales radiance by the squared index", "[material]") {
  for (const double ior : {1.33, 1.5, 2.4}) {
    const Material glass = make(MaterialKind::dielectric, [&](MaterialDescription& m) { m.ior = ior; });
    for (const Vec3& wo : viewing_directions()) {
      const double eta = wo.z > 0 ? static_cast<double>(glass.ior) : 1 / static_cast<double>(glass.ior);
      const double sin2_t =
          (static_cast<double>(wo.x) * wo.x + static_cast<double>(wo.y) * wo.y) / (eta * eta);
      const std::vector<DeltaLobe> lobes = delta_lobes(glass, wo);
      INFO("ior " << ior << ", wo.z " << wo.z);
      if (sin2_t >= 1) {
        REQUIRE(lobes.size() == 1);
        CHECK(lobes[0].sample.wi == Vec3(-wo.x, -wo.y, wo.z));
        CHECK(lobes[0].sample.weight == Vec3(1, 1, 1));
        continue;
      }
      REQUIRE(lobes.size() == 2);
      const BsdfSample& refracted = lobes[1].sample;
      CHECK(lobes[0].sample.wi == Vec3(-wo.x, -wo.y, wo.z));
      CHECK(lobes[0].sample.weight == Vec3(1, 1, 1));
      // Two or three roundings each.
      CHECK(refracted.wi.x == Approx(-wo.x / eta).epsilon(4 * 0x1p-24).margin(1e-12));
      CHECK(refracted.wi.y == Approx(-wo.y / eta).epsilon(4 * 0x1p-24).margin(1e-12));
      CHECK(std::signbit(refracted.wi.z) != std::signbit(wo.z));
      CHECK(std::fabs(refracted.wi.z) == Approx(std::sqrt(1 - sin2_t)).epsilon(1e-5));
      CHECK(refracted.weight.x == Approx(1 / (eta * eta)).epsilon(4 * 0x1p-24));
      CHECK(refracted.eta_scale * refracted.weight.x == Approx(1.0).epsilon(4 * 0x1p-24));
      // The two lobes share all of the light: both probabilities add up to 1, and reflection has Fresnel's,
      // by the closed form in double and the resolution of u_lobe.
      const double cos_i = std::fabs(static_cast<double>(wo.z));
      const double cos_t = std::sqrt(1 - sin2_t);
      const double parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
      const double perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
      const double reflectance = 0.5 * (parallel * parallel + perpendicular * perpendicular);
      CHECK(lobes[0].probability == Approx(reflectance).epsilon(1e-5).margin(0x1p-23));
      CHECK(lobes[0].probability + lobes[1].probability == Approx(1.0));
    }
  }
}

TEST_CASE("a glass slab passes light straight on, with the energy of two interfaces", "[material]") {
  // In through the front and out through the back face, whose normal points the other way: the eta^2 factors
  // cancel and the direction returns.
  const Material glass = make(MaterialKind::dielectric, [](MaterialDescription& m) { m.ior = 1.5; });
  const float last = 1.0f - 0x1p-24f;
  for (const double cos_o : {1.0, 0.7, 0.2}) {
    const Vec3 wo = direction_from(cos_o, 2.0);
    const BsdfSample in = sample_bsdf<false>(glass, wo, last, Vec2{0, 0});
    const BsdfSample out = sample_bsdf<false>(glass, Vec3{-in.wi.x, -in.wi.y, in.wi.z}, last, Vec2{0, 0});
    CHECK(in.weight.x * out.weight.x == Approx(1.0).epsilon(8 * 0x1p-24));
    CHECK(out.wi.x == Approx(-wo.x).margin(4 * 0x1p-24));
    CHECK(out.wi.y == Approx(-wo.y).margin(4 * 0x1p-24));
    // A cosine of 0.2 comes back from a sine with five times its rounding.
    CHECK(out.wi.z == Approx(wo.z).margin(20 * 0x1p-24));
  }
}

TEST_CASE("the smooth conductor reflects Fresnel's reflectance per channel", "[material]") {
  const Material metal = gold(0);
  const BsdfSample sample = sample_bsdf<false>(metal, Vec3{0, 0, 1}, 0, Vec2{0, 0});
  const double n[3] = {0.143, 0.375, 1.442};
  const double k[3] = {3.983, 2.386, 1.603};
  for (int channel = 0; channel < 3; ++channel) {
    const double below = (n[channel] - 1) * (n[channel] - 1) + k[channel] * k[channel];
    const double above = (n[channel] + 1) * (n[channel] + 1) + k[channel] * k[channel];
    CHECK(sample.weight[channel] == Approx(below / above).epsilon(1e-6));
  }
}

}  // namespace mlt::test
