#include "compare/replicates.hpp"

#include <algorithm>
#include <array>

#include "base/assert.hpp"
#include "compare/drawing.hpp"
#include "compare/statistics.hpp"
#include "math/elementary_double.hpp"
#include "math/rng.hpp"

namespace mlt {
namespace {

constexpr std::size_t kLuminance = 3;  // behind the three channels
// All ways to deal up to 6 and 6 replicates (924); of more, this many at random.
constexpr std::size_t kMostRelabellings = 1000;

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

/// Of the means of a set's images, each channel by itself.
std::array<SampleMoments, 3> image_moments(std::span<const ImageView> images) {
  std::array<std::vector<double>, 3> samples;
  for (const ImageView& image : images) {
    const TileMeans means = tile_means(image, {0, 0, image.width, image.height});
    for (std::size_t channel = 0; channel < 3; ++channel) samples[channel].push_back(means[channel]);
  }
  return {sample_moments(samples[0]), sample_moments(samples[1]), sample_moments(samples[2])};
}

/// P-value of the image means of all channels together.
double image_p_value(std::span<const ImageView> first, std::span<const ImageView> second) {
  const std::array<SampleMoments, 3> a = image_moments(first);
  const std::array<SampleMoments, 3> b = image_moments(second);
  double smallest = 1;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    smallest = std::min(smallest, welch_test(a[channel], b[channel]).p_value);
  }
  return sidak_p_value(smallest, 3);
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
    const Tile whole{0, 0, first.front().width, first.front().height};
    for (std::size_t set = 0; set < 2; ++set) {
      for (const ImageView& image : sets_[set]) whole_[set].push_back(tile_means(image, whole)[kLuminance]);
    }
  }

  /// Moments over the replicates of one set, of each channel; appends their shares in the image's luminance.
  std::array<SampleMoments, 3> moments(std::size_t set, const Tile& tile, std::vector<double>& shares) {
    std::array<std::vector<double>, 3> samples;
    for (std::size_t k = 0; k < sets_[set].size(); ++k) {
      const TileMeans means = tile_means(sets_[set][k], tile);
      shares.push_back(whole_[set][k] != 0 ? means[kLuminance] / whole_[set][k] : 0.0);
      for (std::size_t i = 0; i < 3; ++i) samples[i].push_back(means[i]);
    }
    return {sample_moments(samples[0]), sample_moments(samples[1]), sample_moments(samples[2])};
  }

  /// The tile's smallest p-value over the channels; keeps its shares for the test of all.
  double run(const Tile& tile, ReplicateTestResult& result) {
    std::vector<double> shares;
    const std::array<SampleMoments, 3> a = moments(0, tile, shares);
    const std::array<SampleMoments, 3> b = moments(1, tile, shares);
    if (sample_moments(shares).variance > 0) shares_.push_back(shares);
    double smallest = 1;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      if (!tells(a[channel], b[channel])) continue;
      ++result.tests;
      smallest = std::min(smallest, welch_test(a[channel], b[channel]).p_value);
    }
    return smallest;
  }

  /// Of each tile whose share varies: that of each replicate, the first set's first.
  const std::vector<std::vector<double>>& shares() const { return shares_; }

 private:
  std::array<std::span<const ImageView>, 2> sets_;
  std::array<std::vector<double>, 2> whole_;  ///< luminance of each replicate
  std::vector<std::vector<double>> shares_;
};

/// Distance of the tiles' p-values when the replicates marked true are the first set.
double relabelled_distance(const std::vector<std::vector<double>>& tiles, const std::vector<bool>& in_first) {
  std::vector<double> p_values;
  std::vector<double> sets[2];
  for (const std::vector<double>& shares : tiles) {
    for (std::vector<double>& set : sets) set.clear();
    for (std::size_t k = 0; k < shares.size(); ++k) sets[in_first[k] ? 0 : 1].push_back(shares[k]);
    p_values.push_back(welch_test(sample_moments(sets[0]), sample_moments(sets[1])).p_value);
  }
  return ks_small_test(p_values).distance;
}

/// Ways to choose `part` of `all`, or a number above kMostRelabellings.
std::size_t choices(std::size_t all, std::size_t part) {
  double count = 1;
  for (std::size_t i = 1; i <= part; ++i)
    count = count * static_cast<double>(all - part + i) / static_cast<double>(i);
  const double most = static_cast<double>(kMostRelabellings) + 1;
  return static_cast<std::size_t>(std::min(count, most) + 0.5);
}

/// Deals the replicates into two sets in all ways, or in as many random ones as are allowed.
void test_by_relabelling(const std::vector<std::vector<double>>& tiles, std::size_t part, std::size_t all,
                         ReplicateTestResult& result) {
  std::vector<bool> given(all, false);
  std::fill(given.begin(), given.begin() + static_cast<std::ptrdiff_t>(part), true);
  result.relabellings = 1;
  if (tiles.empty()) return;
  result.ks_distance = relabelled_distance(tiles, given);
  const bool every = choices(all, part) <= kMostRelabellings;
  std::uint64_t reached = 1;
  std::vector<bool> labels = given;
  Rng rng(0, StreamPurpose::kRelabelling, 0);
  // In descending order the given labels come first.
  while (every ? std::prev_permutation(labels.begin(), labels.end())
               : result.relabellings < kMostRelabellings) {
    for (std::size_t i = all; !every && i > 1; --i) {
      const std::size_t j = static_cast<std::size_t>(std::uint64_t{rng.next_fixed()} * i >> 32);
      std::vector<bool>::swap(labels[i - 1], labels[j]);
    }
    ++result.relabellings;
    // Labels exchanged give the same distance but for rounding.
    if (relabelled_distance(tiles, labels) >= result.ks_distance * (1 - 1e-9)) ++reached;
  }
  result.ks_p_value = static_cast<double>(reached) / static_cast<double>(result.relabellings);
}

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
  test_by_relabelling(test.shares(), first.size(), first.size() + second.size(), result);
  result.mean_p_value = image_p_value(first, second);
  // Three tests, each at a level by which all pass with probability 1 - alpha [Sidak67].
  result.level = sidak_level(options.alpha, 3);
  result.rejected = result.mean_p_value < result.level || result.sidak_p_value < result.level ||
                    result.ks_p_value < result.level;
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
