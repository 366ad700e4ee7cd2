// Shapes and views at the edge of what positions and directions resolve: slivers, layers upon each other,
// cameras that graze a surface, narrow and wide views.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "scenes.hpp"
#include "sweep.hpp"

namespace mlt::test {
namespace {

// ---- slivers ----

/// Where a wall is cut: a bundle of eight slivers, each 2/aspect wide, at a place without a short number.
std::vector<double> cuts(double aspect) {
  std::vector<double> result = {-1};
  for (int i = 0; i <= 8; ++i) result.push_back(0.37 + i * 2 / aspect);
  result.push_back(1);
  return result;
}

/// The wall at axis = side of the room from -1 to 1, its front inside: strips from edge to edge, or a fan of
/// needles from one corner.
std::string sliver_wall(int axis, double side, double aspect, bool needles) {
  std::string vertices, faces;
  int count = 0;
  const auto vertex = [&](double s, double t) {
    double p[3];
    p[axis] = side;
    p[(axis + 1) % 3] = s;
    p[(axis + 2) % 3] = t;
    vertices +=
        "vertex " + exact_text_of(p[0]) + " " + exact_text_of(p[1]) + " " + exact_text_of(p[2]) + "\n";
    return count++;
  };
  const auto face = [&](int a, int b, int c) {
    if (side > 0) std::swap(b, c);
    faces += "face " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + "\n";
  };
  const int apex = vertex(-1, -1);
  int low = apex, high = -1;
  for (const double s : cuts(aspect)) {
    const int next_high = vertex(s, 1);
    const int next_low = needles ? apex : vertex(s, -1);
    if (high >= 0) {
      face(low, next_high, high);
      if (!needles) face(low, next_low, next_high);
    }
    low = next_low;
    high = next_high;
  }
  if (needles) face(apex, vertex(1, -1), high);
  return "inline_mesh material wall emit 1\n" + vertices + faces + "end\n";
}

/// A closed room of slivers, looked at where these are.
std::string sliver_room(double aspect, bool needles) {
  const double width = 16 / aspect;
  const double degrees = std::min(70.0, std::max(0.001, 3 * width * 180 / kPiExact));
  // Strips lie at 0.37 along the wall; needles, half way to their corner, at (0.37 - 1) / 2.
  const double s = needles ? (0.37 - 1) / 2 : 0.37, t = needles ? 0 : 0.1;
  std::string text = "camera eye 0.2 -0.1 0.3 target 1 " + exact_text_of(s) + " " + exact_text_of(t) +
                     " fov " + exact_text_of(degrees) + "\nmaterial wall diffuse reflectance 0.5\n";
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) text += sliver_wall(axis, side, aspect, needles);
  }
  return text;
}

void sweep_sliver_rooms(SweepTable& table, const std::vector<double>& aspects, std::uint64_t samples) {
  for (const double aspect : aspects) {
    for (const bool needles : {false, true}) {
      add_film_means(table, text_of(aspect) + (needles ? " needles" : " strips"),
                     sliver_room(aspect, needles), 4, samples, 8, furnace_radiance(0.5, 8), 1e-6);
    }
  }
}

/// A sliver of a lamp, 2 units long, over the floor; x is where its near edge stands.
Measurement sliver_lamp(double aspect, double x, IntegratorKind kind, std::uint64_t samples,
                        double rounding) {
  const double width = 2 / aspect;
  const double radiance = std::min(1e12, 0.1 / width);
  const std::string near = exact_text_of(x), far = exact_text_of(x + width);
  const std::string lamp = "quad " + near + " 1.5 -1  " + far + " 1.5 -1  " + far + " 1.5 1  " + near +
                           " 1.5 1 material black emit " + exact_text_of(radiance) + "\n";
  const double expected =
      radiance * 0.5 / kPiExact *
      polygon_irradiance({{x, 1.5, -1}, {x + width, 1.5, -1}, {x + width, 1.5, 1}, {x, 1.5, 1}}, {0, 0, 0});
  const RenderRequest request = small_request(kind, 4, scaled_effort(samples), 2);
  const auto replicates = render_replicates(parse_scene_text(floor_point(lamp), "sliver"), request, 16, 100);
  return film_mean(replicates, expected, rounding + kFloorPointRounding);
}

void sweep_sliver_lamps(SweepTable& table, const std::vector<double>& aspects, std::uint64_t samples) {
  for (const double aspect : aspects) {
    for (const IntegratorKind kind : kIntegrators) {
      const std::string name = text_of(aspect) + " " + name_of(kind);
      // The floor is 10 units wide: positions off by 5 * 2^-25, the width by twice that.
      const double rounding = 10 * 0x1p-25 / (2 / aspect);
      const Measurement beside = sliver_lamp(aspect, 0.63, kind, samples, rounding);
      aspect > 1e5 ? table.add_outside(name + " at 0.63", beside) : table.add(name + " at 0.63", beside);
      // Beside the centre of the scene positions resolve their own size.
      table.add(name + " at the centre", sliver_lamp(aspect, 0, kind, samples, 1e-6));
    }
  }
}

