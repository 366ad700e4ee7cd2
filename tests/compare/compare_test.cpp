#include "compare/compare.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "base/error.hpp"

namespace mlt {
namespace {

ImageBuffer uniform(std::uint32_t width, std::uint32_t height, float value) {
  return {width, height, std::vector<Vec3>(std::size_t{width} * height, Vec3{value, value, value})};
}

/// Without FLIP, which has tests of its own.
ImageComparison figures(const ImageBuffer& image, const ImageBuffer& reference) {
  CompareOptions options;
  options.with_flip = false;
  return compare_images(image.view(), reference.view(), options);
}

TEST_CASE("an image equals itself") {
  const ImageBuffer image{2, 1, {Vec3{1, 2, 3}, Vec3{0, 1e-20f, 1e20f}}};
  const ImageComparison result = figures(image, image);
  CHECK(result.metrics[MetricKind::mse] == 0);
  CHECK(result.metrics[MetricKind::relmse] == 0);
  CHECK(result.mean_ratio_all == 1);
}

TEST_CASE("the metrics of a small pair of images are those computed by hand") {
  // Differences 1, 0, -2, 0, 0, 3; reference 1, 2, 3, 0, 0, 0.
  const ImageBuffer image{1, 2, {Vec3{2, 2, 1}, Vec3{0, 0, 3}}};
  const ImageBuffer reference{1, 2, {Vec3{1, 2, 3}, Vec3{0, 0, 0}}};
  const ImageComparison result = figures(image, reference);
  // Six terms of exactly representable values; the tolerance is that of a few roundings in double.
  CHECK(result.metrics[MetricKind::mse] == Approx((1.0 + 4.0 + 9.0) / 6.0).epsilon(1e-15));
  CHECK(result.metrics[MetricKind::relmse] ==
        Approx((1.0 / 1.01 + 4.0 / 9.01 + 9.0 / 0.01) / 6.0).epsilon(1e-14));
  CHECK(result.metrics[MetricKind::rmse] == Approx(std::sqrt(14.0 / 6.0)).epsilon(1e-15));
  CHECK(result.metrics[MetricKind::mae] == Approx(6.0 / 6.0).epsilon(1e-15));
  CHECK(result.metrics[MetricKind::smape] ==
        Approx((1.0 / 3.01 + 2.0 / 4.01 + 3.0 / 3.01) / 6.0).epsilon(1e-14));
  // Channel means 1, 1, 2 against 0.5, 1, 1.5.
  CHECK(result.mean_image == std::array<double, 3>{1, 1, 2});
  CHECK(result.mean_reference == std::array<double, 3>{0.5, 1, 1.5});
  CHECK(result.mean_ratio == std::array<double, 3>{2, 1, 2 / 1.5});
  CHECK(result.metrics[MetricKind::mean_error] == 1);
  CHECK(result.mean_ratio_all == Approx(8.0 / 6.0).epsilon(1e-15));
}

TEST_CASE("relMSE and the ratio tell which of the two images is the reference") {
  const ImageComparison forward = figures(uniform(4, 4, 2), uniform(4, 4, 1));
  const ImageComparison backward = figures(uniform(4, 4, 1), uniform(4, 4, 2));
  CHECK(forward.mean_ratio_all == 2);
  CHECK(backward.mean_ratio_all == 0.5);
  CHECK(forward.metrics[MetricKind::relmse] == Approx(1 / 1.01).epsilon(1e-14));
  CHECK(backward.metrics[MetricKind::relmse] == Approx(1 / 4.01).epsilon(1e-14));
  CHECK(forward.metrics[MetricKind::mse] == backward.metrics[MetricKind::mse]);
}

TEST_CASE("black references divide by nothing") {
  CHECK(figures(uniform(2, 2, 0), uniform(2, 2, 0)).mean_ratio_all == 1);
  const ImageComparison result = figures(uniform(2, 2, 1), uniform(2, 2, 0));
  CHECK(std::isinf(result.mean_ratio_all));
  CHECK(result.metrics[MetricKind::relmse] == Approx(100).epsilon(1e-14));
}

TEST_CASE("sums do not lose small differences in large images") {
  // 2^22 equal terms of 0.1^2: a float sum would stall; double is good to 2^22 roundings at most.
  const ImageBuffer image = uniform(2048, 2048, 0.5f);
  const ImageBuffer reference = uniform(2048, 2048, 0.4f);
  const double difference = double{0.5f} - double{0.4f};
  CHECK(figures(image, reference).metrics[MetricKind::mse] == Approx(difference * difference).epsilon(1e-10));
}

TEST_CASE("images that cannot be compared are refused with counts, places and sizes") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  ImageBuffer bad = uniform(3, 2, 1);
  bad.pixels[4] = Vec3{1, nan, 1};
  bad.pixels[5] = Vec3{infinity, 1, 1};
  const ImageBuffer good = uniform(3, 2, 1);
  require_comparable("a", good.view(), "b", good.view());
  CHECK_THROWS_AS(require_comparable("a", bad.view(), "b", good.view()), InputError);
  CHECK_THROWS_WITH(require_comparable("a", bad.view(), "b", good.view()),
                    Catch::StartsWith("a: 2 of 6 pixels") && Catch::Contains("the first at x 1, y 1"));
  CHECK_THROWS_WITH(require_comparable("a", good.view(), "b", bad.view()),
                    Catch::StartsWith("b: 2 of 6 pixels"));
  CHECK_THROWS_WITH(require_comparable("a", uniform(2, 3, 1).view(), "b", good.view()),
                    Catch::Contains("has 2 x 3 pixels; expected 3 x 2 as in b"));
}

}  // namespace
}  // namespace mlt
