#include "compare/flip.hpp"

#include <catch2/catch.hpp>
#include <numeric>

#include "compare/flip_colour.hpp"
#include "compare/flip_filter.hpp"
#include "flip_reference.hpp"
#include "math/rng.hpp"

namespace mlt {
namespace {

using test::Real;

ImageBuffer blank(std::uint32_t width, std::uint32_t height, const Vec3& value) {
  return {width, height, std::vector<Vec3>(std::size_t{width} * height, value)};
}

/// A picture with a slope, an edge, coloured noise and some dots; values up to `brightest`, `seed` moves the
/// noise.
ImageBuffer scene(std::uint32_t width, std::uint32_t height, float brightest, std::uint64_t seed) {
  Rng rng(seed, StreamPurpose::kTest, 0);
  ImageBuffer image = blank(width, height, Vec3(0.0f));
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      const float slope = static_cast<float>(x + 1) / static_cast<float>(width);
      Vec3 pixel{slope, x * 2 > y ? 0.8f : 0.1f, 1.0f - slope};
      for (int c = 0; c < 3; ++c) pixel[c] *= 0.5f + rng.next_float();
      if (rng.next_float() < 0.02f) pixel *= brightest;
      image.pixels[std::size_t{y} * width + x] = pixel;
    }
  }
  return image;
}

/// The largest difference of a map from the reference's; the product's map is in float, so 2^-24 of [0,1] is
/// lost, and the published inverse matrix has 9 decimals, which changes chroma by some 1e-7.
constexpr double kTolerance = 2e-6;

double largest_difference(const FlipResult& result, const std::vector<Real>& expected) {
  REQUIRE(result.map.size() == expected.size());
  double largest = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    largest = std::fmax(largest, std::fabs(static_cast<double>(Real(result.map[i]) - expected[i])));
  }
  return largest;
}

FlipOptions ldr(double ppd = kPixelsPerDegree, double exposure = 0) {
  FlipOptions options;
  options.mode = FlipMode::ldr;
  options.pixels_per_degree = ppd;
  options.exposure = exposure;
  return options;
}

TEST_CASE("the constants of FLIP are the published ones") {
  // Illuminant and default of the authors' implementation, to the decimals it gives; its inverse matrix was
  // inverted in float and is right to 1e-7 of the largest entry.
  CHECK(flip::kWhite[0] == Approx(0.950428545).epsilon(1e-9));
  CHECK(flip::kWhite[1] == Approx(1.0).epsilon(1e-15));
  CHECK(flip::kWhite[2] == Approx(1.088900371).epsilon(1e-9));
  const double inverse[3][3] = {{3.241003275, -1.537398934, -0.498615861},
                                {-0.969224334, 1.875930071, 0.041554224},
                                {0.055639423, -0.204011202, 1.057148933}};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) CHECK(flip::kFromXyz[i][j] == Approx(inverse[i][j]).epsilon(0).margin(1e-7));
  }
  // 0.7 m away, 3840 pixels on 0.7 m.
  CHECK(kPixelsPerDegree == Approx(67.0206).epsilon(1e-6));
  // 3 * 0.04502 * 67.02 = 9.05 and 3 * 0.5 * 0.082 * 67.02 = 8.24, rounded up.
  const flip::Filters filters = flip::make_filters(kPixelsPerDegree);
  CHECK(filters.colour_radius == 10);
  CHECK(filters.feature_radius == 9);
}

TEST_CASE("FLIP's colours: white, black and grey have no chroma, and the way back is the way there") {
  CHECK(flip::to_lab(DVec3{1, 1, 1}).x == Approx(100).epsilon(1e-14));
  CHECK(flip::to_lab(DVec3{0, 0, 0}).x == Approx(0).margin(1e-13));
  for (const double grey : {0.0, 0.001, 0.2, 0.7, 1.0}) {
    const DVec3 lab = flip::to_lab(DVec3{grey, grey, grey});
    CHECK(std::fabs(lab.y) < 1e-11);
    CHECK(std::fabs(lab.z) < 1e-11);
  }
  // CIELAB of the sRGB primary green [Lindbloom's calculator: 87.73, -86.18, 83.18].
  const DVec3 green = flip::to_lab(DVec3{0, 1, 0});
  CHECK(green.x == Approx(87.735).epsilon(1e-4));
  CHECK(green.y == Approx(-86.18).epsilon(1e-3));
  CHECK(green.z == Approx(83.18).epsilon(1e-3));
  const DVec3 rgb{0.3, 0.9, 0.05};
  const DVec3 back = flip::from_ycxcz(flip::to_ycxcz(rgb));
  for (int c = 0; c < 3; ++c) CHECK(back[c] == Approx(rgb[c]).epsilon(1e-12));
  const double largest = flip::largest_colour_error();
  // As precomputed in float by a published implementation for graphics processors (FLOP).
  CHECK(largest == Approx(41.2760963).epsilon(1e-7));
  const auto adjusted = [](const DVec3& c) { return flip::hunt_adjusted(flip::to_lab(c)); };
  CHECK(flip::colour_error(adjusted({0, 1, 0}), adjusted({0, 0, 1}), largest) == 1);
  CHECK(flip::colour_error(adjusted({0, 1, 0}), adjusted({0, 1, 0}), largest) == 0);
}

