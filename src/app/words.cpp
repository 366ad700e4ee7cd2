#include "app/words.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <limits>
#include <utility>

#include "base/error.hpp"

namespace mlt {
namespace {

/// "--spp N", or the name alone for a switch.
std::string usage_of(const std::vector<OptionSpec>& options, const std::string& name) {
  for (const OptionSpec& option : options) {
    if (option.name == name || option.short_name == name) {
      return option.value.empty() ? name : name + " " + option.value;
    }
  }
  return "options as in the help text";
}

void report_unknown(const std::string& place, const std::vector<OptionSpec>& options, const std::string& word,
                    Diagnostics& diagnostics) {
  std::vector<std::string> names;
  for (const OptionSpec& option : options) names.push_back(option.name);
  const std::string name = word.substr(0, word.find('='));
  const std::string hint = suggest(name, names);
  diagnostics.push_back(
      {name, 0, 0,
       "unknown option" + (hint.empty() ? std::string("; ") : hint + " ") + "see '" + place + " --help'"});
}

/// Reports options given more often than allowed.
void check_counts(const std::vector<OptionSpec>& options, const Words& words, Diagnostics& diagnostics) {
  for (const OptionSpec& option : options) {
    const auto found = words.options.find(option.name);
    if (option.repeatable || found == words.options.end() || found->second.size() < 2) continue;
    diagnostics.push_back(
        {option.name, 0, 0, fmt::format("found {} times; expected once", found->second.size())});
  }
}

}  // namespace

void fail_words(const std::string& place, const std::string& message) {
  throw InputError(Diagnostic{place, 0, 0, message});
}

std::string allowed_instead(const std::string& word, const std::vector<std::string>& allowed) {
  const std::string hint = suggest(word, allowed);
  return (hint.empty() ? "; expected " : hint + " Expected ") + fmt::format("{}", fmt::join(allowed, ", "));
}

Words split_words(const std::string& place, const std::vector<OptionSpec>& options,
                  std::vector<std::string> words) {
  CLI::App app;
  app.set_help_flag();
  app.allow_extras();
  Words result;
  std::map<std::string, bool> switches;
  for (const OptionSpec& option : options) {
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
    if (name.starts_with("-")) fail_words(name, "found no value; expected " + usage_of(options, name));
    fail_words(place, text + "; see '" + place + " --help'");
  }
  std::erase_if(result.options, [](const auto& item) { return item.second.empty(); });
  for (const auto& [name, given] : switches) {
    if (given) result.options[name] = {""};
  }
  Diagnostics diagnostics;
  for (const std::string& word : app.remaining()) {
    // The mark itself, behind which every word is positional, is handed back too.
    if (word != "--") report_unknown(place, options, word, diagnostics);
  }
  check_counts(options, result, diagnostics);
  if (!diagnostics.empty()) throw InputError(std::move(diagnostics));
  return result;
}

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

std::optional<std::size_t> choose_word(const std::string& option, const std::string& word,
                                       const std::vector<std::string>& allowed, Diagnostics& diagnostics) {
  const auto found = std::find(allowed.begin(), allowed.end(), word);
  if (found != allowed.end()) return static_cast<std::size_t>(found - allowed.begin());
  diagnostics.push_back({option, 0, 0, "found '" + word + "'" + allowed_instead(word, allowed)});
  return std::nullopt;
}

}  // namespace mlt
