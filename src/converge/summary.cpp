#include "converge/summary.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/assert.hpp"

namespace mlt {
namespace {

using Chosen = std::span<const std::uint32_t>;

/// Noise of the reference above this share of an error makes that error hard to trust.
constexpr double kTrustedNoiseShare = 0.2;
constexpr double kSuspectStandardErrors = 4;
constexpr std::uint32_t kReplicatesToSuspect = 8;  // of fewer the standard error itself is too uncertain
constexpr double kRoundingOfMeans =
    1e-5;  // relative; pixels are floats, and some scenes have no noise at all

/// Medians by level over a choice of replicates.
struct Curve {
  std::vector<double> wall, cpu, samples, rel_mse;

  std::vector<double> efficiencies(const std::vector<double>& seconds) const {
    std::vector<double> result;
    for (std::size_t i = 0; i < seconds.size(); ++i) {
      const bool known = rel_mse[i] > 0 && seconds[i] > 0;
      result.push_back(known ? 1 / (rel_mse[i] * seconds[i]) : kUnknown);
    }
    return result;
  }
};

template <class Get>
std::vector<double> collect(const ConvergeRun& run, std::size_t method, std::size_t level, Chosen chosen,
                            const Get& get) {
  std::vector<double> values;
  for (const std::uint32_t replicate : chosen) values.push_back(get(run.row(method, level, replicate)));
  return values;
}

double samples_per_pixel(const ConvergeRun& run, const Measurement& row) {
  return static_cast<double>(row.samples) / (static_cast<double>(run.width) * run.height);
}

Curve curve_of(const ConvergeRun& run, std::size_t method, Chosen chosen) {
  Curve curve;
  for (std::size_t level = 0; level < run.level_count; ++level) {
    const auto median_of = [&](const auto& get) { return median(collect(run, method, level, chosen, get)); };
    curve.wall.push_back(median_of([](const Measurement& row) { return row.wall_seconds; }));
    curve.cpu.push_back(median_of([](const Measurement& row) { return row.cpu_seconds; }));
    curve.samples.push_back(median_of([&](const Measurement& row) { return samples_per_pixel(run, row); }));
    curve.rel_mse.push_back(median_of([](const Measurement& row) { return row.rel_mse; }));
  }
  return curve;
}

/// Efficiency of a curve at `seconds`: between levels along the power law, beyond its ends constant, as it is
/// for independent samples.
double efficiency_at(const std::vector<double>& times, const std::vector<double>& efficiencies,
                     double seconds) {
  std::size_t at = 0;
  while (at < times.size() && times[at] < seconds) ++at;
  if (at == 0) return efficiencies.front();
  if (at == times.size()) return efficiencies.back();
  if (std::isnan(efficiencies[at - 1]) || std::isnan(efficiencies[at]) || !(times[at - 1] > 0))
    return kUnknown;
  const double from = log10_of(times[at - 1]);
  const double share = (log10_of(seconds) - from) / (log10_of(times[at]) - from);
  const double low = log10_of(efficiencies[at - 1]);
  return power_of_10(low + share * (log10_of(efficiencies[at]) - low));
}

double ratio_at(const std::vector<double>& times, const std::vector<double>& efficiencies, std::size_t level,
                const std::vector<double>& base_times, const std::vector<double>& base_efficiencies) {
  return efficiencies[level] / efficiency_at(base_times, base_efficiencies, times[level]);
}

void add_level(const ConvergeRun& run, const Reference* reference, std::size_t method, std::size_t level,
               Chosen all, MethodSummary& summary) {
  LevelSummary result;
  const std::vector<double> errors =
      collect(run, method, level, all, [](const Measurement& row) { return row.rel_mse; });
  const std::vector<double> means =
      collect(run, method, level, all, [](const Measurement& row) { return row.mean; });
  result.budget = static_cast<double>(run.methods[method].budgets[level]);
  result.rel_mse_median = median(errors);
  result.rel_mse_p10 = quantile(errors, 0.1);
  result.rel_mse_p90 = quantile(errors, 0.9);
  result.rel_mse_p95 = quantile(errors, 0.95);
  result.rel_mse_mean = mean_of(errors).mean;
  result.mean = mean_of(means).mean;
  result.mean_standard_error = mean_of(means).standard_error;
  if (reference != nullptr && reference->mean > 0) {
    const double of_image = result.mean_standard_error;
    const double of_reference = reference->mean_standard_error;
    result.bias = result.mean / reference->mean - 1;
    result.bias_standard_error =
        std::sqrt(of_image * of_image + of_reference * of_reference) / reference->mean;
  }
  summary.levels.push_back(result);
}

/// Over all replicates of the levels whose errors all have a logarithm.
std::optional<PowerLaw> slope(const ConvergeRun& run, std::size_t method, Chosen all, bool over_time) {
  std::vector<double> x, y;
  std::size_t levels = 0;
  for (std::size_t level = 0; level < run.level_count; ++level) {
    const auto errors = collect(run, method, level, all, [](const Measurement& row) { return row.rel_mse; });
    const auto efforts = collect(run, method, level, all, [&](const Measurement& row) {
      return over_time ? row.wall_seconds : samples_per_pixel(run, row);
    });
    const auto positive = [](double value) { return value > 0; };
    if (!std::all_of(errors.begin(), errors.end(), positive)) continue;
    if (!std::all_of(efforts.begin(), efforts.end(), positive)) continue;
    ++levels;
    x.insert(x.end(), efforts.begin(), efforts.end());
    y.insert(y.end(), errors.begin(), errors.end());
  }
  // Within one level the times differ by the machine's noise alone.
  return levels < 2 ? std::nullopt : fit_power_law(x, y);
}

Bounded effort_to(const ConvergeRun& run, std::size_t method, double target, const Curve& all,
                  std::vector<double> Curve::*effort) {
  const auto find = [&](const Curve& curve) {
    // The clock cannot tell the shortest renders from 0.
    std::vector<double> x = curve.*effort;
    for (double& value : x) value = std::max(value, 1e-9);
    return find_crossing(x, curve.rel_mse, target).x;
  };
  const Interval interval =
      bootstrap_interval(run.replicates, [&](Chosen chosen) { return find(curve_of(run, method, chosen)); });
  return {find(all), interval.low, interval.high};
}

Bounded bounded_ratio(const ConvergeRun& run, std::size_t method, std::size_t base,
                      std::vector<double> Curve::*seconds, double value) {
  if (std::isnan(value)) return {};
  if (method == base) return {1, 1, 1};
  const std::size_t last = run.level_count - 1;
  const Interval interval = bootstrap_interval(run.replicates, [&](Chosen chosen) {
    const Curve own = curve_of(run, method, chosen);
    const Curve other = curve_of(run, base, chosen);
    return ratio_at(own.*seconds, own.efficiencies(own.*seconds), last, other.*seconds,
                    other.efficiencies(other.*seconds));
  });
  return {value, interval.low, interval.high};
}

void add_slopes(const ConvergeRun& run, std::size_t method, Chosen all, MethodSummary& summary) {
  if (const auto law = slope(run, method, all, true)) {
    summary.slope_time = law->exponent;
    summary.slope_time_error = law->exponent_error;
  }
  if (const auto law = slope(run, method, all, false)) {
    summary.slope_samples = law->exponent;
    summary.slope_samples_error = law->exponent_error;
  }
}

/// The method that the others' efficiency is compared with: the first path tracer, else the first of all.
std::size_t base_of(const ConvergeRun& run) {
  for (std::size_t i = 0; i < run.methods.size(); ++i) {
    if (run.methods[i].settings.integrator == IntegratorKind::path) return i;
  }
  return 0;
}

void add_efficiencies(const ConvergeRun& run, const std::vector<Curve>& curves, ConvergeSummary& summary) {
  const std::size_t base = base_of(run);
  const Curve& other = curves[base];
  summary.base = run.methods[base].name;
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const Curve& curve = curves[i];
    const std::vector<double> wall = curve.efficiencies(curve.wall);
    const std::vector<double> cpu = curve.efficiencies(curve.cpu);
    MethodSummary& method = summary.methods[i];
    for (std::size_t level = 0; level < run.level_count; ++level) {
      LevelSummary& result = method.levels[level];
      result.efficiency = wall[level];
      result.efficiency_cpu = cpu[level];
      result.ratio = ratio_at(curve.wall, wall, level, other.wall, other.efficiencies(other.wall));
      result.ratio_cpu = ratio_at(curve.cpu, cpu, level, other.cpu, other.efficiencies(other.cpu));
    }
    method.ratio = bounded_ratio(run, i, base, &Curve::wall, method.levels.back().ratio);
    method.ratio_cpu = bounded_ratio(run, i, base, &Curve::cpu, method.levels.back().ratio_cpu);
  }
}

void add_warnings(const Reference* reference, ConvergeSummary& summary) {
  const auto warn = [&summary](std::string text) { summary.warnings.push_back(std::move(text)); };
  if (reference == nullptr) {
    warn("without --reference the error is the variance over replicates, which shows no bias");
    return;
  }
  if (reference->variance_path.empty()) {
    warn(fmt::format("{} has no {} beside it, so the reference's own noise is part of every error",
                     reference->path, variance_path_of(reference->path)));
  }
  for (const MethodSummary& method : summary.methods) {
    const double least = method.levels.back().rel_mse_median;
    if (reference->own_rel_mse > kTrustedNoiseShare * std::max(least, 0.0)) {
      warn(fmt::format("{}: the reference's own relMSE, {:.3g}, is large against the smallest error, {:.3g}",
                       method.name, reference->own_rel_mse, least));
    }
    const LevelSummary& last = method.levels.back();
    if (summary.replicates < kReplicatesToSuspect) continue;
    if (std::fabs(last.bias) > kSuspectStandardErrors * last.bias_standard_error + kRoundingOfMeans) {
      warn(
          fmt::format("{}: the image mean is off by {:+.3g} %, {:.1f} standard errors; same depth and scene "
                      "as the reference?",
                      method.name, 100 * last.bias, std::fabs(last.bias) / last.bias_standard_error));
    }
  }
}

}  // namespace

