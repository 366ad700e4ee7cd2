#include "compare/compare.hpp"

#include <limits>
#include <utility>
#include <vector>

#include "base/assert.hpp"
#include "base/error.hpp"

namespace mlt {
namespace {

struct Sums {
  double squared = 0;
  double relative = 0;
  double image = 0;
  double reference = 0;
};

Sums sum_row(const Vec3* image, const Vec3* reference, std::uint32_t width) {
  Sums sums;
  for (std::uint32_t x = 0; x < width; ++x) {
    for (int channel = 0; channel < 3; ++channel) {
      const double a = image[x][channel];
      const double b = reference[x][channel];
      const double squared = (a - b) * (a - b);
      sums.squared += squared;
      sums.relative += squared / (b * b + kRelMseOffset);
      sums.image += a;
      sums.reference += b;
    }
  }
  return sums;
}

void check_finite(const std::string& path, const ImageView& image, std::vector<Diagnostic>& diagnostics) {
  std::uint64_t count = 0;
  std::size_t first = 0;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    if (is_finite(image.pixels[i])) continue;
    if (count == 0) first = i;
    ++count;
  }
  if (count == 0) return;
  diagnostics.push_back(
      {path, 0, 0,
       std::to_string(count) + " of " + std::to_string(image.pixels.size()) +
           " pixels are NaN or infinite, the first at x " + std::to_string(first % image.width) + ", y " +
           std::to_string(first / image.width) + " from the top left; expected finite values"});
}

std::string size_text(const ImageView& image) {
  return std::to_string(image.width) + " x " + std::to_string(image.height);
}

}  // namespace

ImageComparison compare_images(const ImageView& image, const ImageView& reference) {
  MLT_CHECK_OP(image.width, ==, reference.width);
  MLT_CHECK_OP(image.height, ==, reference.height);
  MLT_CHECK_OP(image.pixels.size(), >, 0u);
  MLT_CHECK_OP(image.pixels.size(), ==, reference.pixels.size());
  Sums total;
  for (std::uint32_t y = 0; y < image.height; ++y) {
    const std::size_t row = std::size_t{y} * image.width;
    const Sums sums = sum_row(image.pixels.data() + row, reference.pixels.data() + row, image.width);
    total.squared += sums.squared;
    total.relative += sums.relative;
    total.image += sums.image;
    total.reference += sums.reference;
  }
  const double count = 3.0 * static_cast<double>(image.pixels.size());
  ImageComparison result;
  result.mse = total.squared / count;
  result.rel_mse = total.relative / count;
  result.mean_image = total.image / count;
  result.mean_reference = total.reference / count;
  if (total.reference != 0) {
    result.mean_ratio = total.image / total.reference;
  } else {
    result.mean_ratio = total.image == 0 ? 1.0 : std::numeric_limits<double>::infinity();
  }
  return result;
}

void require_comparable(const std::string& image_path, const ImageView& image,
                        const std::string& reference_path, const ImageView& reference) {
  std::vector<Diagnostic> diagnostics;
  if (image.width != reference.width || image.height != reference.height) {
    diagnostics.push_back({image_path, 0, 0,
                           "has " + size_text(image) + " pixels; expected " + size_text(reference) +
                               " as in " + reference_path});
  }
  check_finite(image_path, image, diagnostics);
  check_finite(reference_path, reference, diagnostics);
  if (!diagnostics.empty()) throw InputError(std::move(diagnostics));
}

}  // namespace mlt
