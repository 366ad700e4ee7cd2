// How far an image is from the truth, found without a reference, from differences between parts of the work.
// The chains of even and of odd number share no random number: for independent sums A and B of equal variance
// Var(A + B) = E[(A - B)^2], so the difference is an unbiased, if noisy, estimate of a pixel's variance, and
// its mean over the image a good one.
//
// The halves of a low-discrepancy sequence complement each other, and their difference overstates the
// variance. With V(n) the variance of the mean of n samples, the halves' difference tells V(n/2) - V(n) and
// those of the quarters V(n/4) - V(n/2). With V(n) = a/n + b/n^2, a part that stratification does not help
// and one that it does, V(n) is (5 - q) / 3 times the first, q being the ratio of the second to the first;
// independent samples have q = 2 and a factor of 1.
//
// What no path has found yet is in no part: the estimate cannot know of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "film/fixed_film.hpp"
#include "film/image_view.hpp"
#include "film/pixel_film.hpp"

namespace mlt {

/// As in relMSE: added to the squared radiance, so that black pixels do not divide by 0.
inline constexpr double kRelativeErrorOffset = 0.01;

/// The half that unit `index` of `count` belongs to: 1 or -1 in turn, 0 for the last of an odd number, which
/// would make the halves unequal.
constexpr int half_of(std::uint64_t index, std::uint64_t count) {
  if (index == count - 1 && count % 2 == 1) return 0;
  return index % 2 == 0 ? 1 : -1;
}

/// The quarter, 0 to 3, that sample `index` of a sequence of `count` belongs to; 4 for the last count % 4.
constexpr std::uint64_t quarter_of(std::uint64_t index, std::uint64_t count) {
  const std::uint64_t size = count / 4;
  return size > 0 && index / size < 4 ? index / size : 4;
}

/// Squared differences by channel, in squared radiance: V(n/2) - V(n) and V(n/4) - V(n/2) in the notation
/// above.
struct PixelDifferences {
  double halves[3] = {0, 0, 0};
  double quarters[3] = {0, 0, 0};  ///< equal to `halves` where there is no sequence
};

/// `scale` turns sums into radiance: of a Metropolis film, pixels * weight_b / (mutations * 2^bits), of a
/// path tracer's 1 / samples.
PixelDifferences pixel_differences(const FilmPixel& pixel, double scale);
PixelDifferences pixel_differences(const PixelSum& pixel, double scale);

/// Sums over pixels, relative to their radiance: means over channels of difference / (radiance^2 + 0.01).
struct ErrorSums {
  double halves = 0;
  double quarters = 0;
};

/// What pixel (x, y) adds. Its radiance is taken to be the mean of its 5 x 5 neighbours without itself: a
/// pixel that owes its brightness to one lucky path must not be measured by that brightness.
ErrorSums relative_differences(const ImageView& image, std::uint32_t x, std::uint32_t y,
                               const PixelDifferences& differences);

/// Square roots of the variances, `factor` times `differences[i].halves`, averaged over the 5 x 5 neighbours
/// of each pixel, itself included.
std::vector<Vec3> smooth_standard_errors(std::span<const PixelDifferences> differences, double factor,
                                         std::uint32_t width, std::uint32_t height);

/// The estimated relMSE of an image.
struct ErrorEstimate {
  double rel_mse = 0;
  double standard_error = 0;  ///< of rel_mse, from the spread over blocks; of one block, all of it
  double factor = 1;          ///< (5 - q) / 3 above, 1/2 to 1
  bool known = false;         ///< false without two halves or four quarters
};

/// From the sums over blocks of pixels; `is_sequence` asks for the factor to be found. Blocks of different
/// brightness differ for other reasons than chance too, so the standard error is rather too large.
ErrorEstimate estimate_error(std::span<const ErrorSums> blocks, std::uint64_t pixels, bool is_sequence);

}  // namespace mlt
