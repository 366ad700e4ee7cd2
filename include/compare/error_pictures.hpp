// Pictures of the error of an image, each with its scale drawn: a heat map of one metric and the signed
// difference. Ready to be written by write_png.
#pragma once

#include <optional>

#include "compare/compare.hpp"
#include "compare/drawing.hpp"

namespace mlt {

/// The metric's error_map in colours: FLIP from 0 to 1 in magma [Andersson20], the others in viridis from 0
/// to `range`, or to display_range of the map.
Picture draw_heat_map(MetricKind kind, const ImageView& image, const ImageView& reference,
                      const ImageComparison& comparison, const CompareOptions& options,
                      std::optional<double> range = std::nullopt);

/// Luminance of image - reference: red where the image is brighter, blue where it is darker, white where both
/// are equal, from -range to range, or to display_range of the differences.
Picture draw_difference(const ImageView& image, const ImageView& reference,
                        std::optional<double> range = std::nullopt);

/// image - reference, each channel rounded once.
ImageBuffer difference_image(const ImageView& image, const ImageView& reference);

}  // namespace mlt
