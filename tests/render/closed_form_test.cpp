// Pictures whose every pixel, or whose mean, is known in closed form, by every integrator. Each render is one
// replicate; the mean of all must lie within its own standard error of the exact value, by Student's test.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <string>

#include "render_fixture.hpp"

namespace mlt::test {
namespace {

constexpr std::uint32_t kReplicates = 16;

/// For all cases of this file together: false alarms in one of 1000 choices of the seeds.
constexpr std::size_t kCases = 54;
double threshold() {
  return sidak_threshold(1e-3, 3 * kCases);
}

/// A stack of float roundings in a long path: each edge multiplies the throughput once.
double rounding(double value, std::uint32_t depth) {
  return value * (depth + 8) * 0x1p-24;
}

void check_film_mean(const SceneDescription& scene, RenderRequest request, const DVec3& expected,
                     double slack) {
  const auto replicates = render_replicates(scene, request, kReplicates, 100);
  DVec3 mean{0, 0, 0};
  for (int channel = 0; channel < 3; ++channel) {
    mean[channel] =
        moments_of(replicates, [channel](const ImageView& image) { return mean_of(image, channel); }).mean;
  }
  INFO(name_of(request.integrator) << " depth " << *request.depth << ": " << mean.x << " " << mean.y << " "
                                   << mean.z << ", exactly " << expected.x << " " << expected.y << " "
                                   << expected.z);
  CHECK(film_mean_p_value(replicates, expected, slack) > threshold());
}

// ---- furnaces ----

/// A closed room whose walls emit 1 and have one albedo in each channel.
std::string furnace(const std::string& albedo, const std::string& shape) {
  return "camera eye 0.2 -0.1 0.3 target 1 0.4 -0.6 fov 70\nmaterial wall diffuse reflectance " + albedo +
         "\n" + shape;
}
constexpr const char* kQuads = "box -1 -1 -1 1 1 1 inward material wall emit 1\n";
constexpr const char* kTriangles = R"(
inline_mesh material wall emit 1
vertex -1 -1 -1
vertex 1 -1 -1
vertex 1 1 -1
vertex -1 1 -1
vertex -1 -1 1
vertex 1 -1 1
vertex 1 1 1
vertex -1 1 1
face 0 1 2 3
face 4 7 6 5
face 0 3 7 4
face 1 5 6 2
face 0 4 5 1
face 3 2 6 7
end
)";

DVec3 furnace_radiance(const DVec3& albedo, std::uint32_t depth) {
  DVec3 sum{0, 0, 0};
  for (int channel = 0; channel < 3; ++channel) {
    sum[channel] = (1 - std::pow(albedo[channel], depth)) / (1 - albedo[channel]);
  }
  return sum;
}

// ---- a lamp over a floor ----

/// Irradiance at the origin, with normal +y, from a polygon of radiance 1 wholly above the floor
/// [Lambert1760]: half the sum over its edges of the angle that the edge subtends times the upward part of
/// the unit normal of the plane through the edge and the origin.
double polygon_irradiance(const std::vector<DVec3>& corners) {
  double sum = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const DVec3 a = normalize(corners[i]);
    const DVec3 b = normalize(corners[(i + 1) % corners.size()]);
    const DVec3 perpendicular = cross(a, b);
    sum += std::atan2(length(perpendicular), dot(a, b)) * normalize(perpendicular).y;
  }
  return std::fabs(sum) / 2;
}

/// A floor of albedo 0.5 at y = 0 seen at the origin in a view so narrow (3e-4 wide) that the irradiance is
/// that of the origin: its slope cancels in the film's mean, its curvature is below 1e-6 of its value.
std::string floor_under(const std::string& lamp) {
  return "camera eye -4 1.5 0.5 target 0 0 0 fov 0.004\nmaterial grey diffuse reflectance 0.5\n"
         "quad -5 0 -5  -5 0 5  5 0 5  5 0 -5 material grey\n" +
         lamp;
}

void check_irradiance(const std::string& lamp, const DVec3& irradiance) {
  const SceneDescription scene = parse_scene_text(floor_under(lamp), "test");
  const DVec3 expected = irradiance * (0.5 / 3.14159265358979323846);
  for (const IntegratorKind kind : kIntegrators) {
    INFO(lamp);
    const double brightest = std::max({expected.x, expected.y, expected.z});
    check_film_mean(scene, small_request(kind, 4, scaled_effort(256), 2), expected, 2e-6 * brightest);
  }
}

}  // namespace

TEST_CASE("furnace: e (1 - a^d) / (1 - a) for several albedos and depths") {
  const DVec3 albedos[] = {{0.2, 0.5, 0.9}, {0.0, 0.99, 1.0 - 1.0 / 64}};
  for (const DVec3& albedo : albedos) {
    const std::string text =
        std::to_string(albedo.x) + " " + std::to_string(albedo.y) + " " + std::to_string(albedo.z);
    const SceneDescription scene = parse_scene_text(furnace(text, kQuads), "test");
    for (const std::uint32_t depth : {1U, 2U, 3U, 8U, 64U}) {
      const DVec3 expected = furnace_radiance(albedo, depth);
      for (const IntegratorKind kind : kIntegrators) {
        const std::uint64_t samples = scaled_effort(depth > 10 ? 8 : 32);
        check_film_mean(scene, small_request(kind, 8, samples, depth), expected,
                        rounding(std::max({expected.x, expected.y, expected.z}), depth));
      }
    }
  }
}

