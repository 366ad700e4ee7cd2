// The options of `mlt converge` and `mlt report`: their entries of the option table, and their values.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/words.hpp"
#include "converge/measure.hpp"

namespace mlt {

struct ConvergeCommand {
  std::string scene;
  std::string folder;
  RenderRequest request;  ///< what all renders have in common; methods hold their settings themselves
  std::optional<std::string> reference;
  std::vector<ConvergeMethod> methods;  ///< without budgets
  std::vector<std::uint64_t> budgets;   ///< increasing; either these
  std::vector<double> times;            ///< increasing; or these
  std::uint32_t replicates = 16;
  std::optional<double> target;
  float exposure = 0;
  bool quiet = false;
  std::vector<std::string> warnings;  ///< options that were accepted and have no effect
};

struct ReportCommand {
  std::string folder;
  std::string output;
};

/// Adds the entries of both commands; those that converge shares with render must be in `table` already.
void add_converge_options(std::vector<OptionSpec>& table);

/// The commands from their words. Throw InputError with every fault found.
ConvergeCommand make_converge_command(const Words& words);
ReportCommand make_report_command(const Words& words);

}  // namespace mlt
