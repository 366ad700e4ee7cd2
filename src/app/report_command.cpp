#include "app/commands.hpp"

namespace mlt {

ExitCode run_report(const ReportCommand&) {
  return ExitCode::kOk;
}

}  // namespace mlt
