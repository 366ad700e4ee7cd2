#include "light/light_table.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "light_reference.hpp"
#include "support/statistics.hpp"

namespace mlt::test {
namespace {

/// A square light of this side, `radiance` in every channel.
Light square_light(float side, float radiance) {
  return make_quad_light(Quad{{0, 0, 0}, {side, 0, 0}, {side, side, 0}, {0, side, 0}},
                         Vec3{radiance, radiance, radiance});
}

struct Table {
  std::vector<Light> lights;
  std::vector<float> cdf;
  LightTable table;

  explicit Table(std::vector<Light> made) : lights(std::move(made)), cdf(lights.size()) {
    table = build_light_table(lights, cdf);
  }
};

}  // namespace

TEST_CASE("lights carry the area, normal and power of their shapes", "[light]") {
  const Light quad = make_quad_light(Quad{{1, 1, 1}, {3, 1, 1}, {3, 4, 1}, {1, 4, 1}}, Vec3{1, 2, 4});
  CHECK(quad.area == 6.0f);
  CHECK(quad.normal == Vec3(0, 0, 1));
  CHECK(light_power(quad) == Approx(kPiDouble * 6 * (0.2126 + 2 * 0.7152 + 4 * 0.0722)).epsilon(1e-12));
  const Light triangle = make_triangle_light(Triangle{{0, 0, 0}, {0, 3, 0}, {4, 0, 0}}, Vec3{1, 1, 1});
  CHECK(triangle.area == 6.0f);
  CHECK(triangle.normal == Vec3(0, 0, -1));
  const Light sphere = make_sphere_light(Sphere{{0, 0, 5}, 2}, Vec3{1, 1, 1});
  CHECK(sphere.area == Approx(16 * kPiDouble).epsilon(1e-6));
  // Sides of 1e-22 would underflow in a float cross product.
  CHECK(make_quad_light(Quad{{0, 0, 0}, {1e-22f, 0, 0}, {1e-22f, 1e-22f, 0}, {0, 1e-22f, 0}}, Vec3{1, 1, 1})
            .normal == Vec3(0, 0, 1));
}

TEST_CASE("lights are chosen in proportion to power, with exactly their probability", "[light]") {
  const Table t({square_light(1, 1), square_light(2, 1), square_light(1, 10), square_light(0.1f, 3)});
  const double powers[] = {1, 4, 10, 0.03};
  double sum = 0;
  float end = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const float p = t.lights[i].choice_probability;
    // Rounded to a multiple of 2^-24, after 4 * 2^-24 was shared out.
    CHECK(p == Approx(powers[i] / 15.03).margin(4 * 0x1p-24));
    CHECK(p == t.cdf[i] - end);
    end = t.cdf[i];
    sum += p;
  }
  CHECK(sum == 1.0);
  CHECK(end == 1.0f);
  // Each interval holds its first and its last primary sample.
  for (std::uint32_t i = 0; i < 4; ++i) {
    CHECK(choose_light(t.cdf, i == 0 ? 0.0f : t.cdf[i - 1]) == i);
    CHECK(choose_light(t.cdf, t.cdf[i] - 0x1p-24f) == i);
  }
  std::vector<std::uint64_t> observed(4, 0);
  std::vector<double> expected;
  Rng rng(31, StreamPurpose::kTest, 0);
  for (int i = 0; i < 100000; ++i) ++observed[choose_light(t.cdf, rng.next_float())];
  for (const Light& light : t.lights) expected.push_back(1e5 * light.choice_probability);
  CHECK(chi_square_test(observed, expected).p_value > 0.001);
}

