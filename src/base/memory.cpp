#include "base/memory.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <cstring>

#include "base/error.hpp"

namespace mlt {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{1} << 47;  // beyond any address space in use

std::size_t round_up(std::size_t bytes) {
  return (bytes + kPage - 1) / kPage * kPage;
}

}  // namespace

std::size_t MemoryPlan::add_bytes(std::string name, Lifetime lifetime, std::size_t count,
                                  std::size_t item_bytes) {
  if (count > kMaxBytes / item_bytes) {
    throw ResourceError(name + ": " + std::to_string(count) + " items of " + std::to_string(item_bytes) +
                        " bytes are more than any machine can address");
  }
  const std::size_t size = round_up(count * item_bytes);
  // Render blocks lie over scratch blocks; both start where the scene blocks end, which is known only once
  // the plan is complete. Offsets here count within the lifetime; the arena adds the base.
  lines_.push_back({std::move(name), lifetime, count, item_bytes, size, bytes(lifetime)});
  if (total_bytes() > kMaxBytes)
    throw ResourceError(lines_.back().name + ": the memory plan exceeds 128 TiB");
  return lines_.size() - 1;
}

std::size_t MemoryPlan::bytes(Lifetime lifetime) const {
  std::size_t sum = 0;
  for (const PlanLine& line : lines_) {
    if (line.lifetime == lifetime) sum += line.bytes;
  }
  return sum;
}

std::size_t MemoryPlan::total_bytes() const {
  return bytes(Lifetime::kScene) + std::max(bytes(Lifetime::kScratch), bytes(Lifetime::kRender));
}

Arena::Arena(const MemoryPlan& plan, const Arena* host)
    : lines_(plan.lines()),
      size_(std::max(plan.total_bytes(), kPage)),
      shared_start_(plan.bytes(Lifetime::kScene)) {
  for (PlanLine& line : lines_) {
    if (line.lifetime != Lifetime::kScene) line.offset += shared_start_;
  }
  if (host != nullptr && size_ <= host->size_ - host->shared_start_) {
    base_ = host->base_ + host->shared_start_;
  } else {
    map();
  }
}

void Arena::map() {
  void* mapping = ::mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (mapping == MAP_FAILED) {
    throw ResourceError("the system refused " + std::to_string(size_) + " bytes of memory");
  }
#if defined(MADV_HUGEPAGE)
  // A hierarchy of a million triangles needs more addresses translated than a processor remembers for small
  // pages. Where the system has no large ones, nothing changes.
  ::madvise(mapping, size_, MADV_HUGEPAGE);
#endif
  // Touches every page now, so that none faults between render begin and render end.
  for (std::size_t offset = 0; offset < size_; offset += kPage) {
    static_cast<volatile char*>(mapping)[offset] = 0;
  }
  base_ = static_cast<std::byte*>(mapping);
  is_mapped_ = true;
}

Arena::~Arena() {
  if (is_mapped_) ::munmap(base_, size_);
}

void* Arena::take_line(std::size_t line, std::size_t item_bytes) {
  MLT_CHECK_OP(line, <, lines_.size());
  MLT_CHECK_OP(item_bytes, ==, lines_[line].item_bytes);
  MLT_CHECK_OP(lines_[line].offset + lines_[line].bytes, <=, size_);
  return base_ + lines_[line].offset;
}

}  // namespace mlt
