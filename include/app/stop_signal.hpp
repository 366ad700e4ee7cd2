// SIGINT and SIGTERM as a flag that the renderer looks at. The first signal asks for a clean stop; a second
// one of the same kind ends the process at once.
#pragma once

#include <atomic>

namespace mlt {

/// Installs the handlers, and ignores SIGPIPE and SIGXFSZ so that failing writes are reported as errors.
void install_signal_handlers();

/// Set by the first SIGINT or SIGTERM.
const std::atomic<bool>& stop_requested();

}  // namespace mlt
