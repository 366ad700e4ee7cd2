// A counter that threads wait on without a lock: the only way workers and the main thread meet. Waiting uses
// the kernel's futex, which neither allocates nor locks; raising the counter is a release, and returning
// from a wait an acquire.
#pragma once

#include <atomic>
#include <cstdint>

namespace mlt {

class Event {
 public:
  std::uint32_t value() const { return value_.load(std::memory_order_acquire); }

  /// Adds one and wakes every waiter.
  void raise();

  /// Returns once the value differs from `old_value`, or after about `milliseconds` (0: no limit).
  void wait_while(std::uint32_t old_value, std::uint32_t milliseconds = 0);

 private:
  std::atomic<std::uint32_t> value_{0};
};

}  // namespace mlt
