#include "light/light_shapes.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "light_reference.hpp"
#include "support/statistics.hpp"

namespace mlt::test {
namespace {

constexpr std::uint64_t kSamples = 20000;
const Vec3 kWhite{1, 1, 1};

struct View {
  const char* name;
  Light light;
  Vec3 reference;
  Vec3 normal{0, 0, 0};  ///< of the receiver, for quads

  Receiver receiver() const { return {reference, normal}; }
};

Light quad_light() {
  return make_quad_light(Quad{{-1, -0.5f, 2}, {-0.8f, 0.7f, 2.1f}, {0.4f, 0.5f, 2.2f}, {0.2f, -0.7f, 2.1f}},
                         kWhite);
}

Light triangle_light() {
  return make_triangle_light(Triangle{{0.5f, 0, 1}, {-0.5f, 0.6f, 1.3f}, {-0.2f, -0.8f, 0.9f}}, kWhite);
}

std::vector<View> views() {
  return {{"quad", quad_light(), {0, 0, 0}},
          {"quad, close", quad_light(), {-0.3f, 0, 2}},
          {"quad, grazing", quad_light(), {3, 0, 2.3f}},
          {"quad, from behind", quad_light(), {0, 0, 4}},
          {"quad over a floor", quad_light(), {0, 0, 0}, {0, 0, 1}},
          {"quad over a floor, close", quad_light(), {-0.3f, 0, 1.9f}, {0, 0, 1}},
          {"quad beside a wall", quad_light(), {-1.5f, 0, 0}, {1, 0, 0}},
          {"triangle", triangle_light(), {0, 0, 0}},
          {"triangle, aside", triangle_light(), {2, -1, 0.3f}},
          {"sphere", make_sphere_light(Sphere{{0.5f, 0.4f, 2}, 0.7f}, kWhite), {0, 0, 0}},
          {"sphere, near its surface", make_sphere_light(Sphere{{0, 0, 2}, 1}, kWhite), {0, 0.1f, 0.99f}},
          {"sphere, inside", make_sphere_light(Sphere{{0, 0, 0}, 1}, kWhite), {0.3f, -0.2f, 0.5f}},
          {"sphere, far", make_sphere_light(Sphere{{3, 4, 0}, 1e-3f}, kWhite), {0, 0, 0}}};
}

/// Directions around the middle of the light in a tangent plane, which a light wholly in front of the
/// reference covers finitely.
struct TangentPlane {
  DVec3 x, y, z;
  double extent = 0;

