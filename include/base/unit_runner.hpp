// A way to do independent units of work on several threads, for stages that do not know what threads there
// are. Without one, the units are done in turn by whoever asks.
#pragma once

#include <cstdint>
#include <type_traits>

namespace mlt {

class UnitRunner {
 public:
  using Unit = void (*)(void* context, std::uint64_t unit);
  /// Calls unit(context, i) for i = 0 to units - 1, in any order and at the same time, and returns when all
  /// have returned. What they wrote is then seen by the caller.
  using Run = void (*)(void* self, Unit unit, void* context, std::uint64_t units);

  UnitRunner() = default;
  UnitRunner(Run function, void* self) : run_(function), self_(self) {}

  /// work(unit) for 0 to units - 1. No unit may depend on what another one does.
  template <class Work>
  void run(std::uint64_t units, Work&& work) const {
    if (run_ == nullptr || units < 2) {
      for (std::uint64_t unit = 0; unit < units; ++unit) work(unit);
      return;
    }
    const auto call = [](void* context, std::uint64_t unit) {
      (*static_cast<std::remove_reference_t<Work>*>(context))(unit);
    };
    run_(self_, call, &work, units);
  }

 private:
  Run run_ = nullptr;
  void* self_ = nullptr;
};

}  // namespace mlt
