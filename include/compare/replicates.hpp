// Do two programs, or two settings, make the same picture but for noise? Replicates (renders that differ in
// their seed alone) of both are compared by the means of square tiles: Welch's t-test for each tile and
// channel [Welch47], all of them together by Sidak's correction [Sidak67], and a Kolmogorov-Smirnov test that
// sees many p-values a little too small [Stephens70].
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
  double smallest_p_value = 1;
  std::uint32_t smallest_x = 0, smallest_y = 0;  ///< tile of the smallest, in pixels from the top left
  double sidak_p_value = 1;                      ///< of the smallest one among `tests`
  double ks_distance = 0;  ///< how far the distribution of the luminance's p-values lies above uniform
  double ks_p_value = 1;
  double level = 0;  ///< each of the last two p-values rejects below it, so that alpha is kept
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
