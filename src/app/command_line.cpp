#include "app/command_line.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "app/number.hpp"
#include "app/options.hpp"
#include "app/request.hpp"
#include "app/version.hpp"
#include "app/words.hpp"
#include "base/assert.hpp"
#include "base/error.hpp"

namespace mlt {
namespace {

/// "folder/name.txt" to "name.png".
std::string default_output(const std::string& scene) {
  std::string name = scene.substr(scene.rfind('/') == std::string::npos ? 0 : scene.rfind('/') + 1);
  const std::size_t dot = name.rfind('.');
  if (dot != std::string::npos && dot > 0) name.resize(dot);
  return name + ".png";
}

/// The full form leaves the integrator to a pilot, unless a setting that PSSMLT alone has speaks for it, or
/// the work is given in mutations. The classic form is that of a Metropolis renderer.
RenderRequest full_form_defaults(const Words& words) {
  RenderRequest defaults;
  const std::vector<OptionSpec> settings = method_options();
  const bool speaks_of_chains =
      words.has("--mutations") ||
      std::any_of(settings.begin(), settings.end(), [&words](const OptionSpec& option) {
        return words.has(option.name) && !option.is_used_by(IntegratorKind::path);
      });
  defaults.integrator = speaks_of_chains ? IntegratorKind::pssmlt : IntegratorKind::automatic;
  return defaults;
}

Command parse_render(const Words& words) {
  Diagnostics diagnostics;
  RenderCommand command;
  check_positional("mlt render", words.positional, {"SCENE"}, diagnostics);
  command.request = read_request(words, full_form_defaults(words), diagnostics);
  command.warnings = unused_options(words, command.request.integrator);
  if (words.has("--exposure")) {
    command.exposure =
        parse_real("--exposure", words.get("--exposure"), -kMaxExposure, kMaxExposure, diagnostics)
            .value_or(0.0f);
  }
  command.quiet = words.has("--quiet");
  if (words.has("--stats")) command.stats = words.get("--stats");
  if (words.has("--error-image")) command.error_image = words.get("--error-image");
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
  command.request = read_request(words, full_form_defaults(words), diagnostics);
  command.warnings = unused_options(words, command.request.integrator);
  if (!diagnostics.empty()) throw InputError(std::move(diagnostics));
  command.scene = words.positional.front();
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
    fail_words("mlt",
               "found the file '" + word + "' where a command belongs; expected 'mlt render " + word + "'");
  }
  names.insert(names.end(), {"--help", "--version"});
  fail_words("mlt", (word.starts_with("-") ? "unknown option '" : "unknown command '") + word + "'" +
                        allowed_instead(word, names));
}

Command parse_help(const std::vector<std::string>& words) {
  if (words.empty() || is_help(words[0])) return TextCommand{general_help()};
  if (words.size() > 1)
    fail_words("mlt help", "found one word too many, '" + words[1] + "'; expected mlt help [COMMAND]");
  return TextCommand{command_help(command_of(words[0]))};
}

}  // namespace

Command parse_command_line(const std::vector<std::string>& words) {
  if (words.empty())
    fail_words("mlt", "no command given; expected one of " +
                          fmt::format("{}", fmt::join(command_names(), ", ")) + "; see 'mlt --help'");
  const std::string& first = words[0];
  if (looks_like_number(first)) return parse_classic(words);
  if (is_help(first)) return TextCommand{general_help()};
  if (first == "--version") return TextCommand{fmt::format("mlt {}\n", kVersion)};
  const CommandKind command = command_of(first);
  const std::vector<std::string> rest(words.begin() + 1, words.end());
  if (command == CommandKind::help) return parse_help(rest);
  if (command == CommandKind::compare) {
    std::optional<CompareCommand> compare = parse_compare(rest);
    return compare ? Command{std::move(*compare)} : Command{TextCommand{command_help(command)}};
  }
  const Words split = split_words("mlt " + first, options_of(command), rest);
  if (split.has("--help")) return TextCommand{command_help(command)};
  switch (command) {
    case CommandKind::render:
      return parse_render(split);
    case CommandKind::info:
      return parse_info(split);
    case CommandKind::converge:
      return make_converge_command(split);
    case CommandKind::report:
      return make_report_command(split);
    case CommandKind::compare:
    case CommandKind::help:
      break;
  }
  MLT_CHECK(command != CommandKind::help);
  return TextCommand{};
}

}  // namespace mlt
