// The hypothesis tests behind `mlt compare --test`, in double and without the C library's functions, so that
// p-values too are the same bits everywhere. Every p-value is the probability, when nothing differs, of data
// at least as extreme as those seen.
#pragma once

#include <cstddef>
#include <span>

namespace mlt {

/// log Gamma(x) for x > 0, error below 1e-14 (1 + |log Gamma(x)|) [DLMF 5.11.1].
double log_gamma(double x);

/// Regularised incomplete beta function I_x(a, b) for a, b > 0 and x in [0,1], relative error below 1e-11 for
/// a, b <= 1e4 [DLMF 8.17.22].
double regularised_beta(double a, double b, double x);

/// P(|T| >= |t|) of Student's distribution with `dof` > 0 (not necessarily whole) degrees of freedom; 0 where
/// t^2 overflows.
double student_tail(double t, double dof);

/// Sample mean and unbiased sample variance (two passes, in order).
struct SampleMoments {
  std::size_t count = 0;
  double mean = 0;
  double variance = 0;  ///< 0 for fewer than two samples
};
SampleMoments sample_moments(std::span<const double> samples);

struct WelchResult {
  double t = 0;
  double dof = 0;
  double p_value = 1;  ///< two-sided
};

/// Do two sets, of at least 2 samples each and of possibly different variances, have the same mean? [Welch47]
/// Where neither varies, p is 1 for equal means and 0 for others.
WelchResult welch_test(const SampleMoments& a, const SampleMoments& b);

/// P-value of the smallest of `tests` independent p-values [Sidak67]: 1 - (1 - smallest)^tests.
double sidak_p_value(double smallest, std::size_t tests);

/// The level at which each of `tests` independent tests must be run so that all pass with probability
/// 1 - alpha when nothing differs [Sidak67]. alpha in (0,1), tests >= 1.
double sidak_level(double alpha, std::size_t tests);

struct UniformResult {
  double distance = 0;  ///< largest excess of the empirical over the uniform distribution function
  double p_value = 1;
};

/// Are p-values smaller than uniform ones would be? The one-sided Kolmogorov-Smirnov test by its asymptotic
/// distribution with a correction for finite counts [Stephens70 table 1A]. Too large p-values, which
/// cautious tests have, pass. `p_values` in [0,1]; none of them pass too.
UniformResult ks_small_test(std::span<const double> p_values);

}  // namespace mlt
