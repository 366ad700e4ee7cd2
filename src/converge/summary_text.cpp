// A summary as JSON and back, as a table for the terminal, and the rows as CSV.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "base/error.hpp"
#include "base/json_string.hpp"
#include "converge/json.hpp"
#include "converge/summary.hpp"

namespace mlt {
namespace {

/// JSON has no infinity, and an effort that was not reached must not be taken for one that is not known.
constexpr char kInfinityWord[] = "infinity";

std::string json_number(double value) {
  if (std::isinf(value) && value > 0) return json_string(kInfinityWord);
  return std::isfinite(value) ? fmt::format("{}", value) : "null";
}

class Writer {
 public:
  void operator()(const char* name, double value) { add(name, json_number(value)); }
  void operator()(const char* name, bool value) { add(name, value ? "true" : "false"); }
  void operator()(const char* name, const std::string& value) { add(name, json_string(value)); }
  void operator()(const char* name, const Bounded& value) {
    add(name, fmt::format("{{\"value\": {}, \"low\": {}, \"high\": {}}}", json_number(value.value),
                          json_number(value.low), json_number(value.high)));
  }
  void operator()(const char* name, const std::vector<std::string>& values) {
    std::string text = "[";
    for (const std::string& value : values) text += (text.size() > 1 ? ", " : "") + json_string(value);
    add(name, text + "]");
  }
  void operator()(const char* name, const std::vector<LevelSummary>& levels) {
    add_list(name, levels,
             [](Writer& writer, const LevelSummary& level) { visit_level_fields(writer, level); });
  }
  void operator()(const char* name, const std::vector<MethodSummary>& methods) {
    add_list(name, methods,
             [](Writer& writer, const MethodSummary& method) { visit_method_fields(writer, method); });
  }

  explicit Writer(std::size_t indent) : indent_(indent, ' ') {}
  std::string finish() const { return "{\n" + text_ + "\n" + indent_ + "}"; }

 private:
  void add(const char* name, const std::string& value) {
    text_ += (text_.empty() ? "" : ",\n") + indent_ + "  " + json_string(name) + ": " + value;
  }
  template <class T, class Visit>
  void add_list(const char* name, const std::vector<T>& items, const Visit& visit) {
    std::string text;
    for (const T& item : items) {
      Writer writer(indent_.size() + 2);
      visit(writer, item);
      text += (text.empty() ? "" : ", ") + writer.finish();
    }
    add(name, "[" + text + "]");
  }

  std::string text_;
  std::string indent_;
};

class Reader {
 public:
  Reader(const JsonValue& object, const std::string& path) : object_(object), path_(path) {
    if (object.kind != JsonValue::Kind::kObject) fail("an object");
  }

  void operator()(const char* name, double& value) { value = number(find(name), name); }
  void operator()(const char* name, bool& value) {
    const JsonValue& found = find(name);
    if (found.kind != JsonValue::Kind::kBool) fail(std::string("true or false as ") + name);
    value = found.boolean;
  }
  void operator()(const char* name, std::string& value) { value = text(find(name), name); }
  void operator()(const char* name, Bounded& value) {
    Reader reader(find(name), path_);
    reader("value", value.value);
    reader("low", value.low);
    reader("high", value.high);
  }
  void operator()(const char* name, std::vector<std::string>& values) {
    for (const JsonValue& item : list(name)) values.push_back(text(item, name));
  }
  void operator()(const char* name, std::vector<LevelSummary>& levels) {
    for (const JsonValue& item : list(name)) {
      Reader reader(item, path_);
      visit_level_fields(reader, levels.emplace_back());
    }
    if (levels.empty() || levels.size() > kMaxConvergeLevels) fail("1 to 64 levels");
  }
  void operator()(const char* name, std::vector<MethodSummary>& methods) {
    for (const JsonValue& item : list(name)) {
      Reader reader(item, path_);
      visit_method_fields(reader, methods.emplace_back());
    }
    if (methods.empty()) fail("at least one method");
  }

 private:
  [[noreturn]] void fail(const std::string& expected) const {
    throw InputError(Diagnostic{path_, 0, 0, "is not a summary of mlt converge; expected " + expected});
  }
  const JsonValue& find(const char* name) const {
    const JsonValue* found = object_.find(name);
    if (found == nullptr) fail(std::string("the member ") + name);
    return *found;
  }
  const std::vector<JsonValue>& list(const char* name) const {
    const JsonValue& found = find(name);
    if (found.kind != JsonValue::Kind::kArray) fail(std::string("a list as ") + name);
    return found.items;
  }
  double number(const JsonValue& value, const char* name) const {
    if (value.kind == JsonValue::Kind::kNull) return kUnknown;
    if (value.kind == JsonValue::Kind::kString && value.text == kInfinityWord) {
      return std::numeric_limits<double>::infinity();
    }
    if (value.kind != JsonValue::Kind::kNumber) fail(std::string("a number as ") + name);
    return value.number;
  }
  std::string text(const JsonValue& value, const char* name) const {
    if (value.kind != JsonValue::Kind::kString) fail(std::string("text as ") + name);
    return value.text;
  }