constexpr const char* kSliverRoomBasis =
    "a closed room of slivers that emit 1: 1/(1-a), cut at 8 edges; Student's test over 16 seeds";
constexpr const char* kSliverLampBasis =
    "a lamp 2 units long: Lambert's closed form; Student's test over 16 seeds, plus rounding of its width";

// ---- layers ----

/// A lit mesh of `layers` squares in one plane: the first reflects half, all others nothing.
std::string coplanar_layers(std::size_t layers) {
  std::string text =
      "camera eye -4 1.5 0.5 target 0 0 0 fov 20\nmaterial grey diffuse reflectance 0.5\n"
      "material black diffuse reflectance 0\n"
      "quad -1 2 -1  1 2 -1  1 2 1  -1 2 1 material black emit 10\n";
  const char* corners = "vertex -5 0 -5\nvertex -5 0 5\nvertex 5 0 5\nvertex 5 0 -5\n";
  text += std::string("inline_mesh material grey\n") + corners + "face 0 1 2 3\nend\n";
  if (layers == 1) return text;
  text += std::string("inline_mesh material black\n") + corners;
  for (std::size_t i = 1; i < layers; ++i) text += "face 0 1 2 3\n";
  return text + "end\n";
}

void sweep_coplanar(SweepTable& table, const std::vector<std::size_t>& counts) {
  for (const IntegratorKind kind : kIntegrators) {
    RenderRequest request = small_request(kind, 4, 4, 2);
    request.bootstrap = 64;
    const std::string one = render(coplanar_layers(1), request).statistics.film_hash;
    for (const std::size_t count : counts) {
      const RenderResult result = render(coplanar_layers(count), request);
      const bool same = result.statistics.film_hash == one && !result.statistics.black;
      table.add_fact(text_of(static_cast<double>(count)) + " " + name_of(kind),
                     same ? "the film of the first alone, bit for bit" : "another film", same);
    }
  }
}

/// Sixteen layers, the one in front last: it emits 1, the others nothing.
std::string spaced_layers(double spacing, double degrees) {
  const double angle = degrees * kPiExact / 180;
  std::string text = "camera eye " + exact_text_of(2 * std::sin(angle)) + " 0 " +
                     exact_text_of(2 * std::cos(angle)) + " target 0 0 0 fov 5\n" +
                     "material black diffuse reflectance 0\n";
  for (int i = 15; i >= 0; --i) {
    const std::string z = exact_text_of(-i * spacing) + " ";
    text += "quad -1 -1 " + z + " 1 -1 " + z + " 1 1 " + z + " -1 1 " + z + " material black";
    text += i == 0 ? " emit 1\n" : "\n";
  }
  return text;
}

void sweep_spacing(SweepTable& table, const std::vector<double>& spacings) {
  for (const double spacing : spacings) {
    for (const double degrees : {0.0, 60.0, 75.0}) {
      const RenderRequest request = small_request(IntegratorKind::path, 16, 16, 1);
      const RenderResult result = render(spaced_layers(spacing, degrees), request);
      const Measurement share{mean_luminance(result.image.view()), 1, 1e-6,
                              result.statistics.rejected_non_finite()};
      const std::string name = text_of(spacing) + " at " + text_of(degrees) + " deg";
      spacing < 1e-6 ? table.add_outside(name, share) : table.add(name, share);
    }
  }
}

// ---- views ----

/// An object on the plane z = 0 under uniform light, from a unit away at a grazing angle.
std::string grazing_view(double degrees_above, const std::string& object) {
  const double angle = degrees_above * kPiExact / 180;
  return "camera eye " + exact_text_of(std::cos(angle)) + " 0 " + exact_text_of(std::sin(angle)) +
         " target 0 0 0 up 0 0 1 fov 0.002\n" + kUniformLight + object;
}

