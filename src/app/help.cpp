#include <fmt/core.h>

#include "app/options.hpp"
#include "app/version.hpp"
#include "base/error.hpp"

namespace mlt {
namespace {

constexpr std::size_t kColumns = 100;
constexpr std::size_t kIndent = 24;

/// `text` in lines of at most kColumns, the first behind `label`, the others below it.
std::string entry(const std::string& label, const std::string& text) {
  std::string result = "  " + label;
  std::size_t column = result.size();
  // A label that is too long for its column has a line of its own.
  if (column >= kIndent) {
    result += '\n';
    column = 0;
  }
  result.append(kIndent - column, ' ');
  column = kIndent;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t space = text.find(' ', begin);
    const std::size_t end = space == std::string::npos ? text.size() : space;
    const bool first = column == kIndent;
    if (!first && column + 1 + (end - begin) > kColumns) {
      result += '\n' + std::string(kIndent, ' ');
      column = kIndent;
    } else if (!first) {
      result += ' ';
      ++column;
    }
    result.append(text, begin, end - begin);
    column += end - begin;
    begin = end + 1;
  }
  return result + '\n';
}

/// With `only_own`, without the options that another command has too.
std::string option_entries(CommandKind command, bool only_own = false) {
  std::string text;
  for (const OptionSpec& option : options_of(command)) {
    if (only_own && option.commands.size() > 1) continue;
    std::string label = option.short_name.empty() ? option.name : option.short_name + ", " + option.name;
    if (!option.value.empty()) label += " " + option.value;
    text += entry(label, option.help);
  }
  return text;
}

std::string exit_codes() {
  struct Row {
    ExitCode code;
    const char* meaning;
  };
  constexpr Row kRows[] = {
      {ExitCode::kOk, "done"},
      {ExitCode::kCompareFailed, "compare: an error lies beyond its limit, or --test found a difference"},
      {ExitCode::kBadInput, "the command line, a scene or an image is not valid"},
      {ExitCode::kResourceLimit, "memory, disk or another capacity is not sufficient"},
      {ExitCode::kBug, "an assertion of the renderer failed; the message holds the command that replays it"},
      {ExitCode::kInterrupted, "stopped by SIGINT or SIGTERM; the image is written and marked partial"},
  };
  std::string text = "Exit codes:\n";
  for (const Row& row : kRows) text += entry(std::to_string(static_cast<int>(row.code)), row.meaning);
  return text;
}

constexpr char kClassicUsage[] = "mlt WIDTH HEIGHT MUTATIONS THREADS DEPTH SCENE";

}  // namespace

std::string general_help() {
  std::string text = fmt::format(
      "mlt {}: renders scenes by Monte Carlo and Metropolis light transport, in fixed memory,\n"
      "with the same bits from any number of threads.\n\nUsage:\n",
      kVersion);
  text +=
      "  mlt render SCENE [OPTION]...\n  mlt info SCENE [OPTION]...\n  mlt compare A B [OPTION]...\n"
      "  mlt compare --test A1 A2 ... -- B1 B2 ... [OPTION]...\n";
  text += "  mlt converge SCENE -o DIR [OPTION]...\n  mlt report DIR [OPTION]...\n";
  text += fmt::format("  {}\n  mlt help [COMMAND]\n  mlt --version\n\nCommands:\n", kClassicUsage);
#define MLT_ITEM(name, help) text += entry(#name, help);
  MLT_COMMANDS(MLT_ITEM)
#undef MLT_ITEM
  text += "\nClassic form, for PSSMLT with MUTATIONS per pixel; it writes the scene's base name with .png:\n";
  text += entry(std::string(kClassicUsage) + ", e.g. mlt 500 500 10 4 5 scenes/CornellBox2.txt",
                "the numbers mean the same as --width, --height, --mutations, --threads and --depth below");
  text +=
      "\nOptions of render; info takes those that change the plan:\n" + option_entries(CommandKind::render);
  text += "\nOptions of converge, besides most of render's:\n" + option_entries(CommandKind::converge, true);
  text += "\nOptions of report:\n" + option_entries(CommandKind::report);
  text += "\nOptions of compare:\n" + option_entries(CommandKind::compare) + "\n" + exit_codes();
  return text;
}

std::string command_help(CommandKind command) {
  switch (command) {
    case CommandKind::render:
      return "Usage: mlt render SCENE [OPTION]...\nRenders SCENE (docs/SCENES.md) to image "
             "files.\n\nOptions:\n" +
             option_entries(command) + "\n" + exit_codes();
    case CommandKind::info:
      return "Usage: mlt info SCENE [OPTION]...\nPrints what SCENE contains, the features found and skipped, "
             "and "
             "the memory plan of the render\nthat the same options of render would start.\n\nOptions:\n" +
             option_entries(command) + "\n" + exit_codes();
    case CommandKind::compare:
      return "Usage: mlt compare A B [OPTION]...\n       mlt compare --test A1 A2 ... -- B1 B2 ... "
             "[OPTION]...\n"
             "Prints how far image A (PFM or PNG) is from the reference B, by the metrics of "
             "docs/COMPARE.md; for "
             "two\nfolders, how far each image of A is from that of the same name in B. With --test it asks "
             "whether\nrenders A1, A2, ... have the same mean as B1, B2, ..., which differ in their seed.\n\n"
             "Options:\n" +
             option_entries(command) + "\n" + exit_codes();
    case CommandKind::converge:
      return "Usage: mlt converge SCENE -o DIR [OPTION]...\nRenders SCENE by several methods at several "
             "budgets, interleaved, and writes error against time and\nsamples into DIR "
             "(docs/CONVERGE.md).\n\nOptions:\n" +
             option_entries(command) + "\n" + exit_codes();
    case CommandKind::report:
      return "Usage: mlt report DIR [OPTION]...\nWrites one self-contained page with the results of mlt "
             "converge in DIR and its subfolders.\n\nOptions:\n" +
             option_entries(command) + "\n" + exit_codes();
    case CommandKind::help:
      return general_help();
  }
  return "";
}

}  // namespace mlt
