// What every metric of the list owes its users, by looping over the list.
#include "compare/metrics.hpp"

#include <fmt/core.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "compare/compare.hpp"
#include "math/rng.hpp"

namespace mlt {
namespace {

ImageBuffer noise(std::uint64_t seed, float amount) {
  Rng common(0, StreamPurpose::kTest, 0);
  Rng rng(seed, StreamPurpose::kTest, 1);
  ImageBuffer image{20, 15, {}};
  for (int i = 0; i < 300; ++i) {
    Vec3 pixel{0, 0, 0};
    for (int c = 0; c < 3; ++c) {
      pixel[c] = 0.2f + 0.6f * common.next_float() + amount * (rng.next_float() - 0.3f);
    }
    image.pixels.push_back(pixel);
  }
  return image;
}

MetricValues metrics(const ImageBuffer& image, const ImageBuffer& reference) {
  return compare_images(image.view(), reference.view(), {}).metrics;
}

MetricKind kind_of(std::size_t index) {
  return static_cast<MetricKind>(index);
}

TEST_CASE("every metric is best for equal images, worse for small and worst for large errors") {
  const ImageBuffer reference = noise(0, 0);
  const MetricValues equal = metrics(reference, reference);
  const MetricValues near = metrics(noise(1, 0.01f), reference);
  const MetricValues far = metrics(noise(1, 0.2f), reference);
  for (std::size_t i = 0; i < kMetricCount; ++i) {
    CAPTURE(kMetrics[i].key);
    const MetricKind kind = kind_of(i);
    if (kMetrics[i].bound == MetricBound::max) {
      CHECK(equal[kind] == 0);
      CHECK(near[kind] > 0);
      CHECK(far[kind] > near[kind]);
      CHECK(std::isfinite(far[kind]));
    } else {
      CHECK(equal[kind] == std::numeric_limits<double>::infinity());
      CHECK(near[kind] > far[kind]);
      CHECK(far[kind] > 0);
    }
  }
}

TEST_CASE("every metric has a name of its own and a bound that NaN exceeds") {
  std::set<std::string> names;
  for (const MetricInfo& metric : kMetrics) {
    CAPTURE(metric.key);
    CHECK(names.insert(metric.key).second);
    CHECK(names.insert(metric.label).second);
    CHECK(std::string(metric.help).size() > 10);
    CHECK(exceeds(metric.bound, std::nan(""), 1));
    CHECK_FALSE(exceeds(metric.bound, 1, 1));
    CHECK(exceeds(metric.bound, 2, 1) == (metric.bound == MetricBound::max));
    CHECK(exceeds(metric.bound, 0.5, 1) == (metric.bound == MetricBound::min));
  }
}

TEST_CASE("every metric survives extreme finite values") {
  const float most = std::numeric_limits<float>::max();
  const std::vector<Vec3> values{Vec3(0.0f), Vec3(most), Vec3(-most), Vec3(1e-45f), Vec3(most, 0, -1)};
  for (const Vec3& a : values) {
    for (const Vec3& b : values) {
      const ImageBuffer image{2, 2, std::vector<Vec3>(4, a)};
      const ImageBuffer reference{2, 2, std::vector<Vec3>(4, b)};
      const MetricValues result = metrics(image, reference);
      for (std::size_t i = 0; i < kMetricCount; ++i) {
        CAPTURE(kMetrics[i].key, a.x, b.x);
        CHECK_FALSE(std::isnan(result[kind_of(i)]));
        if (kMetrics[i].bound == MetricBound::max) CHECK(result[kind_of(i)] >= 0);
      }
    }
  }
}

TEST_CASE("the error map of a metric that is a mean has the metric as its mean") {
  const ImageBuffer image = noise(2, 0.3f);
  const ImageBuffer reference = noise(0, 0);
  const ImageComparison result = compare_images(image.view(), reference.view(), {});
  for (std::size_t i = 0; i < kMetricCount; ++i) {
    CAPTURE(kMetrics[i].key);
    const MetricKind kind = kind_of(i);
    const std::vector<float> map = error_map(kind, image.view(), reference.view(), result, {});
    REQUIRE(map.size() == 300);
    double mean = 0;
    for (const float value : map) {
      CHECK(value >= 0);
      mean += static_cast<double>(value) / 300;
    }
    double expected = result.metrics[kind];
    if (kind == MetricKind::psnr) expected = std::pow(10.0, -expected / 10);
    if (kind == MetricKind::mean_error) expected = result.metrics[MetricKind::mae];
    // A root of each pixel is no longer a mean.
    if (kind != MetricKind::rmse) CHECK(mean == Approx(expected).epsilon(1e-6));
  }
}

TEST_CASE("PSNR is that of the sRGB values as displayed") {
  const auto image = [](float value) { return ImageBuffer{1, 1, {Vec3(value)}}; };
  const auto psnr = [&](float a, float b, double exposure) {
    CompareOptions options;
    options.with_flip = false;
    options.exposure = exposure;
    return compare_images(image(a).view(), image(b).view(), options).metrics[MetricKind::psnr];
  };
  CHECK(psnr(1, 0, 0) == 0);
  CHECK(std::isinf(psnr(1, 50, 0)));  // both are shown as white
  CHECK(std::isinf(psnr(0, -3, 0)));
  const auto srgb = [](double v) { return 1.055 * std::pow(v, 1 / 2.4) - 0.055; };
  // srgb_encode gives floats: 2^-24 of a difference of 0.2.
  CHECK(psnr(0.5f, 0.3f, 0) == Approx(-20 * std::log10(srgb(0.5) - srgb(double{0.3f}))).epsilon(1e-6));
  CHECK(psnr(0.5f, 0.3f, -2) ==
        Approx(-20 * std::log10(srgb(0.125) - srgb(0.25 * double{0.3f}))).epsilon(1e-6));
}

TEST_CASE("every figure is the same bits from every compiler and machine") {
  const MetricValues result = metrics(noise(2, 0.3f), noise(0, 0));
  CompareOptions displayed;
  displayed.flip.mode = FlipMode::ldr;
  const double ldr =
      compare_images(noise(2, 0.3f).view(), noise(0, 0).view(), displayed).metrics[MetricKind::flip];
  // As first computed by g++ 12 at -O2 on x86-64.
  const double expected[kMetricCount] = {0x1.81948a7aa1733p-7, 0x1.bc5100f585a12p-4, 0x1.7286f0f89abcep-4,
                                         0x1.1aeb5c740167bp-4, 0x1.79dc38ab768aap-4, 0x1.6d7824b641b96p+4,
                                         0x1.25995d1f92c6p-3,  0x1.17f974f384b2p-3};
  for (std::size_t i = 0; i < kMetricCount; ++i) {
    CAPTURE(kMetrics[i].key, fmt::format("{:a}", result.all[i]));
    CHECK(result.all[i] == expected[i]);
  }
  CAPTURE(fmt::format("{:a}", ldr));
  CHECK(ldr == 0x1.f6744d7e4b17ep-3);
}

}  // namespace
}  // namespace mlt
