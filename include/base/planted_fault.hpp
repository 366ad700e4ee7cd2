// Faults planted on purpose, one per layer of the proof that a render neither allocates, locks, grows, faults
// nor throws (tests/proof): a build with MLT_PLANTED_FAULT=1..6 must be caught. The worker loop calls
// planted_fault() once per unit of work; in every other build it is empty. Inline, so that the fault's
// symbols stand in the object of the render loop, where the symbol check looks for them. Number 7 makes the
// chains' estimate wrong, which the comparison with the path tracer must catch
// (tools/planted_weight_test.sh).
#pragma once

#ifdef MLT_PLANTED_FAULT

#include <pthread.h>
#include <sys/mman.h>

#include <atomic>
#include <cstddef>

namespace mlt {

inline constexpr int kFaultAllocation = 1;
inline constexpr int kFaultLock = 2;
inline constexpr int kFaultGrowthCall = 3;
inline constexpr int kFaultPage = 4;
inline constexpr int kFaultThrow = 5;
inline constexpr int kFaultRecursion = 6;
inline constexpr int kFaultLostWeight = 7;
static_assert(MLT_PLANTED_FAULT >= kFaultAllocation && MLT_PLANTED_FAULT <= kFaultLostWeight);

/// Address space reserved when the process starts, of which no page is present.
struct UntouchedPages {
  static constexpr std::size_t kBytes = std::size_t{1} << 26;
  static constexpr std::size_t kPage = 4096;
  char* base = static_cast<char*>(
      ::mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0));
  std::atomic<std::size_t> next{0};
};
inline UntouchedPages g_untouched_pages;
inline pthread_mutex_t g_planted_mutex = PTHREAD_MUTEX_INITIALIZER;

/// Through a volatile, because a compiler turns a recursion that it understands into a loop.
__attribute__((noinline)) inline int planted_recursion(volatile int& depth) {
  if (depth == 0) return 0;
  depth = depth - 1;
  return 1 + planted_recursion(depth) * depth;
}

inline void planted_fault() {
  if constexpr (MLT_PLANTED_FAULT == kFaultAllocation) {
    // Through a volatile pointer, because a compiler may elide a new and delete pair.
    char* volatile block = new char[64];
    delete[] block;
  } else if constexpr (MLT_PLANTED_FAULT == kFaultLock) {
    ::pthread_mutex_lock(&g_planted_mutex);
    ::pthread_mutex_unlock(&g_planted_mutex);
  } else if constexpr (MLT_PLANTED_FAULT == kFaultGrowthCall) {
    void* mapping = ::mmap(nullptr, 4096, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (mapping != MAP_FAILED) ::munmap(mapping, 4096);
  } else if constexpr (MLT_PLANTED_FAULT == kFaultPage) {
    const std::size_t page = g_untouched_pages.next.fetch_add(UntouchedPages::kPage);
    if (page < UntouchedPages::kBytes) *static_cast<volatile char*>(g_untouched_pages.base + page) = 1;
  } else if constexpr (MLT_PLANTED_FAULT == kFaultThrow) {
    try {
      throw MLT_PLANTED_FAULT;
    } catch (int) {
    }
  } else if constexpr (MLT_PLANTED_FAULT == kFaultRecursion) {
    volatile int depth = 3;
    planted_recursion(depth);
  }
}

/// Weights that states gain when they are kept; 30 % of them gets lost under the fault.
template <class Double>
constexpr void plant_weight_loss(Double& weights) {
  if (MLT_PLANTED_FAULT == kFaultLostWeight) weights *= 0.7;
}

}  // namespace mlt

#else

namespace mlt {
inline void planted_fault() {}
template <class Double>
constexpr void plant_weight_loss(Double&) {}
}  // namespace mlt

#endif
