// The pinhole camera against its closed form, and primary samples against pixels.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>

#include "math/rng.hpp"
#include "support/compiled_scene.hpp"

namespace mlt::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

SceneDescription scene_with(const CameraDescription& camera) {
  SceneDescription scene = parse_scene_text(R"(
camera eye 0 0 5 target 0 0 0
material grey diffuse reflectance 0.5
sphere 0 0 0 1 material grey emit 1
)",
                                            "test");
  scene.camera = camera;
  return scene;
}

/// The direction through (x, y), in pixels from the upper left corner, by the textbook: the image plane at
/// distance 1 is 2 tan(fov/2) high, x grows along forward x up.
DVec3 expected_direction(const CameraDescription& camera, double width, double height, double x, double y) {
  const DVec3 forward = normalize(camera.target - camera.eye);
  const DVec3 right = normalize(cross(forward, camera.up));
  const DVec3 up = cross(right, forward);
  const double tangent = std::tan(camera.vertical_fov_degrees * kPi / 360);
  const double along = (2 * x / width - 1) * tangent * width / height;
  const double upwards = (1 - 2 * y / height) * tangent;
  return normalize((forward + right * along) + up * upwards);
}

CameraDescription tilted(double fov) {
  CameraDescription camera;
  camera.eye = DVec3{3, -2, 7};
  camera.target = DVec3{-1, 0.5, 2};
  camera.up = DVec3{0.2, 1, -0.3};
  camera.vertical_fov_degrees = fov;
  return camera;
}

}  // namespace

TEST_CASE("camera rays go where the field of view, the aspect and the pixel say") {
  struct Film {
    std::uint32_t width, height;
  };
  for (const double fov : {0.01, 10.0, 39.3077, 90.0, 150.0, 179.0}) {
    for (const Film film : {Film{1, 1}, Film{64, 64}, Film{640, 360}, Film{7, 301}}) {
      const CameraDescription description = tilted(fov);
      const CompiledScene scene(scene_with(description), film.width, film.height);
      const Camera& camera = scene.world().camera;
      for (std::uint32_t y = 0; y < film.height; y += 1 + film.height / 5) {
        for (std::uint32_t x = 0; x < film.width; x += 1 + film.width / 5) {
          const DVec3 expected = expected_direction(description, film.width, film.height, x + 0.5, y + 0.5);
          const Vec3 direction = camera.direction({x, y, Vec2{0.5f, 0.5f}});
          // Some ten float roundings of numbers up to the corner vector's length, which for wide views is
          // longer than the direction itself by 1 over the cosine to the corner.
          const double corner = length(DVec3{camera.corner});
          const double allowed = 10 * 0x1p-24 * corner;
          INFO("fov " << fov << " film " << film.width << "x" << film.height << " pixel " << x << " " << y);
          CHECK(length(DVec3{direction} - expected) <= allowed);
          CHECK(std::fabs(length(DVec3{direction}) - 1) <= 4 * 0x1p-24);
        }
      }
    }
  }
}

TEST_CASE("the upper left pixel is up and to the left, and up need not be perpendicular") {
  CameraDescription description;  // at the origin, looking along -z, y up
  description.up = DVec3{0, 1, 0.9};
  const CompiledScene scene(scene_with(description), 4, 4);
  const Vec3 first = scene.world().camera.direction({0, 0, Vec2{0, 0}});
  const Vec3 last = scene.world().camera.direction({3, 3, Vec2{0.9f, 0.9f}});
  CHECK((first.x < 0 && first.y > 0 && first.z < 0));
  CHECK((last.x > 0 && last.y < 0 && last.z < 0));
}

TEST_CASE("primary samples are cut into pixels exactly, with the rest as position in the pixel") {
  Rng rng(5, StreamPurpose::kTest, 0);
  for (const std::uint32_t side : {1U, 2U, 3U, 7U, 64U, 500U, 1920U, 65535U, 65536U}) {
    Camera camera;
    camera.width = camera.height = side;
    for (int i = 0; i < 2000; ++i) {
      const std::uint32_t sample = i == 0 ? 0U : (i == 1 ? 0xffffffffU : rng.next_fixed());
      const FilmPosition film = camera.film_position(sample, ~sample);
      const long double position = static_cast<long double>(sample) / 0x1p32L * side;
      REQUIRE(film.x == static_cast<std::uint32_t>(std::floor(position)));
      REQUIRE(film.x < side);
      REQUIRE(film.y < side);
      REQUIRE((film.offset.x >= 0.0f && film.offset.x < 1.0f));
      // The offset keeps 24 bits, cut off.
      const long double offset = position - std::floor(position);
      REQUIRE(std::fabs(static_cast<long double>(film.offset.x) - offset) < 0x1p-24L);
    }
  }
}

}  // namespace mlt::test
