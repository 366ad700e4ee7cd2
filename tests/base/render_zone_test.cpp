#include "base/render_zone.hpp"

#include <pthread.h>
#include <sys/mman.h>
#include <sys/prctl.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <string>
#include <thread>

#include "support/faults.hpp"

namespace mlt {
namespace {

constexpr std::size_t kPage = 4096;

std::string thread_name() {
  char name[16] = {};
  ::prctl(PR_GET_NAME, name, 0, 0, 0);
  return name;
}

struct Mapping {
  explicit Mapping(std::size_t pages)
      : size(pages * kPage),
        base(static_cast<char*>(
            ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0))) {
    // Huge pages would make one fault of many.
    ::madvise(base, size, MADV_NOHUGEPAGE);
  }
  ~Mapping() { ::munmap(base, size); }
  std::size_t size;
  char* base;
};

std::uint64_t faults_of_writing(Mapping& mapping) {
  FaultCounter faults;
  faults.start();
  for (std::size_t i = 0; i < mapping.size; i += kPage) static_cast<volatile char*>(mapping.base)[i] = 1;
  return faults.count();
}

char g_zeros[64 * kPage];

TEST_CASE("the render zone is visible to all threads and renames the one that opens it") {
  REQUIRE_FALSE(in_render_zone());
  enter_render_zone();
  CHECK(thread_name() == "mlt:render");
  bool seen = false;
  std::thread([&seen] { seen = in_render_zone(); }).join();
  CHECK(seen);
  SECTION("overlapping zones close with the last one") {
    enter_render_zone();
    leave_render_zone();
    CHECK(in_render_zone());
  }
  leave_render_zone();
  CHECK(thread_name() == "mlt");
  CHECK_FALSE(in_render_zone());
}

TEST_CASE("the fault counter counts the first touch of a page, and prefaulted pages do not fault") {
  if (!MLT_FAULTS_ARE_OURS) return;
  constexpr std::size_t kPages = 32;
  Mapping untouched(kPages);
  CHECK(faults_of_writing(untouched) >= kPages);

  Mapping touched(kPages);
  prefault_writable(touched.base, touched.size);
  CHECK(faults_of_writing(touched) == 0);

  // A page that was only read is the shared zero page, and its first write faults: touching must write.
  Mapping read(kPages);
  for (std::size_t i = 0; i < read.size; i += kPage)
    static_cast<void>(static_cast<volatile char*>(read.base)[i]);
  CHECK(faults_of_writing(read) >= kPages);
  Mapping copied(kPages);
  for (std::size_t i = 0; i < copied.size; i += kPage) {
    static_cast<void>(static_cast<volatile char*>(copied.base)[i]);
  }
  prefault_writable(copied.base, copied.size);
  CHECK(faults_of_writing(copied) == 0);
}

TEST_CASE("prefault_process makes static storage resident and keeps its values") {
  g_zeros[5 * kPage] = 7;
  prefault_process();
  FaultCounter faults;
  faults.start();
  for (std::size_t i = 0; i < sizeof g_zeros; i += kPage) {
    volatile char& byte = g_zeros[i];
    byte = static_cast<char>(byte + 1);
  }
  const std::uint64_t count = faults.count();
  if (MLT_FAULTS_ARE_OURS) CHECK(count == 0);
  CHECK(g_zeros[5 * kPage] == 8);
  CHECK(g_zeros[6 * kPage] == 1);
}

TEST_CASE("prefault_writable keeps what other threads write meanwhile") {
  Mapping shared(4);
  std::atomic<bool> done{false};
  // One writer owns the first byte of each page, which is the byte that touching rewrites.
  std::thread writer([&] {
    for (int value = 1; value <= 100; ++value) {
      for (std::size_t i = 0; i < shared.size; i += kPage) {
        __atomic_store_n(shared.base + i, static_cast<char>(value), __ATOMIC_RELAXED);
        // A lost store would show as an older value here.
        if (__atomic_load_n(shared.base + i, __ATOMIC_RELAXED) != static_cast<char>(value))
          shared.base[1] = 1;
      }
    }
    done = true;
  });
  while (!done) prefault_writable(shared.base, shared.size);
  writer.join();
  CHECK(shared.base[1] == 0);
  for (std::size_t i = 0; i < shared.size; i += kPage) CHECK(int(shared.base[i]) == 100);
}

__attribute__((noinline)) void use_stack() {
  char frame[32 * kPage];
  // The address escapes; otherwise a compiler may keep only the bytes that are written.
  volatile char* bytes = frame;
  asm volatile("" : "+r"(bytes) : : "memory");
  for (std::size_t i = 0; i < sizeof frame; i += kPage) bytes[i] = 1;
}

struct StackRun {
  bool touch;
  std::uint64_t faults;
};

/// Faults of a thread with a stack of its own that uses 32 pages of it.
std::uint64_t faults_of_using_stack(bool touch) {
  Mapping stack(256);
  StackRun run{touch, 0};
  pthread_attr_t attributes;
  REQUIRE(::pthread_attr_init(&attributes) == 0);
  REQUIRE(::pthread_attr_setstack(&attributes, stack.base, stack.size) == 0);
  pthread_t thread;
  const auto body = [](void* argument) -> void* {
    StackRun& self = *static_cast<StackRun*>(argument);
    if (self.touch) prefault_stack(64 * kPage);
    FaultCounter faults;
    faults.start();
    use_stack();
    self.faults = faults.count();
    return nullptr;
  };
  REQUIRE(::pthread_create(&thread, &attributes, body, &run) == 0);
  ::pthread_join(thread, nullptr);
  ::pthread_attr_destroy(&attributes);
  return run.faults;
}

TEST_CASE("prefault_stack makes the next part of the calling thread's stack resident") {
  if (!MLT_FAULTS_ARE_OURS) return;
  // The page next to the thread's first frames may be present already.
  CHECK(faults_of_using_stack(false) >= 31);
  CHECK(faults_of_using_stack(true) == 0);
}

}  // namespace
}  // namespace mlt