std::size_t level_near(const MethodSummary& method, double seconds) {
  std::size_t best = 0;
  double best_ratio = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < method.levels.size(); ++i) {
    const double own = std::max(method.levels[i].wall_seconds, 1e-9);
    const double other = std::max(seconds, 1e-9);
    const double ratio = std::max(own / other, other / own);
    if (ratio < best_ratio) {
      best = i;
      best_ratio = ratio;
    }
  }
  return best;
}

ConvergeSummary summarise(const ConvergeRun& run, const Reference* reference, double target) {
  MLT_CHECK_OP(run.replicates, >, 0u);
  ConvergeSummary summary;
  summary.width = run.width;
  summary.height = run.height;
  summary.depth = run.depth;
  summary.threads = run.threads;
  summary.replicates = run.replicates;
  summary.first_seed = static_cast<double>(run.rows.front().seed);
  summary.interrupted = run.interrupted;
  summary.target = target;
  if (reference != nullptr) {
    summary.reference = reference->path;
    summary.reference_variance = reference->variance_path;
    summary.reference_rel_mse = reference->own_rel_mse;
    summary.reference_mean = reference->mean;
    summary.reference_mean_error = reference->mean_standard_error;
  }
  std::vector<std::uint32_t> all(run.replicates);
  std::iota(all.begin(), all.end(), 0u);
  std::vector<Curve> curves;
  double equal_time = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < run.methods.size(); ++i) {
    curves.push_back(curve_of(run, i, all));
    const Curve& curve = curves.back();
    MethodSummary method;
    method.name = run.methods[i].name;
    for (std::size_t level = 0; level < run.level_count; ++level) {
      add_level(run, reference, i, level, all, method);
      method.levels.back().wall_seconds = curve.wall[level];
      method.levels.back().cpu_seconds = curve.cpu[level];
      method.levels.back().samples_per_pixel = curve.samples[level];
    }
    add_slopes(run, i, all, method);
    if (target > 0) {
      method.seconds_to_target = effort_to(run, i, target, curve, &Curve::wall);
      method.cpu_seconds_to_target = effort_to(run, i, target, curve, &Curve::cpu);
      method.samples_per_pixel_to_target = effort_to(run, i, target, curve, &Curve::samples);
    }
    equal_time = std::min(equal_time, curve.wall.back());
    summary.methods.push_back(std::move(method));
  }
  add_efficiencies(run, curves, summary);
  summary.equal_time_seconds = equal_time;
  for (MethodSummary& method : summary.methods) {
    method.equal_time_level = static_cast<double>(level_near(method, equal_time));
  }
  add_warnings(reference, summary);
  return summary;
}

}  // namespace mlt
