#include "converge/reference.hpp"

#include <sys/stat.h>

#include <cmath>

#include "base/error.hpp"
#include "compare/compare.hpp"
#include "image/image_io.hpp"

namespace mlt {
namespace {

void add_variance(Reference& reference, const ImageBuffer& variance) {
  double relative = 0;
  double of_sum = 0;
  for (std::size_t i = 0; i < variance.pixels.size(); ++i) {
    double deviation = 0;
    for (int channel = 0; channel < 3; ++channel) {
      const double value = variance.pixels[i][channel];
      const double radiance = reference.image.pixels[i][channel];
      if (!(value >= 0)) {
        throw InputError(Diagnostic{reference.variance_path, 0, 0,
                                    "holds the negative variance " + std::to_string(value) +
                                        "; expected the variance of each pixel of " + reference.path});
      }
      relative += value / (radiance * radiance + kRelMseOffset);
      deviation += std::sqrt(value);
    }
    of_sum += deviation * deviation;
  }
  const double count = 3.0 * static_cast<double>(variance.pixels.size());
  reference.own_rel_mse = relative / count;
  reference.mean_standard_error = std::sqrt(of_sum) / count;
}

}  // namespace

double mean_of_image(const ImageView& image) {
  double sum = 0;
  for (const Vec3& pixel : image.pixels) {
    for (int channel = 0; channel < 3; ++channel) sum += static_cast<double>(pixel[channel]);
  }
  return sum / (3.0 * static_cast<double>(image.pixels.size()));
}

std::string variance_path_of(const std::string& path) {
  const std::size_t name = path.rfind('/') == std::string::npos ? 0 : path.rfind('/') + 1;
  const std::size_t dot = path.rfind('.');
  const std::size_t end = dot == std::string::npos || dot <= name ? path.size() : dot;
  return path.substr(0, end) + ".variance.pfm";
}

Reference read_reference(const std::string& path) {
  Reference reference;
  reference.path = path;
  reference.image = read_pfm(path).image;
  const ImageView image = reference.image.view();
  require_comparable(path, image, path, image);
  reference.mean = mean_of_image(image);
  const std::string beside = variance_path_of(path);
  struct stat status {};
  if (::stat(beside.c_str(), &status) != 0) return reference;
  reference.variance_path = beside;
  const ImageBuffer variance = read_pfm(beside).image;
  require_comparable(beside, variance.view(), path, image);
  add_variance(reference, variance);
  return reference;
}

}  // namespace mlt
