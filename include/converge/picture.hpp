// Pictures of errors: values a pixel through a colour map, with the scale drawn below. What is returned is
// linear, so that writing it as PNG with exposure 0 shows the map's colours.
#pragma once

#include <string>
#include <vector>

#include "converge/measure.hpp"

namespace mlt {

/// A value a pixel, rows from top to bottom.
struct ErrorField {
  std::uint32_t width = 0, height = 0;
  std::vector<double> values;
};

/// The root of the mean over replicates and channels of (image - base)^2 / (base^2 + 0.01).
ErrorField error_field(const ConvergeRun& run, std::size_t method, std::size_t level,
                       const ImageBuffer& base);

/// The mean over channels of (image - base) / sqrt(base^2 + 0.01).
ErrorField difference_field(const ImageBuffer& image, const ImageBuffer& base);

/// The quantile of the magnitudes of all fields, rounded up to 1, 2 or 5 times a power of ten; at least 1e-9.
double scale_end(const std::vector<ErrorField>& fields, double share);

enum class ColourMap { kSequential, kDiverging };

/// The field with every pixel enlarged to a square, so that small films can be seen, and a scale below it
/// that runs from 0 (sequential) or -high (diverging) to `high`.
ImageBuffer draw_field(const ErrorField& field, ColourMap map, double high);

/// `image` with pixels enlarged in the same way, without a scale.
ImageBuffer enlarge(const ImageBuffer& image);

}  // namespace mlt