TEST_CASE("the sampler's density holds the probability of the choice", "[light]") {
  const Table t(
      {square_light(1, 1), square_light(2, 1), make_sphere_light(Sphere{{5, 5, 0}, 1}, Vec3{1, 1, 1})});
  const Vec3 reference{0.3f, 0.4f, 2};
  Rng rng(32, StreamPurpose::kTest, 0);
  for (int i = 0; i < 1000; ++i) {
    const float u_choice = rng.next_float();
    const Vec2 u = random_pair(rng);
    const LightSample sample = sample_light<true>(t.table, reference, u_choice, u);
    REQUIRE(sample.light == choose_light(t.cdf, u_choice));
    const Light& light = t.lights[sample.light];
    const LightSample alone = sample_one_light(light, reference, u);
    REQUIRE(sample.pdf_solid_angle == alone.pdf_solid_angle * light.choice_probability);
    REQUIRE(sample.position == alone.position);
    // The offset moves the point by 1e-5 at most, which the density of an area at distance 2 follows.
    REQUIRE(light_pdf_solid_angle<true>(t.table, sample.light, reference, sample.position,
                                        sample.direction) == Approx(sample.pdf_solid_angle).epsilon(2e-5));
  }
}

/// Lights of all shapes around a floor, one of them below it and one that faces away.
Table lamps_over_a_floor() {
  Light away = square_light(1, 4);
  away.origin = Vec3{1, 1, 2};
  Light below = square_light(1, 4);
  below.origin = Vec3{0, 0, -3};
  Light ahead = square_light(1, 2);
  ahead.normal = Vec3{0, 0, -1};
  ahead.origin = Vec3{-1, 2, 1.5f};
  const Light triangle = make_triangle_light(Triangle{{2, 0, 1}, {2, 1, 1}, {2.5f, 0, 1.2f}}, Vec3{3, 3, 3});
  return Table({away, make_sphere_light(Sphere{{5, 5, 1}, 1}, Vec3{1, 1, 1}), below, ahead, triangle,
                make_sphere_light(Sphere{{0, 1, 0.5f}, 0.1f}, Vec3{9, 9, 9})});
}

TEST_CASE("weighed lights are chosen as often as the density says, and those in sight more often",
          "[light]") {
  const Table t = lamps_over_a_floor();
  const Receiver floor{Vec3{0.3f, 0.2f, 0}, Vec3{0, 0, 1}};
  std::vector<double> expected(t.lights.size());
  double sum = 0;
  for (std::uint32_t i = 0; i < t.lights.size(); ++i) {
    const float power = t.lights[i].choice_probability;
    const double p = weighed_light_probability<float>(t.table, floor, i, power);
    sum += p;
    expected[i] = 100000 * p;
    INFO("light " << i);
    CHECK(p >= static_cast<double>(kPowerPart * power));
    // From behind or below the horizon nothing arrives: power alone decides.
    if (i == 0 || i == 2) CHECK(p == static_cast<double>(kPowerPart * power));
  }
  // The sum of six roundings.
  CHECK(sum == Approx(1).epsilon(6 * 0x1p-24));
  // Near and bright, 0.02 of the power.
  CHECK(expected[5] > 20000);
  std::vector<std::uint64_t> observed(t.lights.size());
  Rng rng(33, StreamPurpose::kTest, 0);
  for (int i = 0; i < 100000; ++i) {
    const LightSample sample = sample_light<true>(t.table, floor, rng.next_float(), random_pair(rng));
    REQUIRE(sample.light < t.lights.size());
    observed[sample.light] += 1;
    if (!(sample.pdf_solid_angle > 0)) continue;
    // As above, for points that are offset, at distances from 0.5 on.
    REQUIRE(light_pdf_solid_angle<true>(t.table, sample.light, floor, sample.position, sample.direction) ==
            Approx(sample.pdf_solid_angle).epsilon(1e-3));
  }
  CHECK(chi_square_test(observed, expected).p_value > 0.001);
}

