// From the words of the command line to one command with checked values.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "app/compare_command.hpp"
#include "app/converge_options.hpp"
#include "render/job.hpp"

namespace mlt {

struct RenderCommand {
  std::string scene;
  RenderRequest request;
  std::vector<std::string> outputs;        ///< image files; never empty
  std::optional<std::string> stats;        ///< JSON file
  std::optional<std::string> error_image;  ///< PFM or PNG file of standard errors
  float exposure = 0;                      ///< EV
  bool quiet = false;
  std::vector<std::string> warnings;  ///< options that were accepted and have no effect
};

struct InfoCommand {
  std::string scene;
  RenderRequest request;
  std::vector<std::string> warnings;
};

/// A command that only prints.
struct TextCommand {
  std::string text;
};

using Command =
    std::variant<RenderCommand, InfoCommand, CompareCommand, ConvergeCommand, ReportCommand, TextCommand>;

/// `words` without the program's name. Throws InputError with every fault found; the place is the option's
/// name, or "mlt" with the command for the line as a whole.
Command parse_command_line(const std::vector<std::string>& words);

}  // namespace mlt
