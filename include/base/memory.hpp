// The fixed memory of a render. A MemoryPlan lists every block by name and size before anything is
// allocated; an Arena maps the planned total once, touches every page, and hands out the blocks. Blocks of
// different life times may share storage: a block declared `scratch` is laid over the blocks that are
// first used after the scene is compiled (films, chain state).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "base/assert.hpp"

namespace mlt {

/// Blocks start on pages, the least that a thread's data must keep apart from another's: hardware prefetchers
/// run many cache lines ahead of ascending accesses, but not across pages, and what they fetch is taken from
/// the thread that writes it.
inline constexpr std::size_t kPage = 4096;

/// When a block is in use. kScratch blocks live only while the scene is compiled, kRender blocks only from
/// render begin on, so the two may overlap; kScene blocks live through both.
enum class Lifetime : std::uint8_t { kScene, kScratch, kRender };

/// Names one block of a plan; valid for the arena made from that plan.
template <class T>
struct Slot {
  std::size_t line = 0;
};

struct PlanLine {
  std::string name;  ///< e.g. "film of worker 0"
  Lifetime lifetime;
  std::size_t count;  ///< items
  std::size_t item_bytes;
  std::size_t bytes;       ///< count * item_bytes, rounded up to a page
  std::size_t offset = 0;  ///< from the start of the arena
};

class MemoryPlan {
 public:
  /// Adds `count` items of T. Throws ResourceError when the size does not fit 63 bits.
  template <class T>
  Slot<T> add(std::string name, Lifetime lifetime, std::size_t count) {
    static_assert(std::is_trivially_destructible_v<T>, "the arena runs no destructors");
    static_assert(alignof(T) <= kPage);
    return Slot<T>{add_bytes(std::move(name), lifetime, count, sizeof(T))};
  }

  /// Bytes of the whole arena: scene blocks, then the larger of the scratch and the render blocks.
  std::size_t total_bytes() const;
  std::size_t bytes(Lifetime lifetime) const;
  const std::vector<PlanLine>& lines() const { return lines_; }

 private:
  std::size_t add_bytes(std::string name, Lifetime lifetime, std::size_t count, std::size_t item_bytes);
  std::vector<PlanLine> lines_;
};

/// One anonymous mapping with every page present, zero filled. Not copyable; unmapped on destruction.
class Arena {
 public:
  /// With a `host`, which must outlive it, an arena lies over the host's scratch and render blocks, whatever
  /// they hold, if there is room for all of it. Throws ResourceError when the system refuses the memory.
  explicit Arena(const MemoryPlan& plan, const Arena* host = nullptr);
  ~Arena();
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  /// The block of `slot`, its items value-initialised on this first call for it.
  template <class T>
  std::span<T> take(Slot<T> slot) {
    void* bytes = take_line(slot.line, sizeof(T));
    T* first = static_cast<T*>(bytes);
    const std::size_t count = lines_[slot.line].count;
    for (std::size_t i = 0; i < count; ++i) ::new (static_cast<void*>(first + i)) T();
    return {first, count};
  }

  /// The same as it was left: of a scene block taken for the first time, zeros. For what is large and about
  /// to be written.
  template <class T>
  std::span<T> raw(Slot<T> slot) {
    static_assert(std::is_trivially_copyable_v<T>);
    return {static_cast<T*>(take_line(slot.line, sizeof(T))), lines_[slot.line].count};
  }

  std::size_t bytes() const { return size_; }

 private:
  void map();
  void* take_line(std::size_t line, std::size_t item_bytes);
  std::vector<PlanLine> lines_;
  std::byte* base_ = nullptr;
  std::size_t size_ = 0;
  std::size_t shared_start_ = 0;  ///< of scratch and render blocks
  bool is_mapped_ = false;        ///< of its own, not in a host
};

}  // namespace mlt
