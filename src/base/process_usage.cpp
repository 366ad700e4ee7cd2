#include "base/process_usage.hpp"

#include <sys/resource.h>
#include <time.h>

namespace mlt {
namespace {

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace

double monotonic_seconds() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

ProcessUsage ProcessUsage::now() {
  ProcessUsage usage;
  // The clock first: the page that it is read from faults once.
  usage.wall = monotonic_seconds();
  rusage own{};
  ::getrusage(RUSAGE_SELF, &own);
  usage.cpu = seconds_of(own.ru_utime) + seconds_of(own.ru_stime);
  usage.minor_faults = static_cast<std::uint64_t>(own.ru_minflt);
  return usage;
}

}  // namespace mlt