TEST_CASE("irradiance from several lights is the sum of theirs, whatever weighs them", "[light]") {
  const Table t = lamps_over_a_floor();
  const Receiver floor{Vec3{0.3f, 0.2f, 0}, Vec3{0, 0, 1}};
  const auto irradiance = [&](auto&& sample) {
    std::vector<double> values;
    for (int i = 0; i < 200000; ++i) {
      const LightSample s = sample();
      const double cosine = std::max(0.0, static_cast<double>(s.direction.z));
      values.push_back(s.pdf_solid_angle > 0 ? s.radiance.x * cosine / s.pdf_solid_angle : 0);
    }
    return moments(values);
  };
  Rng rng(34, StreamPurpose::kTest, 0);
  const Moments weighed =
      irradiance([&] { return sample_light<true>(t.table, floor, rng.next_float(), random_pair(rng)); });
  // Without a normal the choice is by power.
  const Moments by_power = irradiance(
      [&] { return sample_light<true>(t.table, floor.position, rng.next_float(), random_pair(rng)); });
  const double error = std::hypot(weighed.standard_error(), by_power.standard_error());
  CHECK(std::fabs(weighed.mean - by_power.mean) < 4 * error);
  CHECK(weighed.variance < 0.3 * by_power.variance);
}

TEST_CASE("lights without power are never chosen", "[light]") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  // pitfall 21: zero area, zero, infinite and NaN radiance among sound lights, first and last.
  const Table t({square_light(0, 1), square_light(1, 1), square_light(1, 0), square_light(1, nan),
                 square_light(1, inf), square_light(1, 1), square_light(1, 0)});
  for (std::size_t i = 0; i < 7; ++i) {
    const bool sound = i == 1 || i == 5;
    CHECK((t.lights[i].choice_probability > 0) == sound);
  }
  for (std::uint32_t u = 0; u < (1U << 24); u += 4099) {
    const std::uint32_t chosen = choose_light(t.cdf, static_cast<float>(u) * 0x1p-24f);
    REQUIRE((chosen == 1 || chosen == 5));
  }
  CHECK(choose_light(t.cdf, 0.0f) == 1);
  CHECK(choose_light(t.cdf, 1.0f - 0x1p-24f) == 5);

  const Table dark({square_light(0, 1), square_light(1, 0)});
  const LightSample none = sample_light<true>(dark.table, Vec3{0, 0, 1}, 0.5f, Vec2{0.5f, 0.5f});
  CHECK(none.pdf_solid_angle == 0.0f);
  CHECK(none.light == kNoLight);
  CHECK(light_pdf_solid_angle<true>(dark.table, 1, Vec3{0, 0, 1}, Vec3{0, 0, 0}, Vec3{0, 0, -1}) == 0.0f);
  const LightTable empty;
  CHECK(sample_light<false>(empty, Vec3{0, 0, 1}, 0, Vec2{0, 0}).pdf_solid_angle == 0.0f);
  CHECK(sample_light<true>(empty, Vec3{0, 0, 1}, 0, Vec2{0, 0}).pdf_solid_angle == 0.0f);
}

TEST_CASE("the weakest of many lights can still be chosen", "[light]") {
  std::vector<Light> lights(100000, square_light(0.01f, 1));
  lights[12345] = square_light(100, 1e6f);
  lights[777] = square_light(1e-6f, 1e-6f);
  const Table t(std::move(lights));
  double sum = 0;
  for (std::uint32_t i = 0; i < t.lights.size(); ++i) {
    const float p = t.lights[i].choice_probability;
    REQUIRE(p >= 0x1p-24f);
    REQUIRE(choose_light(t.cdf, t.cdf[i] - 0x1p-24f) == i);
    sum += p;
  }
  CHECK(sum == 1.0);
  // All but the 1e5 shares of 2^-24 go by power.
  CHECK(t.lights[12345].choice_probability == Approx(1 - 1e5 * 0x1p-24).epsilon(1e-3));
}

TEST_CASE("a table is a pure function of its lights", "[light]") {
  std::vector<Light> lights;
  Rng rng(33, StreamPurpose::kTest, 0);
  for (int i = 0; i < 1000; ++i) {
    const float side = rng.next_float();
    lights.push_back(square_light(side, rng.next_float()));
  }
  const Table first(lights);
  const Table again(lights);
  CHECK(first.cdf == again.cdf);
  CHECK(first.cdf.back() == 1.0f);
}

}  // namespace mlt::test
