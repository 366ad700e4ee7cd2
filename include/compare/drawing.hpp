// Maps of numbers as pictures for people: colour maps, a colour bar with its scale, and digits to label it.
// Colours and sizes depend on the numbers alone, so that equal maps give equal files.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "film/image_view.hpp"
#include "image/image_io.hpp"

namespace mlt {

/// name, one-line description.
#define MLT_COLOUR_MAPS(X)                                                              \
  X(magma, "black over purple and orange to light yellow, even in lightness [Smith15]") \
  X(viridis, "purple over green to yellow, even in lightness [Smith15]")                \
  X(diverging, "blue below, white at and red above the middle")                         \
  X(grey, "black to white")

enum class ColourMap : std::uint8_t {
#define MLT_ENUMERATE(name, help) name,
  MLT_COLOUR_MAPS(MLT_ENUMERATE)
#undef MLT_ENUMERATE
};

struct Rgb8 {
  std::uint8_t r = 0, g = 0, b = 0;
  bool operator==(const Rgb8&) const = default;
};

/// The sRGB colour of a share in [0,1], beyond which it is clipped; NaN gives the colour of 0.
Rgb8 map_colour(ColourMap map, double share);

/// A map of numbers, one a pixel, with the range that its colours stand for.
struct NumberMap {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::span<const float> values;  ///< width * height, top row first; finite
  double low = 0;                 ///< has the first colour
  double high = 1;                ///< has the last colour; above `low`
  ColourMap colours = ColourMap::magma;
  std::string title;  ///< drawn above the bar; letters, digits and ".,+-^/|()=<> %"
};

/// The map in colours with, to its right, a bar of all colours and numbers at round values between low and
/// high. Small maps are enlarged by whole pixels. The height is that of the map or of the bar, whichever is
/// larger. Throws ResourceError when the picture would exceed kMaxFilmSide.
Picture draw_map(const NumberMap& map);

/// The colours alone, one pixel a number.
Picture colour_pixels(const NumberMap& map);

/// Round values within [low, high], at most `most` (at least 2), their distance 1, 2 or 5 times a power of
/// ten.
std::vector<double> round_values(double low, double high, int most);

/// Draws text with its upper left corner at (x, y): 5 x 7 pixels a letter times `size`, 6 * size apart.
void draw_text(Picture& picture, std::uint32_t x, std::uint32_t y, std::uint32_t size,
               const std::string& text, const Rgb8& colour);

/// `share` (0 to 1) of the magnitudes of `values` are at most this; 0 for no values.
double magnitude_quantile(std::span<const float> values, double share);

/// A range for a picture whose brightest pixels should not decide it: 99 % of the magnitudes, rounded up to
/// 1, 2 or 5 times a power of ten; 1 when all are 0.
double display_range(std::span<const float> values);

}  // namespace mlt
