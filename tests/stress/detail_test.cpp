// Small things in large scenes, and cameras far from what they see. Positions are rounded to 2^-25 of the
// scene's half size and directions to 2^-24, so what is small or far against these is seen as rounded.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "scenes.hpp"
#include "sweep.hpp"

namespace mlt::test {
namespace {

/// Where the small things stand in a scene from -1 to 1: numbers without an end.
const DVec3 kSpot{0.3712345678, 0.2198765432, -0.5543210987};

std::string text_of(const DVec3& p) {
  return exact_text_of(p.x) + " " + exact_text_of(p.y) + " " + exact_text_of(p.z) + " ";
}

/// A dark scene from -1 to 1 for the small things to stand in.
const char* const kLargeScene =
    "material black diffuse reflectance 0\nmaterial wall diffuse reflectance 0.5\n"
    "box -1 -1 -1 1 1 1 inward material black\n";

/// A lamp of side `size` before the camera, which it covers by a quarter.
std::string small_lamp(double size) {
  const DVec3 low = kSpot - DVec3{0.3, 0.4, 0} * size, high = low + DVec3{1, 1, 0} * size;
  const double degrees = 2 * std::atan(0.5) * 180 / kPiExact;
  return "camera eye " + text_of(kSpot + DVec3{0, 0, 2} * size) + " target " + text_of(kSpot) + "fov " +
         exact_text_of(degrees) + "\n" + kLargeScene + "quad " + text_of(low) +
         text_of(DVec3{high.x, low.y, low.z}) + text_of(high) + text_of(DVec3{low.x, high.y, low.z}) +
         "material black emit 1\n";
}

/// A closed room of this size that emits 1, with the camera in it.
std::string small_room(double size) {
  const DVec3 half = DVec3{0.5, 0.5, 0.5} * size;
  return "camera eye " + text_of(kSpot + DVec3{0.1, -0.05, 0.15} * size) + " target " +
         text_of(kSpot + DVec3{0.5, 0.2, -0.3} * size) + " fov 70\n" + kLargeScene + "box " +
         text_of(kSpot - half) + text_of(kSpot + half) + "inward material wall emit 1\n";
}

/// A lamp of side 1 seen from `distance` sides away, over a quarter of the view.
std::string distant_lamp(double distance) {
  const double degrees = 2 * std::atan(1 / distance) * 180 / kPiExact;
  const DVec3 towards = normalize(DVec3{0.6, -0.5, 0.7});
  const DVec3 right = normalize(cross(DVec3{0, 1, 0}, towards));
  const DVec3 up = cross(towards, right);
  const DVec3 a = right * -0.3 + up * -0.4;
  return "camera eye " + text_of(towards * distance) + "target 0 0 0 fov " + exact_text_of(degrees) +
         "\nmaterial black diffuse reflectance 0\nquad " + text_of(a) + text_of(a + right) +
         text_of(a + right + up) + text_of(a + up) + "material black emit 1\n";
}

void sweep_lamps(SweepTable& table, const std::vector<double>& values, std::string (*scene_of)(double),
                 double expected, double (*rounding)(double), double first_outside, bool outside_above) {
  for (const double value : values) {
    const auto replicates = render_replicates(parse_scene_text(scene_of(value), "detail"),
                                              small_request(IntegratorKind::path, 16, 64, 1), 16, 100);
    const Measurement measured = film_mean(replicates, expected, rounding(value) + 1e-6);
    const bool outside = outside_above ? value >= first_outside : value <= first_outside;
    outside ? table.add_outside(mlt::test::text_of(value), measured)
            : table.add(mlt::test::text_of(value), measured);
  }
}

/// Eye and lamp are off by 2^-25 each, over the lamp's side, for both of its sides and both axes.
double detail_rounding(double size) {
  return 8 * 0x1p-25 / size;
}
/// Directions are off by 2^-24, over the lamp's side from so far; both sides and axes.
double distance_rounding(double distance) {
  return 4 * 0x1p-24 * distance;
}

void sweep_rooms(SweepTable& table, const std::vector<double>& sizes, std::uint64_t samples) {
  for (const double size : sizes) {
    for (const IntegratorKind kind : kIntegrators) {
      const auto replicates = render_replicates(parse_scene_text(small_room(size), "room"),
                                                small_request(kind, 4, scaled_effort(samples), 8), 16, 100);
      // Lamps are sampled 2^-20 in front of their surface: beside that of the room's size.
      const Measurement measured = film_mean(replicates, furnace_radiance(0.5, 8), 4 * 0x1p-20 / size + 1e-6);
      const std::string name = mlt::test::text_of(size) + " " + name_of(kind);
      size < 0.9e-4 ? table.add_outside(name, measured) : table.add(name, measured);
    }
  }
}

constexpr const char* kCoverageBasis =
    "a lamp that covers a quarter of the view; Student's test over 16 seeds, plus rounding";
constexpr const char* kRoomBasis =
    "a closed room that emits 1: 1/(1-a), cut at 8 edges; Student's test over 16 seeds, plus offsets";

}  // namespace

TEST_CASE("pitfall 16: small rooms in large scenes, some points") {
  SweepTable table("rooms in a scene of size 2", "size", kRoomBasis);
  sweep_rooms(table, {1e-4}, 32);
}

TEST_CASE("pitfall 16: details of 0.1 to 1e-7 of the scene, and distant cameras", "[.stress]") {
  {
    SweepTable table("lamps in a scene of size 2", "side", kCoverageBasis);
    sweep_lamps(table, {0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7}, &small_lamp, 0.25, &detail_rounding, 1.1e-5,
                false);
  }
  {
    SweepTable table("rooms in a scene of size 2", "size", kRoomBasis);
    sweep_rooms(table, {0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7}, 512);
  }
  SweepTable table("distant cameras", "sizes away", kCoverageBasis);
  sweep_lamps(table, {2, 10, 100, 1e3, 8e3, 2e4, 1e5}, &distant_lamp, 0.25, &distance_rounding, 1e4, true);
}

TEST_CASE("details that positions cannot tell, and distant cameras, end in a message") {
  SweepTable table("outside of the range of details and distances", "what", "the message");
  add_message(table, "room of 1e-5", small_room(1e-5), "");
  add_message(table, "room of 1e-6", small_room(1e-6), "6 shapes or triangles are smaller than");
  add_message(table, "lamp of 1e-5", small_lamp(1e-5), "");
  add_message(table, "lamp of 1e-6", small_lamp(1e-6), "1 shape or triangle is smaller than");
  add_message(table, "camera 8e3 sizes away", distant_lamp(8e3), "");
  add_message(table, "camera 2e4 sizes away", distant_lamp(2e4), "the camera is as far from the scene");
}

}  // namespace mlt::test
