// How far an image is from a reference: the figures that `mlt compare` prints and that the golden-image
// tests bound. Sums are in double, within rows and then over rows from top to bottom, so the figures are the
// same bits everywhere.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "compare/flip.hpp"
#include "compare/metrics.hpp"
#include "film/image_view.hpp"

namespace mlt {

/// Added to the squared reference in relMSE, so that black pixels do not divide by 0 [Rousselle11].
inline constexpr double kRelMseOffset = 0.01;
/// Added to the sum of magnitudes in SMAPE, for the same reason [Vogels18 eq. 10].
inline constexpr double kSmapeOffset = 0.01;

struct CompareOptions {
  bool with_flip = true;  ///< otherwise FLIP is left at NaN and no map is made, which is much faster
  FlipOptions flip;
  double exposure = 0;  ///< EV by which pictures are brightened for display (PSNR)
};

struct ImageComparison {
  MetricValues metrics;
  /// Means of each channel, and their ratio; where the reference's mean is 0, the ratio is 1 for two such
  /// images, else infinity.
  std::array<double, 3> mean_image{}, mean_reference{}, mean_ratio{};
  double mean_ratio_all = 0;  ///< of the means over all channels
  FlipResult flip;
};

/// Both images must be of one size, not empty, and finite; see require_comparable. PSNR of images that look
/// the same is infinite.
ImageComparison compare_images(const ImageView& image, const ImageView& reference,
                               const CompareOptions& options);

/// Pixels with a channel that is not finite.
struct NonFinite {
  std::uint64_t count = 0;  ///< nan + infinite
  std::uint64_t nan = 0;    ///< pixels with a NaN
  std::uint64_t infinite = 0;
  std::uint32_t first_x = 0, first_y = 0;
  std::uint32_t x_min = 0, x_max = 0, y_min = 0, y_max = 0;  ///< the smallest rectangle around them

  /// "2 of 6 pixels are NaN or infinite (...)", with their place; `image` gives the total.
  std::string to_string(const ImageView& image) const;
};
NonFinite find_non_finite(const ImageView& image);

/// What speaks against a comparison, as diagnostics that name the file: the sizes differ, or pixels are not
/// finite (with their count and place).
std::vector<Diagnostic> comparison_faults(const std::string& image_path, const ImageView& image,
                                          const std::string& reference_path, const ImageView& reference);

/// Throws these as an InputError, if there are any.
void require_comparable(const std::string& image_path, const ImageView& image,
                        const std::string& reference_path, const ImageView& reference);

/// The error of each pixel whose mean `kind` is, over its channels. For metrics that are no such mean (RMSE:
/// the root of the pixel's MSE; PSNR: the squared difference of the sRGB values; mean error: |A - B|).
/// `comparison` is that of the same images; FLIP's map is taken from it.
std::vector<float> error_map(MetricKind kind, const ImageView& image, const ImageView& reference,
                             const ImageComparison& comparison, const CompareOptions& options);

}  // namespace mlt
