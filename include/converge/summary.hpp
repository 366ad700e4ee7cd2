// What a convergence run says: per method and level the errors over the replicates, and per method the slope,
// the effort to a target error and the efficiency against a base. A figure that is not known (no reference,
// too few points) is NaN here, null in JSON and a dash on a page. The fields are listed once, in
// visit_fields; writing and reading of JSON come from it.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "converge/measure.hpp"
#include "converge/statistics.hpp"

namespace mlt {

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// One method at one budget; all quantiles are over replicates.
struct LevelSummary {
  double budget = 0;                         ///< samples or mutations a pixel, as asked for
  double wall_seconds = 0, cpu_seconds = 0;  ///< medians
  double samples_per_pixel = 0;              ///< paths evaluated, bootstrap included; median
  double rel_mse_median = 0, rel_mse_p10 = 0, rel_mse_p90 = 0, rel_mse_p95 = 0, rel_mse_mean = 0;
  double mean = 0, mean_standard_error = 0;                 ///< of the image
  double bias = kUnknown, bias_standard_error = kUnknown;   ///< mean / reference's mean - 1, both noises
  double efficiency = kUnknown, efficiency_cpu = kUnknown;  ///< 1 / (median relMSE * median seconds)
  double ratio = kUnknown, ratio_cpu = kUnknown;            ///< to that of the base at the same time
};

/// A figure with the interval that holds it with a confidence of 95 %; ends may be 0 or infinite.
struct Bounded {
  double value = kUnknown, low = kUnknown, high = kUnknown;
};

struct MethodSummary {
  std::string name;
  std::vector<LevelSummary> levels;
  /// Exponents of relMSE over wall seconds and over samples, least squares over all replicates.
  double slope_time = kUnknown, slope_time_error = kUnknown;
  double slope_samples = kUnknown, slope_samples_error = kUnknown;
  /// Effort at which the median relMSE reaches the target: 0 when the first level is below it already,
  /// infinity when the last one is not.
  Bounded seconds_to_target, cpu_seconds_to_target, samples_per_pixel_to_target;
  Bounded ratio, ratio_cpu;                                      ///< LevelSummary::ratio at the last level
  double equal_time_level = 0;                                   ///< whose pictures are shown
  std::string picture, mean_picture, error_map, difference_map;  ///< file names beside the summary, or empty
};

struct ConvergeSummary {
  std::string version, command, scene;
  double width = 0, height = 0, depth = 0, threads = 0, replicates = 0, first_seed = 0;
  bool interrupted = false;
  std::string reference, reference_variance, reference_picture;  ///< empty without
  double reference_rel_mse = kUnknown, reference_mean = kUnknown, reference_mean_error = kUnknown;
  double target = kUnknown;
  std::string base;               ///< name of the method that efficiencies are compared with
  double equal_time_seconds = 0;  ///< median wall seconds of the fastest method's last level
  double error_map_high = 0, difference_map_high = 0;  ///< ends of the maps' scales
  std::vector<std::string> warnings;
  std::vector<MethodSummary> methods;
};

/// Statistics of a scored run. `target` is NaN for none. Leaves version, command, scene and pictures empty.
ConvergeSummary summarise(const ConvergeRun& run, const Reference* reference, double target);

/// Index of `method`'s level whose time is nearest to `seconds` as a ratio.
std::size_t level_near(const MethodSummary& method, double seconds);

/// One row a replicate, with a line of column names; RFC 4180, lines ended by a line feed.
std::string to_csv(const ConvergeRun& run, const std::string& scene);

std::string to_json(const ConvergeSummary& summary);
/// Reads what to_json writes. Throws InputError named `path` for anything else.
ConvergeSummary summary_from_json(const std::string& text, const std::string& path);

/// A table for a terminal; without the warnings.
std::string to_text(const ConvergeSummary& summary);

template <class Visitor, class Level>
void visit_level_fields(Visitor& visit, Level& level) {
  visit("budget", level.budget);
  visit("wall_seconds_median", level.wall_seconds);
  visit("cpu_seconds_median", level.cpu_seconds);
  visit("samples_per_pixel", level.samples_per_pixel);
  visit("rel_mse_median", level.rel_mse_median);
  visit("rel_mse_p10", level.rel_mse_p10);
  visit("rel_mse_p90", level.rel_mse_p90);
  visit("rel_mse_p95", level.rel_mse_p95);
  visit("rel_mse_mean", level.rel_mse_mean);
  visit("mean", level.mean);
  visit("mean_standard_error", level.mean_standard_error);
  visit("bias", level.bias);
  visit("bias_standard_error", level.bias_standard_error);
  visit("efficiency", level.efficiency);
  visit("efficiency_cpu", level.efficiency_cpu);
  visit("efficiency_ratio", level.ratio);
  visit("efficiency_ratio_cpu", level.ratio_cpu);
}

template <class Visitor, class Method>
void visit_method_fields(Visitor& visit, Method& method) {
  visit("method", method.name);
  visit("slope_time", method.slope_time);
  visit("slope_time_standard_error", method.slope_time_error);
  visit("slope_samples", method.slope_samples);
  visit("slope_samples_standard_error", method.slope_samples_error);
  visit("seconds_to_target", method.seconds_to_target);
  visit("cpu_seconds_to_target", method.cpu_seconds_to_target);
  visit("samples_per_pixel_to_target", method.samples_per_pixel_to_target);
  visit("efficiency_ratio", method.ratio);
  visit("efficiency_ratio_cpu", method.ratio_cpu);
  visit("equal_time_level", method.equal_time_level);
  visit("picture", method.picture);
  visit("mean_picture", method.mean_picture);
  visit("error_map", method.error_map);
  visit("difference_map", method.difference_map);
  visit("levels", method.levels);
}

template <class Visitor, class Summary>
void visit_summary_fields(Visitor& visit, Summary& summary) {
  visit("version", summary.version);
  visit("command", summary.command);
  visit("scene", summary.scene);
  visit("width", summary.width);
  visit("height", summary.height);
  visit("depth", summary.depth);
  visit("threads", summary.threads);
  visit("replicates", summary.replicates);
  visit("first_seed", summary.first_seed);
  visit("interrupted", summary.interrupted);
  visit("reference", summary.reference);
  visit("reference_variance", summary.reference_variance);
  visit("reference_picture", summary.reference_picture);
  visit("reference_rel_mse", summary.reference_rel_mse);
  visit("reference_mean", summary.reference_mean);
  visit("reference_mean_standard_error", summary.reference_mean_error);
  visit("target", summary.target);
  visit("efficiency_base", summary.base);
  visit("equal_time_seconds", summary.equal_time_seconds);
  visit("error_map_high", summary.error_map_high);
  visit("difference_map_high", summary.difference_map_high);
  visit("warnings", summary.warnings);
  visit("methods", summary.methods);
}

}  // namespace mlt
