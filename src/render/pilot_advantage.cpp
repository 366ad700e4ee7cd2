#include <algorithm>
#include <array>
#include <span>
#include <utility>
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

/// One channel of a film, rows from top to bottom.
struct Plane {
  std::size_t width, height;
  std::vector<double> values;
};

/// Means of up to `reach` items on both sides, in place in a line of items `stride` apart. `line` is room for
/// as many.
void blur_line(double* items, std::size_t stride, std::size_t reach, std::span<double> line) {
  for (std::size_t i = 0; i < line.size(); ++i) line[i] = items[i * stride];
  for (std::size_t i = 0; i < line.size(); ++i) {
    const std::size_t low = i < reach ? 0 : i - reach, high = std::min(i + reach, line.size() - 1);
    double sum = 0;
    for (std::size_t j = low; j <= high; ++j) sum += line[j];
    items[i * stride] = sum / static_cast<double>(high - low + 1);
  }
}

/// Means over squares of 2 `reach` + 1 pixels, less what lies outside.
Plane blurred(Plane plane, std::size_t reach) {
  std::vector<double> line(std::max(plane.width, plane.height));
  for (std::size_t y = 0; y < plane.height; ++y) {
    blur_line(&plane.values[y * plane.width], 1, reach, {line.data(), plane.width});
  }
  for (std::size_t x = 0; x < plane.width; ++x) {
    blur_line(&plane.values[x], plane.width, reach, {line.data(), plane.height});
  }
  return plane;
}

/// The radiance that errors are relative to. It must be the same for both, and may not come from a pixel
/// alone: divided by its own image, noisy as a pilot is, PSSMLT looked up to 25 times too good. The means
/// over many pixels hold where light is smooth. Over few pixels they limit what one lucky path adds. Where
/// both images agree, to a pixel, on more, there is a small lamp or its mirror image, whose radiance is known
/// well.
Plane common_radiance(const ImageBuffer& a, const ImageBuffer& b, int channel) {
  Plane near{a.width, a.height, std::vector<double>(a.pixels.size())};
  const auto value = [channel](const ImageBuffer& image, std::size_t i) {
    return static_cast<double>(image.pixels[i][channel]);
  };
  for (std::size_t i = 0; i < near.values.size(); ++i) near.values[i] = 0.5 * (value(a, i) + value(b, i));
  const Plane far = blurred(near, kFarReach);
  near = blurred(std::move(near), kNearReach);
  for (std::size_t i = 0; i < near.values.size(); ++i) {
    near.values[i] = std::max({far.values[i], near.values[i], std::min(value(a, i), value(b, i))});
  }
  return near;
}

/// The mean but for the largest, kLeftOut of all: each may be one lucky path.
double mean_relative_error(const ImageBuffer& variances, const std::array<Plane, 3>& radiance) {
  const std::size_t pixels = variances.pixels.size();
  std::vector<double> errors(3 * pixels);
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const double value = radiance[i / pixels].values[i % pixels];
    const double variance = variances.pixels[i % pixels][static_cast<int>(i / pixels)];
    errors[i] = variance / (value * value + kRelativeErrorOffset);
  }
  std::sort(errors.begin(), errors.end());
  const std::size_t kept = errors.size() - errors.size() / kLeftOut;
  double sum = 0;
  for (std::size_t i = 0; i < kept; ++i) sum += errors[i];
  return sum / static_cast<double>(kept);
}

struct RelativeErrors {
  double a, b;
};

/// One after the other and by channels, so that little is in memory at a time: a pilot may not need more than
/// the job does.
RelativeErrors relative_errors(const PilotRender& a, const PilotRender& b) {
  MLT_CHECK(a.image.width == b.image.width && a.image.height == b.image.height);
  std::array<Plane, 3> radiance;
  for (int c = 0; c < 3; ++c) radiance[static_cast<std::size_t>(c)] = common_radiance(a.image, b.image, c);
  return {mean_relative_error(a.variances, radiance), mean_relative_error(b.variances, radiance)};
}

double samples_per_path(const PilotRender& render) {
  return render.primary_samples / render.paths;
}

}  // namespace

double pilot_advantage(const PilotRender& path, const PilotRender& pssmlt, bool several_lobes) {
  const RelativeErrors errors = relative_errors(path, pssmlt);
  const double path_work = errors.a * path.per_pixel * samples_per_path(path);
  const double chain_work = errors.b * pssmlt.per_pixel * samples_per_path(pssmlt) *
                            (several_lobes ? kChainCostOfLobes * kUnseenOfLobes : kChainCost);
  // A film without noise, of light that is seen directly, leaves nothing to gain.
  return path_work > 0.0 && chain_work > 0.0 ? path_work / chain_work : 0.0;
}

double pilot_error_ratio(const PilotRender& a, const PilotRender& b) {
  const RelativeErrors errors = relative_errors(a, b);
  return errors.b > 0.0 ? errors.a / errors.b : 1.0;
}

}  // namespace mlt
