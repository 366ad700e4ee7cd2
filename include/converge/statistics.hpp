// The statistics of error against effort: quantiles, power laws, the effort at which a curve reaches a
// target, and bootstrap intervals over replicates. All in double, with the project's own logarithm and random
// numbers, so that a report says the same everywhere. Nothing here knows of images or integrators.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace mlt {

/// Decimal logarithm of a finite x > 0, absolute error below 1e-13 relative to the result or to 1.
double log10_of(double x);
/// 10^x for |x| <= 300, relative error below 1e-9.
double power_of_10(double x);

/// The quantile at `share` in [0,1], linear between order statistics [Hyndman96 definition 7]: 0 gives the
/// smallest value, 1/2 the median, 1 the largest. At least one value; none may be NaN, infinities may occur.
double quantile(std::vector<double> values, double share);
inline double median(std::vector<double> values) {
  return quantile(std::move(values), 0.5);
}

struct MeanEstimate {
  double mean = 0;
  double standard_error = 0;  ///< of the mean; NaN for a single value
};
MeanEstimate mean_of(std::span<const double> values);

/// y = factor * x^exponent by least squares of log y on log x.
struct PowerLaw {
  double exponent = 0;
  double exponent_error = 0;  ///< standard error from the residuals; NaN for two points, which leave none
  double log10_factor = 0;
};
/// Nothing unless there are two different x; all x and y must be positive and finite.
std::optional<PowerLaw> fit_power_law(std::span<const double> x, std::span<const double> y);

enum class Reach : std::uint8_t {
  kReached,      ///< between two points of the curve
  kBeforeFirst,  ///< the first point is at or below the target already
  kNever         ///< no point is
};
struct Crossing {
  Reach reach = Reach::kNever;
  double x = 0;  ///< kReached: where; kBeforeFirst: 0; kNever: infinity
};
/// Where a curve of points in the order of effort first falls to `target`, straight between points in log x
/// and log y; x positive. A y that is not positive has no logarithm: the target then counts as reached at
/// that point's x.
Crossing find_crossing(std::span<const double> x, std::span<const double> y, double target);

struct Interval {
  double low = 0;
  double high = 0;
};

inline constexpr std::uint32_t kResamples = 2000;
inline constexpr double kCoverage = 0.95;

/// Percentile bootstrap [Efron93 chapter 13]: `statistic` gets kResamples lists of `count` replicate indices
/// drawn with replacement, always the same lists, and the interval holds the middle kCoverage of its values.
/// These may be infinite; NaN are left out, and when none is left both ends are NaN.
Interval bootstrap_interval(std::uint32_t count,
                            const std::function<double(std::span<const std::uint32_t>)>& statistic);

}  // namespace mlt
