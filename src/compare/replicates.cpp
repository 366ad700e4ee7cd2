#include "compare/replicates.hpp"

#include <algorithm>
#include <array>

#include "base/assert.hpp"
#include "compare/drawing.hpp"
#include "compare/statistics.hpp"
#include "math/elementary_double.hpp"

namespace mlt {
namespace {

constexpr std::size_t kLuminance = 3;  // behind the three channels

using TileMeans = std::array<double, 4>;

/// A tile of the picture's grid, in pixels.
struct Tile {
  std::uint32_t x0, y0, x1, y1;
};

TileMeans tile_means(const ImageView& image, const Tile& tile) {
  TileMeans means{};
  for (std::uint32_t y = tile.y0; y < tile.y1; ++y) {
    double row[3] = {};
    for (std::uint32_t x = tile.x0; x < tile.x1; ++x) {
      const Vec3& pixel = image.pixels[std::size_t{y} * image.width + x];
      for (int channel = 0; channel < 3; ++channel) row[channel] += static_cast<double>(pixel[channel]);
    }
    for (std::size_t channel = 0; channel < 3; ++channel) means[channel] += row[channel];
  }
  const double count = static_cast<double>(tile.x1 - tile.x0) * static_cast<double>(tile.y1 - tile.y0);
  for (std::size_t channel = 0; channel < 3; ++channel) means[channel] /= count;
  means[kLuminance] = (0.2126 * means[0] + 0.7152 * means[1]) + 0.0722 * means[2];
  return means;
}

/// Whether a test of these says anything: something varies or differs.
bool tells(const SampleMoments& a, const SampleMoments& b) {
  return a.variance > 0 || b.variance > 0 || a.mean != b.mean;
}

class TileTest {
 public:
  TileTest(std::span<const ImageView> first, std::span<const ImageView> second) {
    sets_[0] = first;
    sets_[1] = second;
  }

  /// Moments over the replicates of one set, of each channel and of the luminance.
  std::array<SampleMoments, 4> moments(std::size_t set, const Tile& tile) {
    std::array<std::vector<double>, 4> samples;
    for (const ImageView& image : sets_[set]) {
      const TileMeans means = tile_means(image, tile);
      for (std::size_t i = 0; i < 4; ++i) samples[i].push_back(means[i]);
    }
    std::array<SampleMoments, 4> result;
    for (std::size_t i = 0; i < 4; ++i) result[i] = sample_moments(samples[i]);
    return result;
  }

  /// The tile's smallest p-value over the channels; keeps that of the luminance for the test of all.
  double run(const Tile& tile, ReplicateTestResult& result) {
    const std::array<SampleMoments, 4> a = moments(0, tile);
    const std::array<SampleMoments, 4> b = moments(1, tile);
    double smallest = 1;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      if (!tells(a[channel], b[channel])) continue;
      ++result.tests;
      smallest = std::min(smallest, welch_test(a[channel], b[channel]).p_value);
    }
    if (tells(a[kLuminance], b[kLuminance])) {
      luminance_.push_back(welch_test(a[kLuminance], b[kLuminance]).p_value);
    }
    return smallest;
  }

  const std::vector<double>& luminance() const { return luminance_; }

 private:
  std::array<std::span<const ImageView>, 2> sets_;
  std::vector<double> luminance_;
};

}  // namespace

ReplicateTestResult test_replicates(std::span<const ImageView> first, std::span<const ImageView> second,
                                    const ReplicateTestOptions& options) {
  MLT_CHECK_OP(first.size(), >=, 2u);
  MLT_CHECK_OP(second.size(), >=, 2u);
  MLT_CHECK_OP(options.tile, >=, 1u);
  MLT_CHECK(options.alpha > 0 && options.alpha < 1);
  const ImageView& shape = first.front();
  for (const auto& set : {first, second}) {
    for (const ImageView& image : set) MLT_CHECK(image.width == shape.width && image.height == shape.height);
  }
  const std::uint32_t side = options.tile;
  ReplicateTestResult result;
  result.tiles_x = (shape.width - 1) / side + 1;
  result.tiles_y = (shape.height - 1) / side + 1;
  TileTest test(first, second);
  for (std::uint32_t j = 0; j < result.tiles_y; ++j) {
    for (std::uint32_t i = 0; i < result.tiles_x; ++i) {
      const std::uint32_t x = i * side;
      const std::uint32_t y = j * side;
      const Tile tile{x, y, x + std::min(side, shape.width - x), y + std::min(side, shape.height - y)};
      const double p = test.run(tile, result);
      result.p_values.push_back(p);
      if (p < result.smallest_p_value) {
        result.smallest_p_value = p;
        result.smallest_x = x;
        result.smallest_y = y;
      }
    }
  }
  result.sidak_p_value = sidak_p_value(result.smallest_p_value, result.tests);
  const UniformResult uniform = ks_small_test(test.luminance());
  result.ks_distance = uniform.distance;
  result.ks_p_value = uniform.p_value;
  // Two tests, each at a level by which both pass with probability 1 - alpha [Sidak67].
  result.level = sidak_level(options.alpha, 2);
  result.rejected = result.sidak_p_value < result.level || result.ks_p_value < result.level;
  return result;
}

Picture draw_p_values(const ReplicateTestResult& result, std::uint32_t width, std::uint32_t height,
                      std::uint32_t tile) {
  MLT_CHECK_OP(result.p_values.size(), ==, std::size_t{result.tiles_x} * result.tiles_y);
  constexpr double kMost = 8;
  std::vector<float> values;
  values.reserve(std::size_t{width} * height);
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      const double p = result.p_values[std::size_t{y / tile} * result.tiles_x + x / tile];
      const double digits = p > 0 ? -log_d(p) / kLn10 : kMost;
      values.push_back(static_cast<float>(std::clamp(digits, 0.0, kMost)));
    }
  }
  return draw_map({width, height, values, 0, kMost, ColourMap::viridis, "-log10 p of tiles"});
}

}  // namespace mlt
