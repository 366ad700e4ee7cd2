// FLIP written down once more, as the papers state it and as slowly as that is: two-dimensional filters built
// from their formulas in x and y together, every sum taken over the whole filter, long double, functions of
// the C library, and the published decimal constants of the inverse colour matrix and the white point. Shares
// no code with the product.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "film/image_view.hpp"

namespace mlt::test {

using Real = long double;
using Triple = std::array<Real, 3>;

struct ReferencePicture {
  int width, height;
  std::vector<Triple> pixels;

  const Triple& at(int x, int y) const {
    return pixels[static_cast<std::size_t>(std::clamp(y, 0, height - 1) * width +
                                           std::clamp(x, 0, width - 1))];
  }
};

inline Triple to_xyz(const Triple& c) {
  return {(10135552 * c[0] + 8788810 * c[1] + 4435075 * c[2]) / 24577794,
          (2613072 * c[0] + 8788810 * c[1] + 887015 * c[2]) / 12288897,
          (1425312 * c[0] + 8788810 * c[1] + 70074185 * c[2]) / 73733382};
}
inline constexpr Real kIlluminant[3] = {0.950428545L, 1.0L, 1.088900371L};

inline Triple to_opponent(const Triple& rgb) {
  const Triple xyz = to_xyz(rgb);
  const Real x = xyz[0] / kIlluminant[0], y = xyz[1] / kIlluminant[1], z = xyz[2] / kIlluminant[2];
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}
inline Triple from_opponent(const Triple& c) {
  const Real y = (c[0] + 16) / 116;
  const Triple xyz{(y + c[1] / 500) * kIlluminant[0], y, (y - c[2] / 200) * kIlluminant[2]};
  return {3.241003275L * xyz[0] - 1.537398934L * xyz[1] - 0.498615861L * xyz[2],
          -0.969224334L * xyz[0] + 1.875930071L * xyz[1] + 0.041554224L * xyz[2],
          0.055639423L * xyz[0] - 0.204011202L * xyz[1] + 1.057148933L * xyz[2]};
}
inline Triple adjusted_lab(const Triple& rgb) {
  Triple xyz = to_xyz(rgb);
  for (int i = 0; i < 3; ++i) {
    const Real t = xyz[static_cast<std::size_t>(i)] / kIlluminant[i];
    const Real d = 6.0L / 29;
    xyz[static_cast<std::size_t>(i)] = t > d * d * d ? std::cbrt(t) : t / (3 * d * d) + 4.0L / 29;
  }
  const Real l = 116 * xyz[1] - 16;
  return {l, l / 100 * 500 * (xyz[0] - xyz[1]), l / 100 * 200 * (xyz[1] - xyz[2])};
}
inline Real hyab_distance(const Triple& a, const Triple& b) {
  return std::fabs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

/// A square filter of side 2 r + 1 from a function of x and y in pixels.
struct Filter2D {
  int r;
  std::vector<Real> weights;

  template <class F>
  Filter2D(int radius, F value) : r(radius) {
    for (int y = -r; y <= r; ++y) {
      for (int x = -r; x <= r; ++x) weights.push_back(value(Real(x), Real(y)));
    }
  }
  /// Positive weights to sum 1, negative ones to -1.
  void normalise() {
    Real positive = 0, negative = 0;
    for (const Real w : weights) (w > 0 ? positive : negative) += w;
    for (Real& w : weights) w = w > 0 ? w / positive : (negative < 0 ? w / -negative : 0);
  }
  Real apply(const ReferencePicture& picture, int x, int y, std::size_t channel) const {
    Real sum = 0;
    std::size_t i = 0;
    for (int dy = -r; dy <= r; ++dy) {
      for (int dx = -r; dx <= r; ++dx) sum += weights[i++] * picture.at(x + dx, y + dy)[channel];
    }
    return sum;
  }
};

struct ReferenceFilters {
  std::vector<Filter2D> colour;
  std::vector<Filter2D> features;  ///< edge in x and y, point in x and y
};

inline ReferenceFilters reference_filters(Real ppd) {
  const Real pi = std::acos(-1.0L);
  const Real a1[3] = {1, 1, 34.1L}, b1[3] = {0.0047L, 0.0053L, 0.04L};
  const Real a2[3] = {0, 0, 13.5L}, b2[3] = {1e-5L, 1e-5L, 0.025L};
  ReferenceFilters filters;
  const int r = int(std::ceil(3 * std::sqrt(0.04L / (2 * pi * pi)) * ppd));
  for (int c = 0; c < 3; ++c) {
    Filter2D filter(r, [&](Real x, Real y) {
      const Real d2 = (x * x + y * y) / (ppd * ppd);
      return a1[c] * std::sqrt(pi / b1[c]) * std::exp(-pi * pi * d2 / b1[c]) +
             a2[c] * std::sqrt(pi / b2[c]) * std::exp(-pi * pi * d2 / b2[c]);
    });
    filter.normalise();
    filters.colour.push_back(filter);
  }
  const Real sd = 0.5L * 0.082L * ppd;
  const int rf = int(std::ceil(3 * sd));
  for (int kind = 0; kind < 4; ++kind) {
    Filter2D filter(rf, [&](Real x, Real y) {
      const Real g = std::exp(-(x * x + y * y) / (2 * sd * sd));
      const Real along = kind % 2 == 0 ? x : y;
      return kind < 2 ? -along * g : (along * along / (sd * sd) - 1) * g;
    });
    filter.normalise();
    filters.features.push_back(filter);
  }
  return filters;
}

/// LDR-FLIP of linear RGB in [0,1].
inline std::vector<Real> reference_ldr_flip(const ReferencePicture& a, const ReferencePicture& b, Real ppd) {
  const ReferenceFilters filters = reference_filters(ppd);
  const Real largest = std::pow(hyab_distance(adjusted_lab({0, 1, 0}), adjusted_lab({0, 0, 1})), 0.7L);
  const auto opponent = [](const ReferencePicture& picture) {
    ReferencePicture result{picture.width, picture.height, {}};
    for (const Triple& pixel : picture.pixels) result.pixels.push_back(to_opponent(pixel));
    return result;
  };
  const ReferencePicture views[2] = {opponent(a), opponent(b)};
  std::vector<Real> map;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      Triple lab[2];
      Real edge[2], point[2];
      for (int i = 0; i < 2; ++i) {
        Triple filtered{};
        for (std::size_t c = 0; c < 3; ++c) filtered[c] = filters.colour[c].apply(views[i], x, y, c);
        Triple rgb = from_opponent(filtered);
        for (Real& value : rgb) value = std::clamp(value, Real(0), Real(1));
        lab[i] = adjusted_lab(rgb);
        Real f[4];
        // A derivative of (Y + 16) / 116 is that of Y over 116, since these weights sum to 0.
        for (std::size_t k = 0; k < 4; ++k) f[k] = filters.features[k].apply(views[i], x, y, 0) / 116;
        edge[i] = std::hypot(f[0], f[1]);
        point[i] = std::hypot(f[2], f[3]);
      }
      Real colour = std::pow(hyab_distance(lab[0], lab[1]), 0.7L);
      const Real knee = 0.4L * largest;
      colour = colour < knee ? colour * 0.95L / knee : 0.95L + (colour - knee) / (largest - knee) * 0.05L;
      const Real feature =
          std::sqrt(std::max(std::fabs(edge[0] - edge[1]), std::fabs(point[0] - point[1])) / std::sqrt(2.0L));
      map.push_back(std::pow(colour, 1 - feature));
    }
  }
  return map;
}

