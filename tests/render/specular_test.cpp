// Mirrors, metals and glass under uniform light against Fresnel's closed forms, for the whole way from scene
// to image; and pitfall 15, delta lobes: white furnaces of every material kind, and the limit of small
// roughness.
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <cstdint>
#include <string>

#include "render_fixture.hpp"

namespace mlt::test {
namespace {

constexpr std::uint32_t kReplicates = 16;
constexpr double kPi = 3.14159265358979323846;

/// For all tests of this file together.
double threshold() {
  return sidak_threshold(1e-3, 200);
}

/// Walls of radiance 1 that reflect nothing: all that is seen is what the object in the middle lets through.
const std::string kUniformLight =
    "material black diffuse reflectance 0\nbox -40 -40 -40 40 40 40 inward material black emit 1\n";

/// A view of the origin, so narrow that the angle of incidence is one, at `degrees` off the z axis.
std::string view(double degrees) {
  const double angle = degrees * kPi / 180;
  return "camera eye " + std::to_string(10 * std::sin(angle)) + " 0 " + std::to_string(10 * std::cos(angle)) +
         " target 0 0 0 fov 0.002\n";
}

void check(const SceneDescription& scene, std::uint32_t depth, const DVec3& expected, double slack,
           std::uint64_t samples = 64) {
  for (const IntegratorKind kind : kIntegrators) {
    RenderRequest request = small_request(kind, 4, scaled_effort(samples), depth);
    request.roulette = 0;
    const auto replicates = render_replicates(scene, request, kReplicates, 300);
    INFO(name_of(kind) << " depth " << depth << " exactly " << expected.x << " " << expected.y << " "
                       << expected.z);
    for (int channel = 0; channel < 3; ++channel) {
      const Moments measured =
          moments_of(replicates, [channel](const ImageView& image) { return mean_of(image, channel); });
      INFO("channel " << channel << " is " << measured.mean << " +- " << measured.standard_error());
      CHECK(mean_p_value(measured, expected[channel], slack) > threshold());
    }
  }
}

/// Reflectance of a plane surface of complex index for unpolarised light [Born99 section 14.2], by complex
/// arithmetic: a way of its own, for the renderer uses real sums of squares.
double reflectance(std::complex<double> index, double cos_i) {
  const std::complex<double> cos_t = std::sqrt(1.0 - (1 - cos_i * cos_i) / (index * index));
  const std::complex<double> s = (cos_i - index * cos_t) / (cos_i + index * cos_t);
  const std::complex<double> p = (index * cos_i - cos_t) / (index * cos_i + cos_t);
  return (std::norm(s) + std::norm(p)) / 2;
}

/// What a slab or a ball of glass shows of a uniform field of radiance 1 within d edges: the reflection at
/// the front (2 edges), and all paths with k inner reflections, T R^k T (3 + k edges). The refracted ray
/// meets every face at the same angle, and squeezing into and out of the glass cancels.
double glass_radiance(double ior, double cos_i, std::uint32_t depth) {
  const double r = reflectance(ior, cos_i);
  double sum = depth >= 2 ? r : 0;
  for (std::uint32_t k = 0; k + 3 <= depth; ++k) sum += (1 - r) * (1 - r) * std::pow(r, k);
  return sum;
}

/// Lossless parameters of each kind; a kind without a line here does not compile.
std::string lossless_material(MaterialKind kind) {
  switch (kind) {
    case MaterialKind::diffuse:
      return "diffuse reflectance 1";
    case MaterialKind::mirror:
      return "mirror reflectance 1";
    case MaterialKind::dielectric:
      return "dielectric ior 1.5";
    case MaterialKind::conductor:
      return "conductor eta 0.001 k 100";  // 1 - R < 4 eta / k^2 = 4e-7 at any angle but grazing ones
  }
  return "";
}

}  // namespace

TEST_CASE("metals and mirrors reflect a uniform field by Fresnel's equations, at any angle") {
  for (const double degrees : {0.0, 35.0, 60.0, 80.0}) {
    const double cos_i = std::cos(degrees * kPi / 180);
    const SceneDescription metal =
        parse_scene_text(view(degrees) + kUniformLight +
                             "material metal conductor eta 0.2 0.92 1.1 k 3.9 2.45 2.14\n"
                             "quad -1 -1 0  1 -1 0  1 1 0  -1 1 0 material metal\n",
                         "test");
    const DVec3 expected{reflectance({0.2, 3.9}, cos_i), reflectance({0.92, 2.45}, cos_i),
                         reflectance({1.1, 2.14}, cos_i)};
    check(metal, 2, expected, 4e-6);
    const SceneDescription mirror =
        parse_scene_text(view(degrees) + kUniformLight +
                             "material coloured mirror reflectance 0.9 0.3 0\n"
                             "quad -1 -1 0  1 -1 0  1 1 0  -1 1 0 material coloured\n",
                         "test");
    check(mirror, 2, DVec3{0.9, 0.3, 0}, 2e-6);
  }
}

TEST_CASE("a slab and a ball of glass: the series of inner reflections, cut at the depth") {
  for (const double degrees : {0.0, 60.0, 80.0}) {
    const double cos_i = std::cos(degrees * kPi / 180);
    const SceneDescription slab =
        parse_scene_text(view(degrees) + kUniformLight +
                             "material glass dielectric ior 1.5\nbox -20 -20 -0.1  20 20 0 material glass\n",
                         "test");
    // The ball is moved so that the view meets it at the origin, where its normal is +z.
    const SceneDescription ball = parse_scene_text(
        view(degrees) + kUniformLight + "material glass dielectric ior 1.5\nsphere 0 0 -5 5 material glass\n",
        "test");
    for (const std::uint32_t depth : {2U, 3U, 4U, 8U}) {
      const double expected = glass_radiance(1.5, cos_i, depth);
      // The view is 2e-3 degrees high and wide; on the ball the angle varies with the place as well, over
      // 3.5e-4 / 5 radians / cos, which leaves second-order terms below 1e-5 at 80 degrees.
      check(slab, depth, DVec3{expected, expected, expected}, 4e-6);
      check(ball, depth, DVec3{expected, expected, expected}, 1e-5);
    }
  }
}

TEST_CASE("pitfall 15: every material without loss is invisible in a uniform field, by every integrator") {
#define MLT_ENUMERATE(name) MaterialKind::name,
  for (const MaterialKind kind : {MLT_MATERIAL_KINDS(MLT_ENUMERATE)}) {
#undef MLT_ENUMERATE
    // A convex box: light leaves it for the walls, or, in glass, by refraction.
    const SceneDescription scene = parse_scene_text(
        "camera eye 6 5 8 target 0 0 0 fov 8\n" + kUniformLight + "material object " +
            lossless_material(kind) + "\nbox -1 -1 -1 1 1 1 rotate 20 1 2 3 material object\n",
        "test");
    INFO("material kind " << static_cast<int>(kind));
    // 64 edges leave out what stays inside glass for 60 reflections. Rounding adds up over these.
    check(scene, 64, DVec3{1, 1, 1}, 8e-6, 32);
  }
}

TEST_CASE("pitfall 15: white diffuse surfaces seen through glass, and lit through glass, stay invisible") {
  // A hollow shell of glass around a white block: light sampling is blocked everywhere, and every path that
  // arrives has passed delta lobes. What 128 edges leave out is below 1e-3.
  const SceneDescription scene = parse_scene_text("camera eye 6 5 8 target 0 0 0 fov 16\n" + kUniformLight +
                                                      "material white diffuse reflectance 1\n"
                                                      "material glass dielectric ior 1.5\n"
                                                      "box -1.5 -1.5 -1.5 1.5 1.5 1.5 material glass\n"
                                                      "box -1.3 -1.3 -1.3 1.3 1.3 1.3 inward material glass\n"
                                                      "box -0.8 -0.8 -0.8 0.8 0.8 0.8 material white\n",
                                                  "test");
  check(scene, 128, DVec3{1, 1, 1}, 1e-3, 32);
}

TEST_CASE("pitfall 15: a rough metal tends to the polished one as its roughness goes to zero") {
  // A metal floor that mirrors a checked room with a lamp: light sampling and BSDF sampling share the work at
  // large roughness and hand over to the latter alone at zero.
  const auto scene_of = [](const std::string& roughness) {
    return parse_scene_text(
        "camera eye 0 1.2 3.5 target 0 0.2 0 fov 50\n"
        "material white diffuse reflectance 0.7\nmaterial red diffuse reflectance 0.7 0.1 0.1\n"
        "material metal conductor preset gold roughness " +
            roughness +
            "\nquad -2 0 -2  -2 0 4  2 0 4  2 0 -2 material metal\n"
            "quad -2 0 -2  2 0 -2  2 3 -2  -2 3 -2 material white\n"
            "quad -2 0 4  -2 0 -2  -2 3 -2  -2 3 4 material red\n"
            "quad -0.5 2.5 -1.2  0.5 2.5 -1.2  0.5 2 -0.7  -0.5 2 -0.7 material white emit 8\n",
        "test");
  };
  for (const IntegratorKind kind : kIntegrators) {
    const RenderRequest request = small_request(kind, 16, scaled_effort(16), 4);
    const auto polished = render_replicates(scene_of("0"), request, kReplicates, 500);
    // At 1e-5 and 1e-3 the picture moves by some 1e-3 of a pixel's gradients, below the noise of the tiles.
    for (const char* roughness : {"0.00001", "0.0001", "0.001"}) {
      const auto rough = render_replicates(scene_of(roughness), request, kReplicates, 700);
      const TileComparison tiles = compare_tiles(polished, rough, 4);
      INFO(name_of(kind) << " roughness " << roughness);
      CHECK(tiles.smallest_p_value > sidak_threshold(1e-3, 6 * tiles.tiles));
    }
    // The comparison is sharp enough to see a roughness that is not small.
    const auto blurred = render_replicates(scene_of("0.2"), request, kReplicates, 900);
    CHECK(compare_tiles(polished, blurred, 4).smallest_p_value < 1e-3);
  }
}

}  // namespace mlt::test
