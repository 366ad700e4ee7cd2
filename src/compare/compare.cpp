#include "compare/compare.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/assert.hpp"
#include "math/elementary_double.hpp"
#include "math/srgb.hpp"

namespace mlt {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// What one channel of one pixel adds to the sums behind the metrics.
struct Terms {
  double squared = 0;
  double absolute = 0;
  double relative = 0;
  double symmetric = 0;
  double displayed = 0;  ///< squared difference of the sRGB values

  Terms& operator+=(const Terms& other) {
    squared += other.squared;
    absolute += other.absolute;
    relative += other.relative;
    symmetric += other.symmetric;
    displayed += other.displayed;
    return *this;
  }
};

/// The sRGB value as displayed; too bright ones are clipped by the encoding.
double displayed(double linear, double factor) {
  const double brightened = std::min(linear * factor, 2.0);
  return static_cast<double>(srgb_encode(static_cast<float>(brightened)));
}

Terms channel_terms(double a, double b, double factor) {
  const double difference = a - b;
  const double shown = displayed(a, factor) - displayed(b, factor);
  Terms terms;
  terms.squared = difference * difference;
  terms.absolute = std::fabs(difference);
  terms.relative = terms.squared / (b * b + kRelMseOffset);
  terms.symmetric = terms.absolute / (std::fabs(a) + std::fabs(b) + kSmapeOffset);
  terms.displayed = shown * shown;
  return terms;
}

struct Sums {
  Terms terms;
  double image[3] = {};
  double reference[3] = {};
};

Sums sum_row(const Vec3* image, const Vec3* reference, std::uint32_t width, double factor) {
  Sums sums;
  for (std::uint32_t x = 0; x < width; ++x) {
    for (int channel = 0; channel < 3; ++channel) {
      const double a = image[x][channel];
      const double b = reference[x][channel];
      sums.terms += channel_terms(a, b, factor);
      sums.image[channel] += a;
      sums.reference[channel] += b;
    }
  }
  return sums;
}

double ratio(double image, double reference) {
  if (reference != 0) return image / reference;
  return image == 0 ? 1.0 : kInfinity;
}

double display_factor(const CompareOptions& options) {
  return exp_d(options.exposure * kLn2);
}

void check_sizes(const ImageView& image, const ImageView& reference) {
  MLT_CHECK_OP(image.width, ==, reference.width);
  MLT_CHECK_OP(image.height, ==, reference.height);
  MLT_CHECK_OP(image.pixels.size(), >, 0u);
  MLT_CHECK_OP(image.pixels.size(), ==, reference.pixels.size());
}

void fill_metrics(const Sums& total, double count, ImageComparison& result) {
  MetricValues& metrics = result.metrics;
  metrics[MetricKind::mse] = total.terms.squared / count;
  metrics[MetricKind::rmse] = std::sqrt(metrics[MetricKind::mse]);
  metrics[MetricKind::mae] = total.terms.absolute / count;
  metrics[MetricKind::relmse] = total.terms.relative / count;
  metrics[MetricKind::smape] = total.terms.symmetric / count;
  const double displayed_mse = total.terms.displayed / count;
  metrics[MetricKind::psnr] = displayed_mse > 0 ? -10.0 * (log_d(displayed_mse) / kLn10) : kInfinity;
  metrics[MetricKind::flip] = std::numeric_limits<double>::quiet_NaN();
  double worst = 0;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    result.mean_image[channel] = total.image[channel] * 3 / count;
    result.mean_reference[channel] = total.reference[channel] * 3 / count;
    result.mean_ratio[channel] = ratio(total.image[channel], total.reference[channel]);
    worst = std::max(worst, std::fabs(result.mean_ratio[channel] - 1));
  }
  metrics[MetricKind::mean_error] = worst;
  result.mean_ratio_all = ratio((total.image[0] + total.image[1]) + total.image[2],
                                (total.reference[0] + total.reference[1]) + total.reference[2]);
}

std::string size_text(const ImageView& image) {
  return std::to_string(image.width) + " x " + std::to_string(image.height);
}

double pixel_term(MetricKind kind, const Terms& sum) {
  switch (kind) {
    case MetricKind::mse:
      return sum.squared / 3;
    case MetricKind::rmse:
      return std::sqrt(sum.squared / 3);
    case MetricKind::relmse:
      return sum.relative / 3;
    case MetricKind::smape:
      return sum.symmetric / 3;
    case MetricKind::psnr:
      return sum.displayed / 3;
    case MetricKind::mae:
    case MetricKind::mean_error:
      return sum.absolute / 3;
    case MetricKind::flip:
      break;
  }
  MLT_CHECK(kind != MetricKind::flip);
  return 0;
}

}  // namespace

