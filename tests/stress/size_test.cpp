// Size and place of a scene must not show: pictures of one scene, scaled and moved, against the one at home.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "scenes.hpp"
#include "sweep.hpp"

namespace mlt::test {
namespace {

constexpr std::uint32_t kDepth = 6;
/// Of the film's energy. Positions differ by half a unit in the last place, 6e-8 of the scene, so that of the
/// 16384 paths of a picture, with some 20 edges in view at each of 6 vertices, one or none passes an edge on
/// its other side; from there on it is another path. This bound is the energy of thirty.
constexpr double kDifferingShare = 2e-3;

constexpr bool kBeyondTheRange = true;

SceneDescription scene_at(const Place& place) {
  return parse_scene_text(room_at(place), "room");
}

struct NamedPlace {
  std::string name;
  Place place;
};

void compare_hashes(SweepTable& table, const std::vector<NamedPlace>& places) {
  for (const IntegratorKind kind : kIntegrators) {
    const RenderRequest request = small_request(kind, 24, 8, kDepth);
    const std::string home = render(scene_at({}), request).statistics.film_hash;
    for (const NamedPlace& named : places) {
      const bool same = render(scene_at(named.place), request).statistics.film_hash == home;
      table.add_fact(named.name + " " + name_of(kind), same ? "the same film, bit for bit" : "another film",
                     same);
    }
  }
}

/// The path tracer's pictures, sample by sample.
void compare_pictures(SweepTable& table, const std::vector<NamedPlace>& places,
                      bool beyond_the_range = false) {
  const RenderRequest path = small_request(IntegratorKind::path, 32, 16, kDepth);
  const RenderResult home = render(scene_at({}), path);
  for (const NamedPlace& named : places) {
    const RenderResult moved = render(scene_at(named.place), path);
    const Measurement share{difference_share(home, moved), 0, kDifferingShare,
                            moved.statistics.rejected_non_finite()};
    const std::string parameter = named.name + " path, differing share";
    beyond_the_range ? table.add_outside(parameter, share) : table.add(parameter, share);
  }
}

/// PSSMLT's pictures of the same seeds. Chains part for good where a decision differs by rounding; until then
/// the pair differs by rounding alone, so that the mean of the differences has little noise.
void compare_chains(SweepTable& table, const std::vector<NamedPlace>& places) {
  const RenderRequest request = small_request(IntegratorKind::pssmlt, 16, scaled_effort(32), kDepth);
  const auto home = render_replicates(scene_at({}), request, 16, 1);
  for (const NamedPlace& named : places) {
    const auto moved = render_replicates(scene_at(named.place), request, 16, 1);
    std::vector<double> ratios;
    for (std::size_t i = 0; i < home.size(); ++i) {
      ratios.push_back(mean_luminance(moved[i].image.view()) / mean_luminance(home[i].image.view()));
    }
    Measurement mean = against_exact(moments(ratios), 1, 1e-6);
    mean.defects = defects_of(moved);
    table.add(named.name + " pssmlt, mean over home's", mean);
  }
}

NamedPlace scaled(double scale) {
  return {text_of(scale), {scale, {0, 0, 0}}};
}

/// `sizes` times the size of the room away. A third in size, so that the coordinates have no trailing zeros
/// for the offset to be added to exactly.
NamedPlace moved(double sizes) {
  return {text_of(sizes), {1 / 3.0, DVec3{1, -0.7, 0.3} * (sizes * kRoomSize * 0.345678901)}};
}

constexpr const char* kPictureBasis =
    "against the scene at home, rendered from the same primary samples: edges seen by rounding alone";
constexpr const char* kHashBasis = "against the film hash of the scene at home";

}  // namespace

TEST_CASE("pitfall 16: scale and place of a scene, some points") {
  {
    SweepTable table("scale by powers of two", "scale", kHashBasis);
    compare_hashes(table, {scaled(0x1p-20), scaled(0x1p20)});
  }
  SweepTable table("scale and translation", "", kPictureBasis);
  compare_pictures(table, {scaled(1e-6), scaled(1e6), moved(1e7)});
}

TEST_CASE("pitfalls 14 and 16: scene scale 1e-6 to 1e6 and beyond", "[.stress]") {
  {
    SweepTable table("scale by powers of two", "scale", kHashBasis);
    std::vector<NamedPlace> places;
    for (const int exponent : {-60, -50, -40, -20, -10, -3, -1, 1, 3, 10, 20, 40, 50, 57}) {
      places.push_back(scaled(std::ldexp(1.0, exponent)));
    }
    compare_hashes(table, places);
  }
  std::vector<NamedPlace> places;
  for (int exponent = -6; exponent <= 6; ++exponent) places.push_back(scaled(std::pow(10.0, exponent)));
  SweepTable table("scale", "scale", kPictureBasis);
  compare_pictures(table, places);
  compare_pictures(table, {scaled(1e-17), scaled(1e-12), scaled(1e12), scaled(1e17)});
  compare_chains(table, {scaled(1e-6), scaled(1e-3), scaled(1e3), scaled(1e6)});
}

TEST_CASE("pitfall 16: translation by 0 to 1e7 times the scene's size and beyond", "[.stress]") {
  {
    SweepTable table("exact translations", "offset", kHashBasis);
    compare_hashes(table, {{"2^10", {1, {0x1p10, 0, 0}}},
                           {"2^21", {1, {-0x1p21, 0x1p20, 0x1p21}}},
                           {"2^25", {1, {0x1p25, -0x1p25, 0x1p25}}},
                           {"2^20 at scale 2^-20", {0x1p-20, {1, -1, 1}}}});
  }
  std::vector<NamedPlace> places = {moved(0)};
  for (int exponent = 0; exponent <= 8; ++exponent) places.push_back(moved(std::pow(10.0, exponent)));
  SweepTable table("translation by multiples of the scene's size", "sizes", kPictureBasis);
  compare_pictures(table, places);
  compare_pictures(table, {{"1e6 at scale 1e-6", {1e-6, DVec3{4, -4, 4}}},
                           {"1e6 at scale 1e6", {1e6, DVec3{0, 4e12, 4e12}}},
                           {"1 at scale 1/3", {1 / 3.0, DVec3{1, 2, 3}}}});
  compare_chains(table, {moved(1e3), moved(1e7)});
  compare_pictures(table, {moved(1e9), moved(1e10), moved(1e11), moved(1e12)}, kBeyondTheRange);
}

TEST_CASE("sizes and places that positions cannot tell end in a message") {
  SweepTable table("outside of the range of sizes and places", "what", "the message");
  add_message(table, "scale 1e19", room_at(scaled(1e19).place), "allowed is in [-1e+18, 1e+18]");
  add_message(table, "scale 1e-40", room_at(scaled(1e-40).place), "degenerate");
  add_message(table, "1e20 sizes away", room_at(moved(1e20).place), "allowed is in [-1e+18, 1e+18]");
  add_message(table, "1e10 sizes away", room_at(moved(1e10).place), "far from the origin");
  add_message(table, "1e7 sizes away", room_at(moved(1e7).place), "");
}

}  // namespace mlt::test
