// Shapes in world space, as the geometry and the lights take them.
#pragma once

#include "math/vec.hpp"

namespace mlt {

/// A parallelogram a, b, c, d in order around it; counter-clockwise seen from the front.
struct Quad {
  Vec3 a{0, 0, 0}, b{0, 0, 0}, c{0, 0, 0}, d{0, 0, 0};
};

/// Counter-clockwise seen from the front.
struct Triangle {
  Vec3 a{0, 0, 0}, b{0, 0, 0}, c{0, 0, 0};
};

/// The front is the outside.
struct Sphere {
  Vec3 center{0, 0, 0};
  float radius = 0;
};

}  // namespace mlt
