// How far an image is from a reference: the figures that `mlt compare` prints and that the golden-image
// tests bound. Sums are in double, within rows and then over rows from top to bottom, so the figures are the
// same bits everywhere.
#pragma once

#include <cstdint>
#include <string>

#include "film/image_view.hpp"

namespace mlt {

/// Added to the squared reference in relMSE, so that black pixels do not divide by 0 [Rousselle11].
inline constexpr double kRelMseOffset = 0.01;

struct ImageComparison {
  double mse = 0;         ///< mean over pixels and channels of (image - reference)^2
  double rel_mse = 0;     ///< mean over pixels and channels of (image - reference)^2 / (reference^2 + 0.01)
  double mean_image = 0;  ///< over pixels and channels
  double mean_reference = 0;
  /// mean_image / mean_reference; when the reference's mean is 0, 1 for two such images, else infinity.
  double mean_ratio = 0;
};

/// Both images must be of one size, not empty, and finite; see require_comparable.
ImageComparison compare_images(const ImageView& image, const ImageView& reference);

/// Throws InputError, naming the file, when the sizes differ or a pixel is not finite (with their count and
/// the first one's place).
void require_comparable(const std::string& image_path, const ImageView& image,
                        const std::string& reference_path, const ImageView& reference);

}  // namespace mlt