TEST_CASE("LDR-FLIP agrees with the papers' formulas summed over two-dimensional filters") {
  // Sizes below, at and above the filters' reach and the bands of rows.
  const std::uint32_t sizes[][2] = {{1, 1}, {7, 5}, {24, 17}, {9, 70}};
  for (const auto& size : sizes) {
    const ImageBuffer a = scene(size[0], size[1], 1, 1);
    const ImageBuffer b = scene(size[0], size[1], 1, 2);
    const FlipResult result = compute_flip(a.view(), b.view(), ldr());
    const std::vector<Real> expected = test::reference_ldr_flip(
        test::reference_view(a.view(), false, 0), test::reference_view(b.view(), false, 0), kPixelsPerDegree);
    CAPTURE(size[0], size[1]);
    CHECK(largest_difference(result, expected) < kTolerance);
    const Real mean = std::accumulate(expected.begin(), expected.end(), Real(0)) / Real(expected.size());
    CHECK(result.mean == Approx(static_cast<double>(mean)).epsilon(1e-6));
  }
}

TEST_CASE("LDR-FLIP agrees with the reference at other resolutions and exposures") {
  const ImageBuffer a = scene(20, 12, 1, 3);
  const ImageBuffer b = scene(20, 12, 1, 4);
  for (const double ppd : {1.0, 24.5, 100.0}) {
    const FlipResult result = compute_flip(a.view(), b.view(), ldr(ppd, -1.5));
    const std::vector<Real> expected = test::reference_ldr_flip(
        test::reference_view(a.view(), false, -1.5L), test::reference_view(b.view(), false, -1.5L), ppd);
    CHECK(largest_difference(result, expected) < kTolerance);
  }
}

TEST_CASE("HDR-FLIP agrees with the papers' formulas over all exposures") {
  const ImageBuffer a = scene(18, 13, 100, 5);
  const ImageBuffer b = scene(18, 13, 100, 6);
  const FlipResult result = compute_flip(a.view(), b.view(), {});
  const test::ReferenceHdr expected = test::reference_hdr_flip(a.view(), b.view(), kPixelsPerDegree);
  CHECK(result.start_exposure == Approx(static_cast<double>(expected.start)).epsilon(1e-12));
  CHECK(result.stop_exposure == Approx(static_cast<double>(expected.stop)).epsilon(1e-12));
  CHECK(static_cast<int>(result.exposures) == expected.count);
  CHECK(expected.count >= 5);
  CHECK(largest_difference(result, expected.map) < kTolerance);
}

TEST_CASE("FLIP of uniform pictures is the colour error alone") {
  // Without edges FLIP is the remapped distance; black to white is 100 in HyAB.
  const FlipResult result =
      compute_flip(blank(30, 20, Vec3(1.0f)).view(), blank(30, 20, Vec3(0.0f)).view(), ldr());
  const double largest = flip::largest_colour_error();
  const double power = std::pow(100.0, 0.7);
  const double expected = 0.95 + 0.05 * (power - 0.4 * largest) / (0.6 * largest);
  CHECK(result.mean == Approx(expected).epsilon(1e-6));
  CHECK(result.maximum == Approx(expected).epsilon(1e-6));
}

TEST_CASE("FLIP is zero for equal pictures, symmetric for LDR, and survives any finite values") {
  const ImageBuffer a = scene(20, 12, 1000, 7);
  const ImageBuffer b = scene(20, 12, 1000, 8);
  for (const FlipMode mode : {FlipMode::ldr, FlipMode::hdr}) {
    FlipOptions options;
    options.mode = mode;
    CHECK(compute_flip(a.view(), a.view(), options).maximum == 0);
    const FlipResult result = compute_flip(a.view(), b.view(), options);
    CHECK(result.mean > 0);
    CHECK(result.maximum <= 1);
  }
  CHECK(compute_flip(a.view(), b.view(), ldr()).map == compute_flip(b.view(), a.view(), ldr()).map);
  const float most = 3.4e38f;
  for (const Vec3& value : {Vec3(most), Vec3(-most), Vec3(1e-45f), Vec3(0, most, -1)}) {
    const FlipResult result = compute_flip(blank(3, 3, value).view(), blank(3, 3, Vec3(0.5f)).view(), {});
    const FlipResult back = compute_flip(blank(3, 3, Vec3(0.5f)).view(), blank(3, 3, value).view(), {});
    CHECK((result.mean >= 0 && result.mean <= 1));
    CHECK((back.mean >= 0 && back.mean <= 1));
  }
}

TEST_CASE("FLIP is the same bits from any number of threads") {
  const ImageBuffer a = scene(11, 200, 10, 9);
  const ImageBuffer b = scene(11, 200, 10, 10);
  FlipOptions options;
  const FlipResult one = compute_flip(a.view(), b.view(), options);
  for (const std::uint32_t threads : {2U, 3U, 16U}) {
    options.threads = threads;
    const FlipResult several = compute_flip(a.view(), b.view(), options);
    CHECK(several.map == one.map);
    CHECK(several.mean == one.mean);
  }
}

TEST_CASE("exposures come from the pixels that are not black when the median is") {
  ImageBuffer image = blank(4, 1, Vec3(0.0f));
  CHECK(flip_exposures(image.view()).start == 0);
  CHECK(flip_exposures(image.view()).stop == 0);
  CHECK(compute_flip(image.view(), image.view(), {}).exposures == 2);
  image.pixels[1] = Vec3(8.0f);
  const ExposureRange one = flip_exposures(image.view());
  CHECK(one.start == one.stop);
  image.pixels[2] = Vec3(2.0f);
  image.pixels[3] = Vec3(1.0f);
  // Four pixels 0, 8, 2, 1: the median, the upper of the two in the middle, is 2.
  const ExposureRange range = flip_exposures(image.view());
  CHECK(range.stop - range.start == Approx(2).epsilon(1e-6));
}

}  // namespace
}  // namespace mlt
