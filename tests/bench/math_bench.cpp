// Prints nanoseconds per call of the functions of math/elementary.hpp and of libm's float versions. Two
// figures each: throughput of independent calls (a loop over an array, which the compiler may vectorise where
// the function allows it) and latency of dependent ones. Medians of interleaved runs, so that a change of the
// clock's frequency or another process meets both sides alike.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <vector>

#include "math/elementary.hpp"
#include "math/rng.hpp"
#include "math/srgb.hpp"

namespace {

constexpr std::size_t kCount = 4096;
constexpr int kRuns = 101;

std::vector<float> inputs(float low, float high) {
  mlt::Rng rng(1, mlt::StreamPurpose::kTest, 0);
  std::vector<float> values(kCount);
  for (float& x : values) x = low + (high - low) * rng.next_float();
  return values;
}

double nanoseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count();
}

// The sum keeps the compiler from dropping the calls.
volatile float sink;

template <class F>
double throughput(const std::vector<float>& x, F f) {
  static float out[kCount];
  const auto start = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < kCount; ++i) out[i] = f(x[i]);
  const double elapsed = nanoseconds_since(start);
  sink = out[static_cast<std::size_t>(x[0] != 0.0f)];
  return elapsed / kCount;
}

template <class F>
double latency(const std::vector<float>& x, F f) {
  float previous = 0;
  const auto start = std::chrono::steady_clock::now();
  // Adding 0 times the last result makes each call wait for it and leaves the argument as it is.
  for (std::size_t i = 0; i < kCount; ++i) previous = f(x[i] + 0.0f * previous);
  const double elapsed = nanoseconds_since(start);
  sink = previous;
  return elapsed / kCount;
}

double median(std::vector<double>& values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

template <class F, class G>
void compare(const char* name, float low, float high, F own, G libm) {
  const std::vector<float> x = inputs(low, high);
  std::vector<double> times[4];
  for (int run = 0; run < kRuns; ++run) {
    times[0].push_back(throughput(x, own));
    times[1].push_back(throughput(x, libm));
    times[2].push_back(latency(x, own));
    times[3].push_back(latency(x, libm));
  }
  std::printf("%-22s throughput %6.2f own %6.2f libm   latency %6.2f own %6.2f libm\n", name,
              median(times[0]), median(times[1]), median(times[2]), median(times[3]));
}

float both_own(float u) {
  float s;
  float c;
  mlt::sincos_2pi(u, s, c);
  return s + c;
}

float both_libm(float u) {
  return std::sin(6.2831853f * u) + std::cos(6.2831853f * u);
}

float srgb_libm(float x) {
  return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1.0f / 2.4f) - 0.055f;
}

}  // namespace

int main() {
  std::printf("nanoseconds per call, medians of %d interleaved runs of %zu calls\n", kRuns, kCount);
  compare("sincos_2pi [0,1)", 0.0f, 1.0f, both_own, both_libm);
  compare(
      "exp_f [-10,10]", -10.0f, 10.0f, [](float x) { return mlt::exp_f(x); },
      [](float x) { return std::exp(x); });
  compare(
      "exp2_f [-10,10]", -10.0f, 10.0f, [](float x) { return mlt::exp2_f(x); },
      [](float x) { return std::exp2(x); });
  compare(
      "log_f [1e-3,100]", 1e-3f, 100.0f, [](float x) { return mlt::log_f(x); },
      [](float x) { return std::log(x); });
  compare(
      "log2_f [1e-3,100]", 1e-3f, 100.0f, [](float x) { return mlt::log2_f(x); },
      [](float x) { return std::log2(x); });
  compare(
      "pow_f(x,2.2) [0,4]", 0.0f, 4.0f, [](float x) { return mlt::pow_f(x, 2.2f); },
      [](float x) { return std::pow(x, 2.2f); });
  compare(
      "acos_f [-1,1]", -1.0f, 1.0f, [](float x) { return mlt::acos_f(x); },
      [](float x) { return std::acos(x); });
  compare(
      "atan2_f(y,0.7) [-2,2]", -2.0f, 2.0f, [](float y) { return mlt::atan2_f(y, 0.7f); },
      [](float y) { return std::atan2(y, 0.7f); });
  compare(
      "srgb_encode [0,1]", 0.0f, 1.0f, [](float x) { return mlt::srgb_encode(x); }, srgb_libm);
  return 0;
}