  const JsonValue& object_;
  const std::string& path_;
};

/// RFC 4180: quoted where a comma, a quote or a line's end would be taken for structure.
std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char letter : text) quoted += letter == '"' ? std::string("\"\"") : std::string(1, letter);
  return quoted + "\"";
}

std::string shown(double value, const char* format) {
  return std::isnan(value) ? "-" : fmt::format(fmt::runtime(format), value);
}

std::string shown_effort(const Bounded& effort, const char* unit) {
  if (std::isnan(effort.value)) return "-";
  if (effort.value == 0) return "below the first budget's";
  if (std::isinf(effort.value)) return "not reached";
  return fmt::format("{:.3g} {} [{:.3g}, {:.3g}]", effort.value, unit, effort.low, effort.high);
}

void add_method_lines(const ConvergeSummary& summary, const MethodSummary& method, std::string& text) {
  if (!std::isnan(method.slope_samples)) {
    text += fmt::format("{}: slope over time {} +- {}, over samples {} +- {}\n", method.name,
                        shown(method.slope_time, "{:.3f}"), shown(method.slope_time_error, "{:.3f}"),
                        shown(method.slope_samples, "{:.3f}"), shown(method.slope_samples_error, "{:.3f}"));
  }
  if (!std::isnan(method.ratio.value)) {
    text += fmt::format(
        "{}: efficiency against {} at the last budget {:.3g} [{:.3g}, {:.3g}], by processor "
        "time {:.3g} [{:.3g}, {:.3g}]\n",
        method.name, summary.base, method.ratio.value, method.ratio.low, method.ratio.high,
        method.ratio_cpu.value, method.ratio_cpu.low, method.ratio_cpu.high);
  }
  if (std::isnan(summary.target)) return;
  text += fmt::format("{}: relMSE {:.3g} after {}, {}, {}\n", method.name, summary.target,
                      shown_effort(method.seconds_to_target, "s"),
                      shown_effort(method.cpu_seconds_to_target, "s of processors"),
                      shown_effort(method.samples_per_pixel_to_target, "samples a pixel"));
}

}  // namespace

std::string to_json(const ConvergeSummary& summary) {
  Writer writer(0);
  visit_summary_fields(writer, summary);
  return writer.finish() + "\n";
}

ConvergeSummary summary_from_json(const std::string& text, const std::string& path) {
  const JsonValue value = parse_json(text, path);
  Reader reader(value, path);
  ConvergeSummary summary;
  visit_summary_fields(reader, summary);
  for (const MethodSummary& method : summary.methods) {
    const double level = method.equal_time_level;
    if (!(level >= 0 && level < static_cast<double>(method.levels.size()) && level == std::floor(level))) {
      throw InputError(Diagnostic{path, 0, 0, "names no level as equal_time_level; expected 0 and up"});
    }
  }
  return summary;
}

std::string to_csv(const ConvergeRun& run, const std::string& scene) {
  std::string text =
      "scene,method,level,budget,replicate,seed,samples,wall_seconds,cpu_seconds,rel_mse,rel_mse_raw,mse,"
      "mean,film_hash\n";
  for (const Measurement& row : run.rows) {
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", csv_field(scene),
                        csv_field(run.methods[row.method].name), row.level, row.budget, row.replicate,
                        row.seed, row.samples, row.wall_seconds, row.cpu_seconds, row.rel_mse,
                        row.rel_mse_raw, row.mse, row.mean, row.film_hash);
  }
  return text;
}

std::string to_text(const ConvergeSummary& summary) {
  std::size_t width = 10;
  for (const MethodSummary& method : summary.methods) width = std::max(width, method.name.size());
  width += 2;
  std::string text =
      fmt::format("{:<{}}{:>9}{:>11}{:>11}{:>11}{:>12}{:>12}{:>20}{:>9}\n", "method", width, "budget",
                  "wall s", "cpu s", "samples/px", "relMSE 50%", "relMSE 95%", "bias %", "eff/base");
  for (const MethodSummary& method : summary.methods) {
    for (const LevelSummary& level : method.levels) {
      const std::string bias = std::isnan(level.bias) ? "-"
                                                      : fmt::format("{:+.3f} +- {:.3f}", 100 * level.bias,
                                                                    100 * level.bias_standard_error);
      text +=
          fmt::format("{:<{}}{:>9}{:>11.4g}{:>11.4g}{:>11.4g}{:>12.4g}{:>12.4g}{:>20}{:>9}\n", method.name,
                      width, level.budget, level.wall_seconds, level.cpu_seconds, level.samples_per_pixel,
                      level.rel_mse_median, level.rel_mse_p95, bias, shown(level.ratio, "{:.3g}"));
    }
  }
  for (const MethodSummary& method : summary.methods) add_method_lines(summary, method, text);
  return text;
}

}  // namespace mlt
