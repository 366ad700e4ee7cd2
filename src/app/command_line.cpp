#include "app/command_line.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "app/number.hpp"
#include "app/options.hpp"
#include "app/version.hpp"
#include "base/assert.hpp"
#include "base/error.hpp"

namespace mlt {
namespace {

constexpr double kMaxRelMseLimit = 1e30;

[[noreturn]] void fail(const std::string& place, const std::string& message) {
  throw InputError(Diagnostic{place, 0, 0, message});
}

/// The end of a message: what may have been meant, then what is allowed.
std::string allowed_instead(const std::string& word, const std::vector<std::string>& allowed) {
  const std::string hint = suggest(word, allowed);
  return (hint.empty() ? "; expected " : hint + " Expected ") + fmt::format("{}", fmt::join(allowed, ", "));
}

/// Options and positional words of one command, as strings.
struct Words {
  std::map<std::string, std::vector<std::string>> options;  ///< by long name
  std::vector<std::string> positional;

  bool has(const std::string& name) const { return options.count(name) > 0; }
  const std::string& get(const std::string& name) const { return options.at(name).front(); }
};

/// "--spp N", or the name alone for a switch.
std::string usage_of(CommandKind command, const std::string& name) {
  for (const OptionSpec& option : options_of(command)) {
    if (option.name == name || option.short_name == name) {
      return option.value.empty() ? name : name + " " + option.value;
    }
  }
  return "options as in the help text";
}

void report_unknown(const std::string& place, CommandKind command, const std::string& word,
                    Diagnostics& diagnostics) {
  std::vector<std::string> names;
  for (const OptionSpec& option : options_of(command)) names.push_back(option.name);
  const std::string name = word.substr(0, word.find('='));
  const std::string hint = suggest(name, names);
  diagnostics.push_back(
      {name, 0, 0,
       "unknown option" + (hint.empty() ? std::string("; ") : hint + " ") + "see '" + place + " --help'"});
}

/// Reports options given more often than allowed.
void check_counts(CommandKind command, const Words& words, Diagnostics& diagnostics) {
  for (const OptionSpec& option : options_of(command)) {
    const auto found = words.options.find(option.name);
    if (option.repeatable || found == words.options.end() || found->second.size() < 2) continue;
    diagnostics.push_back(
        {option.name, 0, 0, fmt::format("found {} times; expected once", found->second.size())});
  }
}

/// Splits `words` by the option table. Throws InputError for unknown options, and for options without their
/// value or too often.
Words split_words(const std::string& place, CommandKind command, std::vector<std::string> words) {
  CLI::App app;
  app.set_help_flag();
  app.allow_extras();
  Words result;
  std::map<std::string, bool> switches;
  for (const OptionSpec& option : options_of(command)) {
    const std::string names = option.short_name.empty() ? option.name : option.short_name + "," + option.name;
    if (option.value.empty()) {
      app.add_flag(names, switches[option.name])->disable_flag_override();
    } else {
      // Counted below instead of by the library, for messages that say what was found.
      CLI::Option* added = app.add_option(names, result.options[option.name]);
      added->expected(1)->allow_extra_args(false)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    }
  }
  app.add_option("words", result.positional)->expected(0, std::numeric_limits<int>::max());
  std::reverse(words.begin(), words.end());
  try {
    app.parse(std::move(words));
  } catch (const CLI::ParseError& error) {
    // The library's text starts with the option's name.
    const std::string text = error.what();
    const std::string name = text.substr(0, text.find_first_of(": "));
    if (name.starts_with("-")) fail(name, "found no value; expected " + usage_of(command, name));
    fail(place, text + "; see '" + place + " --help'");
  }
  std::erase_if(result.options, [](const auto& item) { return item.second.empty(); });
  for (const auto& [name, given] : switches) {
    if (given) result.options[name] = {""};
  }
  Diagnostics diagnostics;
  for (const std::string& word : app.remaining()) {
    // The mark itself, behind which every word is positional, is handed back too.
    if (word != "--") report_unknown(place, command, word, diagnostics);
  }
  check_counts(command, result, diagnostics);
  if (!diagnostics.empty()) throw InputError(std::move(diagnostics));
  return result;
}

/// Parses the values of the options that make a RenderRequest.
class RequestReader {
 public:
  RequestReader(const Words& words, Diagnostics& diagnostics) : words_(words), diagnostics_(diagnostics) {}

