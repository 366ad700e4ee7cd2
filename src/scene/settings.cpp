// Statements that may stand once: camera, film, depth.
#include <algorithm>
#include <cmath>

#include "scene/limits.hpp"
#include "scene/parser_state.hpp"

namespace mlt {
namespace {

void forbid_second(std::optional<SourceLocation>& first, const StatementCursor& cursor, const char* what) {
  if (first) {
    fail_at(cursor.start(), std::string("a second ") + what + "; the first stands at " + first->file + ":" +
                                std::to_string(first->line) + ", one is allowed");
  }
  first = cursor.start();
}

/// Direction of unit length whatever the argument's size; 0 when the argument is 0.
DVec3 direction_of(const DVec3& v) {
  const double largest = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
  if (!(largest > 0)) return DVec3{0, 0, 0};
  return normalize(DVec3{v.x / largest, v.y / largest, v.z / largest});
}

DVec3 position(StatementCursor& cursor, const char* what) {
  const Range range{-kMaxCoordinate, kMaxCoordinate};
  const double x = cursor.number_in(what, range);
  const double y = cursor.number_in(what, range);
  const double z = cursor.number_in(what, range);
  return DVec3{x, y, z};
}

void check_camera(const CameraDescription& camera) {
  const DVec3 forward = direction_of(camera.target - camera.eye);
  const DVec3 up = direction_of(camera.up);
  if (length(forward) == 0) fail_at(camera.location, "eye and target of the camera are the same point");
  if (length(up) == 0) fail_at(camera.location, "up of the camera has length 0");
  if (!(length(cross(forward, up)) >= kParallelSine)) {
    fail_at(camera.location,
            "up of the camera is parallel to its direction of view; it must point sideways of it");
  }
}

}  // namespace

void parse_camera(ParserState& state, StatementCursor& cursor) {
  forbid_second(state.camera_at, cursor, "camera");
  CameraDescription camera;
  camera.location = cursor.start();
  bool given[std::size(kCameraClauses)] = {};
  while (!cursor.at_end()) {
    const std::size_t index = cursor.keyword(kCameraClauses, "a parameter of camera");
    if (given[index]) fail_at(cursor.last(), std::string(kCameraClauses[index].word) + " is given twice");
    given[index] = true;
    switch (static_cast<CameraClause>(index)) {
      case CameraClause::eye:
        camera.eye = position(cursor, "a coordinate of eye");
        break;
      case CameraClause::target:
        camera.target = position(cursor, "a coordinate of target");
        break;
      case CameraClause::up:
        camera.up = position(cursor, "a coordinate of up");
        break;
      case CameraClause::fov:
        camera.vertical_fov_degrees = cursor.number_in("the field of view", {kMinFovDegrees, kMaxFovDegrees});
        break;
    }
  }
  for (const CameraClause needed : {CameraClause::eye, CameraClause::target}) {
    const auto index = static_cast<std::size_t>(needed);
    if (!given[index]) {
      fail_at(cursor.here(),
              std::string("the camera has no ") + kCameraClauses[index].word +
                  "; the form is: " + kStatements[static_cast<std::size_t>(StatementKind::camera)].form);
    }
  }
  check_camera(camera);
  state.scene.camera = camera;
}

void parse_film(ParserState& state, StatementCursor& cursor) {
  forbid_second(state.film_at, cursor, "film");
  state.scene.film_width =
      static_cast<std::uint32_t>(cursor.integer_in("the film's width", 1, kMaxFilmSidePixels));
  state.scene.film_height =
      static_cast<std::uint32_t>(cursor.integer_in("the film's height", 1, kMaxFilmSidePixels));
  cursor.expect_end();
}

void parse_depth(ParserState& state, StatementCursor& cursor) {
  forbid_second(state.depth_at, cursor, "depth");
  state.scene.depth = static_cast<std::uint32_t>(cursor.integer_in("the depth", 1, kMaxPathEdges));
  cursor.expect_end();
}

}  // namespace mlt
