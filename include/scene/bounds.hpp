// The axis-aligned box around a scene's shapes, in the scene's own coordinates.
#pragma once

#include <cmath>

#include "scene/description.hpp"

namespace mlt {

/// Empty, with low above high, until it includes a point.
struct Bounds {
  DVec3 low{HUGE_VAL, HUGE_VAL, HUGE_VAL};
  DVec3 high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};

  void include(const DVec3& p);
};

/// Of all polygons, spheres and those vertices of meshes that triangles use.
Bounds bounds_of(const SceneDescription& scene);

}  // namespace mlt
