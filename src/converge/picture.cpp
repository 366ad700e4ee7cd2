#include "converge/picture.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>

#include "base/assert.hpp"
#include "compare/compare.hpp"
#include "converge/statistics.hpp"
#include "math/elementary.hpp"

namespace mlt {
namespace {

constexpr std::uint32_t kLeastSide = 320;  // small films are enlarged to about this
constexpr std::uint32_t kBarHeight = 12;
constexpr std::uint32_t kMargin = 5;
constexpr std::uint32_t kGlyphWidth = 5, kGlyphHeight = 7;

struct Srgb8 {
  std::uint8_t r, g, b;
};

/// Nine colours of viridis, the map of matplotlib, equally spaced.
constexpr Srgb8 kSequential[] = {{68, 1, 84},    {71, 45, 123},  {59, 82, 139},
                                 {44, 114, 142}, {33, 145, 140}, {40, 174, 128},
                                 {94, 201, 98},  {173, 220, 48}, {253, 231, 37}};
/// Seven colours from blue over white to red.
constexpr Srgb8 kDiverging[] = {{33, 102, 172},  {103, 169, 207}, {209, 229, 240}, {247, 247, 247},
                                {253, 219, 199}, {239, 138, 98},  {178, 24, 43}};

/// The inverse of the transfer function of sRGB [IEC 61966-2-1], of a value in [0,1].
float linear_of(float encoded) {
  return encoded <= 0.04045f ? encoded / 12.92f : pow_f((encoded + 0.055f) / 1.055f, 2.4f);
}

/// The colour at `place` in [0,1], interpolated in sRGB as the maps are defined.
Vec3 colour_at(ColourMap map, double place) {
  const std::span<const Srgb8> colours = map == ColourMap::kSequential ? std::span<const Srgb8>(kSequential)
                                                                       : std::span<const Srgb8>(kDiverging);
  const double last = static_cast<double>(colours.size() - 1);
  const double position = (place >= 0 ? std::min(place, 1.0) : 0.0) * last;
  const auto below = static_cast<std::size_t>(std::min(position, last - 1));
  const auto share = static_cast<float>(position - static_cast<double>(below));
  const auto mix = [share](std::uint8_t a, std::uint8_t b) {
    return linear_of((static_cast<float>(a) + share * (static_cast<float>(b) - static_cast<float>(a))) /
                     255.0f);
  };
  const Srgb8& low = colours[below];
  const Srgb8& high = colours[below + 1];
  return Vec3{mix(low.r, high.r), mix(low.g, high.g), mix(low.b, high.b)};
}

struct Glyph {
  char letter;
  std::uint8_t rows[kGlyphHeight];  ///< five bits each, the highest one left
};
constexpr Glyph kGlyphs[] = {{'0', {14, 17, 17, 17, 17, 17, 14}}, {'1', {4, 12, 4, 4, 4, 4, 14}},
                             {'2', {14, 17, 1, 2, 4, 8, 31}},     {'3', {31, 2, 4, 2, 1, 17, 14}},
                             {'4', {2, 6, 10, 18, 31, 2, 2}},     {'5', {31, 16, 30, 1, 1, 17, 14}},
                             {'6', {6, 8, 16, 30, 17, 17, 14}},   {'7', {31, 1, 2, 4, 8, 8, 8}},
                             {'8', {14, 17, 17, 14, 17, 17, 14}}, {'9', {14, 17, 17, 15, 1, 2, 12}},
                             {'.', {0, 0, 0, 0, 0, 12, 12}},      {'-', {0, 0, 0, 14, 0, 0, 0}},
                             {'+', {0, 4, 4, 31, 4, 4, 0}},       {'e', {0, 0, 14, 17, 31, 16, 14}}};

void draw_text(ImageBuffer& image, std::int64_t left, std::int64_t top, std::string_view text) {
  for (const char letter : text) {
    const auto* glyph = std::find_if(std::begin(kGlyphs), std::end(kGlyphs),
                                     [letter](const Glyph& known) { return known.letter == letter; });
    MLT_CHECK(glyph != std::end(kGlyphs));
    for (std::int64_t y = 0; y < kGlyphHeight; ++y) {
      for (std::int64_t x = 0; x < kGlyphWidth; ++x) {
        const bool set = (glyph->rows[y] >> (kGlyphWidth - 1 - x) & 1) != 0;
        const bool inside = left + x >= 0 && left + x < image.width && top + y >= 0 && top + y < image.height;
        if (set && inside) {
          image.pixels[static_cast<std::size_t>((top + y) * image.width + left + x)] = Vec3{0, 0, 0};
        }
      }
    }
    left += kGlyphWidth + 1;
  }
}

std::int64_t text_width(std::string_view text) {
  return static_cast<std::int64_t>(text.size() * (kGlyphWidth + 1)) - 1;
}

std::uint32_t enlargement(std::uint32_t width, std::uint32_t height) {
  return std::max(1u, (kLeastSide + std::max(width, height) / 2) / std::max(width, height));
}

}  // namespace

ErrorField error_field(const ConvergeRun& run, std::size_t method, std::size_t level,
                       const ImageBuffer& base) {
  ErrorField field{run.width, run.height, std::vector<double>(base.pixels.size(), 0.0)};
  for (std::size_t i = 0; i < field.values.size(); ++i) {
    for (std::uint32_t replicate = 0; replicate < run.replicates; ++replicate) {
      const Vec3& pixel = run.images[run.index(method, level, replicate)].pixels[i];
      for (int channel = 0; channel < 3; ++channel) {
        const double scale = base.pixels[i][channel];
        const double difference = static_cast<double>(pixel[channel]) - scale;
        field.values[i] += difference * difference / (scale * scale + kRelMseOffset);
      }
    }
    field.values[i] = std::sqrt(field.values[i] / (3.0 * run.replicates));
  }
  return field;
}

ErrorField difference_field(const ImageBuffer& image, const ImageBuffer& base) {
  ErrorField field{base.width, base.height, std::vector<double>(base.pixels.size(), 0.0)};
  for (std::size_t i = 0; i < field.values.size(); ++i) {
    for (int channel = 0; channel < 3; ++channel) {
      const double scale = base.pixels[i][channel];
      const double difference = static_cast<double>(image.pixels[i][channel]) - scale;
      field.values[i] += difference / std::sqrt(scale * scale + kRelMseOffset) / 3;
    }
  }
  return field;
}

double scale_end(const std::vector<ErrorField>& fields, double share) {
  std::vector<double> magnitudes;
  for (const ErrorField& field : fields) {
    for (const double value : field.values) magnitudes.push_back(std::fabs(value));
  }
  const double high = std::max(quantile(std::move(magnitudes), share), 1e-9);
  const double power = power_of_10(std::floor(log10_of(high)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    // The margin lets a quantile that is such a number stay one in spite of rounding.
    if (factor * power >= high * (1 - 1e-6)) return factor * power;
  }
  return 10 * power;
}

ImageBuffer enlarge(const ImageBuffer& image) {
  const std::uint32_t factor = enlargement(image.width, image.height);
  ImageBuffer result{image.width * factor, image.height * factor, {}};
  result.pixels.resize(std::size_t{result.width} * result.height);
  for (std::uint32_t y = 0; y < result.height; ++y) {
    for (std::uint32_t x = 0; x < result.width; ++x) {
      result.pixels[std::size_t{y} * result.width + x] =
          image.pixels[std::size_t{y / factor} * image.width + x / factor];
    }
  }
  return result;
}

ImageBuffer draw_field(const ErrorField& field, ColourMap map, double high) {
  const double low = map == ColourMap::kSequential ? 0 : -high;
  ImageBuffer colours{field.width, field.height, {}};
  for (const double value : field.values)
    colours.pixels.push_back(colour_at(map, (value - low) / (high - low)));
  ImageBuffer image = enlarge(colours);
  const std::uint32_t bar_top = image.height + kMargin;
  image.height += kMargin + kBarHeight + 3 + kGlyphHeight + kMargin;
  image.pixels.resize(std::size_t{image.width} * image.height, Vec3{1, 1, 1});
  for (std::uint32_t y = bar_top; y < bar_top + kBarHeight; ++y) {
    for (std::uint32_t x = 0; x < image.width; ++x) {
      const double place = (x + 0.5) / image.width;
      image.pixels[std::size_t{y} * image.width + x] = colour_at(map, place);
    }
  }
  const std::int64_t text_top = bar_top + kBarHeight + 3;
  for (const double place : {0.0, 0.5, 1.0}) {
    const double value = low + place * (high - low);
    // The logarithm's error shows in no more than the ninth digit.
    const std::string label = fmt::format("{}{:.4g}", value > 0 && low < 0 ? "+" : "", value);
    const double free = static_cast<double>(image.width) - static_cast<double>(text_width(label));
    draw_text(image, static_cast<std::int64_t>(place * std::max(free, 0.0)), text_top, label);
  }
  return image;
}

}  // namespace mlt
