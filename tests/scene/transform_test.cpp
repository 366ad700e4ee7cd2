#include "scene/transform.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace mlt;

namespace {

constexpr double kPi = 3.14159265358979323846;

double distance(const DVec3& a, const DVec3& b) {
  return length(a - b);
}

/// The textbook matrix of a rotation by an angle about an axis, in long double with libm: a reference that
/// shares neither formula nor functions with the tested code.
DVec3 rotated_reference(double degrees, const DVec3& axis, const DVec3& v) {
  const long double angle =
      static_cast<long double>(degrees) * 3.14159265358979323846264338327950288L / 180.0L;
  const long double x = axis.x, y = axis.y, z = axis.z;
  const long double norm = sqrtl(x * x + y * y + z * z);
  // Unit quaternion q = (w, a, b, c); q v q^-1 as a matrix.
  const long double s = sinl(angle / 2) / norm;
  const long double w = cosl(angle / 2), a = x * s, b = y * s, c = z * s;
  const long double m[3][3] = {{1 - 2 * (b * b + c * c), 2 * (a * b - w * c), 2 * (a * c + w * b)},
                               {2 * (a * b + w * c), 1 - 2 * (a * a + c * c), 2 * (b * c - w * a)},
                               {2 * (a * c - w * b), 2 * (b * c + w * a), 1 - 2 * (a * a + b * b)}};
  return DVec3{static_cast<double>(m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z),
               static_cast<double>(m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z),
               static_cast<double>(m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z)};
}

}  // namespace

TEST_CASE("A quarter turn is exact and counter-clockwise") {
  const Affine about_y = rotation(90, DVec3{0, 2, 0});
  CHECK(about_y.apply(DVec3{1, 5, 0}) == DVec3{0, 5, -1});
  CHECK(about_y.apply(DVec3{0, 0, 1}) == DVec3{1, 0, 0});
  const Affine about_z = rotation(-90, DVec3{0, 0, 1});
  CHECK(about_z.apply(DVec3{1, 0, 7}) == DVec3{0, -1, 7});
}

TEST_CASE("Rotations agree with quaternions in long double") {
  const DVec3 axes[] = {{1, 0, 0},      {0, 0, -3},          {1, 1, 1},
                        {-0.3, 2, 0.7}, {1e-200, 2e-200, 0}, {1e200, 1e200, -1e200}};
  const DVec3 v{0.3, -0.8, 0.55};
  for (const DVec3& axis : axes) {
    for (const double degrees : {0.0, 1e-7, 17.0, 45.0, 90.0, 123.456, 180.0, -200.0, 359.0, 3600.0}) {
      CAPTURE(axis.x, axis.y, axis.z, degrees);
      // About 20 roundings of values below 1; the reference scales tiny and huge axes alike.
      const DVec3 unit_scale = axis * (1.0 / std::fabs(axis.x + axis.y + axis.z));
      CHECK(distance(rotation(degrees, axis).apply(v), rotated_reference(degrees, unit_scale, v)) <
            20 * 1.2e-16);
    }
  }
}

TEST_CASE("Transforms are applied in the order in which they are composed") {
  const Affine move = translation(DVec3{1, 2, 3});
  const Affine grow = scaling(DVec3{2, 3, 4});
  CHECK(compose(move, grow).apply(DVec3{1, 1, 1}) == DVec3{4, 9, 16});
  CHECK(compose(grow, move).apply(DVec3{1, 1, 1}) == DVec3{3, 5, 7});
  CHECK(compose(Affine{}, grow).determinant() == 24.0);
  CHECK(scaling(DVec3{-1, 1, 1}).determinant() == -1.0);
}

TEST_CASE("Similarities are told from other transforms, with their factor") {
  const Affine turn = rotation(33, DVec3{1, 2, 3});
  // Rotation entries carry a few roundings.
  CHECK(similarity_scale(compose(scaling(DVec3{2, 2, 2}), turn)) == Approx(2).epsilon(1e-15));
  CHECK(similarity_scale(compose(turn, scaling(DVec3{-3, 3, 3}))) == Approx(3).epsilon(1e-15));
  CHECK(similarity_scale(scaling(DVec3{1e-200, 1e-200, 1e-200})) == 0.0);  // its square underflows
  CHECK(similarity_scale(scaling(DVec3{1, 1, 1.00001})) == 0.0);
  CHECK(similarity_scale(compose(compose(rotation(45, DVec3{0, 0, 1}), scaling(DVec3{1, 2, 1})),
                                 rotation(30, DVec3{0, 0, 1}))) == 0.0);
  // A shear keeps all axes at length 1 but not their angles.
  Affine shear;
  shear.y = DVec3{std::sin(kPi / 6), std::cos(kPi / 6), 0};
  CHECK(similarity_scale(shear) == 0.0);
}