  RenderRequest read() {
    RenderRequest request;
    choose("--integrator", integrator_kinds(), request.integrator);
    integer("--width", 1, kMaxFilmSide, request.width);
    integer("--height", 1, kMaxFilmSide, request.height);
    integer("--spp", 1, kMaxSamplesPerPixel, request.samples_per_pixel);
    integer("--mutations", 1, kMaxSamplesPerPixel, request.samples_per_pixel);
    if (words_.has("--spp") && words_.has("--mutations")) {
      diagnostics_.push_back(
          {"--mutations", 0, 0, "found together with --spp, which means the same; expected one"});
    }
    integer("--depth", 1, kMaxDepth, request.depth);
    integer("--threads", 1, kMaxThreads, request.threads);
    integer("--seed", 0, std::numeric_limits<std::uint64_t>::max(), request.seed);
    integer("--chains", 1, kMaxChains, request.chains);
    integer("--bootstrap", 1, kMaxBootstrap, request.bootstrap);
    if (words_.has("--large-step")) {
      request.large_step = parse_real("--large-step", words_.get("--large-step"), 0, 1, diagnostics_)
                               .value_or(request.large_step);
    }
    choose("--start", start_kinds(), request.start);
    choose("--mutation", mutation_kinds(), request.mutation);
    roulette(request.roulette);
    if (words_.has("--isa")) {
      request.instruction_set = best_instruction_set();
      choose("--isa", instruction_sets(), *request.instruction_set);
    }
    if (words_.has("--memory")) {
      request.memory_limit =
          parse_bytes("--memory", words_.get("--memory"), diagnostics_).value_or(request.memory_limit);
    }
    return request;
  }

  /// The options given that the chosen integrator does not look at.
  std::vector<std::string> unused(const RenderRequest& request) const {
    std::vector<std::string> warnings;
    if (request.integrator == IntegratorKind::pssmlt) return warnings;
    for (const char* name : {"--chains", "--bootstrap", "--large-step", "--start", "--mutation"}) {
      if (!words_.has(name)) continue;
      warnings.push_back(fmt::format("{}: has no effect with --integrator {}", name,
                                     integrator_kinds()[static_cast<std::size_t>(request.integrator)].name));
    }
    return warnings;
  }

 private:
  template <class Target>
  void integer(const char* name, std::uint64_t min, std::uint64_t max, Target& target) {
    if (!words_.has(name)) return;
    const auto value = parse_integer(name, words_.get(name), min, max, diagnostics_);
    if (value) target = static_cast<decltype(target_value(target))>(*value);
  }
  template <class T>
  static T target_value(const std::optional<T>&);
  static std::uint64_t target_value(const std::uint64_t&);

  template <class Kind>
  void choose(const char* name, const std::vector<NamedKind>& kinds, Kind& chosen) {
    if (!words_.has(name)) return;
    const std::string& word = words_.get(name);
    for (std::size_t i = 0; i < kinds.size(); ++i) {
      if (kinds[i].name == word) {
        chosen = static_cast<Kind>(i);
        return;
      }
    }
    diagnostics_.push_back({name, 0, 0, "found '" + word + "'" + allowed_instead(word, names_of(kinds))});
  }

  void roulette(std::optional<std::uint32_t>& target) {
    if (!words_.has("--roulette")) return;
    const std::string& word = words_.get("--roulette");
    Diagnostics ignored;
    const auto value = parse_integer("--roulette", word, 1, kMaxDepth, ignored);
    if (word == "off") {
      target = 0;
    } else if (value) {
      target = static_cast<std::uint32_t>(*value);
    } else {
      report_value("--roulette", word, fmt::format("'off' or an integer from 1 to {}", kMaxDepth),
                   diagnostics_);
    }
  }

