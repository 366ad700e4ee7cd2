#include "base/event.hpp"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

namespace mlt {
namespace {

static_assert(sizeof(std::atomic<std::uint32_t>) == sizeof(std::uint32_t));

long futex(std::atomic<std::uint32_t>& word, int operation, std::uint32_t value, const timespec* timeout) {
  return ::syscall(SYS_futex, reinterpret_cast<std::uint32_t*>(&word), operation, value, timeout, nullptr, 0);
}

}  // namespace

void Event::raise() {
  value_.fetch_add(1, std::memory_order_release);
  futex(value_, FUTEX_WAKE_PRIVATE, 0x7fffffffU, nullptr);
}

void Event::wait_while(std::uint32_t old_value, std::uint32_t milliseconds) {
  timespec timeout{};
  timeout.tv_sec = static_cast<time_t>(milliseconds / 1000);
  timeout.tv_nsec = static_cast<long>(milliseconds % 1000) * 1000000L;
  while (value() == old_value) {
    futex(value_, FUTEX_WAIT_PRIVATE, old_value, milliseconds == 0 ? nullptr : &timeout);
    if (milliseconds != 0) return;
  }
}

}  // namespace mlt
