#include "base/process_usage.hpp"

#include <catch2/catch.hpp>

namespace mlt {
namespace {

TEST_CASE("what a process has used only grows, and work shows in it") {
  const ProcessUsage begin = ProcessUsage::now();
  ProcessUsage end = begin;
  // Until a millisecond of the processor has passed, or ten seconds, which would be a clock that stands.
  while (end.cpu - begin.cpu < 1e-3 && end.wall - begin.wall < 10.0) end = ProcessUsage::now();
  CHECK(end.cpu - begin.cpu >= 1e-3);
  CHECK(end.wall > begin.wall);
  CHECK(end.minor_faults >= begin.minor_faults);
  CHECK(monotonic_seconds() >= end.wall);
}

}  // namespace
}  // namespace mlt
