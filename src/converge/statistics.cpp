#include "converge/statistics.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "base/assert.hpp"
#include "math/elementary.hpp"
#include "math/rng.hpp"

namespace mlt {
namespace {

constexpr double kLog10Of2 = 0x1.34413509f79ffp-2;
constexpr double kLog2Of10 = 0x1.a934f0979a371p+1;
constexpr double kLog2Of10Low = 0x1.7f2495fb7fa6dp-53;
constexpr double kLog2E = 0x1.71547652b82fep+0;
constexpr double kNanDouble = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinityDouble = std::numeric_limits<double>::infinity();
constexpr std::uint64_t kResampleSeed = 2020;

double log2_of(double x) {
  // Denormals are brought into the range in which the exponent can be read from the bits.
  const bool tiny = x < 0x1p-1022;
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(tiny ? x * 0x1p+54 : x);
  const double exponent = static_cast<double>(static_cast<std::int64_t>(bits >> 52) - 1023 - (tiny ? 54 : 0));
  const double mantissa =
      std::bit_cast<double>((bits & 0x000fffffffffffffULL) | std::uint64_t{1023} << 52);  // in [1, 2)
  // The kernel takes a float; what rounding lost is added to first order, leaving less than 2^-48.
  const float rounded = static_cast<float>(mantissa);
  const double lost = (mantissa - static_cast<double>(rounded)) / static_cast<double>(rounded);
  return exponent + (detail::log2_kernel(rounded) + lost * kLog2E);
}

}  // namespace

double log10_of(double x) {
  MLT_CHECK(x > 0 && std::isfinite(x));
  return log2_of(x) * kLog10Of2;
}

double power_of_10(double x) {
  MLT_CHECK_OP(std::fabs(x), <=, 300.0);
  return detail::exp2_kernel(x * kLog2Of10 + x * kLog2Of10Low);
}

double quantile(std::vector<double> values, double share) {
  MLT_CHECK(!values.empty());
  MLT_CHECK(share >= 0 && share <= 1);
  for (const double value : values) MLT_CHECK(!std::isnan(value));
  std::sort(values.begin(), values.end());
  const double position = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(position);  // at most size - 1
  const double rest = position - static_cast<double>(below);
  if (rest == 0 || below + 1 == values.size() || values[below] == values[below + 1]) return values[below];
  // A weight of less than one on infinity is still infinity.
  return values[below] * (1 - rest) + values[below + 1] * rest;
}

MeanEstimate mean_of(std::span<const double> values) {
  MLT_CHECK(!values.empty());
  const double count = static_cast<double>(values.size());
  double sum = 0;
  for (const double value : values) sum += value;
  const double mean = sum / count;
  if (values.size() < 2) return {mean, kNanDouble};
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return {mean, std::sqrt(squares / (count - 1) / count)};
}

std::optional<PowerLaw> fit_power_law(std::span<const double> x, std::span<const double> y) {
  MLT_CHECK_OP(x.size(), ==, y.size());
  const double count = static_cast<double>(x.size());
  std::vector<double> u, v;
  double mean_u = 0, mean_v = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    u.push_back(log10_of(x[i]));
    v.push_back(log10_of(y[i]));
    mean_u += u.back() / count;
    mean_v += v.back() / count;
  }
  double uu = 0, uv = 0;
  bool differ = false;
  for (std::size_t i = 0; i < u.size(); ++i) {
    uu += (u[i] - mean_u) * (u[i] - mean_u);
    uv += (u[i] - mean_u) * (v[i] - mean_v);
    differ = differ || x[i] != x[0];
  }
  if (!differ || !(uu > 0)) return std::nullopt;
  PowerLaw law;
  law.exponent = uv / uu;
  law.log10_factor = mean_v - law.exponent * mean_u;
  double residuals = 0;
  for (std::size_t i = 0; i < u.size(); ++i) {
    const double residual = v[i] - law.log10_factor - law.exponent * u[i];
    residuals += residual * residual;
  }
  law.exponent_error = u.size() > 2 ? std::sqrt(residuals / (count - 2) / uu) : kNanDouble;
  return law;
}

Crossing find_crossing(std::span<const double> x, std::span<const double> y, double target) {
  MLT_CHECK_OP(x.size(), ==, y.size());
  MLT_CHECK_OP(target, >, 0.0);
  std::size_t at = 0;
  while (at < y.size() && !(y[at] <= target)) ++at;
  if (at == y.size()) return {Reach::kNever, kInfinityDouble};
  if (at == 0) return {Reach::kBeforeFirst, 0};
  if (!(y[at] > 0)) return {Reach::kReached, x[at]};
  const double before = log10_of(y[at - 1]);
  const double share = (before - log10_of(target)) / (before - log10_of(y[at]));
  const double from = log10_of(x[at - 1]);
  return {Reach::kReached, power_of_10(from + share * (log10_of(x[at]) - from))};
}

Interval bootstrap_interval(std::uint32_t count,
                            const std::function<double(std::span<const std::uint32_t>)>& statistic) {
  MLT_CHECK_OP(count, >, 0u);
  std::vector<double> values;
  std::vector<std::uint32_t> chosen(count);
  for (std::uint32_t resample = 0; resample < kResamples; ++resample) {
    Rng rng(kResampleSeed, StreamPurpose::kResampling, resample);
    for (std::uint32_t& index : chosen) {
      index = static_cast<std::uint32_t>(std::uint64_t{rng.next_fixed()} * count >> 32);
    }
    const double value = statistic(chosen);
    if (!std::isnan(value)) values.push_back(value);
  }
  if (values.empty()) return {kNanDouble, kNanDouble};
  return {quantile(values, 0.5 - 0.5 * kCoverage), quantile(values, 0.5 + 0.5 * kCoverage)};
}

}  // namespace mlt
