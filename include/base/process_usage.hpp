// What this process has used of time and pages: differences of two moments tell what lies between.
#pragma once

#include <cstdint>

namespace mlt {

/// Seconds of a clock that only goes forward.
double monotonic_seconds();

/// At one moment, over all threads.
struct ProcessUsage {
  double wall = 0;  ///< monotonic_seconds()
  double cpu = 0;   ///< seconds of processors
  std::uint64_t minor_faults = 0;

  static ProcessUsage now();
};

}  // namespace mlt
