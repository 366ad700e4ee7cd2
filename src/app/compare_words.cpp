#include <fmt/core.h>

#include <algorithm>

#include "app/compare_command.hpp"
#include "app/options.hpp"
#include "app/words.hpp"

namespace mlt {
namespace {

constexpr double kMaxLimit = 1e30;
constexpr char kPlace[] = "mlt compare";

/// Words of the command, and for --test how many of the positional ones stand before the mark.
struct MarkedWords {
  Words words;
  bool marked = false;
  std::size_t before = 0;
};

/// With --test, "--" divides the sets, and options may stand on both sides of it; otherwise it means, as for
/// every command, that no options follow.
MarkedWords split_marked(const std::vector<std::string>& words) {
  MarkedWords result;
  const auto mark = std::find(words.begin(), words.end(), "--");
  result.marked = mark != words.end() && std::find(words.begin(), mark, "--test") != mark;
  if (result.marked) {
    const std::vector<std::string> left(words.begin(), mark);
    result.before = split_words(kPlace, options_of(CommandKind::compare), left).positional.size();
    std::vector<std::string> all = left;
    all.insert(all.end(), mark + 1, words.end());
    result.words = split_words(kPlace, options_of(CommandKind::compare), all);
  } else {
    result.words = split_words(kPlace, options_of(CommandKind::compare), words);
    result.before = result.words.positional.size();
  }
  return result;
}

class CompareReader {
 public:
  CompareReader(const MarkedWords& marked, Diagnostics& diagnostics)
      : marked_(marked), words_(marked.words), diagnostics_(diagnostics) {}

  CompareCommand read() {
    CompareCommand command;
    command.json = words_.has("--json");
    command.test = words_.has("--test");
    if (command.test) {
      read_sets(command);
    } else {
      read_pair(command);
    }
    refuse_unused(command.test);
    return command;
  }

 private:
  void read_pair(CompareCommand& command) {
    if (check_positional(kPlace, words_.positional, {"A", "B"}, diagnostics_)) {
      command.image = words_.positional[0];
      command.reference = words_.positional[1];
    }
    for (std::size_t i = 0; i < kMetricCount; ++i) {
      number(limit_option(kMetrics[i]).c_str(), 0, kMaxLimit, command.limits[i]);
    }
    text("--difference", command.difference);
    text("--heat-map", command.heat_map);
    number("--difference-range", 1e-30, kMaxLimit, command.difference_range);
    number("--heat-range", 1e-30, kMaxLimit, command.heat_range);
    number("--pixels-per-degree", kMinPixelsPerDegree, kMaxPixelsPerDegree, command.pixels_per_degree);
    choose<MetricKind>("--heat-metric", metric_keys(), command.heat_metric);
    choose<FlipMode>("--flip", flip_modes(), command.flip_mode);
    if (words_.has("--exposure")) {
      command.exposure =
          parse_real("--exposure", words_.get("--exposure"), -kMaxExposure, kMaxExposure, diagnostics_)
              .value_or(0.0f);
    }
  }

  void read_sets(CompareCommand& command) {
    const auto begin = words_.positional.begin();
    const auto middle = begin + static_cast<std::ptrdiff_t>(marked_.before);
    command.first.assign(begin, middle);
    command.second.assign(middle, words_.positional.end());
    if (!marked_.marked || command.first.size() < 2 || command.second.size() < 2) {
      diagnostics_.push_back(
          {kPlace, 0, 0,
           fmt::format(
               "found {} and {} images; expected mlt compare --test A1 A2 ... -- B1 B2 ... with two or "
               "more in each set",
               command.first.size(), command.second.size())});
    }
    number("--alpha", 1e-12, 0.5, command.test_options.alpha);
    if (words_.has("--tile")) {
      const auto tile = parse_integer("--tile", words_.get("--tile"), 1, kMaxTile, diagnostics_);
      if (tile) command.test_options.tile = static_cast<std::uint32_t>(*tile);
    }
    text("--p-picture", command.p_picture);
  }

  /// Options of the other use of the command would be ignored silently.
  void refuse_unused(bool test) {
    std::vector<std::string> unused{"--alpha", "--tile", "--p-picture"};
    if (test) {
      unused = {"--difference", "--difference-range",  "--heat-map", "--heat-metric", "--heat-range",
                "--flip",       "--pixels-per-degree", "--exposure"};
      for (const MetricInfo& metric : kMetrics) unused.push_back(limit_option(metric));
    }
    for (const std::string& name : unused) {
      if (!words_.has(name)) continue;
      diagnostics_.push_back(
          {name, 0, 0,
           test ? "has no meaning together with --test" : "has a meaning only together with --test"});
    }
  }

  template <class Target>
  void number(const char* name, double min, double max, Target& target) {
    if (!words_.has(name)) return;
    const std::optional<double> value = parse_double(name, words_.get(name), min, max, diagnostics_);
    if (value) target = *value;
  }

  void text(const char* name, std::optional<std::string>& target) {
    if (words_.has(name)) target = words_.get(name);
  }

  template <class Kind, class Target>
  void choose(const char* name, const std::vector<std::string>& allowed, Target& target) {
    if (!words_.has(name)) return;
    const auto index = choose_word(name, words_.get(name), allowed, diagnostics_);
    if (index) target = static_cast<Kind>(*index);
  }

  static std::vector<std::string> metric_keys() {
    std::vector<std::string> keys;
    for (const MetricInfo& metric : kMetrics) keys.push_back(metric.key);
    return keys;
  }

  static std::vector<std::string> flip_modes() {
    return {
#define MLT_NAME(name, help) #name,
        MLT_FLIP_MODES(MLT_NAME)
#undef MLT_NAME
    };
  }

  const MarkedWords& marked_;
  const Words& words_;
  Diagnostics& diagnostics_;
};

}  // namespace

std::optional<CompareCommand> parse_compare(const std::vector<std::string>& words) {
  const MarkedWords marked = split_marked(words);
  if (marked.words.has("--help")) return std::nullopt;
  Diagnostics diagnostics;
  CompareCommand command = CompareReader(marked, diagnostics).read();
  if (!diagnostics.empty()) throw InputError(std::move(diagnostics));
  return command;
}

}  // namespace mlt
