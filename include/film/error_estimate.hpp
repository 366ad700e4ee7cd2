// How far an image is from the truth, found without a reference, from differences between parts of the work.
// The chains of even and of odd number share no random number: for independent sums A and B of equal variance
// Var(A + B) = E[(A - B)^2], so the difference is an unbiased, if noisy, estimate of a pixel's variance, and
// its mean over the image a good one.
//
// The halves of a low-discrepancy sequence complement each other, and their difference overstates the
// variance, by a factor that no law tells beforehand (docs/ESTIMATOR.md). So every 16th pixel has two
// independent sequences (pixel_film.hpp), and the ratio of their squared difference to that of the halves in
// the same pixels is the factor for all. Independent samples have a factor of 1.
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

/// The half of a sequence of `count` samples that sample `index` belongs to: 1 for the first, -1 for the
/// second, 0 for the last of an odd number.
constexpr int half_of_sequence(std::uint64_t index, std::uint64_t count) {
  const std::uint64_t size = count / 2;
  return index < size ? 1 : index < 2 * size ? -1 : 0;
}

/// Squared differences by channel, in squared radiance.
struct PixelDifferences {
  double halves[3] = {0, 0, 0};
  double sequences[3] = {0, 0, 0};  ///< 0 where there is one sequence, or chains
  bool has_sequences = false;
};

/// `scale` turns sums into radiance: of a Metropolis film, pixels * weight_b / (mutations * 2^bits), of a
/// path tracer's 1 / samples, of which the pixel has `sequences` (1 or 2) times as many.
PixelDifferences pixel_differences(const FilmPixel& pixel, double scale);
PixelDifferences pixel_differences(const PixelSum& pixel, double scale, std::uint32_t sequences);

/// Sums over pixels, relative to their radiance: means over channels of difference / (radiance^2 + 0.01).
struct ErrorSums {
  double halves = 0;
  double paired_halves = 0;     ///< of the pixels with two sequences alone
  double paired_sequences = 0;  ///< of these, the difference between sequences

  void add(const ErrorSums& other) {
    halves += other.halves;
    paired_halves += other.paired_halves;
    paired_sequences += other.paired_sequences;
  }
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
  double factor = 1;          ///< variance over that of the halves' difference
  bool known = false;         ///< false without two halves
};

/// From the sums over blocks of pixels. Blocks of different brightness differ for other reasons than chance
/// too, so the standard error is rather too large.
ErrorEstimate estimate_error(std::span<const ErrorSums> blocks, std::uint64_t pixels);

}  // namespace mlt
