#include "compare/drawing.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/assert.hpp"
#include "base/error.hpp"
#include "render/job.hpp"

namespace mlt {
namespace {

constexpr std::uint32_t kLetterWidth = 6;  // with the gap to the next one
constexpr std::uint32_t kMargin = 8;
constexpr std::uint32_t kBarWidth = 16;
constexpr std::uint32_t kMinBarHeight = 160;
constexpr std::uint32_t kTitleHeight = 20;
constexpr std::uint32_t kSmallSide = 256;  // maps below this are enlarged
constexpr int kMostLabels = 7;
constexpr Rgb8 kPaper{255, 255, 255};
constexpr Rgb8 kInk{0, 0, 0};

struct Glyph {
  char letter;
  const char* rows;  ///< 7 rows of 5, from the top
};

// The digits, signs and capital letters that labels and titles need.
constexpr Glyph kGlyphs[] = {
    {'0', ".###.#...##..###.#.###..##...#.###."}, {'1', "..#...##....#....#....#....#...###."},
    {'2', ".###.#...#....#...#...#...#...#####"}, {'3', "#####...#...#.....#.....##...#.###."},
    {'4', "...#...##..#.#.#..#.#####...#....#."}, {'5', "######....####.....#....##...#.###."},
    {'6', "..##..#...#....####.#...##...#.###."}, {'7', "#####....#...#...#...#....#....#..."},
    {'8', ".###.#...##...#.###.#...##...#.###."}, {'9', ".###.#...##...#.####....#...#..##.."},
    {'.', "..........................##...##.."}, {',', ".....................##...#...#...."},
    {'-', "...............#####..............."}, {'+', ".......#....#..#####..#....#......."},
    {'^', "..#...#.#.#...#...................."}, {'/', "....#....#...#...#...#...#....#...."},
    {'|', "..#....#....#....#....#....#....#.."}, {'(', "...#...#...#....#....#.....#.....#."},
    {')', ".#.....#.....#....#....#...#...#..."}, {'=', "..........#####.....#####.........."},
    {'<', "...#...#...#...#.....#.....#.....#."}, {'>', "#.....#.....#.....#...#...#...#...."},
    {'%', "##...##..#....#...#...#....#..##.##"}, {'A', ".###.#...##...##...#######...##...#"},
    {'B', "####.#...##...#####.#...##...#####."}, {'C', ".###.#...##....#....#....#...#.###."},
    {'D', "####.#...##...##...##...##...#####."}, {'E', "######....#....####.#....#....#####"},
    {'F', "######....#....####.#....#....#...."}, {'G', ".###.#...##....#.####...##...#.####"},
    {'H', "#...##...##...#######...##...##...#"}, {'I', ".###...#....#....#....#....#...###."},
    {'J', "..###...#....#....#....#.#..#..##.."}, {'K', "#...##..#.#.#..##...#.#..#..#.#...#"},
    {'L', "#....#....#....#....#....#....#####"}, {'M', "#...###.###.#.##.#.##...##...##...#"},
    {'N', "#...##...###..##.#.##..###...##...#"}, {'O', ".###.#...##...##...##...##...#.###."},
    {'P', "####.#...##...#####.#....#....#...."}, {'Q', ".###.#...##...##...##.#.##..#..##.#"},
    {'R', "####.#...##...#####.#.#..#..#.#...#"}, {'S', ".#####....#.....###.....#....#####."},
    {'T', "#####..#....#....#....#....#....#.."}, {'U', "#...##...##...##...##...##...#.###."},
    {'V', "#...##...##...##...##...#.#.#...#.."}, {'W', "#...##...##...##.#.##.#.###.###...#"},
    {'X', "#...##...#.#.#...#...#.#.#...##...#"}, {'Y', "#...##...#.#.#...#....#....#....#.."},
    {'Z', "#####....#...#...#...#...#....#####"},
};

const char* glyph_of(char letter) {
  const char capital = letter >= 'a' && letter <= 'z' ? static_cast<char>(letter - 'a' + 'A') : letter;
  for (const Glyph& glyph : kGlyphs) {
    if (glyph.letter == capital) return glyph.rows;
  }
  return nullptr;
}

void set_pixel(Picture& picture, std::uint32_t x, std::uint32_t y, const Rgb8& colour) {
  if (x >= picture.width || y >= picture.height) return;
  std::uint8_t* bytes = picture.bytes.data() + 3 * (std::size_t{y} * picture.width + x);
  bytes[0] = colour.r;
  bytes[1] = colour.g;
  bytes[2] = colour.b;
}

Picture blank(std::uint64_t width, std::uint64_t height) {
  if (width > kMaxFilmSide || height > kMaxFilmSide) {
    throw ResourceError(
        fmt::format("a drawing of {} x {} pixels exceeds {} on a side", width, height, kMaxFilmSide));
  }
  Picture picture{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), {}};
  picture.bytes.assign(3 * width * height, kPaper.r);
  return picture;
}

double share_of(const NumberMap& map, double value) {
  return (value - map.low) / (map.high - map.low);
}

/// "0.25", "-1e-06"; the same digits for all values of one scale.
std::string label_of(double value, double step) {
  // Round values are small multiples of their distance; 0 could be a rounding error.
  if (std::fabs(value) < 0.5 * step) return "0";
  return fmt::format("{:.3g}", value);
}

std::vector<std::pair<double, std::string>> labels_of(const NumberMap& map) {
  const std::vector<double> values = round_values(map.low, map.high, kMostLabels);
  const double step = values.size() > 1 ? values[1] - values[0] : 0;
  std::vector<std::pair<double, std::string>> labels;
  for (const double value : values) labels.emplace_back(value, label_of(value, step));
  return labels;
}

/// A line around the rectangle of this size at (left, top), outside of it.
void draw_frame(Picture& picture, std::uint32_t left, std::uint32_t top, std::uint64_t width,
                std::uint64_t height) {
  for (std::uint32_t x = 0; x < width + 2; ++x) {
    set_pixel(picture, left - 1 + x, top - 1, kInk);
    set_pixel(picture, left - 1 + x, top + static_cast<std::uint32_t>(height), kInk);
  }
  for (std::uint32_t y = 0; y < height + 2; ++y) {
    set_pixel(picture, left - 1, top - 1 + y, kInk);
    set_pixel(picture, left + static_cast<std::uint32_t>(width), top - 1 + y, kInk);
  }
}

/// The bar of all colours in a frame, with a tick and a label for each value, its left edge at x.
void draw_bar(Picture& picture, const NumberMap& map, std::uint32_t left, std::uint32_t top,
              std::uint32_t height) {
  for (std::uint32_t y = 0; y < height; ++y) {
    const double share = 1 - static_cast<double>(y) / static_cast<double>(height - 1);
    for (std::uint32_t x = 0; x < kBarWidth; ++x) {
      const bool frame = x == 0 || x + 1 == kBarWidth || y == 0 || y + 1 == height;
      set_pixel(picture, left + x, top + y, frame ? kInk : map_colour(map.colours, share));
    }
  }
  for (const auto& [value, label] : labels_of(map)) {
    const double place = (1 - share_of(map, value)) * static_cast<double>(height - 1) + 0.5;
    const auto y = top + static_cast<std::uint32_t>(std::clamp(place, 0.0, static_cast<double>(height - 1)));
    for (std::uint32_t x = 0; x < 4; ++x) set_pixel(picture, left + kBarWidth + x, y, kInk);
    draw_text(picture, left + kBarWidth + 7, y < 3 ? 0 : y - 3, 1, label, kInk);
  }
}

}  // namespace

