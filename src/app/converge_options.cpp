#include "app/converge_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace mlt {
namespace {

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

std::vector<ConvergeMethod> read_methods(const std::string& text, Diagnostics& diagnostics) {
  const std::vector<NamedKind>& kinds = integrator_kinds();
  std::vector<ConvergeMethod> methods;
  for (const std::string& word : split_list(text)) {
    const auto found = std::find_if(kinds.begin(), kinds.end(),
                                    [&word](const NamedKind& kind) { return kind.name == word; });
    if (found == kinds.end()) {
      const std::string hint = suggest(word, names_of(kinds));
      report_value("--integrators", word,
                   fmt::format("a list of {}{}", fmt::join(names_of(kinds), ", "), hint), diagnostics);
      continue;
    }
    const bool twice = std::any_of(methods.begin(), methods.end(),
                                   [&word](const ConvergeMethod& method) { return method.name == word; });
    if (twice) report_value("--integrators", text, "each name once", diagnostics);
    methods.push_back({static_cast<IntegratorKind>(found - kinds.begin()), word, {}});
  }
  return methods;
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
                  fmt::join(names_of(integrator_kinds()), ",")));
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
  explicit Given(const OptionWords& options) : options_(options) {}
  const std::string* operator()(const char* name) const {
    const auto found = options_.find(name);
    return found == options_.end() ? nullptr : &found->second.front();
  }

 private:
  const OptionWords& options_;
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

/// Warns of options that none of the methods looks at.
void add_unused(const Given& given, ConvergeCommand& command) {
  for (const ConvergeMethod& method : command.methods) {
    if (method.kind == IntegratorKind::pssmlt) return;
  }
  for (const char* name : {"--chains", "--bootstrap", "--large-step", "--start", "--mutation"}) {
    if (given(name) == nullptr) continue;
    command.warnings.push_back(fmt::format("{}: has no effect without pssmlt among --integrators", name));
  }
}

}  // namespace

void add_converge_options(std::vector<OptionSpec>& table) {
  const std::vector<std::string> shared{"--depth", "--chains",   "--bootstrap", "--large-step",
                                        "--start", "--mutation", "--roulette",  "--threads",
                                        "--isa",   "--memory",   "--exposure",  "--quiet"};
  for (OptionSpec& option : table) {
    // Another command may have an option of the same name that means something else.
    const bool of_render = std::find(option.commands.begin(), option.commands.end(), CommandKind::render) !=
                           option.commands.end();
    if (of_render && std::find(shared.begin(), shared.end(), option.name) != shared.end()) {
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

ConvergeCommand make_converge_command(const OptionWords& options, const std::vector<std::string>& positional,
                                      const RenderRequest& request, Diagnostics& diagnostics) {
  ConvergeCommand command;
  command.request = request;
  command.scene = only_word("mlt converge", "SCENE", positional, diagnostics);
  const Given given(options);
  if (const std::string* folder = given("--output")) {
    command.folder = *folder;
  } else {
    diagnostics.push_back({"--output", 0, 0, "is missing; expected -o DIR, the folder for the results"});
  }
  const std::string* names = given("--integrators");
  command.methods = read_methods(
      names != nullptr ? *names : fmt::format("{}", fmt::join(names_of(integrator_kinds()), ",")),
      diagnostics);
  if (const std::string* reference = given("--reference")) command.reference = *reference;
  read_effort(given, command, diagnostics);
  if (const std::string* target = given("--target")) {
    command.target = parse_double("--target", *target, kSmallestTarget, kLargestTarget, diagnostics);
  }
  if (const std::string* exposure = given("--exposure")) {
    command.exposure =
        parse_real("--exposure", *exposure, -kMaxExposure, kMaxExposure, diagnostics).value_or(0.0f);
  }
  add_unused(given, command);
  if (given("--seed") == nullptr) command.request.seed = kDefaultConvergeSeed;
  command.quiet = given("--quiet") != nullptr;
  if (!diagnostics.empty()) throw InputError(diagnostics);
  return command;
}

ReportCommand make_report_command(const OptionWords& options, const std::vector<std::string>& positional) {
  Diagnostics diagnostics;
  ReportCommand command;
  command.folder = only_word("mlt report", "DIR", positional, diagnostics);
  const std::string* output = Given(options)("--output");
  command.output = output != nullptr ? *output : command.folder + "/report.html";
  if (!diagnostics.empty()) throw InputError(diagnostics);
  return command;
}

}  // namespace mlt