  const Words& words_;
  Diagnostics& diagnostics_;
};

/// "folder/name.txt" to "name.png".
std::string default_output(const std::string& scene) {
  std::string name = scene.substr(scene.rfind('/') == std::string::npos ? 0 : scene.rfind('/') + 1);
  const std::size_t dot = name.rfind('.');
  if (dot != std::string::npos && dot > 0) name.resize(dot);
  return name + ".png";
}

/// Reports a number of positional words other than `names`; returns whether it was right.
bool check_positional(const std::string& place, const std::vector<std::string>& words,
                      const std::vector<std::string>& names, Diagnostics& diagnostics) {
  for (std::size_t i = words.size(); i < names.size(); ++i) {
    diagnostics.push_back(
        {place, 0, 0,
         names[i] + " is missing; expected " + fmt::format("{} {}", place, fmt::join(names, " "))});
  }
  for (std::size_t i = names.size(); i < words.size(); ++i) {
    diagnostics.push_back({place, 0, 0,
                           fmt::format("found one word too many, '{}'; expected {} {}", words[i], place,
                                       fmt::join(names, " "))});
  }
  return words.size() == names.size();
}

Command parse_render(const Words& words) {
  Diagnostics diagnostics;
  RenderCommand command;
  check_positional("mlt render", words.positional, {"SCENE"}, diagnostics);
  RequestReader reader(words, diagnostics);
  command.request = reader.read();
  command.warnings = reader.unused(command.request);
  if (words.has("--exposure")) {
    command.exposure =
        parse_real("--exposure", words.get("--exposure"), -kMaxExposure, kMaxExposure, diagnostics)
            .value_or(0.0f);
  }
  command.quiet = words.has("--quiet");
  if (words.has("--stats")) command.stats = words.get("--stats");
  if (!diagnostics.empty()) throw InputError(std::move(diagnostics));
  command.scene = words.positional.front();
  command.outputs = words.has("--output") ? words.options.at("--output")
                                          : std::vector<std::string>{default_output(command.scene)};
  return command;
}

Command parse_info(const Words& words) {
  Diagnostics diagnostics;
  InfoCommand command;
  check_positional("mlt info", words.positional, {"SCENE"}, diagnostics);
  RequestReader reader(words, diagnostics);
  command.request = reader.read();
  command.warnings = reader.unused(command.request);
  if (!diagnostics.empty()) throw InputError(std::move(diagnostics));
  command.scene = words.positional.front();
  return command;
}

Command parse_compare(const Words& words) {
  Diagnostics diagnostics;
  CompareCommand command;
  check_positional("mlt compare", words.positional, {"A.pfm", "B.pfm"}, diagnostics);
  if (words.has("--max-relmse")) {
    command.max_rel_mse =
        parse_double("--max-relmse", words.get("--max-relmse"), 0, kMaxRelMseLimit, diagnostics);
  }
  if (!diagnostics.empty()) throw InputError(std::move(diagnostics));
  command.image = words.positional[0];
  command.reference = words.positional[1];
  return command;
}

Command parse_classic(const std::vector<std::string>& words) {
  Diagnostics diagnostics;
  const bool complete = check_positional(
      "mlt", words, {"WIDTH", "HEIGHT", "MUTATIONS", "THREADS", "DEPTH", "SCENE"}, diagnostics);
  RenderCommand command;
  const auto number = [&](std::size_t index, const char* name, std::uint64_t max) {
    return index < words.size() ? parse_integer(name, words[index], 1, max, diagnostics).value_or(1) : 1;
  };
  command.request.width = static_cast<std::uint32_t>(number(0, "WIDTH", kMaxFilmSide));
  command.request.height = static_cast<std::uint32_t>(number(1, "HEIGHT", kMaxFilmSide));
  command.request.samples_per_pixel = number(2, "MUTATIONS", kMaxSamplesPerPixel);
  command.request.threads = static_cast<std::uint32_t>(number(3, "THREADS", kMaxThreads));
  command.request.depth = static_cast<std::uint32_t>(number(4, "DEPTH", kMaxDepth));
  if (!complete || !diagnostics.empty()) throw InputError(std::move(diagnostics));
  command.scene = words[5];
  command.outputs = {default_output(command.scene)};
  return command;
}

bool looks_like_number(const std::string& word) {
  const std::size_t first = !word.empty() && (word[0] == '-' || word[0] == '+') ? 1 : 0;
  return word.size() > first && word[first] >= '0' && word[first] <= '9';
}

bool is_help(const std::string& word) {
  return word == "--help" || word == "-h";
}

CommandKind command_of(const std::string& word) {
  std::vector<std::string> names = command_names();
  const auto found = std::find(names.begin(), names.end(), word);
  if (found != names.end()) return static_cast<CommandKind>(found - names.begin());
  struct stat status {};
  if (::stat(word.c_str(), &status) == 0) {
    fail("mlt", "found the file '" + word + "' where a command belongs; expected 'mlt render " + word + "'");
  }
  names.insert(names.end(), {"--help", "--version"});
  fail("mlt", (word.starts_with("-") ? "unknown option '" : "unknown command '") + word + "'" +
                  allowed_instead(word, names));
}

Command parse_help(const std::vector<std::string>& words) {
  if (words.empty() || is_help(words[0])) return TextCommand{general_help()};
  if (words.size() > 1)
    fail("mlt help", "found one word too many, '" + words[1] + "'; expected mlt help [COMMAND]");
  return TextCommand{command_help(command_of(words[0]))};
}

}  // namespace

Command parse_command_line(const std::vector<std::string>& words) {
  if (words.empty())
    fail("mlt", "no command given; expected one of " + fmt::format("{}", fmt::join(command_names(), ", ")) +
                    "; see 'mlt --help'");
  const std::string& first = words[0];
  if (looks_like_number(first)) return parse_classic(words);
  if (is_help(first)) return TextCommand{general_help()};
  if (first == "--version") return TextCommand{fmt::format("mlt {}\n", kVersion)};
  const CommandKind command = command_of(first);
  const std::vector<std::string> rest(words.begin() + 1, words.end());
  if (command == CommandKind::help) return parse_help(rest);
  const Words split = split_words("mlt " + first, command, rest);
  if (split.has("--help")) return TextCommand{command_help(command)};
  switch (command) {
    case CommandKind::render:
      return parse_render(split);
    case CommandKind::info:
      return parse_info(split);
    case CommandKind::compare:
      return parse_compare(split);
    case CommandKind::converge: {
      Diagnostics diagnostics;
      const RenderRequest request = RequestReader(split, diagnostics).read();
      return make_converge_command(split.options, split.positional, request, diagnostics);
    }
    case CommandKind::report:
      return make_report_command(split.options, split.positional);
    case CommandKind::help:
      break;
  }
  MLT_CHECK(command != CommandKind::help);
  return TextCommand{};
}

}  // namespace mlt
