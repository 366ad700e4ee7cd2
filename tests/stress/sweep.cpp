#include "sweep.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "base/error.hpp"

namespace mlt::test {
namespace {

double relative(double difference, double expected) {
  return expected == 0 ? std::fabs(difference) : std::fabs(difference / expected);
}

double significance() {
  return sidak_threshold(1e-3, kStatisticalRows);
}

}  // namespace

double student_quantile(double p_value, double dof) {
  double low = 0, high = 1e6;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (student_p_value(middle, dof) > p_value ? low : high) = middle;
  }
  return high;
}

Measurement against_exact(const Moments& replicates, double expected, double slack) {
  const double quantile = student_quantile(significance(), static_cast<double>(replicates.count - 1));
  return {replicates.mean, expected, relative(quantile * replicates.standard_error(), expected) + slack, 0};
}

Measurement film_mean(const std::vector<RenderResult>& replicates, double expected, double slack) {
  Measurement result = against_exact(luminance_of(replicates), expected, slack);
  result.defects = defects_of(replicates);
  return result;
}

Measurement against_replicates(const Moments& replicates, const Moments& reference, double slack) {
  const double error = std::hypot(replicates.standard_error(), reference.standard_error());
  const double dof = welch_t_test(replicates, reference).dof;
  const double quantile = dof > 0 ? student_quantile(significance(), dof) : 0.0;
  return {replicates.mean, reference.mean, relative(quantile * error, reference.mean) + slack, 0};
}

std::uint64_t defects_of(const std::vector<RenderResult>& replicates) {
  std::uint64_t defects = 0;
  for (const RenderResult& replicate : replicates) defects += replicate.statistics.rejected_non_finite();
  return defects;
}

std::string text_of(double value) {
  return fmt::format("{:.8g}", value);
}

std::string exact_text_of(double value) {
  return fmt::format("{:.17g}", value);
}

SweepTable::SweepTable(std::string title, std::string parameter, std::string basis)
    : title_(std::move(title)), parameter_(std::move(parameter)), basis_(std::move(basis)) {}

SweepTable::Row SweepTable::row_of(const std::string& parameter, const Measurement& m) {
  Row row;
  row.parameter = parameter;
  row.measured = true;
  row.error = relative(m.measured - m.expected, m.expected);
  row.passed = row.error <= m.tolerance && m.defects == 0;
  row.text =
      fmt::format("{:>14.7g} {:>14.7g} {:>9.1e} {:>9.1e}", m.measured, m.expected, row.error, m.tolerance);
  if (m.defects > 0) row.text += fmt::format("  {} contributions rejected", m.defects);
  return row;
}

void SweepTable::add(const std::string& parameter, const Measurement& measurement) {
  rows_.push_back(row_of(parameter, measurement));
}

void SweepTable::add(double parameter, const char* variant, const Measurement& measurement) {
  add(text_of(parameter) + " " + variant, measurement);
}

void SweepTable::add_outside(const std::string& parameter, const Measurement& measurement) {
  Row row = row_of(parameter, measurement);
  row.passed = measurement.defects == 0 && std::isfinite(measurement.measured);
  row.outside = true;
  rows_.push_back(row);
}

void SweepTable::add_fact(const std::string& parameter, const std::string& what, bool holds) {
  rows_.push_back({parameter, what, 0, holds, false, false});
}

SweepTable::~SweepTable() noexcept(false) {
  std::size_t width = parameter_.size();
  for (const Row& row : rows_) width = std::max(width, row.parameter.size());
  std::string text = fmt::format("\n{}\n  {}\n  {:<{}} {:>14} {:>14} {:>9} {:>9}\n", title_, basis_,
                                 parameter_, width, "measured", "expected", "error", "allowed");
  const Row* worst = nullptr;
  for (const Row& row : rows_) {
    const char* verdict = !row.passed ? "FAILED" : row.outside ? "outside" : "ok";
    text += fmt::format("  {:<{}} {}  {}\n", row.parameter, width, row.text, verdict);
    if (!row.measured || row.outside) continue;
    if (worst == nullptr || !(row.error <= worst->error)) worst = &row;
  }
  if (worst != nullptr) text += fmt::format("  worst error {:.1e} at {}\n", worst->error, worst->parameter);
  std::fputs(text.c_str(), stdout);
  std::fflush(stdout);
  for (const Row& row : rows_) {
    INFO(title_ << ": " << row.parameter << " " << row.text);
    CHECK(row.passed);
  }
}

void add_film_means(SweepTable& table, const std::string& parameter, const std::string& scene_text,
                    std::uint32_t side, std::uint64_t samples_per_pixel, std::uint32_t depth, double expected,
                    double slack) {
  const SceneDescription scene = parse_scene_text(scene_text, "sweep");
  for (const IntegratorKind kind : kIntegrators) {
    const RenderRequest request = small_request(kind, side, scaled_effort(samples_per_pixel), depth);
    const auto replicates = render_replicates(scene, request, 16, 100);
    table.add(parameter + " " + name_of(kind), film_mean(replicates, expected, slack));
  }
}

namespace {

template <class Read>
std::string collect_messages(Read&& read) {
  std::string text;
  try {
    for (const std::string& warning : read().warnings) text += warning + "\n";
  } catch (const InputError& error) {
    for (const Diagnostic& diagnostic : error.diagnostics()) text += diagnostic.to_string() + "\n";
  } catch (const ResourceError& error) {
    text += error.what();
  }
  return text;
}

}  // namespace

std::string messages_of(const std::string& scene_text) {
  return collect_messages([&] { return parse_scene_text(scene_text, "scene"); });
}

std::string file_messages_of(const std::string& path) {
  return collect_messages([&] { return parse_scene_file(path); });
}

void add_message(SweepTable& table, const std::string& parameter, const std::string& scene_text,
                 const std::string& wanted) {
  const std::string message = messages_of(scene_text);
  const bool holds = wanted.empty() ? message.empty() : message.find(wanted) != std::string::npos;
  table.add_fact(parameter, message.empty() ? "(no message)" : message.substr(0, message.find('\n')), holds);
}

}  // namespace mlt::test
