// The span from render begin to render end, in which no thread allocates, locks, throws, makes a growth
// system call or takes a page fault. The renderer marks it; the proofs in tests/proof read the marks: the
// process-wide flag from inside (malloc guard), the change of the thread's name from outside (strace).
// Before the span, the renderer makes resident what it will touch beyond the arena: the loaded segments and
// each thread's stack.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/planted_fault.hpp"

namespace mlt {

/// Opens the zone; renames the calling thread to "mlt:render". Zones of several renderers may overlap: the
/// process is outside only when all of them have closed.
void enter_render_zone();
/// Closes the zone; renames the calling thread to "mlt". Must pair with enter_render_zone().
void leave_render_zone();
/// True from any thread while a zone is open. Lock-free and callable from a malloc hook.
bool in_render_zone();

/// Machine code in memory.
struct CodeRange {
  const char* begin = nullptr;
  const char* end = nullptr;
};

/// Reads every page of the segments of the program and of the libraries that rendering calls, but for those
/// within `unused`, and writes the writable ones with the values they hold, so that neither file mappings nor
/// copies on write fault later.
/// Safe while other threads run. Once per process is enough; the pages stay unless the system reclaims them.
void prefault_process(std::span<const CodeRange> unused = {});

/// Touches the next `bytes` of the calling thread's stack, in steps of a page. The stack must be that large.
void prefault_stack(std::size_t bytes);

/// Touches the pages that hold [first, first + bytes) as prefault_process does with writable segments.
void prefault_writable(void* first, std::size_t bytes);

/// Page faults of the calling thread that needed no input or output, counted from start().
class FaultCounter {
 public:
  void start() { begin_ = thread_minor_faults(); }
  std::uint64_t count() const { return thread_minor_faults() - begin_; }

 private:
  static std::uint64_t thread_minor_faults();
  std::uint64_t begin_ = 0;
};

}  // namespace mlt
