// The filters of FLIP: the eye's contrast sensitivity in YCxCz [Andersson20 section 4.1.1], and detectors of
// edges and points, the first and second derivatives of a Gaussian [section 4.2]. All are products of
// functions of x and of y, or sums of two such products (Cz), so rows and columns are filtered one after the
// other.
#pragma once

#include <cstdint>
#include <vector>

#include "compare/flip.hpp"
#include "math/vec.hpp"

namespace mlt::flip {

/// Weights from -radius to radius.
using Weights = std::vector<double>;

struct Filters {
  Weights y, cx, cz1, cz2;        ///< one dimension of the sensitivity filters; Cz is cz1 x cz1 + cz2 x cz2
  Weights gauss, first, second;   ///< of the detectors
  std::size_t colour_radius = 0;  ///< pixels
  std::size_t feature_radius = 0;
  std::size_t radius = 0;  ///< the larger one
};

/// `pixels_per_degree` in [kMinPixelsPerDegree, kMaxPixelsPerDegree].
Filters make_filters(double pixels_per_degree);

/// A picture as FLIP looks at it: linear RGB in [0,1], after exposure and, for HDR, tone mapping.
class Viewed {
 public:
  Viewed(const ImageView& image, FlipMode mode, double exposure);

  std::uint32_t width() const { return image_.width; }
  std::uint32_t height() const { return image_.height; }
  DVec3 pixel(std::size_t x, std::size_t y) const;

 private:
  ImageView image_;
  bool tone_mapped_;
  double factor_;
};

/// What the eye keeps of some rows of a picture.
struct FilteredRows {
  std::vector<DVec3> colour;   ///< CIELAB, Hunt-adjusted, of the filtered colour
  std::vector<double> edges;   ///< magnitude of the first derivatives of the lightness, which is in [0,1]
  std::vector<double> points;  ///< of the second derivatives
};

/// Filters rows y0 to y0 + rows - 1; beyond its borders the picture repeats its outermost pixels. Keeps its
/// buffers from call to call.
class BandFilter {
 public:
  explicit BandFilter(const Filters& filters) : filters_(filters) {}
  void filter(const Viewed& picture, std::size_t y0, std::size_t rows, FilteredRows& result);

 private:
  /// The planes that filtering along x leaves.
  enum Plane { kY, kCx, kCz1, kCz2, kGauss, kFirst, kSecond, kPlanes };

  void filter_row(const Viewed& picture, std::size_t y, std::size_t h);
  void filter_columns(std::size_t width, std::size_t row, std::size_t at, FilteredRows& result);
  double* plane(int index, std::size_t h) {
    return planes_[static_cast<std::size_t>(index)].data() + h * stride_;
  }

  const Filters& filters_;
  std::size_t stride_ = 0;  ///< width rounded up to whole blocks
  std::vector<double> padded_[4];
  std::vector<double> planes_[kPlanes];
  std::vector<double> columns_;
};

}  // namespace mlt::flip