void draw_text(Picture& picture, std::uint32_t x, std::uint32_t y, std::uint32_t size,
               const std::string& text, const Rgb8& colour) {
  for (const char letter : text) {
    const char* rows = glyph_of(letter);
    for (std::uint32_t i = 0; rows != nullptr && i < 35 * size * size; ++i) {
      const std::uint32_t column = i % (5 * size);
      const std::uint32_t row = i / (5 * size);
      if (rows[5 * (row / size) + column / size] == '#') set_pixel(picture, x + column, y + row, colour);
    }
    x += kLetterWidth * size;
  }
}

std::vector<double> round_values(double low, double high, int most) {
  MLT_CHECK(high > low && std::isfinite(high - low) && most >= 2);
  // A power of ten below the distance that is looked for, found without logarithms.
  const double wanted = (high - low) / (most - 1);
  double power = 1;
  while (power > wanted) power /= 10;
  while (power * 10 <= wanted) power *= 10;
  double step = power;
  for (const double factor : {2.0, 5.0, 10.0}) {
    if (step < wanted * (1 - 1e-9)) step = power * factor;
  }
  std::vector<double> values;
  const double slack = 1e-9 * (high - low);
  for (double i = std::ceil((low - slack) / step); i * step <= high + slack; i += 1) {
    values.push_back(i * step);
  }
  return values;
}

