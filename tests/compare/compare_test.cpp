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

TEST_CASE("an image equals itself") {
  const ImageBuffer image{2, 1, {Vec3{1, 2, 3}, Vec3{0, 1e-20f, 1e20f}}};
  const ImageComparison result = compare_images(image.view(), image.view());
  CHECK(result.mse == 0);
  CHECK(result.rel_mse == 0);
  CHECK(result.mean_ratio == 1);
}

TEST_CASE("the metrics of a small pair of images are those computed by hand") {
  // Differences 1, 0, -2, 0, 0, 3; reference 1, 2, 3, 0, 0, 0.
  const ImageBuffer image{1, 2, {Vec3{2, 2, 1}, Vec3{0, 0, 3}}};
  const ImageBuffer reference{1, 2, {Vec3{1, 2, 3}, Vec3{0, 0, 0}}};
  const ImageComparison result = compare_images(image.view(), reference.view());
  // Six terms of exactly representable values; the tolerance is that of a few roundings in double.
  CHECK(result.mse == Approx((1.0 + 4.0 + 9.0) / 6.0).epsilon(1e-15));
  CHECK(result.rel_mse == Approx((1.0 / 1.01 + 4.0 / 9.01 + 9.0 / 0.01) / 6.0).epsilon(1e-14));
  CHECK(result.mean_image == Approx(8.0 / 6.0).epsilon(1e-15));
  CHECK(result.mean_reference == Approx(1.0).epsilon(1e-15));
  CHECK(result.mean_ratio == Approx(8.0 / 6.0).epsilon(1e-15));
}

TEST_CASE("relMSE and the ratio tell which of the two images is the reference") {
  const ImageComparison forward = compare_images(uniform(4, 4, 2).view(), uniform(4, 4, 1).view());
  const ImageComparison backward = compare_images(uniform(4, 4, 1).view(), uniform(4, 4, 2).view());
  CHECK(forward.mean_ratio == 2);
  CHECK(backward.mean_ratio == 0.5);
  CHECK(forward.rel_mse == Approx(1 / 1.01).epsilon(1e-14));
  CHECK(backward.rel_mse == Approx(1 / 4.01).epsilon(1e-14));
  CHECK(forward.mse == backward.mse);
}

TEST_CASE("black references divide by nothing") {
  CHECK(compare_images(uniform(2, 2, 0).view(), uniform(2, 2, 0).view()).mean_ratio == 1);
  const ImageComparison result = compare_images(uniform(2, 2, 1).view(), uniform(2, 2, 0).view());
  CHECK(std::isinf(result.mean_ratio));
  CHECK(result.rel_mse == Approx(100).epsilon(1e-14));
}

TEST_CASE("sums do not lose small differences in large images") {
  // 2^22 equal terms of 0.1^2: a float sum would stall; double is good to 2^22 roundings at most.
  const ImageBuffer image = uniform(2048, 2048, 0.5f);
  const ImageBuffer reference = uniform(2048, 2048, 0.4f);
  const double difference = double{0.5f} - double{0.4f};
  CHECK(compare_images(image.view(), reference.view()).mse == Approx(difference * difference).epsilon(1e-10));
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
