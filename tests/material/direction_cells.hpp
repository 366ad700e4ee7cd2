// Cells of the sphere of directions that follow a lobe, so that a chi-square test and a quadrature see a lobe
// 1e-5 wide as well as a whole hemisphere. A pilot set of samples decides: coordinates around the lobe's mean
// direction for a narrow lobe away from the horizon, azimuth and cosine around the normal otherwise, and a
// rectangle of them cut at medians until each cell holds about the same share. All arithmetic is in double.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "math/vec.hpp"
#include "support/statistics.hpp"

namespace mlt::test {

class DirectionCells {
 public:
  static constexpr int kLevels = 6;
  static constexpr std::size_t kCells = std::size_t{1} << kLevels;
  static constexpr std::size_t kOutside = kCells;  ///< the rest of the sphere

  /// `side` (1 or -1) is the sign of z of the hemisphere that holds the pilot's directions.
  DirectionCells(std::span<const Vec3> pilot, double side) {
    DVec3 sum{0, 0, 0};
    for (const Vec3& w : pilot) sum += DVec3{w};
    const double resultant = length(sum) / static_cast<double>(pilot.size());
    const DVec3 mean = normalize(sum);
    narrow_ = resultant > 0.99 && side * mean.z > 0.25;
    z_ = narrow_ ? mean : DVec3{0, 0, side};
    // Azimuths count from the opposite of the lobe, so that a lobe does not straddle the seam.
    const DVec3 flat{mean.x, mean.y, 0};
    const bool has_azimuth = !narrow_ && length(flat) > 1e-3;
    x_ = has_azimuth ? normalize(flat)
                     : normalize(cross(z_, std::fabs(z_.x) < 0.5 ? DVec3{1, 0, 0} : DVec3{0, 1, 0}));
    y_ = cross(z_, x_);

    std::vector<Point2> points;
    points.reserve(pilot.size());
    for (const Vec3& w : pilot) points.push_back(coordinates(w));
    boxes_.assign(2 * kCells, Box{});
    boxes_[1] = root_box(points, resultant);
    std::erase_if(points, [&](const Point2& p) { return !boxes_[1].contains(p); });
    cut(1, 0, points);
  }

  std::size_t cell_of(const Vec3& w) const {
    const Point2 p = coordinates(w);
    if (!boxes_[1].contains(p)) return kOutside;
    std::size_t node = 1;
    for (int level = 0; level < kLevels; ++level) {
      const int axis = level % 2;
      node = 2 * node + (p[axis] >= boxes_[2 * node].high[axis] ? 1 : 0);
    }
    return node - kCells;
  }

  /// Integrals of `density` (per steradian) over each cell, by adaptive quadrature.
  std::vector<double> integrate(const std::function<double(const Vec3&)>& density) const {
    const Density2D transformed = [&](double a, double b) {
      const DVec3 d = direction(a, b);
      const double jacobian = narrow_ ? std::pow(1.0 + a * a + b * b, -1.5) : 1.0;
      return density(Vec3{d}) * jacobian;
    };
    std::vector<double> result(kCells);
    for (std::size_t cell = 0; cell < kCells; ++cell) {
      const Box& box = boxes_[kCells + cell];
      result[cell] =
          mlt::test::integrate(transformed, box.low[0], box.high[0], box.low[1], box.high[1], 2e-3, 3);
    }
    return result;
  }

 private:
  static constexpr double kPi = 3.141592653589793;
  struct Box {
    Point2 low{0, 0}, high{0, 0};
    bool contains(const Point2& p) const {
      return p[0] >= low[0] && p[0] <= high[0] && p[1] >= low[1] && p[1] <= high[1];
    }
  };

  /// The whole hemisphere for a wide lobe, all but the outermost 2 % on each side of a narrow one: its tails
  /// reach so far that a cell with them would need a quadrature of its own. The horizon stays a border.
  Box root_box(const std::vector<Point2>& points, double resultant) const {
    if (!narrow_ && resultant < 0.9) return Box{{-kPi, 0}, {kPi, 1}};
    Box box;
    for (int axis = 0; axis < 2; ++axis) {
      std::vector<double> values;
      values.reserve(points.size());
      for (const Point2& p : points) values.push_back(p[axis]);
      std::sort(values.begin(), values.end());
      box.low[axis] = values[values.size() / 50];
      box.high[axis] = values[values.size() - 1 - values.size() / 50];
    }
    return box;
  }

  void cut(std::size_t node, int level, std::vector<Point2>& points) {
    if (level == kLevels) return;
    const int axis = level % 2;
    Box low = boxes_[node];
    Box high = boxes_[node];
    double middle = 0.5 * (low.low[axis] + low.high[axis]);
    if (!points.empty()) {
      const auto median = points.begin() + static_cast<std::ptrdiff_t>(points.size() / 2);
      std::nth_element(points.begin(), median, points.end(),
                       [axis](const Point2& a, const Point2& b) { return a[axis] < b[axis]; });
      middle = (*median)[axis];
    }
    low.high[axis] = middle;
    high.low[axis] = middle;
    boxes_[2 * node] = low;
    boxes_[2 * node + 1] = high;
    std::vector<Point2> below, above;
    for (const Point2& p : points) (p[axis] < middle ? below : above).push_back(p);
    cut(2 * node, level + 1, below);
    cut(2 * node + 1, level + 1, above);
  }

  Point2 coordinates(const Vec3& w) const {
    const DVec3 d = normalize(DVec3{w});
    const double x = dot(d, x_);
    const double y = dot(d, y_);
    const double z = dot(d, z_);
    if (!narrow_) return {std::atan2(y, x), z};
    // Gnomonic: the tangent plane at the mean direction. What lies behind it is outside of every cell.
    return z > 0 ? Point2{x / z, y / z} : Point2{HUGE_VAL, HUGE_VAL};
  }

  DVec3 direction(double a, double b) const {
    if (narrow_) return normalize((x_ * a + y_ * b) + z_);
    const double radius = std::sqrt((1.0 - b) * (1.0 + b));
    return (x_ * (radius * std::cos(a)) + y_ * (radius * std::sin(a))) + z_ * b;
  }

  bool narrow_ = false;
  DVec3 x_{1, 0, 0}, y_{0, 1, 0}, z_{0, 0, 1};
  std::vector<Box> boxes_;  ///< a binary heap from index 1; leaves are the last kCells
};

}  // namespace mlt::test
