// Brightness and size of lights, against Lambert's closed forms.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "scenes.hpp"
#include "sweep.hpp"

namespace mlt::test {
namespace {

/// Samples a pixel.
constexpr std::uint64_t kFew = 32;
constexpr std::uint64_t kMany = 512;

constexpr const char* kIrradianceBasis =
    "a floor of albedo 0.5: Lambert's closed form; Student's test over 16 seeds, plus rounding";

void sweep_emission(SweepTable& table, double emission, std::uint64_t samples) {
  const double expected = lit_floor_radiance() / 10 * emission;
  // Roundings of a channel's few factors.
  add_film_means(table, text_of(emission), lit_floor(exact_text_of(emission)), 8, samples, 2, expected, 1e-6);
}

/// A closed room of 2 units, with a lamp of a given share of a wall's area below its ceiling: its emission
/// keeps the floor equally bright. Walls reflect nothing, so that the floor's light is the lamp's.
struct Lamp {
  std::string text;
  double irradiance = 0;
};

std::string emission_of(double radiance) {
  return " material black emit " + exact_text_of(radiance) + "\n";
}

Lamp quad_lamp(double share) {
  const double side = 2 * std::sqrt(share);
  const double x0 = 0.3, x1 = 0.3 + side, y = 1.9, z0 = -0.2, z1 = -0.2 + side;
  const double radiance = 0.01 / (side * side);
  const auto corner = [y](double x, double z) {
    return exact_text_of(x) + " " + exact_text_of(y) + " " + exact_text_of(z) + "  ";
  };
  const std::string text =
      "quad " + corner(x0, z0) + corner(x1, z0) + corner(x1, z1) + corner(x0, z1) + emission_of(radiance);
  return {text,
          radiance * polygon_irradiance({{x0, y, z0}, {x1, y, z0}, {x1, y, z1}, {x0, y, z1}}, {0, 0, 0})};
}

Lamp triangle_lamp(double share) {
  const double side = 2 * std::sqrt(2 * share);
  const double x0 = 0.05, y = 1.9, z0 = -0.2;
  const double radiance = 0.02 / (side * side);
  const std::string text = "triangle " + exact_text_of(x0) + " 1.9 -0.2  " + exact_text_of(x0 + side) +
                           " 1.9 -0.2  " + exact_text_of(x0) + " 1.9 " + exact_text_of(z0 + side) +
                           emission_of(radiance);
  return {text,
          radiance * polygon_irradiance({{x0, y, z0}, {x0 + side, y, z0}, {x0, y, z0 + side}}, {0, 0, 0})};
}

Lamp sphere_lamp(double share) {
  const double radius = std::sqrt(4 * share / kPiExact);
  const double radiance = 0.01 / (kPiExact * radius * radius);
  const std::string text = "sphere 0.3 1.4 -0.2 " + exact_text_of(radius) + emission_of(radiance);
  return {text, radiance * sphere_irradiance({0.3, 1.4, -0.2}, radius, {0, 0, 0})};
}

std::string lamp_room(const std::string& lamp) {
  return "camera eye -0.9 1.2 0.5 target 0 0 0 fov 0.004\nmaterial grey diffuse reflectance 0.5\n"
         "material black diffuse reflectance 0\nquad -1 0 -1  -1 0 1  1 0 1  1 0 -1 material grey\n"
         "box -1 0 -1  1 2 1 inward material black\n" +
         lamp;
}

/// Corners are off by up to 2^-25 of the scene's half size, 1 here, so that a side is off by twice that, and
/// an area by the sum over both sides.
double corner_rounding(double side) {
  return 4 * 0x1p-25 / side;
}

void sweep_area(SweepTable& table, double share, std::uint64_t samples, bool outside = false) {
  const double side = 2 * std::sqrt(share);
  const struct {
    const char* name;
    Lamp lamp;
    double slack;
  } lamps[] = {{"quad", quad_lamp(share), corner_rounding(side)},
               {"triangle", triangle_lamp(share), corner_rounding(side)},
               {"sphere", sphere_lamp(share), 0}};
  for (const auto& [name, lamp, slack] : lamps) {
    const double expected = lamp.irradiance * 0.5 / kPiExact;
    const SceneDescription scene = parse_scene_text(lamp_room(lamp.text), "lamp");
    for (const IntegratorKind kind : kIntegrators) {
      const RenderRequest request = small_request(kind, 4, scaled_effort(samples), 2);
      const auto replicates = render_replicates(scene, request, 16, 100);
      const Measurement mean = film_mean(replicates, expected, slack + 2 * kFloorPointRounding);
      const std::string parameter = text_of(share) + " " + name + " " + name_of(kind);
      outside ? table.add_outside(parameter, mean) : table.add(parameter, mean);
    }
  }
}

}  // namespace

TEST_CASE("pitfall 14: emission and light area, some points") {
  {
    SweepTable table("emission", "W/(m^2 sr)", kIrradianceBasis);
    for (const double emission : {1e-12, 1e12}) sweep_emission(table, emission, kFew);
  }
  SweepTable table("light area", "of a wall", kIrradianceBasis);
  sweep_area(table, 1e-8, kFew);
}

TEST_CASE("pitfall 14: emission 1e-12 to 1e12", "[.stress]") {
  SweepTable table("emission", "W/(m^2 sr)", kIrradianceBasis);
  for (int exponent = -18; exponent <= 12; exponent += exponent < -12 ? 3 : 2) {
    sweep_emission(table, std::pow(10.0, exponent), kMany);
  }
}

TEST_CASE("pitfall 14: light area down to 1e-8 of the room", "[.stress]") {
  SweepTable table("light area", "of a wall", kIrradianceBasis);
  for (int exponent = -1; exponent >= -10; --exponent) sweep_area(table, std::pow(10.0, exponent), kMany);
  for (const double share : {1e-12, 1e-13, 1e-14}) sweep_area(table, share, kMany, true);
}

TEST_CASE("emission and lights that numbers cannot tell end in a message") {
  SweepTable table("outside of the range of lights", "what", "the message");
  add_message(table, "emission 1e13", lit_floor("1e13"), "allowed is in [0, 1e+12]");
  add_message(table, "emission -1", lit_floor("-1"), "allowed is in [0, 1e+12]");
  add_message(table, "emission 1e-18", lit_floor("1e-18"), "");
  add_message(table, "emission 1e-20", lit_floor("1e-20"), "PSSMLT takes paths dimmer than 8e-31 for black");
  add_message(table, "emission 1e-300", lit_floor("1e-300"), "may be lost");
  add_message(table, "emission 0", lit_floor("0"), "the shape is no light");
  add_message(table, "emission inf", lit_floor("inf"), "number");
  add_message(table, "light area 1e-10", lamp_room(quad_lamp(1e-10).text), "");
  add_message(table, "light area 1e-12", lamp_room(quad_lamp(1e-12).text), "the light is narrower than");
  add_message(table, "light area 1e-14", lamp_room(quad_lamp(1e-14).text), "the light is narrower than");
  add_message(table, "light area 1e-14", lamp_room(triangle_lamp(1e-14).text), "the light is narrower than");
}

}  // namespace mlt::test
