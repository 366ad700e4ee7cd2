// Films of a single pixel, row or column, up to the largest side, and pictures of more contrast than a float
// has digits, against the closed form of the lit floor.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "scenes.hpp"
#include "sweep.hpp"

namespace mlt::test {
namespace {

constexpr const char* kFloorBasis =
    "a lit floor: integrals of Lambert's closed form; Student's test over 16 seeds, plus rounding";

/// The whole of a film that shows the floor's full width or height, and its brightest or lowest quarter.
void sweep_film(SweepTable& table, std::uint32_t width, std::uint32_t height, std::uint64_t samples) {
  const double side = std::max(width, height);
  // The view is as high as the film; a row of pixels needs a lower one to be as wide as the floor.
  const double half = std::tan(kLitFloorFov / 2 * kPiExact / 180) * height / side;
  const SceneDescription scene =
      parse_scene_text(lit_floor("10", 2 * std::atan(half) * 180 / kPiExact), "film");
  const double u = 0.5 * width / side, v = 0.5 * height / side;
  // Directions are rounded to 2^-24, against a view of 2 * half; twice that over its gradient, at most 4 a
  // view's width of the mean.
  const double slack = 2e-6 + (width > height ? 0.0 : 4 * 0x1p-23 / (2 * half));
  for (const IntegratorKind kind : kIntegrators) {
    RenderRequest request = small_request(kind, 1, scaled_effort(samples), 2);
    request.width = width;
    request.height = height;
    const std::uint64_t mutations = std::uint64_t{width} * height * *request.samples_per_pixel;
    request.chains =
        static_cast<std::uint32_t>(std::max<std::uint64_t>(1, std::min<std::uint64_t>(64, mutations / 64)));
    request.bootstrap = 4096;
    const auto replicates = render_replicates(scene, request, 16, 100);
    const std::string name = std::to_string(width) + "x" + std::to_string(height) + " " + name_of(kind);
    table.add(name + ", film",
              film_mean(replicates, lit_floor_radiance(0.5 - u, 0.5 - v, 0.5 + u, 0.5 + v), slack));
    if (side < 4) continue;
    const std::uint32_t x0 = width > height ? width - width / 4 : 0;
    const std::uint32_t y0 = width > height ? 0 : height - height / 4;
    const Moments quarter = moments_of(
        replicates, [&](const ImageView& image) { return mean_luminance(image, x0, y0, width, height); });
    table.add(name + ", last quarter",
              against_exact(quarter,
                            lit_floor_radiance(0.5 - u + 2 * u * x0 / width, 0.5 - v + 2 * v * y0 / height,
                                               0.5 + u, 0.5 + v),
                            slack));
  }
}

/// The left half of the divided floor is `ratio` times darker than the right one.
void sweep_contrast(SweepTable& table, double ratio, std::uint64_t samples, bool outside = false) {
  const SceneDescription scene = parse_scene_text(divided_floor(ratio), "contrast");
  for (const IntegratorKind kind : kIntegrators) {
    const auto replicates =
        render_replicates(scene, small_request(kind, 8, scaled_effort(samples), 2), 16, 100);
    const double bright = lit_floor_radiance(0.5, 0, 1, 1);
    for (const bool left : {true, false}) {
      const Moments half = moments_of(replicates, [left](const ImageView& image) {
        return left ? mean_luminance(image, 0, 0, 4, 8) : mean_luminance(image, 4, 0, 8, 8);
      });
      const std::string name =
          text_of(ratio) + " " + name_of(kind) + (left ? ", dark half" : ", bright half");
      const Measurement measured = against_exact(half, left ? bright / ratio : bright, 2e-6);
      outside ? table.add_outside(name, measured) : table.add(name, measured);
    }
  }
}

}  // namespace

TEST_CASE("films of one pixel, row or column, and high contrast, some points") {
  {
    SweepTable table("films", "pixels", kFloorBasis);
    sweep_film(table, 1, 1, 256);
    sweep_film(table, 1, 37, 16);
    sweep_film(table, 37, 1, 16);
  }
  SweepTable table("contrast", "ratio", kFloorBasis);
  sweep_contrast(table, 1e6, 32);
}

TEST_CASE("films of 1x1 and 1xN pixels up to the largest side", "[.stress]") {
  SweepTable table("films", "pixels", kFloorBasis);
  sweep_film(table, 1, 1, 16384);
  for (const std::uint32_t side : {2U, 7U, 64U, 1000U}) {
    sweep_film(table, 1, side, 16384 / side);
    sweep_film(table, side, 1, 16384 / side);
  }
  sweep_film(table, 1, 65536, 2);
  sweep_film(table, 65536, 1, 2);
}

TEST_CASE("pitfalls 9 and 14: contrast of 1 to 1e12 within a picture, and beyond", "[.stress]") {
  SweepTable table("contrast", "ratio", kFloorBasis);
  for (const double ratio : {1.0, 1e2, 1e4, 1e6, 1e8, 1e10, 1e12}) sweep_contrast(table, ratio, 512);
  for (const double ratio : {1e13, 1e14, 1e16}) sweep_contrast(table, ratio, 512, true);
}

TEST_CASE("films and jobs out of their ranges end in a message") {
  SweepTable table("outside of the range of films and jobs", "what", "the message");
  add_message(table, "film 0 1", "film 0 1\n" + lit_floor(), "1 to 65536");
  add_message(table, "film 65537 1", "film 65537 1\n" + lit_floor(), "1 to 65536");
  add_message(table, "fov 0.0009", lit_floor("10", 0.0009), "[0.001, 179]");
  const SceneDescription scene = parse_scene_text(lit_floor(), "floor");
  const auto job = [&](const char* what, const RenderRequest& request, const std::string& wanted) {
    std::string message = "(no message)";
    try {
      resolve_job(request, scene);
    } catch (const std::exception& error) {
      message = error.what();
    }
    message = message.substr(0, message.find('\n'));
    table.add_fact(what, message, message.find(wanted) != std::string::npos);
  };
  RenderRequest request = small_request(IntegratorKind::pssmlt, 8, 16, 2);
  request.chains = 1025;
  job("1025 chains of 1024 mutations", request, "at most one chain a mutation, 1024");
  request.chains = 0;
  job("no chain", request, "--chains");
  request = small_request(IntegratorKind::pssmlt, 8, 16, 2);
  request.large_step = 1.5f;
  job("--large-step 1.5", request, "0 to 1");
  request = small_request(IntegratorKind::pssmlt, 8, 16, 2);
  request.samples_per_pixel = (std::uint64_t{1} << 25) + 1;
  job("2^31 + 64 mutations", request, "fixed point has room for 2147483648");
}

}  // namespace mlt::test
