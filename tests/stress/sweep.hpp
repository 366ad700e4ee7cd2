// Sweeps: one property of the renderer over a range of one parameter, printed as a table of what was
// measured, what was to be expected, the error and what error is allowed. A row fails when its error exceeds
// the tolerance, or when any contribution of its renders was not finite or negative.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "render/render_fixture.hpp"

namespace mlt::test {

/// Rows of all sweeps, roughly: tolerances of statistical rows are such that a right renderer fails any of
/// them for one choice of the seeds in a thousand.
inline constexpr std::size_t kStatisticalRows = 500;

/// The |t| that Student's distribution exceeds with probability `p_value`, two-sided.
double student_quantile(double p_value, double dof);

/// What one row compares. Errors are relative to `expected` unless that is 0.
struct Measurement {
  double measured = 0;
  double expected = 0;
  double tolerance = 0;
  std::uint64_t defects = 0;  ///< contributions that were rejected
};

/// `expected` against the mean of replicates. The tolerance is the deviation that Student's test allows plus
/// `slack`, which is relative to `expected` and covers rounding and stated truncation.
Measurement against_exact(const Moments& replicates, double expected, double slack);
/// The same for the film's mean luminance, with the defects of all replicates.
Measurement film_mean(const std::vector<RenderResult>& replicates, double expected, double slack);
/// Two sets of replicates; the second is the reference.
Measurement against_replicates(const Moments& replicates, const Moments& reference, double slack);

std::uint64_t defects_of(const std::vector<RenderResult>& replicates);

/// A whole number, a power of ten or any other number, in as few characters as tell it.
std::string text_of(double value);
/// With all digits, for scene files.
std::string exact_text_of(double value);

class SweepTable {
 public:
  /// `basis` says where the expected values and the tolerances come from.
  SweepTable(std::string title, std::string parameter, std::string basis);
  SweepTable(const SweepTable&) = delete;
  /// Prints the table and fails the test case for every row that failed.
  ~SweepTable() noexcept(false);

  void add(const std::string& parameter, const Measurement& measurement);
  void add(double parameter, const char* variant, const Measurement& measurement);
  /// A row beyond the stated range, to show how the error grows. Only defects fail it.
  void add_outside(const std::string& parameter, const Measurement& measurement);
  /// A row that holds or not: equal hashes, a message that says what it must.
  void add_fact(const std::string& parameter, const std::string& what, bool holds);

 private:
  struct Row {
    std::string parameter, text;
    double error = 0;
    bool passed = false;
    bool measured = false;
    bool outside = false;
  };

  static Row row_of(const std::string& parameter, const Measurement& measurement);

  std::string title_, parameter_, basis_;
  std::vector<Row> rows_;
};

/// Rows for the scene by every integrator: the film's mean luminance over 16 replicates against `expected`.
void add_film_means(SweepTable& table, const std::string& parameter, const std::string& scene_text,
                    std::uint32_t side, std::uint64_t samples_per_pixel, std::uint32_t depth, double expected,
                    double slack);

/// The diagnostics that reading `scene_text` ends with, or its warnings; empty when there is neither.
std::string messages_of(const std::string& scene_text);
std::string file_messages_of(const std::string& path);
/// A row for a scene whose reading must say `wanted`; "" stands for silence.
void add_message(SweepTable& table, const std::string& parameter, const std::string& scene_text,
                 const std::string& wanted);

}  // namespace mlt::test