Picture colour_pixels(const NumberMap& map) {
  MLT_CHECK_OP(map.values.size(), ==, std::size_t{map.width} * map.height);
  MLT_CHECK(map.high > map.low);
  Picture picture = blank(map.width, map.height);
  for (std::size_t i = 0; i < map.values.size(); ++i) {
    const Rgb8 colour = map_colour(map.colours, share_of(map, static_cast<double>(map.values[i])));
    picture.bytes[3 * i] = colour.r;
    picture.bytes[3 * i + 1] = colour.g;
    picture.bytes[3 * i + 2] = colour.b;
  }
  return picture;
}

Picture draw_map(const NumberMap& map) {
  const Picture pixels = colour_pixels(map);
  const std::uint32_t longest = std::max(map.width, map.height);
  const std::uint32_t zoom = std::max(1U, kSmallSide / longest);
  const std::uint64_t map_width = std::uint64_t{map.width} * zoom;
  const std::uint64_t map_height = std::uint64_t{map.height} * zoom;
  std::size_t longest_label = 0;
  for (const auto& label : labels_of(map)) longest_label = std::max(longest_label, label.second.size());
  const std::uint64_t bar = 2 * kMargin + kBarWidth + 7 + kLetterWidth * longest_label;
  const std::uint64_t titled = std::max(map_width + bar, kLetterWidth * map.title.size() + kMargin) + kMargin;
  const std::uint64_t body = std::max<std::uint64_t>(map_height, kMinBarHeight);
  Picture picture = blank(titled, kTitleHeight + body + kMargin);
  draw_text(picture, kMargin, 7, 1, map.title, kInk);
  for (std::uint32_t y = 0; y < map_height; ++y) {
    for (std::uint32_t x = 0; x < map_width; ++x) {
      const std::uint8_t* bytes = pixels.bytes.data() + 3 * (std::size_t{y / zoom} * map.width + x / zoom);
      set_pixel(picture, kMargin + x, kTitleHeight + y, {bytes[0], bytes[1], bytes[2]});
    }
  }
  draw_frame(picture, kMargin, kTitleHeight, map_width, map_height);
  draw_bar(picture, map, static_cast<std::uint32_t>(map_width) + 2 * kMargin, kTitleHeight,
           static_cast<std::uint32_t>(body));
  return picture;
}

double magnitude_quantile(std::span<const float> values, double share) {
  if (values.empty()) return 0;
  std::vector<float> magnitudes;
  magnitudes.reserve(values.size());
  for (const float value : values) magnitudes.push_back(std::fabs(value));
  const double place = std::clamp(share, 0.0, 1.0) * static_cast<double>(values.size() - 1);
  const auto middle = magnitudes.begin() + static_cast<std::ptrdiff_t>(place);
  std::nth_element(magnitudes.begin(), middle, magnitudes.end());
  return static_cast<double>(*middle);
}

double display_range(std::span<const float> values) {
  double range = magnitude_quantile(values, 0.99);
  if (range == 0) range = magnitude_quantile(values, 1);
  if (range == 0) return 1;
  double power = 1;
  while (power > range) power /= 10;
  while (power * 10 < range) power *= 10;
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (range <= power * factor) return power * factor;
  }
  return power * 10;
}

}  // namespace mlt
