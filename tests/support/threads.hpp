// Threads for what takes a UnitRunner.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

#include "base/unit_runner.hpp"

namespace mlt::test {

/// Starts so many threads anew for each call, which take the units in turn.
class Threads {
 public:
  explicit Threads(unsigned count) : count_(count) {}
  UnitRunner runner() { return {&Threads::run, this}; }

 private:
  static void run(void* self, UnitRunner::Unit unit, void* context, std::uint64_t units) {
    std::atomic<std::uint64_t> next{0};
    std::vector<std::thread> threads;
    for (unsigned i = 0; i < static_cast<Threads*>(self)->count_; ++i) {
      threads.emplace_back([&] {
        for (std::uint64_t u = next++; u < units; u = next++) unit(context, u);
      });
    }
    for (std::thread& thread : threads) thread.join();
  }
  unsigned count_;
};

}  // namespace mlt::test
