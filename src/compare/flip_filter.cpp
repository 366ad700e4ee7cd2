#include "compare/flip_filter.hpp"

#include <algorithm>
#include <cstring>

#include "base/assert.hpp"
#include "compare/flip_colour.hpp"
#include "math/elementary_double.hpp"

namespace mlt::flip {
namespace {

// Constants of the sensitivity filters [Andersson20 table 1]: a sqrt(pi / b) exp(-pi^2 d^2 / b) at d degrees.
constexpr double kBY = 0.0047;
constexpr double kBCx = 0.0053;
constexpr double kACz1 = 34.1;
constexpr double kBCz1 = 0.04;
constexpr double kACz2 = 13.5;
constexpr double kBCz2 = 0.025;
// Width of the edges and points looked for, in degrees.
constexpr double kFeatureWidth = 0.082;
// Pixels of a row that are filtered together, in four vector registers.
constexpr std::size_t kBlock = 8;

std::size_t ceil_to_size(double x) {
  MLT_CHECK(x >= 0 && x < 1e6);
  return static_cast<std::size_t>(std::ceil(x));
}

Weights gaussian(std::size_t radius, double factor, double exponent) {
  Weights weights;
  for (std::size_t i = 0; i <= 2 * radius; ++i) {
    const double x = static_cast<double>(i) - static_cast<double>(radius);
    weights.push_back(factor * exp_d(exponent * (x * x)));
  }
  return weights;
}

double sum(const Weights& weights) {
  double total = 0;
  for (const double weight : weights) total += weight;
  return total;
}

void divide(Weights& weights, double divisor) {
  for (double& weight : weights) weight /= divisor;
}

/// Positive weights are scaled to sum to 1 and negative ones to -1.
void normalise_signed(Weights& weights) {
  double positive = 0;
  double negative = 0;
  for (const double weight : weights) (weight > 0 ? positive : negative) += weight;
  for (double& weight : weights) weight /= weight > 0 ? positive : -negative;
}

/// A register of any x86-64 or Arm; each lane does what plain code would do for its pixel.
using Pair = double __attribute__((vector_size(16)));

Pair load(const double* values) {
  Pair pair;
  std::memcpy(&pair, values, sizeof pair);
  return pair;
}

/// out[x] = sum over i of weights[i] * in[x + i * stride]: a filter along a row with a stride of 1, and along
/// columns with that of the rows.
void convolve(const double* in, std::size_t stride, const Weights& weights, std::size_t width, double* out) {
  for (std::size_t x = 0; x < width; x += kBlock) {
    // Not an array, which compilers keep in memory.
    Pair sum0{}, sum1{}, sum2{}, sum3{};
    static_assert(kBlock == 4 * 2);
    const double* values = in + x;
    for (const double weight : weights) {
      sum0 += weight * load(values);
      sum1 += weight * load(values + 2);
      sum2 += weight * load(values + 4);
      sum3 += weight * load(values + 6);
      values += stride;
    }
    const Pair sums[] = {sum0, sum1, sum2, sum3};
    std::memcpy(out + x, sums, sizeof sums);
  }
}

double clamp_to_unit(double x) {
  if (!(x > 0)) return 0;
  return x < 1 ? x : 1.0;
}

}  // namespace

Filters make_filters(double pixels_per_degree) {
  MLT_CHECK(pixels_per_degree >= kMinPixelsPerDegree && pixels_per_degree <= kMaxPixelsPerDegree);
  Filters filters;
  // Three standard deviations of the widest Gaussian.
  filters.colour_radius =
      ceil_to_size(3 * std::sqrt(kBCz1 / (2 * kPiDouble * kPiDouble)) * pixels_per_degree);
  const double square = kPiDouble * kPiDouble / (pixels_per_degree * pixels_per_degree);
  const std::size_t r = filters.colour_radius;
  filters.y = gaussian(r, 1, -square / kBY);
  filters.cx = gaussian(r, 1, -square / kBCx);
  filters.cz1 = gaussian(r, std::sqrt(kACz1 * std::sqrt(kPiDouble / kBCz1)), -square / kBCz1);
  filters.cz2 = gaussian(r, std::sqrt(kACz2 * std::sqrt(kPiDouble / kBCz2)), -square / kBCz2);
  divide(filters.y, sum(filters.y));
  divide(filters.cx, sum(filters.cx));
  // In two dimensions the weights sum to the squares of the sums in one.
  const double sum1 = sum(filters.cz1);
  const double sum2 = sum(filters.cz2);
  const double root = std::sqrt(sum1 * sum1 + sum2 * sum2);
  divide(filters.cz1, root);
  divide(filters.cz2, root);

  const double deviation = 0.5 * kFeatureWidth * pixels_per_degree;
  filters.feature_radius = ceil_to_size(3 * deviation);
  filters.gauss = gaussian(filters.feature_radius, 1, -1 / (2 * deviation * deviation));
  for (std::size_t i = 0; i < filters.gauss.size(); ++i) {
    const double x = static_cast<double>(i) - static_cast<double>(filters.feature_radius);
    filters.first.push_back(-x * filters.gauss[i]);
    filters.second.push_back((x * x / (deviation * deviation) - 1) * filters.gauss[i]);
  }
  divide(filters.gauss, sum(filters.gauss));
  normalise_signed(filters.first);
  normalise_signed(filters.second);
  filters.radius = std::max(filters.colour_radius, filters.feature_radius);
  return filters;
}

Viewed::Viewed(const ImageView& image, FlipMode mode, double exposure)
    : image_(image), tone_mapped_(mode == FlipMode::hdr), factor_(exp_d(exposure * kLn2)) {}

DVec3 Viewed::pixel(std::size_t x, std::size_t y) const {
  const Vec3& stored = image_.pixels[y * image_.width + x];
  DVec3 result{0, 0, 0};
  for (int channel = 0; channel < 3; ++channel) {
    double value = static_cast<double>(stored[channel]) * factor_;
    if (!(value > 0)) continue;
    if (tone_mapped_) {
      // A fit of the ACES film curve [Narkowicz15] with its exposure of 0.6. Beyond 1e9 it is at its limit,
      // which is above 1.
      value = std::min(value, 1e9);
      const double numerator = (0.36 * 2.51 * value + 0.6 * 0.03) * value;
      value = numerator / ((0.36 * 2.43 * value + 0.6 * 0.59) * value + 0.14);
    }
    result[channel] = clamp_to_unit(value);
  }
  return result;
}

void BandFilter::filter_row(const Viewed& picture, std::size_t y, std::size_t h) {
  const std::size_t radius = filters_.radius;
  const std::size_t width = picture.width();
  for (std::size_t i = 0; i < stride_ + 2 * radius; ++i) {
    const std::size_t x = std::min(i < radius ? 0 : i - radius, width - 1);
    // Only the ends are copies of pixels converted already.
    const bool copy = i > 0 && (i <= radius || i >= radius + width);
    const DVec3 colour =
        copy ? DVec3{padded_[0][i - 1], padded_[1][i - 1], padded_[2][i - 1]} : to_ycxcz(picture.pixel(x, y));
    for (int channel = 0; channel < 3; ++channel) padded_[channel][i] = colour[channel];
    padded_[3][i] = (colour.x + 16.0) / 116.0;
  }
  const std::size_t colour = radius - filters_.colour_radius;
  const std::size_t feature = radius - filters_.feature_radius;
  convolve(padded_[0].data() + colour, 1, filters_.y, width, plane(kY, h));
  convolve(padded_[1].data() + colour, 1, filters_.cx, width, plane(kCx, h));
  convolve(padded_[2].data() + colour, 1, filters_.cz1, width, plane(kCz1, h));
  convolve(padded_[2].data() + colour, 1, filters_.cz2, width, plane(kCz2, h));
  convolve(padded_[3].data() + feature, 1, filters_.gauss, width, plane(kGauss, h));
  convolve(padded_[3].data() + feature, 1, filters_.first, width, plane(kFirst, h));
  convolve(padded_[3].data() + feature, 1, filters_.second, width, plane(kSecond, h));
}

void BandFilter::filter_columns(std::size_t width, std::size_t row, std::size_t at, FilteredRows& result) {
  const std::size_t colour = row + filters_.radius - filters_.colour_radius;
  const std::size_t feature = row + filters_.radius - filters_.feature_radius;
  double* out = columns_.data();
  const auto column = [&](int index, std::size_t from, const Weights& weights) {
    convolve(plane(index, from), stride_, weights, width, out);
    out += stride_;
    return out - stride_;
  };
  const double* y = column(kY, colour, filters_.y);
  const double* cx = column(kCx, colour, filters_.cx);
  const double* cz1 = column(kCz1, colour, filters_.cz1);
  const double* cz2 = column(kCz2, colour, filters_.cz2);
  const double* first_x = column(kFirst, feature, filters_.gauss);
  const double* first_y = column(kGauss, feature, filters_.first);
  const double* second_x = column(kSecond, feature, filters_.gauss);
  const double* second_y = column(kGauss, feature, filters_.second);
  for (std::size_t x = 0; x < width; ++x) {
    DVec3 rgb = from_ycxcz(DVec3{y[x], cx[x], cz1[x] + cz2[x]});
    for (int channel = 0; channel < 3; ++channel) rgb[channel] = clamp_to_unit(rgb[channel]);
    result.colour[at + x] = hunt_adjusted(to_lab(rgb));
    result.edges[at + x] = std::sqrt(first_x[x] * first_x[x] + first_y[x] * first_y[x]);
    result.points[at + x] = std::sqrt(second_x[x] * second_x[x] + second_y[x] * second_y[x]);
  }
}

void BandFilter::filter(const Viewed& picture, std::size_t y0, std::size_t rows, FilteredRows& result) {
  const std::size_t radius = filters_.radius;
  const std::size_t width = picture.width();
  stride_ = (width + kBlock - 1) / kBlock * kBlock;
  for (auto& line : padded_) line.resize(stride_ + 2 * radius);
  for (auto& values : planes_) values.resize(stride_ * (rows + 2 * radius));
  columns_.resize(8 * stride_);
  for (std::size_t h = 0; h < rows + 2 * radius; ++h) {
    const std::size_t y = y0 + h < radius ? 0 : y0 + h - radius;
    filter_row(picture, std::min<std::size_t>(y, picture.height() - 1), h);
  }
  result.colour.resize(rows * width, DVec3{0, 0, 0});
  result.edges.resize(rows * width);
  result.points.resize(rows * width);
  for (std::size_t row = 0; row < rows; ++row) filter_columns(width, row, row * width, result);
}

}  // namespace mlt::flip
