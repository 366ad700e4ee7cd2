#include "compare/drawing.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace mlt {
namespace {

bool near(const Rgb8& colour, double r, double g, double b) {
  const auto off = [](std::uint8_t value, double expected) { return std::fabs(value - 255 * expected); };
  // The maps' points are rounded to bytes, and lines between them are right to 2/255.
  return off(colour.r, r) <= 2.5 && off(colour.g, g) <= 2.5 && off(colour.b, b) <= 2.5;
}

TEST_CASE("magma and viridis pass through the published colours") {
  // Entries of the published tables of 256 colours, most of them between the points that are stored.
  CHECK(near(map_colour(ColourMap::magma, 0), 0.001462, 0.000466, 0.013866));
  CHECK(near(map_colour(ColourMap::magma, 4 / 255.0), 0.005950, 0.004843, 0.037130));
  CHECK(near(map_colour(ColourMap::magma, 100 / 255.0), 0.538, 0.157, 0.506));
  CHECK(near(map_colour(ColourMap::magma, 180 / 255.0), 0.969680, 0.446936, 0.360311));
  CHECK(near(map_colour(ColourMap::magma, 1), 0.987053, 0.991438, 0.749504));
  CHECK(near(map_colour(ColourMap::viridis, 0), 0.267004, 0.004874, 0.329415));
  CHECK(near(map_colour(ColourMap::viridis, 148 / 255.0), 0.124780, 0.640461, 0.527068));
  CHECK(near(map_colour(ColourMap::viridis, 244 / 255.0), 0.886271, 0.892374, 0.095374));
  CHECK(near(map_colour(ColourMap::viridis, 1), 0.993248, 0.906157, 0.143936));
}

TEST_CASE("every colour map is continuous, clips, and takes NaN") {
  for (const ColourMap map : {ColourMap::magma, ColourMap::viridis, ColourMap::diverging, ColourMap::grey}) {
    Rgb8 before = map_colour(map, 0);
    CHECK(map_colour(map, -1) == before);
    CHECK(map_colour(map, std::numeric_limits<double>::quiet_NaN()) == before);
    CHECK(map_colour(map, 2) == map_colour(map, 1));
    CHECK(map_colour(map, std::numeric_limits<double>::infinity()) == map_colour(map, 1));
    for (int i = 1; i <= 1000; ++i) {
      const Rgb8 colour = map_colour(map, i / 1000.0);
      REQUIRE(std::abs(colour.r - before.r) <= 3);
      REQUIRE(std::abs(colour.g - before.g) <= 3);
      REQUIRE(std::abs(colour.b - before.b) <= 3);
      before = colour;
    }
  }
  CHECK(map_colour(ColourMap::diverging, 0.5) == Rgb8{247, 247, 247});
}

TEST_CASE("round values lie in the range, are few and evenly spaced") {
  CHECK(round_values(0, 1, 7) == std::vector<double>{0, 0.2, 0.4, 0.6000000000000001, 0.8, 1});
  CHECK(round_values(-2, 2, 5) == std::vector<double>{-2, -1, 0, 1, 2});
  CHECK(round_values(0.3, 0.9, 3).size() == 1);
  for (const double scale : {1e-30, 3e-5, 0.7, 12.0, 4e20}) {
    for (const double low : {-1.0, -0.3, 0.0, 0.2}) {
      const std::vector<double> values = round_values(low * scale, scale, 7);
      CAPTURE(scale, low);
      CHECK(values.size() >= 2);
      CHECK(values.size() <= 7);
      CHECK(values.front() >= (low - 1e-6) * scale);
      CHECK(values.back() <= 1.000001 * scale);
    }
  }
}

TEST_CASE("a drawn map holds every number's colour, enlarged when small, and a labelled bar") {
  const std::vector<float> values{0.0f, 0.5f, 1.0f, 0.25f};
  const NumberMap map{2, 2, values, 0, 1, ColourMap::grey, "FLIP"};
  const Picture plain = colour_pixels(map);
  CHECK(plain.bytes == std::vector<std::uint8_t>{0, 0, 0, 128, 128, 128, 255, 255, 255, 64, 64, 64});
  const Picture drawn = draw_map(map);
  CHECK(drawn.bytes.size() == std::size_t{3} * drawn.width * drawn.height);
  const auto pixel = [&drawn](std::uint32_t x, std::uint32_t y) {
    return drawn.bytes[3 * (std::size_t{y} * drawn.width + x)];
  };
  // Each number is 128 pixels a side, below the title's 20 rows and behind a margin of 8.
  CHECK(pixel(8, 20) == 0);
  CHECK(pixel(8 + 127, 20 + 127) == 0);
  CHECK(pixel(8 + 128, 20) == 128);
  CHECK(pixel(8 + 10, 20 + 128) == 255);
  CHECK(pixel(8 + 255, 20 + 255) == 64);
  // The bar goes from the highest value at the top to the lowest.
  CHECK(pixel(8 + 256 + 8 + 5, 21) == 254);
  CHECK(pixel(8 + 256 + 8 + 5, 20 + 254) == 1);
  CHECK(draw_map({2, 2, values, 0, 1, ColourMap::grey, "FLIP"}).bytes == drawn.bytes);
}

TEST_CASE("quantiles and display ranges") {
  const std::vector<float> values{-3, 1, 2, -0.5f, 0};
  CHECK(magnitude_quantile(values, 0) == 0);
  CHECK(magnitude_quantile(values, 0.5) == 1);
  CHECK(magnitude_quantile(values, 1) == 3);
  CHECK(magnitude_quantile({}, 0.5) == 0);
  CHECK(display_range(std::vector<float>{0, 0}) == 1);
  CHECK(display_range(std::vector<float>{-0.3f}) == Approx(0.5));
  CHECK(display_range(std::vector<float>{7}) == Approx(10));
  CHECK(display_range(std::vector<float>{2e-6f}) == Approx(2e-6));
  std::vector<float> outlier(1000, 0.15f);
  outlier[3] = 1e30f;
  CHECK(display_range(outlier) == Approx(0.2));
}

}  // namespace
}  // namespace mlt
