// OpenEXR files, where EXR=yes builds them in.
#if defined(MLT_HAS_OPENEXR)
#include <catch2/catch.hpp>
#include <fstream>
#include <limits>
#include <string>

#include "base/error.hpp"
#include "image/image_io.hpp"
#include "support/temporary_folder.hpp"

namespace mlt::test {
namespace {

ImageBuffer ramp(std::uint32_t width, std::uint32_t height) {
  ImageBuffer image{width, height, {}};
  for (std::uint32_t i = 0; i < width * height; ++i) {
    const auto value = static_cast<float>(i);
    image.pixels.push_back(Vec3{0.1f + value, 1e-30f * value, -3e20f / (1 + value)});
  }
  return image;
}

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

TEST_CASE("an OpenEXR file keeps every bit, for sizes from one pixel on") {
  const TemporaryFolder folder;
  for (const auto& [width, height] : {std::pair{1U, 1U}, {7U, 5U}, {1U, 40U}, {33U, 17U}}) {
    const ImageBuffer image = ramp(width, height);
    write_image(folder / "a.EXR", image.view(), {});
    const LoadedImage read = read_image(folder / "a.EXR");
    CHECK(read.image.width == width);
    CHECK(read.image.height == height);
    CHECK(read.image.pixels == image.pixels);
    CHECK(read.non_finite == 0);
  }
}

TEST_CASE("equal images give equal OpenEXR bytes, which hold the metadata") {
  const TemporaryFolder folder;
  const ImageBuffer image = ramp(5, 3);
  const ImageOptions options{0, {{"command", "mlt render x.txt"}, {"film_hash", "abc"}}};
  write_exr(folder / "a.exr", image.view(), options);
  write_exr(folder / "b.exr", image.view(), options);
  CHECK(bytes_of(folder / "a.exr") == bytes_of(folder / "b.exr"));
  CHECK(bytes_of(folder / "a.exr").find("mlt render x.txt") != std::string::npos);
}

TEST_CASE("values that are not finite pass through an OpenEXR file and their pixels are counted") {
  const TemporaryFolder folder;
  ImageBuffer image = ramp(4, 1);
  image.pixels[1].y = std::numeric_limits<float>::infinity();
  image.pixels[3].x = std::numeric_limits<float>::quiet_NaN();
  write_exr(folder / "a.exr", image.view(), {});
  CHECK(read_exr(folder / "a.exr").non_finite == 2);
}

TEST_CASE("a file that is not an OpenEXR image is refused, whole or cut anywhere") {
  const TemporaryFolder folder;
  write_exr(folder / "a.exr", ramp(9, 9).view(), {});
  const std::string whole = bytes_of(folder / "a.exr");
  const std::string path = folder / "cut.exr";
  for (std::size_t size = 0; size < whole.size(); size += 1 + size / 8) {
    std::ofstream(path, std::ios::binary) << whole.substr(0, size);
    CHECK_THROWS_AS(read_exr(path), InputError);
  }
  std::ofstream(path, std::ios::binary) << "PF\n1 1\n-1.0\n000000000000";
  CHECK_THROWS_WITH(read_exr(path), Catch::Contains("cut.exr: is not an OpenEXR image that can be read"));
  CHECK_THROWS_AS(read_exr(folder / "missing.exr"), InputError);
  // A data window of 2^31 columns, where the header keeps its right border.
  std::string huge = whole;
  const std::size_t window = huge.find("dataWindow") + sizeof "dataWindow" + sizeof "box2i" + 4;
  huge.replace(window + 8, 4, "\xff\xff\xff\x7f", 4);
  std::ofstream(path, std::ios::binary) << huge;
  CHECK_THROWS_AS(read_exr(path), InputError);
}

}  // namespace
}  // namespace mlt::test
#endif
