#include "app/converge_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <sstream>

#include "app/request.hpp"

namespace mlt {
namespace {

/// All integrators but auto, which is one of the others.
std::vector<std::string> default_methods() {
  std::vector<std::string> names = names_of(integrator_kinds());
  names.resize(static_cast<std::size_t>(IntegratorKind::automatic));
  return names;
}

constexpr double kLongestSeconds = 86400;
constexpr double kShortestSeconds = 1e-3;
constexpr double kSmallestTarget = 1e-30;
constexpr double kLargestTarget = 1e30;

/// "a,b" to a and b; an empty word between two commas stays, to be refused.
std::vector<std::string> split_list(const std::string& text) {
  std::vector<std::string> words{""};
  for (const char letter : text) {
    if (letter == ',') {
      words.emplace_back();
    } else {
      words.back() += letter;
    }
  }
  return words;
}

/// "a  b" to a and b.
std::vector<std::string> split_at_blanks(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

/// One method from "INTEGRATOR [SETTING]..." as found with `option`, with the settings of the whole command
/// where it has none of its own. Its name says the same with single blanks and the settings in the table's
/// order.
ConvergeMethod read_method(const std::string& option, const std::string& text, ConvergeCommand& command) {
  const std::vector<OptionSpec> settings = method_options();
  const Words words = split_words("mlt converge", settings, split_at_blanks(text));
  Diagnostics diagnostics;
  RenderRequest request = read_request(words, command.request, diagnostics);
  const std::string first = words.positional.empty() ? "" : words.positional.front();
  const auto kind = choose_word(option, first, names_of(integrator_kinds()), diagnostics);
  for (std::size_t i = 1; i < words.positional.size(); ++i) {
    report_value(option, words.positional[i], "settings as of mlt render behind the integrator", diagnostics);
  }
  if (!diagnostics.empty()) throw InputError(std::move(diagnostics));
  request.integrator = static_cast<IntegratorKind>(*kind);
  std::string name = first;
  for (const OptionSpec& setting : settings) {
    if (words.has(setting.name)) name += fmt::format(" {} {}", setting.name, words.get(setting.name));
  }
  for (const std::string& warning : unused_options(words, request.integrator)) {
    command.warnings.push_back(fmt::format("--method '{}': {}", name, warning));
  }
  return {request, name, {}};
}

/// Methods from texts of `option`, --integrators or --method, whose name goes before every fault.
void read_methods(const std::string& option, const std::vector<std::string>& texts, ConvergeCommand& command,
                  Diagnostics& diagnostics) {
  for (const std::string& text : texts) {
    try {
      ConvergeMethod method = read_method(option, text, command);
      const bool twice = std::any_of(command.methods.begin(), command.methods.end(),
                                     [&](const ConvergeMethod& other) { return other.name == method.name; });
      if (twice) report_value(option, method.name, "each method once", diagnostics);
      command.methods.push_back(std::move(method));
    } catch (const InputError& error) {
      for (Diagnostic fault : error.diagnostics()) {
        if (fault.file != option) fault.file = fmt::format("{} '{}': {}", option, text, fault.file);
        diagnostics.push_back(fault);
      }
    }
  }
}

/// Reports a list that is too long or does not increase.
template <class T>
void check_increasing(const char* option, const std::string& text, const std::vector<T>& values,
                      Diagnostics& diagnostics) {
  if (values.size() > kMaxConvergeLevels) {
    report_value(option, text, fmt::format("at most {} numbers", kMaxConvergeLevels), diagnostics);
  }
  if (std::adjacent_find(values.begin(), values.end(), std::greater_equal<>()) != values.end()) {
    report_value(option, text, "numbers that increase", diagnostics);
  }
}

std::vector<std::uint64_t> read_budgets(const std::string& text, Diagnostics& diagnostics) {
  std::vector<std::uint64_t> values;
  for (const std::string& word : split_list(text)) {
    const auto value = parse_integer("--budgets", word, 1, kMaxSamplesPerPixel, diagnostics);
    if (value) values.push_back(*value);
  }
  check_increasing("--budgets", text, values, diagnostics);
  return values;
}

std::vector<double> read_times(const std::string& text, Diagnostics& diagnostics) {
  std::vector<double> values;
  for (const std::string& word : split_list(text)) {
    const auto value = parse_double("--times", word, kShortestSeconds, kLongestSeconds, diagnostics);
    if (value) values.push_back(*value);
  }
  check_increasing("--times", text, values, diagnostics);
  return values;
}

void add_own_options(std::vector<OptionSpec>& table) {
  const auto add = [&table](const char* name, const char* short_name, const char* value, std::string help) {
    table.push_back({name, short_name, value, false, {CommandKind::converge}, std::move(help)});
  };
  add("--output", "-o", "DIR",
      "folder for converge.csv, summary.json, plots and pictures; made when it is not there. Needed");
  add("--integrators", "", "LIST",
      fmt::format("methods to compare, names with commas between them. Default: {}",
                  fmt::join(default_methods(), ",")));
  std::vector<std::string> settings;
  for (const OptionSpec& option : table) {
    if (!option.integrators.empty()) settings.push_back(option.name);
  }
  add("--method", "", "METHOD",
      fmt::format(
          "instead of --integrators, any number of times: an integrator and its settings in one word, e.g. "
          "--method 'pssmlt --large-step 0.5'. Settings are {}; outside of a method they hold for all that "
          "say nothing else",
          fmt::join(settings, ", ")));
  table.back().repeatable = true;
  add("--reference", "", "R.pfm",
      "picture that errors are measured against; R.variance.pfm beside it, the variance of its pixels, is "
      "taken off. Without a reference the error is the variance over replicates");
  add("--budgets", "", "LIST",
      fmt::format("samples or mutations a pixel, increasing, at most {} numbers with commas between them. "
                  "Default: 1,2,4,8,16,32,64",
                  kMaxConvergeLevels));
  add("--times", "", "LIST",
      fmt::format(
          "instead of --budgets: wall seconds a render, {} to {}; each method's budgets are chosen by "
          "trial renders",
          kShortestSeconds, kLongestSeconds));
  add("--replicates", "", "N",
      fmt::format("renders with different seeds for each method and budget, 1 to {}; default 16",
                  kMaxReplicates));
  add("--target", "", "X", "also reports the time and the samples until relMSE is X, with their intervals");
  add("--width", "", "N", "image width in pixels; default: the reference's, else the scene's");
  add("--height", "", "N", "image height in pixels; default: the reference's, else the scene's");
  add("--seed", "", "N",
      fmt::format("first of the run's seeds, which must not be those that made the reference. Default: {}",
                  kDefaultConvergeSeed));
}

/// Looks options up by name.
class Given {
 public:
  explicit Given(const Words& words) : words_(words) {}
  const std::string* operator()(const char* name) const {
    return words_.has(name) ? &words_.get(name) : nullptr;
  }

 private:
  const Words& words_;
};

std::string only_word(const std::string& place, const std::string& name,
                      const std::vector<std::string>& positional, Diagnostics& diagnostics) {
  if (positional.size() == 1 && !positional.front().empty()) return positional.front();
  const std::string found =
      positional.size() > 1 ? "found one word too many, '" + positional[1] + "'" : name + " is missing";
  diagnostics.push_back({place, 0, 0, found + "; expected " + place + " " + name});
  return "";
}

/// --budgets or --times, and --replicates.
void read_effort(const Given& given, ConvergeCommand& command, Diagnostics& diagnostics) {
  const std::string* budgets = given("--budgets");
  const std::string* times = given("--times");
  if (budgets != nullptr && times != nullptr) {
    diagnostics.push_back({"--times", 0, 0, "found together with --budgets; expected one of them"});
  }
  if (times != nullptr) {
    command.times = read_times(*times, diagnostics);
  } else {
    command.budgets = read_budgets(budgets != nullptr ? *budgets : "1,2,4,8,16,32,64", diagnostics);
  }
  if (const std::string* replicates = given("--replicates")) {
    // Without a reference the replicates are measured against their own mean.
    const std::uint64_t fewest = command.reference ? 1 : 2;
    const auto value = parse_integer("--replicates", *replicates, fewest, kMaxReplicates, diagnostics);
    command.replicates = static_cast<std::uint32_t>(value.value_or(command.replicates));
  }
}

/// The methods of --method, or of --integrators, or the default ones.
void read_all_methods(const Words& words, ConvergeCommand& command, Diagnostics& diagnostics) {
  const Given given(words);
  const std::string* names = given("--integrators");
  if (names != nullptr && words.has("--method")) {
    diagnostics.push_back({"--method", 0, 0, "found together with --integrators; expected one of them"});
  }
  if (words.has("--method")) {
    read_methods("--method", words.options.at("--method"), command, diagnostics);
  } else {
    read_methods("--integrators", names != nullptr ? split_list(*names) : default_methods(), command,
                 diagnostics);
  }
}

/// Warns of settings for all methods that none of them looks at.
void add_unused(const Words& words, ConvergeCommand& command) {
  for (const OptionSpec& option : method_options()) {
    const bool used = std::any_of(
        command.methods.begin(), command.methods.end(),
        [&option](const ConvergeMethod& method) { return option.is_used_by(method.settings.integrator); });
    if (used || !words.has(option.name)) continue;
    command.warnings.push_back(fmt::format("{}: has no effect on any of the methods", option.name));
  }
}

}  // namespace

void add_converge_options(std::vector<OptionSpec>& table) {
  const std::vector<std::string> shared{"--depth", "--threads", "--isa", "--memory", "--exposure", "--quiet"};
  for (OptionSpec& option : table) {
    // Another command may have an option of the same name that means something else.
    const bool of_render = std::find(option.commands.begin(), option.commands.end(), CommandKind::render) !=
                           option.commands.end();
    const bool is_shared = std::find(shared.begin(), shared.end(), option.name) != shared.end();
    if (of_render && (is_shared || !option.integrators.empty())) {
      option.commands.push_back(CommandKind::converge);
    }
    if (option.name == "--help") {
      option.commands.insert(option.commands.end(), {CommandKind::converge, CommandKind::report});
    }
  }
  add_own_options(table);
  table.push_back({"--output",
                   "-o",
                   "FILE",
                   false,
                   {CommandKind::report},
                   "the page to write, a name that ends in .html; default: DIR/report.html"});
}

ConvergeCommand make_converge_command(const Words& words) {
  Diagnostics diagnostics;
  ConvergeCommand command;
  command.request = read_request(words, {}, diagnostics);
  command.scene = only_word("mlt converge", "SCENE", words.positional, diagnostics);
  const Given given(words);
  if (const std::string* folder = given("--output")) {
    command.folder = *folder;
  } else {
    diagnostics.push_back({"--output", 0, 0, "is missing; expected -o DIR, the folder for the results"});
  }
  if (given("--seed") == nullptr) command.request.seed = kDefaultConvergeSeed;
  read_all_methods(words, command, diagnostics);
  if (const std::string* reference = given("--reference")) command.reference = *reference;
  read_effort(given, command, diagnostics);
  if (const std::string* target = given("--target")) {
    command.target = parse_double("--target", *target, kSmallestTarget, kLargestTarget, diagnostics);
  }
  if (const std::string* exposure = given("--exposure")) {
    command.exposure =
        parse_real("--exposure", *exposure, -kMaxExposure, kMaxExposure, diagnostics).value_or(0.0f);
  }
  add_unused(words, command);
  command.quiet = given("--quiet") != nullptr;
  if (!diagnostics.empty()) throw InputError(diagnostics);
  return command;
}

ReportCommand make_report_command(const Words& words) {
  Diagnostics diagnostics;
  ReportCommand command;
  command.folder = only_word("mlt report", "DIR", words.positional, diagnostics);
  const std::string* output = Given(words)("--output");
  command.output = output != nullptr ? *output : command.folder + "/report.html";
  if (!diagnostics.empty()) throw InputError(diagnostics);
  return command;
}

}  // namespace mlt
