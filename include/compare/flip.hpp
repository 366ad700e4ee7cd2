// FLIP, the error that a person sees when two pictures are alternated: LDR-FLIP [Andersson20] for display
// values, HDR-FLIP [Andersson21] for radiance, which is the largest LDR-FLIP over a range of exposures of the
// tone-mapped pictures. Computed in double by separable filters, in bands of rows, so that the memory beside
// the pictures stays small; the figures are the same bits everywhere. docs/COMPARE.md states what was
// compared with what.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "film/image_view.hpp"

namespace mlt {

/// name, one-line description for the help text.
#define MLT_FLIP_MODES(X)                                                         \
  X(ldr, "the pictures as displayed: brightened by --exposure, clipped to [0,1]") \
  X(hdr, "the largest error over a range of exposures, tone-mapped, found in the reference")

enum class FlipMode : std::uint8_t {
#define MLT_ENUMERATE(name, help) name,
  MLT_FLIP_MODES(MLT_ENUMERATE)
#undef MLT_ENUMERATE
};

/// Pixels per degree of a screen 3840 pixels and 0.7 m wide seen from 0.7 m [Andersson20 section 4].
inline constexpr double kPixelsPerDegree = 3840.0 * 3.14159265358979323846 / 180.0;

/// Bounds of pixels_per_degree: filters of 1 to 135 pixels on each side.
inline constexpr double kMinPixelsPerDegree = 1;
inline constexpr double kMaxPixelsPerDegree = 1000;

struct FlipOptions {
  FlipMode mode = FlipMode::hdr;
  double pixels_per_degree = kPixelsPerDegree;
  double exposure = 0;  ///< EV, for LDR
  /// EV, for HDR: both of them, or neither to take them from the reference.
  std::optional<double> start_exposure, stop_exposure;
  std::uint32_t threads = 1;  ///< at least 1; without influence on the figures
};

struct FlipResult {
  std::vector<float> map;  ///< error in [0,1] of each pixel, in the picture's order; empty: not computed
  double mean = 0;
  double maximum = 0;
  FlipMode mode = FlipMode::hdr;
  double pixels_per_degree = 0;
  double start_exposure = 0, stop_exposure = 0;  ///< EV; both the given exposure for LDR
  std::uint32_t exposures = 1;
};

/// Both images must be finite, of one size and not empty. Negative values count as 0.
FlipResult compute_flip(const ImageView& image, const ImageView& reference, const FlipOptions& options);

/// The exposures at which the brightest pixel and the median pixel of `reference` reach 0.85 of the display's
/// range after tone mapping [Andersson21 section 3.2]. Departs from the paper where half of the pixels are
/// black: the median is then that of the pixels that are not (0 for both when there are none).
struct ExposureRange {
  double start = 0, stop = 0;  ///< EV, start <= stop
};
ExposureRange flip_exposures(const ImageView& reference);

}  // namespace mlt
