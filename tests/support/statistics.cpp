#include "support/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace mlt::test {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kMaxIterations = 100000;
constexpr double kEpsilon = 1e-16;
// Keeps Lentz's continued fractions off a division by zero.
constexpr double kTiny = 1e-300;

/// x^a e^-x / Gamma(a), in logarithms so that large arguments do not overflow.
double gamma_prefactor(double a, double x) {
  return std::exp(a * std::log(x) - x - std::lgamma(a));
}

double lower_gamma_series(double a, double x) {
  double term = 1.0 / a;
  double sum = term;
  for (int n = 1; n < kMaxIterations && term > sum * kEpsilon; ++n) {
    term *= x / (a + n);
    sum += term;
  }
  return sum * gamma_prefactor(a, x);
}

double upper_gamma_fraction(double a, double x) {
  double b = x + 1.0 - a;
  double c = 1.0 / kTiny;
  double d = 1.0 / b;
  double result = d;
  for (int n = 1; n < kMaxIterations; ++n) {
    const double numerator = -n * (n - a);
    b += 2.0;
    d = numerator * d + b;
    d = 1.0 / (std::fabs(d) < kTiny ? kTiny : d);
    c = b + numerator / c;
    if (std::fabs(c) < kTiny) c = kTiny;
    const double factor = d * c;
    result *= factor;
    if (std::fabs(factor - 1.0) < kEpsilon) break;
  }
  return result * gamma_prefactor(a, x);
}

double beta_fraction(double a, double b, double x) {
  double c = 1.0;
  double d = 1.0 - (a + b) * x / (a + 1.0);
  d = 1.0 / (std::fabs(d) < kTiny ? kTiny : d);
  double result = d;
  const auto step = [&](double numerator) {
    d = 1.0 + numerator * d;
    d = 1.0 / (std::fabs(d) < kTiny ? kTiny : d);
    c = 1.0 + numerator / c;
    if (std::fabs(c) < kTiny) c = kTiny;
    result *= c * d;
    return c * d;
  };
  for (int m = 1; m < kMaxIterations; ++m) {
    step(m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)));
    const double factor = step(-(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1)));
    if (std::fabs(factor - 1.0) < kEpsilon) break;
  }
  return result;
}

}  // namespace

double upper_gamma_q(double a, double x) {
  if (!(a > 0) || !(x >= 0)) throw std::domain_error("upper_gamma_q");
  if (x == 0) return 1;
  if (std::isinf(x)) return 0;
  return x < a + 1 ? 1.0 - lower_gamma_series(a, x) : upper_gamma_fraction(a, x);
}

double incomplete_beta(double a, double b, double x) {
  if (!(a > 0) || !(b > 0) || !(x >= 0 && x <= 1)) throw std::domain_error("incomplete_beta");
  if (x == 0 || x == 1) return x;
  const double front =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x));
  // The fraction converges fast only on this side of the mean.
  if (x < (a + 1) / (a + b + 2)) return front * beta_fraction(a, b, x) / a;
  return 1.0 - front * beta_fraction(b, a, 1.0 - x) / b;
}

double chi_square_p_value(double statistic, double dof) {
  return upper_gamma_q(0.5 * dof, 0.5 * statistic);
}

double normal_p_value(double z) {
  return std::erfc(std::fabs(z) / std::sqrt(2.0));
}

double student_p_value(double t, double dof) {
  if (std::isinf(t)) return 0;
  return incomplete_beta(0.5 * dof, 0.5, dof / (dof + t * t));
}

double sidak_threshold(double significance, std::size_t tests) {
  if (!(significance > 0 && significance < 1) || tests == 0) throw std::domain_error("sidak_threshold");
  return -std::expm1(std::log1p(-significance) / static_cast<double>(tests));
}

double Moments::standard_error() const {
  return count < 2 ? 0.0 : std::sqrt(variance / static_cast<double>(count));
}

Moments moments(std::span<const double> samples) {
  Moments result;
  result.count = samples.size();
  if (samples.empty()) return result;
  const double n = static_cast<double>(samples.size());
  result.mean = std::accumulate(samples.begin(), samples.end(), 0.0) / n;
  double squares = 0;
  for (const double x : samples) squares += (x - result.mean) * (x - result.mean);
  if (samples.size() > 1) result.variance = squares / (n - 1);
  return result;
}

namespace {

/// t-test of a difference whose standard error may be 0: then only an exact 0 passes.
TTestResult t_test(double difference, double standard_error, double dof) {
  if (standard_error == 0) {
    return difference == 0
               ? TTestResult{0, dof, 1}
               : TTestResult{std::copysign(std::numeric_limits<double>::infinity(), difference), dof, 0};
  }
  const double t = difference / standard_error;
  return {t, dof, student_p_value(t, dof)};
}

}  // namespace

TTestResult student_t_test(const Moments& samples, double mean) {
  if (samples.count < 2) throw std::domain_error("student_t_test needs two samples");
  return t_test(samples.mean - mean, samples.standard_error(), static_cast<double>(samples.count - 1));
}

