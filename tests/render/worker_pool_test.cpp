// The threads of a render: every unit once, whatever the number of threads. Data that units share is plain
// where the pool's own ordering must suffice, so that a thread sanitizer sees it when it does not.
#include "render/worker_pool.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

#include "base/assert.hpp"
#include "base/event.hpp"
#include "support/child_process.hpp"

namespace mlt::test {
namespace {

const std::atomic<bool> kNeverStop{false};

/// A pool with its storage.
class Pool {
 public:
  explicit Pool(std::uint32_t workers) : stacks_(new WorkerStack[workers]), threads_(workers) {
    pool_.start({stacks_.get(), workers}, threads_);
  }
  WorkerPool& operator*() { return pool_; }
  WorkerPool* operator->() { return &pool_; }

 private:
  std::unique_ptr<WorkerStack[]> stacks_;  // not initialised: the pool touches what it needs
  std::vector<pthread_t> threads_;
  WorkerPool pool_;  // ends its threads before their stacks go
};

/// Plain counters: one a unit, and one a worker, which no two threads may share.
struct Counters {
  std::vector<std::uint32_t> of_unit;
  std::vector<std::uint64_t> of_worker;

  Counters(std::uint64_t units, std::uint32_t workers) : of_unit(units), of_worker(workers) {}

  static void count(void* context, std::uint32_t worker, std::uint64_t unit) {
    auto& counters = *static_cast<Counters*>(context);
    counters.of_unit[unit] += 1;
    counters.of_worker.at(worker) += 1;
  }

  bool all_units_equal(std::uint32_t times) const {
    for (const std::uint32_t runs : of_unit) {
      if (runs != times) return false;
    }
    return true;
  }
  std::uint64_t total_of_workers() const {
    std::uint64_t total = 0;
    for (const std::uint64_t runs : of_worker) total += runs;
    return total;
  }
};

TEST_CASE("every unit runs exactly once, on 1 to 64 threads", "[threads]") {
  for (const std::uint32_t workers : {1U, 2U, 3U, 4U, 7U, 16U, 33U, 64U}) {
    Pool pool(workers);
    for (const std::uint64_t units : {0U, 1U, 2U, 63U, 1000U}) {
      INFO(workers << " threads, " << units << " units");
      Counters counters(units, workers);
      CHECK(pool->run({"test", &Counters::count, &counters, units, true}, kNeverStop, nullptr, nullptr) ==
            units);
      CHECK(counters.all_units_equal(1));
      CHECK(counters.total_of_workers() == units);
    }
  }
}

TEST_CASE("phases follow each other, and each sees what the one before wrote", "[threads]") {
  Pool pool(4);
  constexpr std::uint64_t kUnits = 50;
  constexpr std::uint32_t kPhases = 500;
  Counters counters(kUnits, 4);
  for (std::uint32_t phase = 0; phase < kPhases; ++phase) {
    pool->run({"test", &Counters::count, &counters, kUnits, false}, kNeverStop, nullptr, nullptr);
    REQUIRE(counters.all_units_equal(phase + 1));
  }
  CHECK(counters.total_of_workers() == kUnits * kPhases);
}

TEST_CASE("as a runner of units the pool runs each once, and its caller sees what they wrote", "[threads]") {
  for (const std::uint32_t workers : {1U, 2U, 7U}) {
    Pool pool(workers);
    const UnitRunner runner = pool->runner();
    for (const std::uint64_t units : {0U, 1U, 2U, 63U, 1000U}) {
      INFO(workers << " threads, " << units << " units");
      std::vector<std::uint32_t> runs(units);
      for (std::uint32_t round = 1; round <= 20; ++round) {
        runner.run(units, [&](std::uint64_t unit) { runs[unit] += 1; });
        REQUIRE(std::count(runs.begin(), runs.end(), round) == static_cast<std::ptrdiff_t>(units));
      }
    }
  }
}

/// Sets the stop flag in one unit and notes which units ran.
struct Stopping {
  std::atomic<bool> stop{false};
  std::vector<std::uint32_t> runs = std::vector<std::uint32_t>(1000);
  std::uint64_t stopping_unit = 100;

