// Do two programs, or two settings, make the same picture but for noise? Replicates (renders that differ in
// their seed alone) of both are compared by the means of the whole image and of square tiles: Welch's t-test
// for each channel [Welch47], all tiles together by Sidak's correction [Sidak67], and the Kolmogorov-Smirnov
// distance of the tiles' p-values, which sees many of them a little too small, by permutation [Janssen97].
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "film/image_view.hpp"
#include "image/image_io.hpp"

namespace mlt {

struct ReplicateTestOptions {
  std::uint32_t tile = 16;  ///< pixels on a side; tiles at the right and lower border may be smaller
  double alpha = 0.01;      ///< probability of rejecting equal pictures, in (0,1)
};

struct ReplicateTestResult {
  std::uint32_t tiles_x = 0, tiles_y = 0;
  /// Of each tile, row by row: the smallest p-value of its three channels. 1 where nothing varies and all is
  /// equal, 0 where nothing varies and something differs.
  std::vector<double> p_values;
  std::uint64_t tests = 0;  ///< tiles times channels in which anything varies or differs
  double mean_p_value = 1;  ///< of the image means: the smallest of the channels', by Sidak's correction
  double smallest_p_value = 1;
  std::uint32_t smallest_x = 0, smallest_y = 0;  ///< tile of the smallest, in pixels from the top left
  double sidak_p_value = 1;                      ///< of the smallest one among `tests`
  /// How far the distribution of the p-values of the tiles' shares in the image's luminance lies above the
  /// uniform one. Shares, since replicates of a Metropolis render differ in a common factor.
  double ks_distance = 0;
  /// The part of the ways to deal the replicates into two such sets that give this distance or more: tiles
  /// depend on each other (chains visit many of them), which a table for independent ones does not know.
  double ks_p_value = 1;
  std::uint64_t relabellings = 0;  ///< ways tried, the given one included; ks_p_value is at least 1 / this
  double level = 0;  ///< the image means, Sidak and Kolmogorov-Smirnov reject below it, which keeps alpha
  bool rejected = false;
};

/// `first` and `second`: at least two images each, all finite and of one size. The t-tests hold for tile
/// means that are close to normal, which takes tiles of many samples; neighbouring pixels may depend on each
/// other, tiles should not.
ReplicateTestResult test_replicates(std::span<const ImageView> first, std::span<const ImageView> second,
                                    const ReplicateTestOptions& options);

/// The tiles' p-values in colours, as -log10 p from 0 to 8, with the bar; for images of this size.
Picture draw_p_values(const ReplicateTestResult& result, std::uint32_t width, std::uint32_t height,
                      std::uint32_t tile);

}  // namespace mlt
