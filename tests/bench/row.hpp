// What every benchmark prints: one line of CSV for each figure, which tools/bench.sh joins to one table and
// one file. Median and quartiles over the readings, linear between them; times are processor time, which
// other processes lengthen less than wall time.
#pragma once

#include <fmt/format.h>
#include <time.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <string>
#include <vector>

#include "converge/statistics.hpp"

namespace mlt::test {

/// One measurement. Figure, scene and note hold no comma.
struct BenchRow {
  std::string figure;
  std::string scene;  ///< or what else was measured
  std::string unit;
  std::function<double()> measure = {};  ///< returns one reading
  std::vector<double> readings = {};
  std::string rival = {};  ///< another program's name that was measured on the same, if any
  std::vector<double> rival_readings = {};
  std::string note = {};
};

/// Whether BENCH_QUICK=1 asks for few runs, whose figures show that all works rather than how fast.
inline bool quick_bench() {
  const char* value = std::getenv("BENCH_QUICK");
  return value != nullptr && std::string(value) == "1";
}

/// Of this thread.
inline double cpu_seconds() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// The columns that tools/bench.sh names. A row without readings prints nothing.
inline void print_row(const BenchRow& row) {
  if (row.readings.empty()) return;
  const double middle = median(row.readings);
  std::string rival = ",,";
  if (!row.rival_readings.empty()) {
    const double other = median(row.rival_readings);
    rival = fmt::format("{},{:.4g},{:.3g}", row.rival, other, middle / other);
  }
  fmt::print("{},{},{},{:.4g},{:.4g},{:.4g},{},{},{}\n", row.figure, row.scene, row.unit, middle,
             quantile(row.readings, 0.25), quantile(row.readings, 0.75), row.readings.size(), rival,
             row.note);
  std::fflush(stdout);
}

/// Takes `runs` readings of each row, one of each after the other, so that a change of the clock's frequency
/// or another process meets all rows alike; then prints them.
inline void measure_rows(std::vector<BenchRow>& rows, int runs) {
  for (int run = 0; run < runs; ++run) {
    for (BenchRow& row : rows) row.readings.push_back(row.measure());
  }
  for (const BenchRow& row : rows) print_row(row);
}

/// The body of a benchmark's main: its exit code, or 2 with what went wrong on stderr.
inline int run_bench(int (*run)()) {
  try {
    return run();
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}

}  // namespace mlt::test