TTestResult welch_t_test(const Moments& a, const Moments& b) {
  if (a.count < 2 || b.count < 2) throw std::domain_error("welch_t_test needs two samples in each set");
  const double va = a.variance / static_cast<double>(a.count);
  const double vb = b.variance / static_cast<double>(b.count);
  const double sum = va + vb;
  // Welch-Satterthwaite degrees of freedom; shares of the sum, so that tiny variances do not underflow.
  double dof = static_cast<double>(a.count + b.count - 2);
  if (sum > 0) {
    const double sa = va / sum;
    const double sb = vb / sum;
    dof = 1.0 / (sa * sa / static_cast<double>(a.count - 1) + sb * sb / static_cast<double>(b.count - 1));
  }
  return t_test(a.mean - b.mean, std::sqrt(sum), dof);
}

KolmogorovResult ks_uniform_test(std::span<const double> values) {
  if (values.empty()) throw std::domain_error("ks_uniform_test needs values");
  std::vector<double> sorted(values.begin(), values.end());
  for (const double x : sorted) {
    if (!(x >= 0 && x <= 1)) throw std::domain_error("ks_uniform_test: value outside [0,1]");
  }
  std::sort(sorted.begin(), sorted.end());
  const double n = static_cast<double>(sorted.size());
  KolmogorovResult result;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const double below = sorted[i] - static_cast<double>(i) / n;
    const double above = static_cast<double>(i + 1) / n - sorted[i];
    result.distance = std::max({result.distance, below, above});
  }
  const double lambda = (std::sqrt(n) + 0.12 + 0.11 / std::sqrt(n)) * result.distance;
  if (lambda < 0.2) return result;  // here 1 - p lies below 1e-12 and the series converges slowly
  double p = 0;
  for (int k = 1; k <= 100; ++k) {
    const double term = std::exp(-2.0 * k * k * lambda * lambda);
    p += (k % 2 == 1 ? 2.0 : -2.0) * term;
    if (term < 1e-18) break;
  }
  result.p_value = std::clamp(p, 0.0, 1.0);
  return result;
}

ChiSquareResult chi_square_test(std::span<const std::uint64_t> observed, std::span<const double> expected,
                                double minimal_expected) {
  if (observed.size() != expected.size()) throw std::domain_error("chi_square_test: lengths differ");
  std::vector<std::size_t> order(expected.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return expected[a] < expected[b]; });
  ChiSquareResult result;
  std::size_t cells = 0;
  double pool_expected = 0;
  double pool_observed = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const double e = expected[order[k]];
    const double o = static_cast<double>(observed[order[k]]);
    if (!(e >= 0)) throw std::domain_error("chi_square_test: negative or NaN expectation");
    if (e == 0 && o > 0) return {std::numeric_limits<double>::infinity(), 0, 0, 0};
    const bool is_small = e < minimal_expected;
    if (is_small) ++result.pooled_cells;
    // Cells come smallest first, so an unfinished pool also takes in the first cell that is large enough.
    pool_expected += e;
    pool_observed += o;
    if (pool_expected < minimal_expected) continue;
    const double difference = pool_observed - pool_expected;
    result.statistic += difference * difference / pool_expected;
    ++cells;
    pool_expected = 0;
    pool_observed = 0;
  }
  // A pool that stays below the limit has no larger cell to join; it is too small to tell anything.
  result.dof = cells > 0 ? static_cast<double>(cells - 1) : 0.0;
  result.p_value = result.dof > 0 ? chi_square_p_value(result.statistic, result.dof) : 1.0;
  return result;
}

std::optional<std::size_t> Grid2D::cell_of(double u, double v) const {
  if (!(u >= u_min && u <= u_max && v >= v_min && v <= v_max)) return std::nullopt;
  const double x = (u - u_min) / (u_max - u_min) * static_cast<double>(u_cells);
  const double y = (v - v_min) / (v_max - v_min) * static_cast<double>(v_cells);
  const std::size_t i = std::min(static_cast<std::size_t>(x), u_cells - 1);
  const std::size_t j = std::min(static_cast<std::size_t>(y), v_cells - 1);
  return j * u_cells + i;
}

Grid2D unit_grid(std::size_t u_cells, std::size_t v_cells) {
  return {0, 1, u_cells, 0, 1, v_cells};
}

Grid2D direction_grid(std::size_t azimuth_cells, std::size_t cos_cells, double cos_min, double cos_max) {
  return {-kPi, kPi, azimuth_cells, cos_min, cos_max, cos_cells};
}

