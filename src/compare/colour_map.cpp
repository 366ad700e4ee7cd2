#include <array>
#include <cmath>

#include "compare/drawing.hpp"

namespace mlt {
namespace {

using Points = std::array<std::array<std::uint8_t, 3>, 33>;

// Every eighth of the 256 colours of the maps [Smith15], and the last one; between them the maps are straight
// to 2/255.
constexpr Points kMagma = {
    {{0, 0, 4},       {3, 3, 18},      {10, 8, 34},     {19, 13, 52},    {29, 17, 71},    {41, 17, 90},
     {54, 16, 107},   {68, 15, 118},   {81, 18, 124},   {93, 23, 127},   {106, 28, 129},  {118, 33, 129},
     {131, 38, 129},  {144, 42, 129},  {156, 46, 127},  {170, 51, 125},  {183, 55, 121},  {196, 60, 117},
     {208, 65, 111},  {220, 72, 105},  {231, 82, 99},   {239, 93, 94},   {245, 107, 92},  {249, 121, 93},
     {252, 137, 97},  {253, 152, 105}, {254, 167, 114}, {254, 182, 124}, {254, 196, 136}, {254, 211, 149},
     {253, 226, 163}, {252, 240, 178}, {252, 253, 191}}};
constexpr Points kViridis = {{{68, 1, 84},    {71, 13, 96},   {72, 24, 106},  {72, 35, 116},  {71, 45, 123},
                              {69, 55, 129},  {66, 64, 134},  {62, 73, 137},  {59, 82, 139},  {55, 91, 141},
                              {51, 99, 141},  {47, 107, 142}, {44, 114, 142}, {41, 122, 142}, {38, 130, 142},
                              {35, 137, 142}, {33, 145, 140}, {31, 152, 139}, {31, 160, 136}, {34, 167, 133},
                              {40, 174, 128}, {50, 182, 122}, {63, 188, 115}, {78, 195, 107}, {94, 201, 98},
                              {112, 207, 87}, {132, 212, 75}, {152, 216, 62}, {173, 220, 48}, {194, 223, 35},
                              {216, 226, 25}, {236, 229, 27}, {253, 231, 37}}};

Rgb8 between(const std::uint8_t* a, const std::uint8_t* b, double share) {
  const auto mix = [&](int i) {
    const double value = static_cast<double>(a[i]) + share * (static_cast<double>(b[i]) - a[i]);
    return static_cast<std::uint8_t>(value + 0.5);
  };
  return {mix(0), mix(1), mix(2)};
}

/// `share` in [0,1]. The points stand at multiples of 8 of 256 colours, the last one at 255.
Rgb8 along(const Points& points, double share) {
  const double colour = share * 255;
  const std::size_t first = colour < 248 ? static_cast<std::size_t>(colour / 8) : 31;
  const double start = 8 * static_cast<double>(first);
  const double end = first == 31 ? 255 : start + 8;
  return between(points[first].data(), points[first + 1].data(), (colour - start) / (end - start));
}

// Blue and red of equal lightness, darker towards the ends.
constexpr std::uint8_t kDiverging[5][3] = {
    {5, 48, 97}, {67, 147, 195}, {247, 247, 247}, {214, 96, 77}, {103, 0, 31}};

Rgb8 diverging(double share) {
  const double place = share * 4;
  const std::size_t first = place < 3 ? static_cast<std::size_t>(place) : 3;
  return between(kDiverging[first], kDiverging[first + 1], place - static_cast<double>(first));
}

}  // namespace

Rgb8 map_colour(ColourMap map, double share) {
  // Negated, so that NaN is caught.
  double clipped = !(share > 0) ? 0 : share;
  clipped = clipped < 1 ? clipped : 1.0;
  switch (map) {
    case ColourMap::magma:
      return along(kMagma, clipped);
    case ColourMap::viridis:
      return along(kViridis, clipped);
    case ColourMap::diverging:
      return diverging(clipped);
    case ColourMap::grey: {
      const auto value = static_cast<std::uint8_t>(clipped * 255 + 0.5);
      return {value, value, value};
    }
  }
  return {};
}

}  // namespace mlt
