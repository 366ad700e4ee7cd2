// Preloaded into a program (LD_PRELOAD) by tools/proof.sh: ends it when any thread asks the heap for memory,
// or gives memory back, between render begin and render end. The program must export mlt::in_render_zone
// (linked with -rdynamic); outside the zone, and in a program without it, the calls go to the C library.

#include <dlfcn.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>

// Weak, so that the guard can also be loaded where there is no zone (the shell that starts the program).
namespace mlt {
__attribute__((weak)) bool in_render_zone();
}

// The allocator of glibc under the names by which it calls itself.
extern "C" {
void* __libc_malloc(std::size_t);
void __libc_free(void*);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
}

namespace {

constexpr int kGuardExitCode = 99;

void refuse_in_zone(const char* call) {
  if (mlt::in_render_zone == nullptr || !mlt::in_render_zone()) return;
  const char text[] = "malloc guard: between render begin and render end: ";
  const auto ignored = ::write(STDERR_FILENO, text, sizeof text - 1) +
                       ::write(STDERR_FILENO, call, std::strlen(call)) + ::write(STDERR_FILENO, "\n", 1);
  static_cast<void>(ignored);
  ::_exit(kGuardExitCode);
}

}  // namespace

extern "C" {

void* malloc(std::size_t bytes) {
  refuse_in_zone("malloc");
  return __libc_malloc(bytes);
}

void free(void* block) {
  refuse_in_zone("free");
  __libc_free(block);
}

void* calloc(std::size_t count, std::size_t bytes) {
  refuse_in_zone("calloc");
  return __libc_calloc(count, bytes);
}

void* realloc(void* block, std::size_t bytes) {
  refuse_in_zone("realloc");
  return __libc_realloc(block, bytes);
}

void* memalign(std::size_t alignment, std::size_t bytes) {
  refuse_in_zone("memalign");
  return __libc_memalign(alignment, bytes);
}

void* aligned_alloc(std::size_t alignment, std::size_t bytes) {
  refuse_in_zone("aligned_alloc");
  return __libc_memalign(alignment, bytes);
}

int posix_memalign(void** block, std::size_t alignment, std::size_t bytes) {
  refuse_in_zone("posix_memalign");
  *block = __libc_memalign(alignment, bytes);
  return *block == nullptr ? ENOMEM : 0;
}
}
