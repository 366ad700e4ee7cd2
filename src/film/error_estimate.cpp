#include "film/error_estimate.hpp"

#include <algorithm>
#include <cmath>

namespace mlt {
namespace {

constexpr std::uint32_t kReach = 2;  ///< neighbours within so many columns and rows

/// Calls visit(index) for each pixel around (x, y), itself included.
template <class Visit>
void visit_neighbours(std::uint32_t width, std::uint32_t height, std::uint32_t x, std::uint32_t y,
                      Visit&& visit) {
  const std::uint32_t first_x = x < kReach ? 0 : x - kReach, last_x = std::min(x + kReach, width - 1);
  const std::uint32_t first_y = y < kReach ? 0 : y - kReach, last_y = std::min(y + kReach, height - 1);
  for (std::uint32_t row = first_y; row <= last_y; ++row) {
    for (std::uint32_t column = first_x; column <= last_x; ++column) visit(std::size_t{row} * width + column);
  }
}

/// Mean of the pixels around (x, y), without itself; 0 where there are none.
DVec3 mean_of_neighbours(const ImageView& image, std::uint32_t x, std::uint32_t y) {
  const std::size_t own = std::size_t{y} * image.width + x;
  DVec3 sum{0, 0, 0};
  double count = 0;
  visit_neighbours(image.width, image.height, x, y, [&](std::size_t i) {
    if (i == own) return;
    sum += DVec3{image.pixels[i]};
    count += 1;
  });
  return count > 0 ? sum * (1.0 / count) : sum;
}

}  // namespace

PixelDifferences pixel_differences(const FilmPixel& pixel, double scale) {
  PixelDifferences differences;
  for (int c = 0; c < 3; ++c) {
    const double difference = scale * static_cast<double>(pixel.difference[c]);
    differences.halves[c] = difference * difference;
  }
  return differences;
}

PixelDifferences pixel_differences(const PixelSum& pixel, double scale, std::uint32_t sequences) {
  PixelDifferences differences;
  const double own = scale / sequences;
  differences.has_sequences = sequences > 1;
  for (int c = 0; c < 3; ++c) {
    differences.halves[c] = own * own * pixel.halves[c] * pixel.halves[c];
    if (sequences > 1) differences.sequences[c] = own * own * pixel.sequences[c] * pixel.sequences[c];
  }
  return differences;
}

ErrorSums relative_differences(const ImageView& image, std::uint32_t x, std::uint32_t y,
                               const PixelDifferences& differences) {
  const DVec3 around = mean_of_neighbours(image, x, y);
  ErrorSums sums;
  for (int c = 0; c < 3; ++c) {
    const double weight = 1.0 / (3.0 * (around[c] * around[c] + kRelativeErrorOffset));
    sums.halves += differences.halves[c] * weight;
    sums.paired_sequences += differences.sequences[c] * weight;
  }
  if (differences.has_sequences) sums.paired_halves = sums.halves;
  return sums;
}

std::vector<Vec3> smooth_standard_errors(std::span<const PixelDifferences> differences, double factor,
                                         std::uint32_t width, std::uint32_t height) {
  std::vector<Vec3> errors(differences.size());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    double sums[3] = {0, 0, 0};
    double count = 0;
    visit_neighbours(width, height, static_cast<std::uint32_t>(i % width),
                     static_cast<std::uint32_t>(i / width), [&](std::size_t neighbour) {
                       for (int c = 0; c < 3; ++c) sums[c] += differences[neighbour].halves[c];
                       count += 1;
                     });
    for (int c = 0; c < 3; ++c) errors[i][c] = static_cast<float>(std::sqrt(factor * sums[c] / count));
  }
  return errors;
}

ErrorEstimate estimate_error(std::span<const ErrorSums> blocks, std::uint64_t pixels) {
  ErrorEstimate estimate;
  if (blocks.empty() || pixels == 0) return estimate;
  const double count = static_cast<double>(blocks.size());
  ErrorSums sum;
  for (const ErrorSums& block : blocks) sum.add(block);
  const bool is_paired = sum.paired_halves > 0.0;
  if (is_paired) estimate.factor = sum.paired_sequences / sum.paired_halves;
  // The estimate is halves * sequences / paired halves; to first order, this is what a block adds to it.
  double squares = 0;
  for (const ErrorSums& block : blocks) {
    double deviation = estimate.factor * (block.halves - sum.halves / count);
    if (is_paired) {
      deviation +=
          sum.halves / sum.paired_halves * (block.paired_sequences - estimate.factor * block.paired_halves);
    }
    squares += deviation * deviation;
  }
  estimate.rel_mse = estimate.factor * sum.halves / static_cast<double>(pixels);
  estimate.standard_error = estimate.rel_mse;
  if (blocks.size() > 1) {
    estimate.standard_error = std::sqrt(squares * count / (count - 1.0)) / static_cast<double>(pixels);
  }
  estimate.known = true;
  return estimate;
}

}  // namespace mlt
