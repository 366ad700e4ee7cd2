// The options of every command, in one table: the parser, the help text, the suggestions for misspelled
// options and the tests come from it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "render/job.hpp"

namespace mlt {

/// name, what it does in one line.
#define MLT_COMMANDS(X)                                                                \
  X(render, "render a scene to image files")                                           \
  X(info, "print what a scene contains, what was skipped for it, and the memory plan") \
  X(compare, "measure how far an image is from a reference")                           \
  X(converge, "measure error against time and samples for several methods")            \
  X(report, "make one page of all results of converge below a folder")                 \
  X(help, "explain a command")

enum class CommandKind : std::uint8_t {
#define MLT_ENUMERATE(name, help) name,
  MLT_COMMANDS(MLT_ENUMERATE)
#undef MLT_ENUMERATE
};

/// "render", "info", ... in the order of MLT_COMMANDS.
std::vector<std::string> command_names();

inline constexpr float kMaxExposure = 64;  ///< EV; 2^64 brings the smallest radiance worth showing to 1

struct OptionSpec {
  std::string name;        ///< e.g. "--width"
  std::string short_name;  ///< e.g. "-o", or empty
  std::string value;       ///< placeholder of its value; empty for a switch
  bool repeatable = false;
  std::vector<CommandKind> commands;
  std::string help;  ///< what it means, its range and its default
  /// Of a setting of how to estimate the image: the integrators that look at it. Otherwise empty.
  std::vector<IntegratorKind> integrators = {};

  bool is_used_by(IntegratorKind kind) const;  ///< true of what is no such setting
};

/// All options; built once.
const std::vector<OptionSpec>& option_table();

/// Those of `command`.
std::vector<OptionSpec> options_of(CommandKind command);

/// The settings of integrators, which a method of converge is made of.
std::vector<OptionSpec> method_options();

/// A value of an enumeration as the command line spells it (an underscore of the identifier is a hyphen
/// here).
struct NamedKind {
  std::string name;
  std::string help;
};

/// In the order of their enums.
const std::vector<NamedKind>& integrator_kinds();
const std::vector<NamedKind>& start_kinds();
const std::vector<NamedKind>& mutation_kinds();
const std::vector<NamedKind>& instruction_sets();
std::vector<std::string> names_of(const std::vector<NamedKind>& kinds);

/// Text of `mlt --help`, and of `mlt help COMMAND` or `mlt COMMAND --help`; at most 100 columns.
std::string general_help();
std::string command_help(CommandKind command);

}  // namespace mlt
