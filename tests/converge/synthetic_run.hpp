// Runs without rendering: rows whose errors and times follow laws that the statistics must find again.
#pragma once

#include <cmath>
#include <string>

#include "converge/measure.hpp"

namespace mlt::test {

struct Law {
  IntegratorKind kind;
  std::string name;
  double error;     ///< relMSE at budget 1
  double exponent;  ///< of relMSE over the budget
  double seconds_per_budget;
};

/// Budgets 1, 2, 4, ...; replicate r of n has the error and the time times 1 + spread * (r - (n - 1) / 2), so
/// that the median is the law's. 2 x 2 pixels, all images of constant 1.
inline ConvergeRun synthetic_run(const std::vector<Law>& laws, std::size_t levels, std::uint32_t replicates,
                                 double spread) {
  ConvergeRun run;
  run.level_count = levels;
  run.replicates = replicates;
  run.width = run.height = 2;
  run.depth = 3;
  run.threads = 1;
  for (const Law& law : laws) {
    ConvergeMethod method;
    method.settings.integrator = law.kind;
    method.name = law.name;
    run.methods.push_back(method);
    for (std::size_t level = 0; level < levels; ++level) run.methods.back().budgets.push_back(1ULL << level);
  }
  for (std::uint32_t replicate = 0; replicate < replicates; ++replicate) {
    const double factor = 1 + spread * (replicate - 0.5 * (replicates - 1));
    for (std::size_t level = 0; level < levels; ++level) {
      for (std::size_t method = 0; method < laws.size(); ++method) {
        Measurement row;
        row.method = method;
        row.level = level;
        row.replicate = replicate;
        row.budget = 1ULL << level;
        row.seed = 100 + replicate * levels + level;
        row.samples = 4 * row.budget;
        row.wall_seconds = laws[method].seconds_per_budget * static_cast<double>(row.budget);
        row.cpu_seconds = 2 * row.wall_seconds;
        row.rel_mse = row.rel_mse_raw =
            laws[method].error * factor * std::pow(static_cast<double>(row.budget), laws[method].exponent);
        row.mean = 1;
        row.film_hash = "0123";
        run.rows.push_back(row);
        run.images.push_back({2, 2, std::vector<Vec3>(4, Vec3{1, 1, 1})});
      }
    }
  }
  return run;
}

}  // namespace mlt::test