void sweep_grazing(SweepTable& table, const std::vector<double>& angles, std::uint64_t samples) {
  const struct {
    const char* name;
    const char* text;
    std::uint32_t depth;
  } objects[] = {
      {"diffuse",
       "material m diffuse reflectance 1\nquad -30 -30 0  30 -30 0  30 30 0  -30 30 0 material m\n", 2},
      {"mirror", "material m mirror reflectance 1\nquad -30 -30 0  30 -30 0  30 30 0  -30 30 0 material m\n",
       2},
      {"metal",
       "material m conductor eta 0.001 k 100\nquad -30 -30 0  30 -30 0  30 30 0  -30 30 0 material m\n", 2},
      {"glass", "material m dielectric ior 1.5\nbox -30 -30 -0.05  30 30 0 material m\n", 64},
  };
  for (const double angle : angles) {
    const double cosine = std::sin(angle * kPiExact / 180);
    for (const auto& [name, text, depth] : objects) {
      // White surfaces and mirrors are as bright as the light. The view is 0.002 degrees high: where that is
      // not small against the angle, what metal and glass lose, proportional to the angle, has its mean over
      // the angles in view, at most 0.001 degrees or 2e-5 each.
      double expected = 1, spread = 1e-6;
      // A camera in the plane itself is inside of the glass for half of its view.
      if (angle == 0 && depth > 2) continue;
      if (std::string_view(name) == "metal") {
        expected = reflectance({0.001, 100}, cosine);
        spread = 2e-6;
      } else if (depth > 2) {
        expected = slab_radiance(1.5, cosine, depth);
        spread = 1e-4;
      }
      add_film_means(table, text_of(angle) + " deg " + name, grazing_view(angle, text), 4, samples, depth,
                     expected, spread);
    }
  }
}

/// A lamp that covers 35 % of the view, from three tenths right of its middle on.
void sweep_field_of_view(SweepTable& table, const std::vector<double>& degrees) {
  for (const double fov : degrees) {
    const double half = std::tan(fov / 2 * kPiExact / 180);
    const double reach = std::max(1.0, 3 * half);
    const auto corner = [](double x, double y) { return exact_text_of(x) + " " + exact_text_of(y) + " -1 "; };
    const std::string text = "camera eye 0 0 0 target 0 0 -1 fov " + exact_text_of(fov) +
                             "\nmaterial black diffuse reflectance 0\nquad " + corner(0.3 * half, -reach) +
                             corner(reach, -reach) + corner(reach, reach) + corner(0.3 * half, reach) +
                             "material black emit 1\n";
    // The lamp's edge and the directions are off by up to 2^-24 of the reach, of 1, of what the view spans.
    const double rounding = 2 * 0x1p-24 * reach / (2 * half) / 0.35;
    const RenderRequest request = small_request(IntegratorKind::path, 16, 64, 1);
    table.add(text_of(fov), film_mean(render_replicates(parse_scene_text(text, "view"), request, 16, 100),
                                      0.35, rounding + 1e-6));
  }
}

constexpr const char* kLayersBasis = "against the film hash of the first layer alone: it wins every tie";
constexpr const char* kGrazingBasis =
    "a plane under uniform light: albedo 1, Fresnel's equations; Student's test over 16 seeds";

}  // namespace

TEST_CASE("pitfalls 16 and 20: slivers, layers and grazing views, some points") {
  {
    SweepTable table("rooms of slivers", "aspect", kSliverRoomBasis);
    sweep_sliver_rooms(table, {1e7}, 16);
  }
  {
    SweepTable table("coplanar layers", "layers", kLayersBasis);
    sweep_coplanar(table, {1000});
  }
  {
    SweepTable table("layers in front of each other", "spacing", "only the front one shines");
    sweep_spacing(table, {1e-5});
  }
  SweepTable table("grazing cameras", "above", kGrazingBasis);
  sweep_grazing(table, {1e-4}, 16);
}

TEST_CASE("pitfall 16: rooms of slivers of aspect 30 to 1e7, and beyond", "[.stress]") {
  SweepTable table("rooms of slivers", "aspect", kSliverRoomBasis);
  sweep_sliver_rooms(table, {30, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e11}, 128);
}

TEST_CASE("pitfall 16: slivers as lamps", "[.stress]") {
  SweepTable table("slivers as lamps", "aspect", kSliverLampBasis);
  sweep_sliver_lamps(table, {10, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7}, 512);
}

TEST_CASE("pitfall 20: 1 to 1e6 coplanar layers", "[.stress]") {
  {
    SweepTable table("coplanar layers", "layers", kLayersBasis);
    sweep_coplanar(table, {2, 10, 100, 1000, 10000, 100000, 1000000});
  }
  SweepTable table("layers in front of each other", "spacing", "only the front one shines");
  sweep_spacing(table, {0.01, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9});
}

TEST_CASE("pitfall 16: grazing cameras, narrow and wide views", "[.stress]") {
  {
    SweepTable table("grazing cameras", "above", kGrazingBasis);
    sweep_grazing(table, {10, 1, 0.1, 0.01, 1e-3, 1e-4, 1e-5, 0}, 64);
  }
  SweepTable table("field of view", "degrees", "a lamp that covers 35 % of it; Student's test over 16 seeds");
  sweep_field_of_view(table, {179, 170, 120, 90, 45, 10, 1, 0.1, 0.01, 0.001});
}

}  // namespace mlt::test
