#include "base/render_zone.hpp"

#include <alloca.h>
#include <fmt/format.h>
#include <link.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <span>
#include <string>

#include "base/assert.hpp"

// The pages are touched byte-wise at their starts, which under a sanitizer may be a red zone or another
// thread's variable; both are intended.
#define MLT_TOUCHES_ANYTHING __attribute__((no_sanitize_address, no_sanitize_thread, noinline))

namespace mlt {
namespace {

std::atomic<int> g_open_zones{0};

std::uintptr_t page_bytes() {
  return static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
}

MLT_TOUCHES_ANYTHING void touch_readable(std::uintptr_t address) {
  static_cast<void>(*reinterpret_cast<const volatile char*>(address));
}

/// Stores the value that is there, atomically, so that no store of another thread is lost. A compare and
/// exchange, since compilers turn a fetch_or of 0 into a load, which leaves the page shared.
MLT_TOUCHES_ANYTHING void touch_writable(std::uintptr_t address) {
  volatile char* byte = reinterpret_cast<volatile char*>(address);
  char value = *byte;
  while (!__atomic_compare_exchange_n(byte, &value, value, false, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
  }
}

int touch_object(dl_phdr_info* info, std::size_t, void*);

/// Whether rendering may call into an object: the program, libc, and libfmt for the line of progress. The
/// others (the libraries of C++, images and compression) would add a megabyte that nothing reads;
/// tools/proof.sh lists what the render loop calls.
bool is_called(const dl_phdr_info& info) {
  std::string (*const format)(fmt::string_view, fmt::format_args) = &fmt::vformat;
  const std::uintptr_t functions[] = {reinterpret_cast<std::uintptr_t>(&touch_object),
                                      reinterpret_cast<std::uintptr_t>(&::syscall),
                                      reinterpret_cast<std::uintptr_t>(format)};
  for (int i = 0; i < info.dlpi_phnum; ++i) {
    const ElfW(Phdr)& header = info.dlpi_phdr[i];
    const std::uintptr_t first = info.dlpi_addr + header.p_vaddr;
    for (const std::uintptr_t function : functions) {
      if (header.p_type == PT_LOAD && function >= first && function - first < header.p_memsz) return true;
    }
  }
  return false;
}

/// The end of the range that holds the address, or 0.
std::uintptr_t end_of_range(std::span<const CodeRange> ranges, std::uintptr_t address) {
  for (const CodeRange& range : ranges) {
    const auto begin = reinterpret_cast<std::uintptr_t>(range.begin);
    const auto end = reinterpret_cast<std::uintptr_t>(range.end);
    if (address >= begin && address < end) return end;
  }
  return 0;
}

/// One loaded object: its segments, without writing to what the loader made read-only after relocation, and
/// without the pages that hold nothing but unused code.
int touch_object(dl_phdr_info* info, std::size_t, void* context) {
  if (!is_called(*info)) return 0;
  const auto& unused = *static_cast<const std::span<const CodeRange>*>(context);
  const std::uintptr_t page = page_bytes();
  const auto round_down = [page](std::uintptr_t address) { return address / page * page; };
  std::uintptr_t relro_begin = 0;
  std::uintptr_t relro_end = 0;
  for (int i = 0; i < info->dlpi_phnum; ++i) {
    const ElfW(Phdr)& header = info->dlpi_phdr[i];
    if (header.p_type != PT_GNU_RELRO) continue;
    // glibc and musl protect the whole pages between the two ends rounded down.
    relro_begin = round_down(info->dlpi_addr + header.p_vaddr);
    relro_end = round_down(info->dlpi_addr + header.p_vaddr + header.p_memsz);
  }
  for (int i = 0; i < info->dlpi_phnum; ++i) {
    const ElfW(Phdr)& header = info->dlpi_phdr[i];
    if (header.p_type != PT_LOAD || header.p_memsz == 0 || (header.p_flags & PF_R) == 0) continue;
    const std::uintptr_t first = info->dlpi_addr + header.p_vaddr;
    const std::uintptr_t end = first + header.p_memsz;
    for (std::uintptr_t at = first; at < end; at = round_down(at) + page) {
      const bool relro = at >= relro_begin && at < relro_end;
      const std::uintptr_t unused_end = end_of_range(unused, at);
      if (unused_end != 0 && round_down(at) + page <= unused_end) continue;
      if ((header.p_flags & PF_W) != 0 && !relro) {
        touch_writable(at);
      } else {
        touch_readable(at);
      }
    }
  }
  return 0;
}

}  // namespace

void enter_render_zone() {
  ::prctl(PR_SET_NAME, "mlt:render", 0, 0, 0);
  g_open_zones.fetch_add(1);
}

void leave_render_zone() {
  const int open = g_open_zones.fetch_sub(1);
  MLT_CHECK_OP(open, >, 0);
  ::prctl(PR_SET_NAME, "mlt", 0, 0, 0);
}

bool in_render_zone() {
  return g_open_zones.load(std::memory_order_relaxed) > 0;
}

void prefault_process(std::span<const CodeRange> unused) {
  ::dl_iterate_phdr(touch_object, &unused);
}

MLT_TOUCHES_ANYTHING void prefault_stack(std::size_t bytes) {
  const std::size_t page = page_bytes();
  volatile char* block = static_cast<volatile char*>(alloca(bytes + page));
  // The address escapes; otherwise a compiler that knows `bytes` may keep only the bytes written below.
  asm volatile("" : "+r"(block) : : "memory");
  // From the high end down, as a stack grows: the kernel extends the main thread's stack that way.
  for (std::size_t used = 0; used <= bytes; used += page) block[bytes + page - 1 - used] = 0;
  block[0] = 0;
}

void prefault_writable(void* first, std::size_t bytes) {
  if (bytes == 0) return;
  const std::uintptr_t page = page_bytes();
  const std::uintptr_t begin = reinterpret_cast<std::uintptr_t>(first);
  for (std::uintptr_t at = begin; at < begin + bytes; at = at / page * page + page) touch_writable(at);
}

std::uint64_t FaultCounter::thread_minor_faults() {
  rusage usage{};
  if (::getrusage(RUSAGE_THREAD, &usage) != 0) return 0;
  return static_cast<std::uint64_t>(usage.ru_minflt);
}

}  // namespace mlt
