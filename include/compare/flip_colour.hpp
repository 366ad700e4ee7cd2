// The colour spaces and the colour error of FLIP [Andersson20 section 4.1], one pixel at a time. Linear RGB
// has the primaries of sRGB and is in [0,1]; white is the sum of the primaries, close to D65.
#pragma once

#include <cmath>

#include "math/elementary_double.hpp"
#include "math/vec.hpp"

namespace mlt::flip {

// Linear RGB to XYZ; the fractions follow from the chromaticities of sRGB.
inline constexpr double kToXyz[3][3] = {{10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794},
                                        {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
                                        {1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382}};
inline constexpr double kWhite[3] = {kToXyz[0][0] + kToXyz[0][1] + kToXyz[0][2],
                                     kToXyz[1][0] + kToXyz[1][1] + kToXyz[1][2],
                                     kToXyz[2][0] + kToXyz[2][1] + kToXyz[2][2]};

/// A cofactor of kToXyz: its minor without row `i` and column `j`, with the sign.
constexpr double cofactor(int i, int j) {
  const int r1 = (i + 1) % 3;
  const int r2 = (i + 2) % 3;
  const int c1 = (j + 1) % 3;
  const int c2 = (j + 2) % 3;
  return kToXyz[r1][c1] * kToXyz[r2][c2] - kToXyz[r1][c2] * kToXyz[r2][c1];
}
inline constexpr double kDeterminant =
    kToXyz[0][0] * cofactor(0, 0) + kToXyz[0][1] * cofactor(0, 1) + kToXyz[0][2] * cofactor(0, 2);
inline constexpr double kFromXyz[3][3] = {
    {cofactor(0, 0) / kDeterminant, cofactor(1, 0) / kDeterminant, cofactor(2, 0) / kDeterminant},
    {cofactor(0, 1) / kDeterminant, cofactor(1, 1) / kDeterminant, cofactor(2, 1) / kDeterminant},
    {cofactor(0, 2) / kDeterminant, cofactor(1, 2) / kDeterminant, cofactor(2, 2) / kDeterminant}};

inline DVec3 times(const double (&matrix)[3][3], const DVec3& v) {
  return DVec3{(matrix[0][0] * v.x + matrix[0][1] * v.y) + matrix[0][2] * v.z,
               (matrix[1][0] * v.x + matrix[1][1] * v.y) + matrix[1][2] * v.z,
               (matrix[2][0] * v.x + matrix[2][1] * v.y) + matrix[2][2] * v.z};
}

/// Linear RGB to the opponent space YCxCz, a linear form of CIELAB in which the eye's sensitivity filters.
inline DVec3 to_ycxcz(const DVec3& rgb) {
  const DVec3 xyz = times(kToXyz, rgb);
  const double x = xyz.x / kWhite[0];
  const double y = xyz.y / kWhite[1];
  const double z = xyz.z / kWhite[2];
  return DVec3{116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)};
}

inline DVec3 from_ycxcz(const DVec3& ycxcz) {
  const double y = (ycxcz.x + 16.0) / 116.0;
  const double x = y + ycxcz.y / 500.0;
  const double z = y - ycxcz.z / 200.0;
  return times(kFromXyz, DVec3{x * kWhite[0], y * kWhite[1], z * kWhite[2]});
}

/// Linear RGB to CIELAB.
inline DVec3 to_lab(const DVec3& rgb) {
  const DVec3 xyz = times(kToXyz, rgb);
  const auto lightness = [](double t) {
    constexpr double kDelta = 6.0 / 29;
    return t > kDelta * kDelta * kDelta ? cbrt_d(t) : t / (3 * kDelta * kDelta) + 4.0 / 29;
  };
  const double x = lightness(xyz.x / kWhite[0]);
  const double y = lightness(xyz.y / kWhite[1]);
  const double z = lightness(xyz.z / kWhite[2]);
  return DVec3{116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)};
}

/// CIELAB with its chroma scaled by the lightness, since dark colours look less colourful (Hunt).
inline DVec3 hunt_adjusted(const DVec3& lab) {
  return DVec3{lab.x, 0.01 * lab.x * lab.y, 0.01 * lab.x * lab.z};
}

/// HyAB: city-block distance in lightness, Euclidean distance in chroma.
inline double hyab(const DVec3& a, const DVec3& b) {
  const double da = a.y - b.y;
  const double db = a.z - b.z;
  return std::fabs(a.x - b.x) + std::sqrt(da * da + db * db);
}

inline constexpr double kColourExponent = 0.7;   ///< q_c
inline constexpr double kFeatureExponent = 0.5;  ///< q_f
inline constexpr double kRemapFrom = 0.4;        ///< p_c, a share of the largest error
inline constexpr double kRemapTo = 0.95;         ///< p_t

/// The largest colour error, between green and blue, to the power q_c.
inline double largest_colour_error() {
  const DVec3 green = hunt_adjusted(to_lab(DVec3{0, 1, 0}));
  const DVec3 blue = hunt_adjusted(to_lab(DVec3{0, 0, 1}));
  return pow_d(hyab(green, blue), kColourExponent);
}

/// The distance of two adjusted colours as an error in [0,1]: raised to q_c, then mapped piecewise linearly
/// so that p_c of `largest` becomes p_t. Rounding above 1 is cut off.
inline double colour_error(const DVec3& a, const DVec3& b, double largest) {
  const double power = pow_d(hyab(a, b), kColourExponent);
  const double knee = kRemapFrom * largest;
  if (power < knee) return power * (kRemapTo / knee);
  const double error = kRemapTo + (power - knee) / (largest - knee) * (1 - kRemapTo);
  return error < 1 ? error : 1.0;
}

}  // namespace mlt::flip