  explicit TangentPlane(const View& view) : x{0, 0, 0}, y{0, 0, 0}, z{0, 0, 0} {
    DVec3 sum{0, 0, 0};
    std::vector<DVec3> directions;
    for (int i = 0; i <= 20; ++i) {
      for (int j = 0; j <= 20; ++j) {
        const Vec2 u{static_cast<float>(i) / 20.001f, static_cast<float>(j) / 20.001f};
        directions.push_back(DVec3{sample_one_light(view.light, view.receiver(), u).direction});
        sum += directions.back();
      }
    }
    z = normalize(sum);
    x = normalize(cross(z, std::fabs(z.x) < 0.5 ? DVec3{1, 0, 0} : DVec3{0, 1, 0}));
    y = cross(z, x);
    for (const DVec3& d : directions) {
      extent = std::max({extent, std::fabs(dot(d, x) / dot(d, z)), std::fabs(dot(d, y) / dot(d, z))});
    }
    extent *= 1.01;
  }
  DVec3 direction(double a, double b) const { return normalize((x * a + y * b) + z); }
};

/// Integrals over all cells. Cells that the light's edge crosses need many points: 40 x 40 leave an error of
/// about 1/40 of the cell's share there, well below its noise.
std::vector<double> cell_integrals(const Grid2D& grid, const Density2D& density) {
  constexpr std::size_t kPoints = 40;
  std::vector<double> result(grid.cells());
  const double du = (grid.u_max - grid.u_min) / static_cast<double>(grid.u_cells * kPoints);
  const double dv = (grid.v_max - grid.v_min) / static_cast<double>(grid.v_cells * kPoints);
  for (std::size_t j = 0; j < grid.v_cells * kPoints; ++j) {
    for (std::size_t i = 0; i < grid.u_cells * kPoints; ++i) {
      const double u = grid.u_min + (static_cast<double>(i) + 0.5) * du;
      const double v = grid.v_min + (static_cast<double>(j) + 0.5) * dv;
      result[j / kPoints * grid.u_cells + i / kPoints] += density(u, v) * du * dv;
    }
  }
  return result;
}

}  // namespace

TEST_CASE("every light shape: sampled directions follow the density, chi-square", "[light]") {
  const double threshold = sidak_threshold(0.001, views().size());
  std::uint64_t stream = 0;
  for (const View& view : views()) {
    Rng rng(41, StreamPurpose::kTest, ++stream);
    // Inside a sphere, and close to one, a tangent plane does not hold the directions: the sphere of
    // directions itself is the grid then.
    const bool wide = solid_angle(view.light, DVec3{view.reference}) > 4;
    const TangentPlane plane(view);
    const double e = plane.extent;
    constexpr std::size_t kSide = 12;
    const Grid2D grid = wide ? direction_grid(16, 12) : Grid2D{-e, e, kSide, -e, e, kSide};
    const auto draw = [&]() -> std::optional<Point2> {
      const LightSample sample = sample_one_light(view.light, view.receiver(), random_pair(rng));
      if (!(sample.pdf_solid_angle > 0)) return std::nullopt;
      const DVec3 d{sample.direction};
      if (wide) return Point2{std::atan2(d.y, d.x), std::min(1.0, std::max(-1.0, d.z))};
      return Point2{dot(d, plane.x) / dot(d, plane.z), dot(d, plane.y) / dot(d, plane.z)};
    };
    const auto density = [&](double a, double b) {
      const double radius = std::sqrt(std::max(0.0, (1 - b) * (1 + b)));
      const DVec3 d = wide ? DVec3{radius * std::cos(a), radius * std::sin(a), b} : plane.direction(a, b);
      const std::optional<DVec3> point = meet_light(view.light, DVec3{view.reference}, d);
      if (!point) return 0.0;
      const double jacobian = wide ? 1.0 : std::pow(1 + a * a + b * b, -1.5);
      return jacobian * one_light_pdf_solid_angle(view.light, view.receiver(), Vec3{*point}, Vec3{d});
    };
    std::vector<double> expected = cell_integrals(grid, density);
    for (double& x : expected) x *= kSamples;
    double total = 0;
    for (const double x : expected) total += x / kSamples;
    INFO(view.name << ", integral of the density " << total);
    // The same edges, whose errors cancel over the light's circumference.
    CHECK(total == Approx(1.0).margin(3e-3));
    std::vector<std::uint64_t> observed(grid.cells(), 0);
    for (std::uint64_t i = 0; i < kSamples; ++i) {
      const auto point = draw();
      const auto cell = point ? grid.cell_of((*point)[0], (*point)[1]) : std::nullopt;
      REQUIRE(cell.has_value());
      ++observed[*cell];
    }
    // A float direction at the very edge may fall into a cell that the quadrature found just empty.
    for (double& x : expected) x = std::max(x, 1e-3);
    const ChiSquareResult result = chi_square_test(observed, expected);
    INFO("chi-square " << result.statistic << ", dof " << result.dof);
    CHECK(result.dof > 10);
    CHECK(result.p_value > threshold);
  }
}

TEST_CASE("every light shape: samples and densities agree with exact geometry", "[light]") {
  std::uint64_t stream = 50;
  for (const View& view : views()) {
    const SingleLight single(view.light);
    Rng rng(42, StreamPurpose::kTest, ++stream);
    std::vector<double> inverse;
    INFO(view.name);
    for (std::uint64_t i = 0; i < kSamples; ++i) {
      const LightSample sample = sample_light<false>(single.table, view.receiver(), 0, random_pair(rng));
      REQUIRE(sample.light == 0);
      REQUIRE(sample.pdf_solid_angle > 0.0f);
      REQUIRE(length(DVec3{sample.direction}) == Approx(1.0).epsilon(4 * 0x1p-24));
      inverse.push_back(1.0 / sample.pdf_solid_angle);
      // The unoffset point by the reference; an edge may be missed by rounding, but hardly ever.
      const DVec3 from{view.reference};
      const DVec3 direction = normalize(DVec3{sample.direction});
      const std::optional<DVec3> point = meet_light(view.light, from, direction);
      if (!point) continue;
      const float pdf =
          light_pdf_solid_angle<false>(single.table, 0, view.receiver(), Vec3{*point}, sample.direction);
      REQUIRE(pdf == Approx(sample.pdf_solid_angle).epsilon(2e-4));
    }
    const double exact = solid_angle(view.light, DVec3{view.reference});
    const Moments mean = moments(inverse);
    // 1/pdf averages to the solid angle; for a cone it is the solid angle each time, to about six roundings.
    CHECK(std::fabs(mean.mean - exact) < 4 * mean.standard_error() + 1e-6 * exact);
  }
}

namespace {

/// Of the point that `u` chooses: bilinear between corners that count by their cosine at the receiver and
/// solid angle, bounded close to the receiver; found here by bisection of the distributions' functions.
double relative_density(const View& view, const Vec2& u) {
  if (view.light.shape != LightShape::kQuad || is_zero(view.normal)) return 1;
  double corner[2][2];
  double sum = 0;
  const double area = view.light.area;
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      const DVec3 to = DVec3{view.light.origin} + DVec3{view.light.edge_u} * static_cast<double>(i) +
                       DVec3{view.light.edge_v} * static_cast<double>(j) - DVec3{view.reference};
      corner[i][j] = std::max(0.0, dot(DVec3{view.normal}, to)) / std::pow(dot(to, to) + area / 16, 2);
      sum += corner[i][j];
    }
  }
  const auto invert = [](double wanted, double at_0, double at_1) {
    double low = 0;
    double high = 1;
    for (int i = 0; i < 60; ++i) {
      const double x = 0.5 * (low + high);
      const bool below = (at_0 * x + 0.5 * (at_1 - at_0) * x * x) / (0.5 * (at_0 + at_1)) < wanted;
      (below ? low : high) = x;
    }
    return low;
  };
  const double y = invert(u.y, corner[0][0] + corner[1][0], corner[0][1] + corner[1][1]);
  const double at_0 = corner[0][0] + y * (corner[0][1] - corner[0][0]);
  const double at_1 = corner[1][0] + y * (corner[1][1] - corner[1][0]);
  const double x = invert(u.x, at_0, at_1);
  return 4 * (at_0 + x * (at_1 - at_0)) / sum;
}

}  // namespace

