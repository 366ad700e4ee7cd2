#include "compare/flip.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <system_error>
#include <thread>

#include "base/assert.hpp"
#include "compare/flip_colour.hpp"
#include "compare/flip_filter.hpp"
#include "math/elementary_double.hpp"

namespace mlt {
namespace {

using namespace flip;

// Rows filtered together: enough that the rows around them, which are filtered twice, are few.
constexpr std::size_t kBandRows = 64;

/// The error of one pixel from what the eye keeps of both pictures [Andersson20 eqs. 9 to 13].
double pixel_error(const FilteredRows& a, const FilteredRows& b, std::size_t i, double largest) {
  const double colour = colour_error(a.colour[i], b.colour[i], largest);
  // Also keeps log(0) out of the power.
  if (colour == 0) return 0;
  const double edge = std::fabs(a.edges[i] - b.edges[i]);
  const double point = std::fabs(a.points[i] - b.points[i]);
  static_assert(kFeatureExponent == 0.5);
  const double feature = std::sqrt(std::max(edge, point) / std::sqrt(2.0));
  return pow_d(colour, feature < 1 ? 1 - feature : 0.0);
}

/// The work of compute_flip: bands of rows, each of which several threads may do; which one does is without
/// influence on the figures.
class BandQueue {
 public:
  BandQueue(const ImageView& image, const ImageView& reference, const FlipOptions& options,
            FlipResult& result)
      : image_(image),
        reference_(reference),
        filters_(make_filters(options.pixels_per_degree)),
        largest_(largest_colour_error()),
        result_(result) {}

  /// Takes bands until none is left.
  void work() {
    BandFilter band(filters_);
    FilteredRows a;
    FilteredRows b;
    for (std::size_t y = next_.fetch_add(kBandRows); y < image_.height; y = next_.fetch_add(kBandRows)) {
      const std::size_t rows = std::min<std::size_t>(kBandRows, image_.height - y);
      float* errors = result_.map.data() + y * image_.width;
      for (std::uint32_t i = 0; i < result_.exposures; ++i) {
        band.filter(Viewed(image_, result_.mode, exposure(i)), y, rows, a);
        band.filter(Viewed(reference_, result_.mode, exposure(i)), y, rows, b);
        for (std::size_t k = 0; k < rows * image_.width; ++k) {
          errors[k] = std::max(errors[k], static_cast<float>(pixel_error(a, b, k, largest_)));
        }
      }
    }
  }

  /// work() in several threads; the first failure is thrown when all have ended.
  void work(std::uint32_t threads) {
    std::vector<std::exception_ptr> failures(threads);
    const auto guarded = [&](std::uint32_t index) {
      try {
        work();
      } catch (...) {
        failures[index] = std::current_exception();
      }
    };
    std::vector<std::thread> others;
    try {
      for (std::uint32_t i = 1; i < threads; ++i) others.emplace_back(guarded, i);
    } catch (const std::system_error&) {
      // The system grants no more threads; those there are take all bands.
    }
    guarded(0);
    for (std::thread& other : others) other.join();
    for (const std::exception_ptr& failure : failures) {
      if (failure) std::rethrow_exception(failure);
    }
  }

 private:
  double exposure(std::uint32_t index) const {
    const double last = std::max(1.0, static_cast<double>(result_.exposures) - 1);
    const double range = result_.stop_exposure - result_.start_exposure;
    return result_.start_exposure + static_cast<double>(index) * (range / last);
  }

  ImageView image_, reference_;
  Filters filters_;
  double largest_;
  FlipResult& result_;
  std::atomic<std::size_t> next_{0};
};

/// Radiance at which the tone-mapped value is 0.85: the root of (A - t C) x^2 + (B - t D) x - t E with the
/// coefficients of the tone map (Viewed::pixel).
double radiance_of_white() {
  constexpr double kT = 0.85;
  constexpr double kA = 0.36 * 2.51 - kT * 0.36 * 2.43;
  constexpr double kB = 0.6 * 0.03 - kT * 0.6 * 0.59;
  constexpr double kC = -kT * 0.14;
  const double half = -0.5 * kB / kA;
  return half + std::sqrt(half * half - kC / kA);
}

/// Number of exposures in a range, its ends included [Andersson21 section 3.2].
std::uint32_t exposure_count(const ExposureRange& range) {
  const double steps = std::ceil(range.stop - range.start);
  MLT_CHECK(steps >= 0 && steps < 1e6);
  return std::max(2U, static_cast<std::uint32_t>(steps));
}

}  // namespace

ExposureRange flip_exposures(const ImageView& reference) {
  std::vector<double> luminances;
  std::vector<double> positive;
  for (const Vec3& pixel : reference.pixels) {
    const double value = (0.2126 * static_cast<double>(pixel.x) + 0.7152 * static_cast<double>(pixel.y)) +
                         0.0722 * static_cast<double>(pixel.z);
    luminances.push_back(value);
    if (value > 0) positive.push_back(value);
  }
  if (positive.empty()) return {};
  const auto median = [](std::vector<double>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  const double brightest = *std::max_element(positive.begin(), positive.end());
  const double of_all = median(luminances);
  const double middle = of_all > 0 ? of_all : median(positive);
  const double white = radiance_of_white();
  return {log_d(white / brightest) / kLn2, log_d(white / middle) / kLn2};
}

FlipResult compute_flip(const ImageView& image, const ImageView& reference, const FlipOptions& options) {
  MLT_CHECK_OP(image.width, ==, reference.width);
  MLT_CHECK_OP(image.height, ==, reference.height);
  MLT_CHECK_OP(image.pixels.size(), ==, std::size_t{image.width} * image.height);
  MLT_CHECK_OP(image.pixels.size(), >, 0u);
  MLT_CHECK_OP(options.start_exposure.has_value(), ==, options.stop_exposure.has_value());
  FlipResult result;
  result.mode = options.mode;
  result.pixels_per_degree = options.pixels_per_degree;
  result.map.assign(image.pixels.size(), 0.0f);
  ExposureRange range{options.exposure, options.exposure};
  if (options.mode == FlipMode::hdr) {
    range = options.start_exposure ? ExposureRange{*options.start_exposure, *options.stop_exposure}
                                   : flip_exposures(reference);
    result.exposures = exposure_count(range);
  }
  result.start_exposure = range.start;
  result.stop_exposure = range.stop;
  const std::uint32_t bands = static_cast<std::uint32_t>((image.height - 1) / kBandRows + 1);
  BandQueue(image, reference, options, result).work(std::clamp(options.threads, 1U, bands));
  double total = 0;
  for (std::uint32_t y = 0; y < image.height; ++y) {
    double row = 0;
    for (std::uint32_t x = 0; x < image.width; ++x) {
      const double error = static_cast<double>(result.map[std::size_t{y} * image.width + x]);
      row += error;
      result.maximum = std::max(result.maximum, error);
    }
    total += row;
  }
  result.mean = total / static_cast<double>(image.pixels.size());
  return result;
}

}  // namespace mlt
