#include "compare/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/assert.hpp"
#include "math/elementary_double.hpp"

namespace mlt {
namespace {

/// Lentz's evaluation of the continued fraction of the incomplete beta function.
double beta_fraction(double a, double b, double x) {
  constexpr int kMaxSteps = 10000;
  constexpr double kTiny = 1e-300;  // keeps off a division by zero
  const auto off_zero = [](double value) { return std::fabs(value) < kTiny ? kTiny : value; };
  double c = 1;
  double d = 1 / off_zero(1 - (a + b) * x / (a + 1));
  double result = d;
  for (int step = 1; step < kMaxSteps; ++step) {
    const double m = step;
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    double factor = 1;
    for (const double numerator : {even, odd}) {
      d = 1 / off_zero(1 + numerator * d);
      c = off_zero(1 + numerator / c);
      factor = c * d;
      result *= factor;
    }
    if (std::fabs(factor - 1) < 1e-16) break;
  }
  return result;
}

}  // namespace

double log_gamma(double x) {
  MLT_CHECK(x > 0);
  // Stirling's series from 15 on; below that by Gamma(x) = Gamma(x + n) / (x (x + 1) ...).
  double product = 1;
  while (x < 15) {
    product *= x;
    x += 1;
  }
  const double inverse = 1 / x;
  const double square = inverse * inverse;
  double series = -691.0 / 360360;
  for (const double term : {1.0 / 1188, -1.0 / 1680, 1.0 / 1260, -1.0 / 360, 1.0 / 12}) {
    series = term + square * series;
  }
  constexpr double kHalfLogTwoPi = 0x1.d67f1c864beb5p-1;
  return ((x - 0.5) * log_d(x) - x + kHalfLogTwoPi + inverse * series) - log_d(product);
}

double regularised_beta(double a, double b, double x) {
  MLT_CHECK(a > 0 && b > 0 && x >= 0 && x <= 1);
  if (x == 0 || x == 1) return x;
  const double front =
      exp_d(((log_gamma(a + b) - log_gamma(a)) - log_gamma(b)) + (a * log_d(x) + b * log1p_d(-x)));
  // The fraction converges fast only on this side of the mean.
  if (x < (a + 1) / (a + b + 2)) return front * beta_fraction(a, b, x) / a;
  return 1 - front * beta_fraction(b, a, 1 - x) / b;
}

double student_tail(double t, double dof) {
  MLT_CHECK(dof > 0);
  const double square = t * t;
  if (!(square <= std::numeric_limits<double>::max())) return 0;
  return std::clamp(regularised_beta(0.5 * dof, 0.5, dof / (dof + square)), 0.0, 1.0);
}

SampleMoments sample_moments(std::span<const double> samples) {
  SampleMoments result;
  result.count = samples.size();
  if (samples.empty()) return result;
  const double count = static_cast<double>(samples.size());
  double sum = 0;
  for (const double sample : samples) sum += sample;
  result.mean = sum / count;
  double squares = 0;
  for (const double sample : samples) squares += (sample - result.mean) * (sample - result.mean);
  if (samples.size() > 1) result.variance = squares / (count - 1);
  // Equal samples have a mean that may differ from them by rounding, but do not vary.
  const bool constant = std::all_of(samples.begin(), samples.end(),
                                    [&samples](double sample) { return sample == samples.front(); });
  if (constant) result = {samples.size(), samples.front(), 0};
  return result;
}

WelchResult welch_test(const SampleMoments& a, const SampleMoments& b) {
  MLT_CHECK_OP(a.count, >=, 2u);
  MLT_CHECK_OP(b.count, >=, 2u);
  const double va = a.variance / static_cast<double>(a.count);
  const double vb = b.variance / static_cast<double>(b.count);
  const double sum = va + vb;
  WelchResult result;
  result.dof = static_cast<double>(a.count + b.count - 2);
  if (!(sum > 0)) {
    result.p_value = a.mean == b.mean ? 1 : 0;
    if (a.mean != b.mean) result.t = std::copysign(std::numeric_limits<double>::infinity(), a.mean - b.mean);
    return result;
  }
  // Shares of the sum, whose squares do not underflow.
  const double sa = va / sum;
  const double sb = vb / sum;
  result.dof = 1 / (sa * sa / static_cast<double>(a.count - 1) + sb * sb / static_cast<double>(b.count - 1));
  result.t = (a.mean - b.mean) / std::sqrt(sum);
  result.p_value = student_tail(result.t, result.dof);
  return result;
}

double sidak_p_value(double smallest, std::size_t tests) {
  MLT_CHECK(smallest >= 0 && smallest <= 1);
  if (smallest == 1) return 1;
  return -expm1_d(static_cast<double>(tests) * log1p_d(-smallest));
}

double sidak_level(double alpha, std::size_t tests) {
  MLT_CHECK(alpha > 0 && alpha < 1);
  MLT_CHECK_OP(tests, >=, 1u);
  return -expm1_d(log1p_d(-alpha) / static_cast<double>(tests));
}

UniformResult ks_small_test(std::span<const double> p_values) {
  UniformResult result;
  if (p_values.empty()) return result;
  std::vector<double> sorted(p_values.begin(), p_values.end());
  std::sort(sorted.begin(), sorted.end());
  const double count = static_cast<double>(sorted.size());
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    result.distance = std::max(result.distance, static_cast<double>(i + 1) / count - sorted[i]);
  }
  const double root = std::sqrt(count);
  const double scaled = (root + 0.12 + 0.11 / root) * result.distance;
  result.p_value = std::min(1.0, exp_d(-2 * scaled * scaled));
  return result;
}

}  // namespace mlt