TEST_CASE("the density of each sample is that of its distance and cosine", "[light]") {
  // Inside polygons: rounding of the point is below 1e-5 of the distance in these views.
  std::uint64_t stream = 80;
  for (const View& view : views()) {
    if (view.light.shape == LightShape::kSphere) continue;
    Rng rng(43, StreamPurpose::kTest, ++stream);
    for (int i = 0; i < 2000; ++i) {
      const Vec2 u{0.01f + 0.98f * rng.next_float(), 0.01f + 0.98f * rng.next_float()};
      const LightSample sample = sample_one_light(view.light, view.receiver(), u);
      const DVec3 d = normalize(DVec3{sample.direction});
      const auto point = meet_light(view.light, DVec3{view.reference}, d);
      REQUIRE(point.has_value());
      const DVec3 u_edge{view.light.edge_u};
      const DVec3 v_edge{view.light.edge_v};
      const DVec3 normal = cross(u_edge, v_edge);
      const double area = length(normal) * (view.light.shape == LightShape::kQuad ? 1.0 : 0.5);
      const DVec3 to = *point - DVec3{view.reference};
      const double expected =
          dot(to, to) / (std::fabs(dot(normalize(normal), d)) * area) * relative_density(view, u);
      INFO(view.name);
      REQUIRE(sample.pdf_solid_angle == Approx(expected).epsilon(2e-5));
      const bool front = dot(normal, d) < 0;
      REQUIRE(is_zero(sample.radiance) == !front);
    }
  }
}