ImageComparison compare_images(const ImageView& image, const ImageView& reference,
                               const CompareOptions& options) {
  check_sizes(image, reference);
  const double factor = display_factor(options);
  Sums total;
  for (std::uint32_t y = 0; y < image.height; ++y) {
    const std::size_t row = std::size_t{y} * image.width;
    const Sums sums = sum_row(image.pixels.data() + row, reference.pixels.data() + row, image.width, factor);
    total.terms += sums.terms;
    for (int channel = 0; channel < 3; ++channel) {
      total.image[channel] += sums.image[channel];
      total.reference[channel] += sums.reference[channel];
    }
  }
  ImageComparison result;
  fill_metrics(total, 3.0 * static_cast<double>(image.pixels.size()), result);
  if (options.with_flip) {
    result.flip = compute_flip(image, reference, options.flip);
    result.metrics[MetricKind::flip] = result.flip.mean;
  }
  return result;
}

NonFinite find_non_finite(const ImageView& image) {
  NonFinite found;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const Vec3& pixel = image.pixels[i];
    if (is_finite(pixel)) continue;
    const auto x = static_cast<std::uint32_t>(i % image.width);
    const auto y = static_cast<std::uint32_t>(i / image.width);
    if (found.count == 0) {
      found.first_x = found.x_min = found.x_max = x;
      found.first_y = found.y_min = y;
    }
    found.x_min = std::min(found.x_min, x);
    found.x_max = std::max(found.x_max, x);
    found.y_max = y;
    ++found.count;
    const bool nan = std::isnan(pixel.x) || std::isnan(pixel.y) || std::isnan(pixel.z);
    ++(nan ? found.nan : found.infinite);
  }
  return found;
}

std::string NonFinite::to_string(const ImageView& image) const {
  std::string text = std::to_string(count) + " of " + std::to_string(image.pixels.size()) +
                     " pixels are NaN or infinite (NaN " + std::to_string(nan) + ", infinite " +
                     std::to_string(infinite) + "), the first at x " + std::to_string(first_x) + ", y " +
                     std::to_string(first_y) + " from the top left";
  if (count > 1) {
    text += ", all in x " + std::to_string(x_min) + " to " + std::to_string(x_max) + ", y " +
            std::to_string(y_min) + " to " + std::to_string(y_max);
  }
  return text;
}

std::vector<Diagnostic> comparison_faults(const std::string& image_path, const ImageView& image,
                                          const std::string& reference_path, const ImageView& reference) {
  std::vector<Diagnostic> diagnostics;
  if (image.width != reference.width || image.height != reference.height) {
    diagnostics.push_back({image_path, 0, 0,
                           "has " + size_text(image) + " pixels; expected " + size_text(reference) +
                               " as in " + reference_path});
  }
  const auto check_finite = [&diagnostics](const std::string& path, const ImageView& view) {
    const NonFinite found = find_non_finite(view);
    if (found.count > 0) {
      diagnostics.push_back({path, 0, 0, found.to_string(view) + "; expected finite values"});
    }
  };
  check_finite(image_path, image);
  check_finite(reference_path, reference);
  return diagnostics;
}

void require_comparable(const std::string& image_path, const ImageView& image,
                        const std::string& reference_path, const ImageView& reference) {
  std::vector<Diagnostic> diagnostics = comparison_faults(image_path, image, reference_path, reference);
  if (!diagnostics.empty()) throw InputError(std::move(diagnostics));
}

std::vector<float> error_map(MetricKind kind, const ImageView& image, const ImageView& reference,
                             const ImageComparison& comparison, const CompareOptions& options) {
  check_sizes(image, reference);
  if (kind == MetricKind::flip) return comparison.flip.map;
  const double factor = display_factor(options);
  std::vector<float> map;
  map.reserve(image.pixels.size());
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    Terms sum;
    for (int channel = 0; channel < 3; ++channel) {
      sum += channel_terms(image.pixels[i][channel], reference.pixels[i][channel], factor);
    }
    // Large finite values may have a square beyond float.
    const double largest = static_cast<double>(std::numeric_limits<float>::max());
    map.push_back(static_cast<float>(std::min(pixel_term(kind, sum), largest)));
  }
  return map;
}

}  // namespace mlt