namespace {

// Positive abscissae and weights of the 8 point Gauss-Legendre rule on [-1,1] [Abramowitz64, table 25.4].
constexpr double kNodes[4] = {0.1834346424956498049394761, 0.5255324099163289858177390,
                              0.7966664774136267395915539, 0.9602898564975362316835609};
constexpr double kWeights[4] = {0.3626837833783619829651504, 0.3137066458778872873379622,
                                0.2223810344533744705443560, 0.1012285362903762591525314};

struct Box {
  double u_min, u_max, v_min, v_max;
};

double gauss_legendre(const Density2D& density, const Box& box) {
  const double u_half = 0.5 * (box.u_max - box.u_min);
  const double v_half = 0.5 * (box.v_max - box.v_min);
  const double u_mid = 0.5 * (box.u_max + box.u_min);
  const double v_mid = 0.5 * (box.v_max + box.v_min);
  double sum = 0;
  for (int i = 0; i < 8; ++i) {
    const double u = u_mid + (i < 4 ? kNodes[i] : -kNodes[i - 4]) * u_half;
    for (int j = 0; j < 8; ++j) {
      const double v = v_mid + (j < 4 ? kNodes[j] : -kNodes[j - 4]) * v_half;
      sum += kWeights[i & 3] * kWeights[j & 3] * density(u, v);
    }
  }
  return sum * u_half * v_half;
}

double refine(const Density2D& density, const Box& box, double whole, double relative_tolerance, int depth) {
  const double u_mid = 0.5 * (box.u_max + box.u_min);
  const double v_mid = 0.5 * (box.v_max + box.v_min);
  const Box quarters[4] = {{box.u_min, u_mid, box.v_min, v_mid},
                           {u_mid, box.u_max, box.v_min, v_mid},
                           {box.u_min, u_mid, v_mid, box.v_max},
                           {u_mid, box.u_max, v_mid, box.v_max}};
  double parts[4];
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    parts[i] = gauss_legendre(density, quarters[i]);
    sum += parts[i];
  }
  if (depth <= 1 || std::fabs(sum - whole) <= std::max(1e-10, relative_tolerance * std::fabs(sum)))
    return sum;
  double refined = 0;
  for (int i = 0; i < 4; ++i)
    refined += refine(density, quarters[i], parts[i], relative_tolerance, depth - 1);
  return refined;
}

}  // namespace

double integrate(const Density2D& density, double u_min, double u_max, double v_min, double v_max,
                 double relative_tolerance, int max_depth) {
  const Box box{u_min, u_max, v_min, v_max};
  const double whole = gauss_legendre(density, box);
  return max_depth < 1 ? whole : refine(density, box, whole, relative_tolerance, max_depth);
}

std::vector<double> integrate_cells(const Grid2D& grid, const Density2D& density, double relative_tolerance,
                                    int max_depth) {
  std::vector<double> result(grid.cells());
  const double du = (grid.u_max - grid.u_min) / static_cast<double>(grid.u_cells);
  const double dv = (grid.v_max - grid.v_min) / static_cast<double>(grid.v_cells);
  for (std::size_t j = 0; j < grid.v_cells; ++j) {
    const double v = grid.v_min + static_cast<double>(j) * dv;
    for (std::size_t i = 0; i < grid.u_cells; ++i) {
      const double u = grid.u_min + static_cast<double>(i) * du;
      result[j * grid.u_cells + i] = integrate(density, u, u + du, v, v + dv, relative_tolerance, max_depth);
    }
  }
  return result;
}

ChiSquareResult chi_square_2d(const Grid2D& grid, std::uint64_t samples, const Sampler2D& draw,
                              const Density2D& density) {
  std::vector<std::uint64_t> observed(grid.cells() + 1, 0);
  for (std::uint64_t k = 0; k < samples; ++k) {
    const std::optional<Point2> point = draw();
    const std::optional<std::size_t> cell = point ? grid.cell_of((*point)[0], (*point)[1]) : std::nullopt;
    ++observed[cell.value_or(grid.cells())];
  }
  std::vector<double> expected = integrate_cells(grid, density);
  const double inside = std::accumulate(expected.begin(), expected.end(), 0.0);
  expected.push_back(std::max(0.0, 1.0 - inside));
  // A density that integrates to more than 1 must not pass because its excess has nowhere to go.
  if (inside > 1.0 + 1e-4) return {std::numeric_limits<double>::infinity(), 0, 0, 0};
  for (double& e : expected) e *= static_cast<double>(samples);
  return chi_square_test(observed, expected);
}

ChiSquareResult chi_square_directions(const Grid2D& grid, std::uint64_t samples,
                                      const std::function<std::optional<Vec3>()>& draw,
                                      const std::function<double(const Vec3&)>& pdf_solid_angle) {
  const Sampler2D draw_point = [&]() -> std::optional<Point2> {
    const std::optional<Vec3> w = draw();
    if (!w) return std::nullopt;
    // A float unit vector's z may exceed 1 by a rounding error; that is no sample outside the sphere.
    const double cos_theta = std::clamp(static_cast<double>(w->z), -1.0, 1.0);
    return Point2{std::atan2(static_cast<double>(w->y), static_cast<double>(w->x)), cos_theta};
  };
  const Density2D density = [&](double azimuth, double cos_theta) {
    const double sin_theta = std::sqrt((1.0 - cos_theta) * (1.0 + cos_theta));
    return pdf_solid_angle(Vec3{static_cast<float>(sin_theta * std::cos(azimuth)),
                                static_cast<float>(sin_theta * std::sin(azimuth)),
                                static_cast<float>(cos_theta)});
  };
  return chi_square_2d(grid, samples, draw_point, density);
}

}  // namespace mlt::test