TEST_CASE("irradiance from a quad light is its closed-form form factor", "[light]") {
  // A square of side 2 at height 1 above the receiver's middle: four corners of the classic configuration
  // [Howell82]: F = (2/pi) * 2 * (1/sqrt(2)) * atan(1/sqrt(2)), E = pi L F.
  const SingleLight square(
      make_quad_light(Quad{{-1, -1, 1}, {-1, 1, 1}, {1, 1, 1}, {1, -1, 1}}, Vec3{1, 1, 1}));
  const double corner = 1 / std::sqrt(2.0) * std::atan(1 / std::sqrt(2.0));
  const double closed_form = 4 * corner;
  REQUIRE(polygon_irradiance_factor(square.light, DVec3{0, 0, 0}, DVec3{0, 0, 1}) ==
          Approx(closed_form).epsilon(1e-12));

  std::uint64_t stream = 90;
  for (const View& view : views()) {
    if (view.light.shape == LightShape::kSphere) continue;
    const SingleLight single(view.light);
    Rng rng(44, StreamPurpose::kTest, ++stream);
    // A receiver that looks at the light's middle has all of it above its horizon.
    const DVec3 normal = TangentPlane(view).z;
    std::vector<double> values;
    for (std::uint64_t i = 0; i < kSamples; ++i) {
      const LightSample s = sample_light<false>(single.table, view.receiver(), 0, random_pair(rng));
      values.push_back(s.radiance.x * std::max(0.0, dot(DVec3{s.direction}, normal)) / s.pdf_solid_angle);
    }
    const bool behind = dot(DVec3{view.light.normal}, normal) > 0;
    const double expected = polygon_irradiance_factor(view.light, DVec3{view.reference}, normal);
    const Moments mean = moments(values);
    INFO(view.name);
    CHECK(std::fabs(mean.mean - (behind ? 0.0 : expected)) <= 4 * mean.standard_error() + 1e-6);
  }
}

TEST_CASE("irradiance from a sphere light is pi L sin^2 cos", "[light]") {
  std::uint64_t stream = 110;
  for (const float distance : {1.0001f, 1.01f, 1.5f, 10.0f, 1e4f}) {
    for (const double tilt : {0.0, 0.5}) {
      // The closed form holds while the whole sphere is above the horizon.
      if (std::asin(1.0 / distance) + tilt > kPiDouble / 2) continue;
      const SingleLight single(make_sphere_light(Sphere{{0, 0, distance}, 1}, Vec3{2, 2, 2}));
      Rng rng(45, StreamPurpose::kTest, ++stream);
      const DVec3 normal{std::sin(tilt), 0, std::cos(tilt)};
      std::vector<double> values;
      for (std::uint64_t i = 0; i < kSamples; ++i) {
        const LightSample s = sample_light<false>(single.table, Vec3{0, 0, 0}, 0, random_pair(rng));
        values.push_back(s.radiance.x * std::max(0.0, dot(DVec3{s.direction}, normal)) / s.pdf_solid_angle);
      }
      const double d = distance;
      const double expected = 2 * kPiDouble / (d * d) * std::cos(tilt);
      const Moments mean = moments(values);
      INFO("distance " << distance << ", tilt " << tilt);
      // 1e-6 for about ten roundings.
      CHECK(std::fabs(mean.mean - expected) < 4 * mean.standard_error() + 1e-6 * expected);
    }
  }
}

TEST_CASE("densities of tiny and huge cones keep their digits", "[light]") {
  for (const double sine : {1e-9, 1e-7, 1e-5, 1e-3, 0.1, 0.9, 0.999, 0.99999}) {
    const auto radius = static_cast<float>(sine);
    const Light light = make_sphere_light(Sphere{{0, 0, 1}, radius}, kWhite);
    const LightSample sample = sample_one_light(light, Vec3{0, 0, 0}, Vec2{0.5f, 0.25f});
    const double s2 = static_cast<double>(radius) * radius;
    const double expected = (1 + std::sqrt(1 - s2)) / (2 * kPiDouble * s2);
    // sqrt(1 - s2) is off by half a unit of s2 over twice its own value, 7e-6 at 0.99999.
    CHECK(sample.pdf_solid_angle == Approx(expected).epsilon(1e-6 + 0x1p-24 / std::sqrt(1 - s2)));
  }
  // A light of 1e-8 of the room's area, in every shape.
  const float side = 1e-4f;
  const Light lights[] = {
      make_quad_light(Quad{{0, 0, 1}, {0, side, 1}, {side, side, 1}, {side, 0, 1}}, kWhite),
      make_triangle_light(Triangle{{0, 0, 1}, {0, side, 1}, {side, 0, 1}}, kWhite),
      make_sphere_light(Sphere{{0, 0, 1}, side}, kWhite)};
  const double projected[] = {1e-8, 0.5e-8, kPiDouble * 1e-8};
  for (int i = 0; i < 3; ++i) {
    const LightSample sample = sample_one_light(lights[i], Vec3{0, 0, 0}, Vec2{0.3f, 0.3f});
    // Areas of float sides, and a distance that varies by side^2.
    CHECK(1 / sample.pdf_solid_angle == Approx(projected[i]).epsilon(1e-5));
    CHECK(sample.radiance == kWhite);
  }
}

