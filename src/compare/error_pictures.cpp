#include "compare/error_pictures.hpp"

#include <algorithm>
#include <limits>

namespace mlt {

Picture draw_heat_map(MetricKind kind, const ImageView& image, const ImageView& reference,
                      const ImageComparison& comparison, const CompareOptions& options,
                      std::optional<double> range) {
  const std::vector<float> values = error_map(kind, image, reference, comparison, options);
  const bool is_flip = kind == MetricKind::flip;
  NumberMap map{image.width, image.height, values, 0, 1, ColourMap::viridis, {}};
  map.high = range.value_or(is_flip ? 1.0 : display_range(values));
  map.colours = is_flip ? ColourMap::magma : ColourMap::viridis;
  map.title = kMetrics[static_cast<std::size_t>(kind)].label;
  return draw_map(map);
}

Picture draw_difference(const ImageView& image, const ImageView& reference, std::optional<double> range) {
  std::vector<float> values;
  values.reserve(image.pixels.size());
  const auto luminance_of = [](const Vec3& pixel) {
    return (0.2126 * static_cast<double>(pixel.x) + 0.7152 * static_cast<double>(pixel.y)) +
           0.0722 * static_cast<double>(pixel.z);
  };
  const double largest = static_cast<double>(std::numeric_limits<float>::max());
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const double difference = luminance_of(image.pixels[i]) - luminance_of(reference.pixels[i]);
    values.push_back(static_cast<float>(std::clamp(difference, -largest, largest)));
  }
  const double high = range.value_or(display_range(values));
  return draw_map({image.width, image.height, values, -high, high, ColourMap::diverging, "A - B, luminance"});
}

ImageBuffer difference_image(const ImageView& image, const ImageView& reference) {
  ImageBuffer result{image.width, image.height, {}};
  result.pixels.reserve(image.pixels.size());
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    result.pixels.push_back(image.pixels[i] - reference.pixels[i]);
  }
  return result;
}

}  // namespace mlt