inline ReferencePicture reference_view(const ImageView& image, bool tone_map, Real exposure) {
  ReferencePicture result{static_cast<int>(image.width), static_cast<int>(image.height), {}};
  for (const Vec3& pixel : image.pixels) {
    Triple rgb{};
    for (int c = 0; c < 3; ++c) {
      Real v = std::max(Real(pixel[c]), Real(0)) * std::exp2(exposure);
      const Real x = 0.6L * v;
      if (tone_map) v = x * (2.51L * x + 0.03L) / (x * (2.43L * x + 0.59L) + 0.14L);
      rgb[static_cast<std::size_t>(c)] = std::clamp(v, Real(0), Real(1));
    }
    result.pixels.push_back(rgb);
  }
  return result;
}

struct ReferenceHdr {
  std::vector<Real> map;
  Real start, stop;
  int count;
};

/// HDR-FLIP; `reference` must not have half of its pixels black.
inline ReferenceHdr reference_hdr_flip(const ImageView& image, const ImageView& reference, Real ppd) {
  std::vector<Real> luminances;
  for (const Vec3& p : reference.pixels) {
    luminances.push_back(0.2126L * Real(p.x) + 0.7152L * Real(p.y) + 0.0722L * Real(p.z));
  }
  std::sort(luminances.begin(), luminances.end());
  // The tone map reaches 0.85 where 0.6 x (2.51 * 0.6 x + 0.03) = 0.85 (...), solved by bisection.
  Real low = 0, high = 100;
  for (int i = 0; i < 200; ++i) {
    const Real mid = (low + high) / 2, x = 0.6L * mid;
    (x * (2.51L * x + 0.03L) / (x * (2.43L * x + 0.59L) + 0.14L) < 0.85L ? low : high) = mid;
  }
  ReferenceHdr result{
      {}, std::log2(low / luminances.back()), std::log2(low / luminances[luminances.size() / 2]), 0};
  result.count = std::max(2, int(std::ceil(result.stop - result.start)));
  for (int i = 0; i < result.count; ++i) {
    const Real exposure = result.start + i * (result.stop - result.start) / (result.count - 1);
    const std::vector<Real> map = reference_ldr_flip(reference_view(image, true, exposure),
                                                     reference_view(reference, true, exposure), ppd);
    result.map.resize(map.size(), 0);
    for (std::size_t k = 0; k < map.size(); ++k) result.map[k] = std::max(result.map[k], map[k]);
  }
  return result;
}

}  // namespace mlt::test