TEST_CASE("furnace of triangles, with roulette from different edges, up to 100 edges") {
  const SceneDescription scene = parse_scene_text(furnace("0.3 0.6 0.95", kTriangles), "test");
  for (const std::uint32_t roulette : {1U, 4U, 40U}) {
    const std::uint32_t depth = 100;
    const DVec3 expected = furnace_radiance({0.3, 0.6, 0.95}, depth);
    for (const IntegratorKind kind : kIntegrators) {
      RenderRequest request = small_request(kind, 8, scaled_effort(8), depth);
      request.roulette = roulette;
      INFO("roulette from edge " << roulette);
      check_film_mean(scene, request, expected, rounding(expected.z, depth));
    }
  }
}

TEST_CASE("irradiance under polygon lamps is Lambert's closed form") {
  // Parallel, tilted and off to the side; the fronts face the origin.
  const std::vector<DVec3> parallel = {{-1, 2, -1}, {1, 2, -1}, {1, 2, 1}, {-1, 2, 1}};
  check_irradiance("quad -1 2 -1  1 2 -1  1 2 1  -1 2 1 material grey emit 10 5 1",
                   DVec3{10, 5, 1} * polygon_irradiance(parallel));
  const std::vector<DVec3> beside = {{2, 0.5, -1}, {2, 0.5, 1}, {2.5, 1.5, 1}, {2.5, 1.5, -1}};
  check_irradiance("quad 2 0.5 -1  2 0.5 1  2.5 1.5 1  2.5 1.5 -1 material grey emit 3",
                   DVec3{3, 3, 3} * polygon_irradiance(beside));
  const std::vector<DVec3> triangle = {{-0.5, 1, 0}, {0.75, 1.5, -0.5}, {0.5, 1, 1}};
  check_irradiance("triangle -0.5 1 0  0.75 1.5 -0.5  0.5 1 1 material grey emit 2",
                   DVec3{2, 2, 2} * polygon_irradiance(triangle));
}

TEST_CASE("irradiance under a spherical lamp, and under three lamps at once") {
  // A sphere above the horizon is as bright as the disc of its outline: pi (r/D)^2 cos.
  const double sphere = 3.14159265358979323846 * (0.36 / 6.25) * (2.0 / 2.5);
  check_irradiance("sphere 1.5 2 0 0.6 material grey emit 4", DVec3{4, 4, 4} * sphere);
  const std::vector<DVec3> parallel = {{-1, 3, -1}, {0, 3, -1}, {0, 3, 1}, {-1, 3, 1}};
  const std::vector<DVec3> triangle = {{-2.5, 1, 0}, {-2, 1.5, -0.5}, {-2, 1, 1}};
  check_irradiance(
      "sphere 1.5 2 0 0.6 material grey emit 4 0 0\n"
      "quad -1 3 -1  0 3 -1  0 3 1  -1 3 1 material grey emit 0 5 0\n"
      "triangle -2.5 1 0  -2 1.5 -0.5  -2 1 1 material grey emit 0 0 6",
      DVec3{4 * sphere, 5 * polygon_irradiance(parallel), 6 * polygon_irradiance(triangle)});
}

TEST_CASE("the analytic scenes show what their header comments derive") {
  struct Row {
    const char* file;
    DVec3 expected;
    double slack;  ///< stated in the file: truncation and curvature
  };
  const Row rows[] = {
      {"furnace", {1.9921875, 1.9921875, 1.9921875}, 2e-6},
      {"furnace_shapes", {1.9921875, 1.9921875, 1.9921875}, 2e-6},
      {"furnace_glass", {1, 1, 1}, 2e-6},
      {"mirror", {0.8, 0.5, 0.2}, 2e-6},
      {"conductor", {0.9666875122082698, 0.8022053053547903, 0.3240339562776068}, 2e-6},
      {"glass_slab", {0.9230769230769231, 0.07692307692307693, 0}, 2e-6},
      {"glass_slab_oblique", {0.8362324627101683, 0.16376753728983162, 0}, 2e-6},
      {"quad_light", {1.1972823523038676, 1.1972823523038676, 1.1972823523038676}, 1.2e-5},
      {"sphere_light", {0.21650635094610965, 0.21650635094610965, 0.21650635094610965}, 2e-6},
  };
  for (const Row& row : rows) {
    const SceneDescription scene = parse_scene_file(std::string("scenes/") + row.file + ".txt");
    for (const IntegratorKind kind : kIntegrators) {
      RenderRequest request = small_request(kind, 8, scaled_effort(64), scene.depth.value_or(0));
      request.roulette = 0;  // the closed forms state a depth
      INFO(row.file);
      check_film_mean(scene, request, row.expected, row.slack);
    }
  }
}

}  // namespace mlt::test
