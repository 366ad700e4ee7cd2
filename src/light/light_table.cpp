#include "light/light_table.hpp"

#include <fmt/core.h>

#include <cmath>

#include "base/assert.hpp"
#include "base/error.hpp"

namespace mlt {

namespace {
constexpr std::uint64_t kUnits = std::uint64_t{1} << 24;
}  // namespace

double light_power(const Light& light) {
  const Vec3& rgb = light.radiance;
  const double emitted = (0.2126 * rgb.x + 0.7152 * rgb.y) + 0.0722 * rgb.z;
  const double power = 3.14159265358979324 * static_cast<double>(light.area) * emitted;
  return std::isfinite(power) && power > 0.0 ? power : 0.0;
}

LightTable build_light_table(std::span<Light> lights, std::span<float> cdf) {
  MLT_CHECK_OP(lights.size(), ==, cdf.size());
  double total = 0;
  std::uint64_t emitting = 0;
  for (const Light& light : lights) {
    const double power = light_power(light);
    total += power;
    if (power > 0.0) ++emitting;
  }
  if (emitting > kMaxLights) {
    throw ResourceError(fmt::format("{} emitting primitives; at most {} are possible", emitting, kMaxLights));
  }
  const double shared = static_cast<double>(kUnits - emitting);
  double cumulative = 0;
  std::uint64_t seen = 0;
  std::uint64_t previous_end = 0;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const double power = light_power(lights[i]);
    cumulative += power;
    if (power > 0.0) ++seen;
    std::uint64_t end = previous_end;
    // The last one ends at exactly 1: its cumulative sum is the total, term by term.
    if (power > 0.0) end = seen + static_cast<std::uint64_t>(std::floor(shared * (cumulative / total) + 0.5));
    lights[i].choice_probability = static_cast<float>(end - previous_end) * 0x1p-24f;
    cdf[i] = static_cast<float>(end) * 0x1p-24f;
    previous_end = end;
  }
  return {lights, cdf};
}

}  // namespace mlt