  static void run(void* context, std::uint32_t, std::uint64_t unit) {
    auto& self = *static_cast<Stopping*>(context);
    self.runs[unit] += 1;
    if (unit == self.stopping_unit) self.stop.store(true);
  }
};

TEST_CASE("a stop flag ends a stoppable phase between units, of which the first ones have run", "[threads]") {
  for (const std::uint32_t workers : {1U, 4U, 16U}) {
    Pool pool(workers);
    Stopping stopping;
    const std::uint64_t run =
        pool->run({"test", &Stopping::run, &stopping, 1000, true}, stopping.stop, nullptr, nullptr);
    // Each other worker may have one unit more in hand.
    CHECK(run >= 101);
    CHECK(run <= 1000);
    if (workers == 1) CHECK(run == 101);
    for (std::uint64_t unit = 0; unit < 1000; ++unit) REQUIRE(stopping.runs[unit] == (unit < run ? 1U : 0U));

    // It is still set, so that a further phase does nothing, unless it cannot be stopped.
    CHECK(pool->run({"test", &Stopping::run, &stopping, 1000, true}, stopping.stop, nullptr, nullptr) == 0);
    CHECK(pool->run({"test", &Stopping::run, &stopping, 1000, false}, stopping.stop, nullptr, nullptr) ==
          1000);
  }
}

TEST_CASE("the waiting thread is called back while units run", "[threads]") {
  struct Waiting {
    std::atomic<bool> called{false};
    static void unit(void* context, std::uint32_t, std::uint64_t) {
      while (!static_cast<Waiting*>(context)->called.load()) std::this_thread::yield();
    }
    static void idle(void* context) { static_cast<Waiting*>(context)->called.store(true); }
  } waiting;
  Pool pool(2);
  // Ends only because idle is called before the units are done.
  CHECK(pool->run({"test", &Waiting::unit, &waiting, 2, true}, kNeverStop, &Waiting::idle, &waiting) == 2);
}

TEST_CASE("units know the stage for failure reports", "[threads]") {
  const ChildResult child = run_in_child([] {
    Pool pool(2);
    const auto fail = [](void*, std::uint32_t, std::uint64_t unit) { MLT_CHECK_OP(unit, <, 5U); };
    pool->run({"some stage", fail, nullptr, 6, true}, kNeverStop, nullptr, nullptr);
  });
  CHECK(child.exit_code == 70);
  CHECK_THAT(child.errors, Catch::Contains("while: some stage"));
}

TEST_CASE("a pool can end without a phase, be stopped twice, or never start", "[threads]") {
  WorkerPool never_started;
  Pool pool(3);
  pool->stop();
  pool->stop();
}

TEST_CASE("a pool without threads, or started again, is a bug instead of a wait for ever", "[threads]") {
  const auto exit_code = [](auto body) { return run_in_child(body).exit_code; };
  CHECK(exit_code([] { Pool pool(0); }) == 70);
  CHECK(exit_code([] {
          Pool pool(1);
          pool->stop();
          std::array<pthread_t, 1> thread{};
          const std::unique_ptr<WorkerStack[]> stack(new WorkerStack[1]);
          pool->start({stack.get(), 1}, thread);
        }) == 70);
}

TEST_CASE("an event releases all waiters once it differs from the value they know", "[threads]") {
  for (int repetition = 0; repetition < 100; ++repetition) {
    Event event;
    int written = 0;
    std::atomic<int> seen{0};
    std::vector<std::thread> waiters;
    for (int i = 0; i < 3; ++i) {
      waiters.emplace_back([&] {
        event.wait_while(0);
        seen.fetch_add(written);
      });
    }
    written = 7;
    event.raise();
    for (std::thread& waiter : waiters) waiter.join();
    REQUIRE(seen.load() == 21);
    REQUIRE(event.value() == 1);
    // The value has changed before: no wait.
    event.wait_while(0);
  }
}

TEST_CASE("an event's wait with a limit ends without being raised", "[threads]") {
  Event event;
  event.wait_while(0, 5);
  CHECK(event.value() == 0);
}

}  // namespace
}  // namespace mlt::test