TEST_CASE("pitfall 14: densities do not change with the scale of the scene", "[light]") {
  // Powers of two are exact, so that even the bits must be equal; 2^20 is about 1e6.
  std::uint64_t stream = 140;
  for (const View& view : views()) {
    for (const float scale : {0x1p-20f, 0x1p20f}) {
      Light scaled = view.light;
      scaled.origin *= scale;
      scaled.edge_u *= scale;
      scaled.edge_v *= scale;
      scaled.radius *= scale;
      scaled.area *= scale * scale;
      scaled.offset_bound *= scale;
      Rng rng(46, StreamPurpose::kTest, ++stream);
      for (int i = 0; i < 200; ++i) {
        const Vec2 u = random_pair(rng);
        const LightSample a = sample_one_light(view.light, view.receiver(), u);
        const LightSample b = sample_one_light(scaled, {view.reference * scale, view.normal}, u);
        INFO(view.name);
        REQUIRE(a.direction == b.direction);
        REQUIRE(a.pdf_solid_angle == b.pdf_solid_angle);
        REQUIRE(a.position * scale == b.position);
      }
    }
  }
}

TEST_CASE("pitfall 21: nothing is emitted from the back or inside, and no reference point gives NaN",
          "[light]") {
  const Light quad = make_quad_light(Quad{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, kWhite);
  const Light triangle = make_triangle_light(Triangle{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, kWhite);
  const Light sphere = make_sphere_light(Sphere{{0, 0, 0}, 1}, kWhite);
  const Light flat = make_quad_light(Quad{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 0, 0}}, kWhite);
  const Light point = make_sphere_light(Sphere{{0, 0, 0}, 0}, kWhite);
  const float denormal = std::numeric_limits<float>::denorm_min();
  const std::vector<Vec3> references = {{0, 0, 0},
                                        {0.5f, 0.5f, 0},
                                        {5, 5, 0},
                                        {-1, 0, 0},
                                        {1, 0, 0},
                                        {0.5f, 0.5f, denormal},
                                        {0.5f, 0.5f, 1e-30f},
                                        {0.5f, 0.5f, -1e-7f},
                                        {0, 0, 1},
                                        {0, 0, 1 + 0x1p-23f},
                                        {0, 0, 1 - 0x1p-24f},
                                        {0.2f, 0.1f, -0.3f},
                                        {1e6f, 0, 1e-6f},
                                        {1e9f, 1e9f, 1e9f}};
  const std::vector<float> edges = {0.0f, denormal, 0x1p-24f, 0.25f, 0.5f, 0.75f, 1.0f - 0x1p-24f};
  const std::vector<Vec3> normals = {{0, 0, 0}, {0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0.6f, -0.8f, 0}};
  std::size_t count = 0;  // five normals and 49 pairs: each pair of numbers meets each of them somewhere
  for (const Light& light : {quad, triangle, sphere, flat, point}) {
    for (const Vec3& reference : references) {
      for (const float u : edges) {
        for (const float v : edges) {
          const Receiver receiver{reference, normals[++count % normals.size()]};
          const LightSample s = sample_one_light(light, receiver, Vec2{u, v});
          INFO("shape " << static_cast<int>(light.shape) << ", reference " << reference.x << " "
                        << reference.y << " " << reference.z << ", u " << u << " " << v);
          REQUIRE(is_finite(s.position));
          REQUIRE(is_finite(s.direction));
          REQUIRE(std::isfinite(s.pdf_solid_angle));
          REQUIRE(s.pdf_solid_angle >= 0.0f);
          const float pdf = one_light_pdf_solid_angle(light, receiver, s.position, s.direction);
          REQUIRE(std::isfinite(pdf));
          REQUIRE(pdf >= 0.0f);
          if (s.pdf_solid_angle == 0.0f) continue;
          const bool inside = light.shape == LightShape::kSphere && length(DVec3{reference}) <= light.radius;
          const bool behind = light.shape != LightShape::kSphere && reference.z <= 0;
          if (inside || behind) REQUIRE(is_zero(s.radiance));
          if (light.shape == LightShape::kQuad && reference.z > 0) REQUIRE(s.radiance == kWhite);
        }
      }
    }
  }
  CHECK(is_zero(emitted_radiance(quad, quad.normal, Vec3{0, 0, 1})));
  CHECK(is_zero(emitted_radiance(quad, quad.normal, Vec3{1, 0, 0})));
  CHECK(emitted_radiance(quad, quad.normal, Vec3{0, 0, -1}) == kWhite);
}

}  // namespace mlt::test
