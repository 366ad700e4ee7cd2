// The error metrics, in one list: names, JSON keys, the options that bound them, help text and the contract
// tests come from it. docs/COMPARE.md gives each formula with its source.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace mlt {

/// key (of JSON, and with hyphens in the option), label, side of the bound (`max`: larger is worse and the
/// option is --max-KEY; `min`: smaller is worse, --min-KEY), definition for the help text, of image A against
/// reference B.
#define MLT_COMPARE_METRICS(X)                                                                          \
  X(mse, "MSE", max, "mean of (A - B)^2 over pixels and channels")                                      \
  X(rmse, "RMSE", max, "square root of the MSE")                                                        \
  X(mae, "MAE", max, "mean of |A - B|")                                                                 \
  X(relmse, "relMSE", max, "mean of (A - B)^2 / (B^2 + 0.01)")                                          \
  X(smape, "SMAPE", max, "mean of |A - B| / (|A| + |B| + 0.01), 0 to 1")                                \
  X(psnr, "PSNR", min, "peak signal-to-noise ratio in dB of the sRGB values, clipped to [0,1], peak 1") \
  X(flip, "FLIP", max, "mean of the visible difference when flipping between both, 0 to 1")             \
  X(mean_error, "mean error", max, "largest of |mean A / mean B - 1| over the channels")

enum class MetricKind : std::uint8_t {
#define MLT_ENUMERATE(key, label, bound, help) key,
  MLT_COMPARE_METRICS(MLT_ENUMERATE)
#undef MLT_ENUMERATE
};

enum class MetricBound : std::uint8_t { max, min };

struct MetricInfo {
  const char* key;
  const char* label;
  MetricBound bound;
  const char* help;
};

inline constexpr MetricInfo kMetrics[] = {
#define MLT_ITEM(key, label, bound, help) {#key, label, MetricBound::bound, help},
    MLT_COMPARE_METRICS(MLT_ITEM)
#undef MLT_ITEM
};
inline constexpr std::size_t kMetricCount = sizeof kMetrics / sizeof kMetrics[0];

/// A number for each metric, by its enum.
struct MetricValues {
  std::array<double, kMetricCount> all{};

  double& operator[](MetricKind kind) { return all[static_cast<std::size_t>(kind)]; }
  double operator[](MetricKind kind) const { return all[static_cast<std::size_t>(kind)]; }
};

/// True when `value` is on the bad side of `limit`, or no number.
inline bool exceeds(MetricBound bound, double value, double limit) {
  // Negated, so that a NaN exceeds.
  return bound == MetricBound::max ? !(value <= limit) : !(value >= limit);
}

}  // namespace mlt
