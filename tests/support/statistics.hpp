// Hypothesis tests for statistical unit tests. All of it runs in double with libm, so it must never be
// included from src/ or include/. Every p-value is the probability, under the null hypothesis, of data at
// least as extreme as those seen; a test with fixed seeds fails when it lies below a threshold that
// sidak_threshold() derives from the number of such tests.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "math/vec.hpp"

namespace mlt::test {

// ---- Distributions ------------------------------------------------------------------------------------

/// Regularised upper incomplete gamma function Q(a, x), a > 0, x >= 0; relative error below 1e-10 for
/// a <= 1e4 [DLMF 8.11.4, 8.9.2].
double upper_gamma_q(double a, double x);

/// Regularised incomplete beta function I_x(a, b), a, b > 0, x in [0,1] [DLMF 8.17.22].
double incomplete_beta(double a, double b, double x);

/// P(X >= statistic) of a chi-square variable with dof > 0 degrees of freedom.
double chi_square_p_value(double statistic, double dof);

/// P(|Z| >= |z|) of a standard normal variable.
double normal_p_value(double z);

/// P(|T| >= |t|) of Student's distribution with dof > 0 (not necessarily whole) degrees of freedom.
double student_p_value(double t, double dof);

/// The level at which each of `tests` independent tests must be run so that all pass with probability
/// 1 - significance when every null hypothesis holds [Sidak67]. significance in (0,1), tests >= 1.
double sidak_threshold(double significance, std::size_t tests);

// ---- Moments, t-tests and Kolmogorov-Smirnov --------------------------------------------------------------

/// Sample mean and unbiased sample variance (two passes).
struct Moments {
  std::size_t count = 0;
  double mean = 0;
  double variance = 0;

  /// Standard deviation of the mean; 0 for fewer than two samples.
  double standard_error() const;
};
Moments moments(std::span<const double> samples);

struct TTestResult {
  double t = 0;
  double dof = 0;
  double p_value = 1;  ///< two-sided
};

/// Do the samples (at least 2) have this mean? Student's test. When all samples are equal, p is 1 if they
/// equal `mean` and 0 otherwise.
TTestResult student_t_test(const Moments& samples, double mean);

/// Do two sets (at least 2 each) with possibly different variances have the same mean? [Welch47]
TTestResult welch_t_test(const Moments& a, const Moments& b);

struct KolmogorovResult {
  double distance = 0;  ///< largest gap between the empirical and the uniform distribution function
  double p_value = 1;
};

/// Are the values, e.g. p-values of many tests, uniform on [0,1]? Uses the asymptotic distribution with
/// Stephens' correction for finite counts, good to about 2 % of p from 5 values on [Stephens70].
KolmogorovResult ks_uniform_test(std::span<const double> values);

// ---- Chi-square -----------------------------------------------------------------------------------------

struct ChiSquareResult {
  double statistic = 0;
  double dof = 0;                ///< cells after pooling minus 1
  double p_value = 0;            ///< 0 when something was observed where nothing was expected
  std::size_t pooled_cells = 0;  ///< cells that were merged because too little was expected in them
};

/// Compares counts with expected counts (same length, the same total within rounding). Cells of fewer than
/// `minimal_expected` are merged, smallest first; a count in a cell of expectation 0 gives p-value 0. With
/// fewer than two cells left there is nothing to test: dof 0 and p-value 1.
ChiSquareResult chi_square_test(std::span<const std::uint64_t> observed, std::span<const double> expected,
                                double minimal_expected = 5);

/// A rectangle cut into u_cells * v_cells equal cells; cell (i, j) has index j * u_cells + i.
struct Grid2D {
  double u_min = 0, u_max = 1;
  std::size_t u_cells = 1;
  double v_min = 0, v_max = 1;
  std::size_t v_cells = 1;

  std::size_t cells() const { return u_cells * v_cells; }
  /// Empty outside the closed rectangle and for NaN; points on an inner border belong to the upper cell.
  std::optional<std::size_t> cell_of(double u, double v) const;
};

/// The unit square.
Grid2D unit_grid(std::size_t u_cells, std::size_t v_cells);
/// Directions by u = azimuth in [-pi, pi] and v = cos(theta) in [cos_min, cos_max]; du dv is solid angle.
Grid2D direction_grid(std::size_t azimuth_cells, std::size_t cos_cells, double cos_min = -1,
                      double cos_max = 1);

using Point2 = std::array<double, 2>;
using Density2D = std::function<double(double u, double v)>;
using Sampler2D = std::function<std::optional<Point2>()>;

/// Integral of `density` over the rectangle by 8 x 8 point Gauss-Legendre quadrature. A rectangle is cut in
/// four, at most `max_depth` times, until both levels agree to relative_tolerance or to 1e-10 absolutely.
/// A feature much narrower than a cell's 16 x 16 points can be missed: choose coordinates or cells to suit.
double integrate(const Density2D& density, double u_min, double u_max, double v_min, double v_max,
                 double relative_tolerance = 1e-6, int max_depth = 8);

/// integrate() over each cell of the grid.
std::vector<double> integrate_cells(const Grid2D& grid, const Density2D& density,
                                    double relative_tolerance = 1e-6, int max_depth = 8);

/// Draws `samples` points and compares their histogram with the cell integrals of `density`, which is with
/// respect to du dv. Points outside the grid, and draws that return nothing (absorbed, rejected), fall into
/// one more cell whose probability is what the density lacks to 1.
ChiSquareResult chi_square_2d(const Grid2D& grid, std::uint64_t samples, const Sampler2D& draw,
                              const Density2D& density);

/// The same for unit directions on a direction_grid(); `pdf_solid_angle` is a density per steradian.
ChiSquareResult chi_square_directions(const Grid2D& grid, std::uint64_t samples,
                                      const std::function<std::optional<Vec3>()>& draw,
                                      const std::function<double(const Vec3&)>& pdf_solid_angle);

}  // namespace mlt::test
