#include <fmt/core.h>

#include "app/commands.hpp"
#include "app/console.hpp"
#include "base/atomic_file.hpp"
#include "converge/report.hpp"

namespace mlt {

ExitCode run_report(const ReportCommand& command) {
  if (!command.output.ends_with(".html")) {
    throw InputError(
        Diagnostic{"--output", 0, 0, "found '" + command.output + "'; expected a name that ends in .html"});
  }
  const std::vector<ReportEntry> entries = read_results(command.folder);
  const std::string page = report_page(entries);
  AtomicFile file(command.output);
  file.write(page.data(), page.size());
  file.commit();
  print_output(fmt::format("{}\n", command.output));
  return ExitCode::kOk;
}

}  // namespace mlt
