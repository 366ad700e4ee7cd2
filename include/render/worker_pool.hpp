// The threads of a render. They are created, with stacks from the arena, before render begin; a phase hands
// them numbered units of work from one shared counter. Which thread runs which unit is left to chance and
// has no influence on any result.
#pragma once

#include <pthread.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/event.hpp"
#include "base/memory.hpp"
#include "base/unit_runner.hpp"

namespace mlt {

/// One unit of a phase; `worker` selects the thread's own storage.
using UnitFunction = void (*)(void* context, std::uint32_t worker, std::uint64_t unit);

struct Phase {
  const char* stage = "";  ///< for failure reports
  UnitFunction run = nullptr;
  void* context = nullptr;
  std::uint64_t units = 0;
  bool stoppable = false;  ///< whether the stop flag ends it between units
};

#ifndef MLT_LARGE_STACKS
#if defined(__SANITIZE_THREAD__)
#define MLT_LARGE_STACKS 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define MLT_LARGE_STACKS 1
#endif
#endif
#endif
#ifndef MLT_LARGE_STACKS
#define MLT_LARGE_STACKS 0
#endif

/// A worker's stack. Deep enough for the larger frames of sanitizers; those that keep their own data for each
/// thread on its stack refuse to start one with less than about a megabyte. Without optimisation, for which
/// the Makefile asks for large ones, every value in lanes has a place of its own.
struct alignas(64) WorkerStack {
  static constexpr std::size_t kBytes = MLT_LARGE_STACKS ? std::size_t{2} << 20 : std::size_t{256} << 10;
  std::byte bytes[kBytes];
};

class WorkerPool {
 public:
  WorkerPool() = default;
  ~WorkerPool() { stop(); }
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// Starts one thread for each stack (at least one) and waits until all are ready to work. Throws
  /// ResourceError when the system refuses a thread. A pool starts once.
  void start(std::span<WorkerStack> stacks, std::span<pthread_t> threads);

  /// Ends and joins all threads; called by the destructor as well.
  void stop();

  /// Runs all units, or those taken before `stop_flag` was set. While waiting, calls `idle(idle_context)`
  /// about four times a second. Returns the number of units run; units are taken in order of their number.
  std::uint64_t run(const Phase& phase, const std::atomic<bool>& stop_flag, void (*idle)(void*),
                    void* idle_context);

  /// For stages that do not know of pools. One thread is no faster than its caller, who then does the units.
  UnitRunner runner();

 private:
  static void run_for(void* pool, UnitRunner::Unit unit, void* context, std::uint64_t units);
  static void* thread_main(void* pool);
  void work(std::uint32_t worker);
  void run_units(std::uint32_t worker);

  std::span<pthread_t> threads_;
  Phase phase_;
  const std::atomic<bool>* stop_flag_ = nullptr;
  bool exiting_ = false;
  Event phase_begun_;
  Event phase_done_;
  std::atomic<std::uint32_t> next_worker_{0};
  std::atomic<std::uint32_t> busy_workers_{0};
  alignas(64) std::atomic<std::uint64_t> next_unit_{0};
};

}  // namespace mlt
