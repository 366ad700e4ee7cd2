#include "scene/transform.hpp"

#include <algorithm>
#include <cmath>

#include "math/elementary.hpp"
#include "scene/limits.hpp"

namespace mlt {

Affine compose(const Affine& first, const Affine& second) {
  return Affine{second.apply_linear(first.x), second.apply_linear(first.y), second.apply_linear(first.z),
                second.apply(first.offset)};
}

Affine translation(const DVec3& offset) {
  Affine result;
  result.offset = offset;
  return result;
}

Affine rotation(double degrees, const DVec3& axis) {
  // Dividing by the largest component first keeps the squares of tiny and huge axes in range.
  const double largest = std::max({std::fabs(axis.x), std::fabs(axis.y), std::fabs(axis.z)});
  const DVec3 unit = normalize(DVec3{axis.x / largest, axis.y / largest, axis.z / largest});
  const DSinCos angle = sincos_degrees(degrees);
  // Rodrigues' formula: v cos + (u x v) sin + u (u.v) (1 - cos), for each axis v.
  const auto rotate = [&](const DVec3& v) {
    return (v * angle.cos + cross(unit, v) * angle.sin) + unit * (dot(unit, v) * (1.0 - angle.cos));
  };
  return Affine{rotate(DVec3{1, 0, 0}), rotate(DVec3{0, 1, 0}), rotate(DVec3{0, 0, 1}), DVec3{0, 0, 0}};
}

Affine scaling(const DVec3& factors) {
  return Affine{DVec3{factors.x, 0, 0}, DVec3{0, factors.y, 0}, DVec3{0, 0, factors.z}, DVec3{0, 0, 0}};
}

double similarity_scale(const Affine& transform) {
  const DVec3 columns[3] = {transform.x, transform.y, transform.z};
  const double scale = length(transform.x);
  if (!(scale > 0) || !std::isfinite(scale)) return 0;
  const double tolerance = kSimilarityTolerance;
  for (int i = 0; i < 3; ++i) {
    const DVec3 unit = columns[i] / scale;
    if (!(std::fabs(length(unit) - 1.0) <= tolerance)) return 0;
    for (int j = 0; j < i; ++j) {
      if (!(std::fabs(dot(unit, columns[j] / scale)) <= tolerance)) return 0;
    }
  }
  return scale;
}

}  // namespace mlt
