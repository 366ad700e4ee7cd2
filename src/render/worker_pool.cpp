#include "render/worker_pool.hpp"

#include <limits>
#include <string>

#include "base/assert.hpp"
#include "base/error.hpp"
#include "base/planted_fault.hpp"
#include "base/render_zone.hpp"

namespace mlt {
namespace {

// What a unit of work may use of a stack, with room to spare; the rest is for thread start and exit.
constexpr std::size_t kTouchedStack = std::size_t{128} << 10;
constexpr std::uint32_t kIdleMilliseconds = 250;

/// Results differ where denormals are flushed to zero, which another library can switch on for a process.
void check_denormals() {
  volatile float smallest = std::numeric_limits<float>::denorm_min();
  volatile float half_of_normal = std::numeric_limits<float>::min() * 0.5f;
  MLT_CHECK(smallest * 1.0f > 0.0f);
  MLT_CHECK(half_of_normal > 0.0f);
}

}  // namespace

void WorkerPool::start(std::span<WorkerStack> stacks, std::span<pthread_t> threads) {
  MLT_CHECK_OP(stacks.size(), ==, threads.size());
  MLT_CHECK_OP(threads.size(), >, 0U);
  MLT_CHECK(threads_.empty() && !exiting_);
  const std::uint32_t ready = phase_done_.value();
  busy_workers_.store(static_cast<std::uint32_t>(threads.size()));
  for (std::size_t i = 0; i < threads.size(); ++i) {
    pthread_attr_t attributes;
    pthread_attr_init(&attributes);
    pthread_attr_setstack(&attributes, stacks[i].bytes, WorkerStack::kBytes);
    const int error = pthread_create(&threads[i], &attributes, &WorkerPool::thread_main, this);
    pthread_attr_destroy(&attributes);
    if (error != 0) {
      threads_ = threads.first(i);
      throw ResourceError("the system refused thread " + std::to_string(i + 1) + " of " +
                          std::to_string(threads.size()));
    }
  }
  threads_ = threads;
  phase_done_.wait_while(ready);
}

void WorkerPool::stop() {
  exiting_ = true;
  phase_begun_.raise();
  for (const pthread_t thread : threads_) pthread_join(thread, nullptr);
  threads_ = {};
}

std::uint64_t WorkerPool::run(const Phase& phase, const std::atomic<bool>& stop_flag, void (*idle)(void*),
                              void* idle_context) {
  MLT_CHECK_OP(threads_.size(), >, 0U);
  const std::uint32_t done = phase_done_.value();
  phase_ = phase;
  stop_flag_ = &stop_flag;
  next_unit_.store(0, std::memory_order_relaxed);
  busy_workers_.store(static_cast<std::uint32_t>(threads_.size()), std::memory_order_relaxed);
  phase_begun_.raise();
  while (phase_done_.value() == done) {
    phase_done_.wait_while(done, kIdleMilliseconds);
    if (idle != nullptr) idle(idle_context);
  }
  const std::uint64_t taken = next_unit_.load(std::memory_order_relaxed);
  return taken < phase.units ? taken : phase.units;
}

UnitRunner WorkerPool::runner() {
  return threads_.size() < 2 ? UnitRunner{} : UnitRunner{&WorkerPool::run_for, this};
}

void WorkerPool::run_for(void* pool, UnitRunner::Unit unit, void* context, std::uint64_t units) {
  struct Call {
    UnitRunner::Unit unit;
    void* context;
  } call{unit, context};
  const auto run_one = [](void* own, std::uint32_t, std::uint64_t i) {
    const Call& made = *static_cast<const Call*>(own);
    made.unit(made.context, i);
  };
  const std::atomic<bool> never{false};
  static_cast<WorkerPool*>(pool)->run(Phase{"scene", run_one, &call, units, false}, never, nullptr, nullptr);
}

void* WorkerPool::thread_main(void* pool) {
  auto* self = static_cast<WorkerPool*>(pool);
  const std::uint32_t worker = self->next_worker_.fetch_add(1, std::memory_order_relaxed);
  prefault_stack(kTouchedStack);
  check_denormals();
  self->work(worker);
  return nullptr;
}

void WorkerPool::work(std::uint32_t worker) {
  std::uint32_t seen = 0;
  for (;;) {
    if (busy_workers_.fetch_sub(1, std::memory_order_acq_rel) == 1) phase_done_.raise();
    phase_begun_.wait_while(seen);
    seen = phase_begun_.value();
    if (exiting_) return;
    run_units(worker);
  }
}

void WorkerPool::run_units(std::uint32_t worker) {
  replay_context().stage = phase_.stage;
  for (;;) {
    if (phase_.stoppable && stop_flag_->load(std::memory_order_relaxed)) return;
    const std::uint64_t unit = next_unit_.fetch_add(1, std::memory_order_relaxed);
    if (unit >= phase_.units) return;
    planted_fault();
    phase_.run(phase_.context, worker, unit);
  }
}

}  // namespace mlt
