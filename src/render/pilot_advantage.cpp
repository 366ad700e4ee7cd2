#include <algorithm>
#include <vector>

#include "base/assert.hpp"
#include "film/error_estimate.hpp"
#include "render/pilot.hpp"

namespace mlt {
namespace {

/// Processor time a primary sample, of PSSMLT over the path tracer: 0.87 to 1.05 on six scenes where light is
/// hard to find, the bootstrap included (docs/RESULTS.md), and a little more, for most pilots miss some
/// errors of chains. What else a path costs is in proportion to its primary samples.
constexpr double kChainCost = 1.1;
/// The same of materials with several lobes, whose paths differ most in length: chains' lanes wait for the
/// longest, while the path tracer's are moved together.
constexpr double kChainCostOfLobes = 1.4;
/// There most pilots' chains have not met the brightest caustics: the error of whole jobs is 0.9 to 2.7 times
/// what they show.
constexpr double kUnseenOfLobes = 1.5;
/// Neighbours in how many rows and columns on each side tell a pixel's radiance.
constexpr std::size_t kFarReach = 8;
constexpr std::size_t kNearReach = 2;
/// One in so many pixels is left out, those of the largest errors. Where a small lamp is seen, one of the
/// path tracer's samples that hits it would otherwise outweigh all others, and most pilots have none.
constexpr std::size_t kLeftOut = 2000;

/// Three channels a pixel, rows from top to bottom.
struct Plane {
  std::uint32_t width, height;
  std::vector<double> values;
};

/// To a film of width x height pixels, which is not larger: the means of those that lie in each.
Plane reduced(const ImageView& image, std::uint32_t width, std::uint32_t height) {
  MLT_CHECK(width <= image.width && height <= image.height);
  Plane result{width, height, std::vector<double>(std::size_t{width} * height * 3)};
  std::vector<double> counts(std::size_t{width} * height);
  for (std::uint32_t y = 0; y < image.height; ++y) {
    const std::size_t row = std::size_t{y} * height / image.height * width;
    for (std::uint32_t x = 0; x < image.width; ++x) {
      const std::size_t target = row + std::size_t{x} * width / image.width;
      const Vec3& pixel = image.pixels[std::size_t{y} * image.width + x];
      counts[target] += 1;
      for (int c = 0; c < 3; ++c) result.values[target * 3 + static_cast<std::size_t>(c)] += pixel[c];
    }
  }
  for (std::size_t i = 0; i < result.values.size(); ++i) result.values[i] /= counts[i / 3];
  return result;
}

/// Means of up to `reach` items on both sides, in a line of `count` items `stride` apart.
void blur_line(const std::vector<double>& from, std::vector<double>& to, std::size_t first, std::size_t count,
               std::size_t stride, std::size_t reach) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t low = i < reach ? 0 : i - reach, high = std::min(i + reach, count - 1);
    double sum = 0;
    for (std::size_t j = low; j <= high; ++j) sum += from[first + j * stride];
    to[first + i * stride] = sum / static_cast<double>(high - low + 1);
  }
}

/// Means over squares of 2 `reach` + 1 pixels, less what lies outside.
Plane blurred(const Plane& plane, std::size_t reach) {
  Plane rows = plane, result = plane;
  const std::size_t row = std::size_t{plane.width} * 3;
  for (std::size_t y = 0; y < plane.height; ++y) {
    for (std::size_t c = 0; c < 3; ++c) {
      blur_line(plane.values, rows.values, y * row + c, plane.width, 3, reach);
    }
  }
  for (std::size_t i = 0; i < row; ++i) blur_line(rows.values, result.values, i, plane.height, row, reach);
  return result;
}

/// The radiance that errors are relative to. It must be the same for both, and may not come from a pixel
/// alone: divided by its own image, noisy as a pilot is, PSSMLT looked up to 25 times too good. The means
/// over many pixels hold where light is smooth. Over few pixels they limit what one lucky path adds. Where
/// both images agree, to a pixel, on more, there is a small lamp or its mirror image, whose radiance is known
/// well.
Plane common_radiance(const Plane& path, const Plane& pssmlt) {
  Plane pooled = path;
  for (std::size_t i = 0; i < pooled.values.size(); ++i) {
    pooled.values[i] = 0.5 * (path.values[i] + pssmlt.values[i]);
  }
  const Plane far = blurred(pooled, kFarReach), near = blurred(pooled, kNearReach);
  for (std::size_t i = 0; i < pooled.values.size(); ++i) {
    const double agreed = std::min(path.values[i], pssmlt.values[i]);
    pooled.values[i] = std::max({far.values[i], near.values[i], agreed});
  }
  return pooled;
}

/// The mean but for the largest, kLeftOut of all: each may be one lucky path.
double mean_relative_error(const Plane& variances, const Plane& radiance) {
  std::vector<double> errors(variances.values.size());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    errors[i] = variances.values[i] / (radiance.values[i] * radiance.values[i] + kRelativeErrorOffset);
  }
  std::sort(errors.begin(), errors.end());
  const std::size_t kept = errors.size() - errors.size() / kLeftOut;
  double sum = 0;
  for (std::size_t i = 0; i < kept; ++i) sum += errors[i];
  return sum / static_cast<double>(kept);
}

double samples_per_path(const PilotRender& render) {
  return render.primary_samples / render.paths;
}

}  // namespace

ImageBuffer reduced_image(const ImageView& image, std::uint32_t width, std::uint32_t height) {
  const Plane plane = reduced(image, width, height);
  ImageBuffer result{width, height, std::vector<Vec3>(std::size_t{width} * height)};
  for (std::size_t i = 0; i < plane.values.size(); ++i)
    result.pixels[i / 3][static_cast<int>(i % 3)] = static_cast<float>(plane.values[i]);
  return result;
}

double pilot_advantage(const PilotRender& path, const PilotRender& pssmlt, bool several_lobes) {
  const std::uint32_t width = path.image.width, height = path.image.height;
  const auto plane_of = [&](const ImageBuffer& image) { return reduced(image.view(), width, height); };
  const Plane radiance = common_radiance(plane_of(path.image), plane_of(pssmlt.image));
  const double path_work =
      mean_relative_error(plane_of(path.variances), radiance) * path.per_pixel * samples_per_path(path);
  const double chain_work = mean_relative_error(plane_of(pssmlt.variances), radiance) * pssmlt.per_pixel *
                            samples_per_path(pssmlt) *
                            (several_lobes ? kChainCostOfLobes * kUnseenOfLobes : kChainCost);
  // A film without noise, of light that is seen directly, leaves nothing to gain.
  return path_work > 0.0 && chain_work > 0.0 ? path_work / chain_work : 0.0;
}

double pilot_error_ratio(const PilotRender& a, const PilotRender& b) {
  const auto plane_of = [](const ImageBuffer& image) {
    return reduced(image.view(), image.width, image.height);
  };
  const Plane radiance = common_radiance(plane_of(a.image), plane_of(b.image));
  const double error = mean_relative_error(plane_of(b.variances), radiance);
  return error > 0.0 ? mean_relative_error(plane_of(a.variances), radiance) / error : 1.0;
}

}  // namespace mlt
