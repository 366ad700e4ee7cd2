// Affine transforms of a statement, in double: columns of the linear part and an offset. They are composed in
// the order in which they are written: the first one written meets the shape first.
#pragma once

#include "math/vec.hpp"

namespace mlt {

struct Affine {
  DVec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};  ///< images of the axes
  DVec3 offset{0, 0, 0};

  DVec3 apply_linear(const DVec3& v) const { return (x * v.x + y * v.y) + z * v.z; }
  DVec3 apply(const DVec3& point) const { return apply_linear(point) + offset; }
  double determinant() const { return dot(cross(x, y), z); }
};

/// `first`, then `second`.
Affine compose(const Affine& first, const Affine& second);

Affine translation(const DVec3& offset);

/// Counter-clockwise by `degrees` for one who looks against `axis`; the axis must not have length 0.
Affine rotation(double degrees, const DVec3& axis);

Affine scaling(const DVec3& factors);

/// The common factor s > 0 when the linear part is s times a rotation or reflection, within
/// kSimilarityTolerance; 0 otherwise.
double similarity_scale(const Affine& transform);

}  // namespace mlt
