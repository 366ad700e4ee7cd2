// Nanoseconds per call of the functions of math/elementary.hpp and of libm's float versions. Two figures
// each: throughput of independent calls (a loop over an array, which the compiler may vectorise where the
// function allows it) and latency of dependent ones. Medians of interleaved runs, so that a change of the
// clock's frequency or another process meets both sides alike.
#include <cmath>
#include <cstdio>
#include <vector>

#include "math/elementary.hpp"
#include "math/rng.hpp"
#include "math/srgb.hpp"
#include "row.hpp"

namespace mlt::test {
namespace {

constexpr std::size_t kCount = 4096;
constexpr int kRunsOfAll = 101;
constexpr int kQuickRuns = 11;

std::vector<float> inputs(float low, float high) {
  Rng rng(1, StreamPurpose::kTest, 0);
  std::vector<float> values(kCount);
  for (float& x : values) x = low + (high - low) * rng.next_float();
  return values;
}

// The sum keeps the compiler from dropping the calls.
volatile float sink;

template <class F>
double throughput(const std::vector<float>& x, F f) {
  static float out[kCount];
  const double start = cpu_seconds();
  for (std::size_t i = 0; i < kCount; ++i) out[i] = f(x[i]);
  const double elapsed = 1e9 * (cpu_seconds() - start);
  sink = out[static_cast<std::size_t>(x[0] != 0.0f)];
  return elapsed / kCount;
}

template <class F>
double latency(const std::vector<float>& x, F f) {
  float previous = 0;
  const double start = cpu_seconds();
  // Adding 0 times the last result makes each call wait for it and leaves the argument as it is.
  for (std::size_t i = 0; i < kCount; ++i) previous = f(x[i] + 0.0f * previous);
  const double elapsed = 1e9 * (cpu_seconds() - start);
  sink = previous;
  return elapsed / kCount;
}

template <class F, class G>
void compare(const char* name, float low, float high, F own, G libm) {
  const std::vector<float> x = inputs(low, high);
  BenchRow fast{"calls", name, "ns"};
  BenchRow slow{"dependent calls", name, "ns"};
  fast.rival = slow.rival = "libm";
  const int runs = quick_bench() ? kQuickRuns : kRunsOfAll;
  for (int run = 0; run < runs; ++run) {
    fast.readings.push_back(throughput(x, own));
    fast.rival_readings.push_back(throughput(x, libm));
    slow.readings.push_back(latency(x, own));
    slow.rival_readings.push_back(latency(x, libm));
  }
  print_row(fast);
  print_row(slow);
}

float both_own(float u) {
  float s;
  float c;
  sincos_2pi(u, s, c);
  return s + c;
}

float both_libm(float u) {
  return std::sin(6.2831853f * u) + std::cos(6.2831853f * u);
}

float srgb_libm(float x) {
  return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1.0f / 2.4f) - 0.055f;
}

void compare_all() {
  compare("sincos_2pi 0 to 1", 0.0f, 1.0f, both_own, both_libm);
  compare(
      "exp_f -10 to 10", -10.0f, 10.0f, [](float x) { return exp_f(x); },
      [](float x) { return std::exp(x); });
  compare(
      "exp2_f -10 to 10", -10.0f, 10.0f, [](float x) { return exp2_f(x); },
      [](float x) { return std::exp2(x); });
  compare(
      "log_f 1e-3 to 100", 1e-3f, 100.0f, [](float x) { return log_f(x); },
      [](float x) { return std::log(x); });
  compare(
      "log2_f 1e-3 to 100", 1e-3f, 100.0f, [](float x) { return log2_f(x); },
      [](float x) { return std::log2(x); });
  compare(
      "pow_f(x 2.2) 0 to 4", 0.0f, 4.0f, [](float x) { return pow_f(x, 2.2f); },
      [](float x) { return std::pow(x, 2.2f); });
  compare(
      "acos_f -1 to 1", -1.0f, 1.0f, [](float x) { return acos_f(x); }, [](float x) { return std::acos(x); });
  compare(
      "atan2_f(y 0.7) -2 to 2", -2.0f, 2.0f, [](float y) { return atan2_f(y, 0.7f); },
      [](float y) { return std::atan2(y, 0.7f); });
  compare(
      "srgb_encode 0 to 1", 0.0f, 1.0f, [](float x) { return srgb_encode(x); }, srgb_libm);
}

}  // namespace
}  // namespace mlt::test

int main() {
  mlt::test::compare_all();
  return 0;
}
