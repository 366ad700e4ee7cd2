#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "base/error.hpp"
#include "image/image_io.hpp"
#include "support/temporary_folder.hpp"

namespace mlt {
namespace {

ImageBuffer make_image(std::uint32_t width, std::uint32_t height) {
  ImageBuffer image{width, height, {}};
  for (std::uint32_t i = 0; i < width * height; ++i) {
    const float value = static_cast<float>(i);
    image.pixels.push_back(Vec3{value / 3.0f, -value * 1e-30f, 1e30f + value});
  }
  return image;
}

/// The bytes of a float, written out here independently of the writer: least significant first.
std::string little_endian(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  std::string bytes;
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(bits >> shift);
  return bytes;
}

std::string big_endian(float value) {
  const std::string bytes = little_endian(value);
  return std::string(bytes.rbegin(), bytes.rend());
}

TEST_CASE("a PFM is written as the format demands: header, little-endian floats, bottom row first") {
  const TemporaryFolder folder;
  const ImageBuffer image{1, 2, {Vec3{1, 2, 3}, Vec3{4, 5, 0.1f}}};
  write_pfm(folder / "x.pfm", image.view());
  std::string expected = "PF\n1 2\n-1.0\n";
  for (const float value : {4.0f, 5.0f, 0.1f, 1.0f, 2.0f, 3.0f}) expected += little_endian(value);
  CHECK(read_text(folder / "x.pfm") == expected);
}

TEST_CASE("a PFM keeps every bit, for sizes from one pixel on") {
  const TemporaryFolder folder;
  struct Size {
    std::uint32_t width, height;
  };
  for (const Size size : {Size{1, 1}, Size{1, 7}, Size{7, 1}, Size{13, 5}, Size{65536, 1}}) {
    ImageBuffer image = make_image(size.width, size.height);
    image.pixels[0] =
        Vec3{std::numeric_limits<float>::denorm_min(), -0.0f, std::numeric_limits<float>::max()};
    write_pfm(folder / "x.pfm", image.view());
    const LoadedImage read = read_pfm(folder / "x.pfm");
    REQUIRE(read.image.width == size.width);
    REQUIRE(read.image.height == size.height);
    REQUIRE(read.non_finite == 0);
    REQUIRE(std::memcmp(read.image.pixels.data(), image.pixels.data(), image.pixels.size() * sizeof(Vec3)) ==
            0);
  }
}

TEST_CASE("values that are not finite pass through a PFM and their pixels are counted") {
  const TemporaryFolder folder;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  const ImageBuffer image{
      2, 2, {Vec3{nan, nan, 0}, Vec3{0, 0, -infinity}, Vec3{1, 1, 1}, Vec3{0, infinity, 0}}};
  write_pfm(folder / "x.pfm", image.view());
  const LoadedImage read = read_pfm(folder / "x.pfm");
  CHECK(read.non_finite == 3);
  CHECK(std::isnan(read.image.pixels[0].x));
  CHECK(read.image.pixels[1].z == -infinity);
}

TEST_CASE("big-endian, grey and scaled PFMs are read") {
  const TemporaryFolder folder;
  write_text(folder / "big.pfm", "PF 1 1 1\n" + big_endian(1.5f) + big_endian(-2) + big_endian(3));
  CHECK(read_pfm(folder / "big.pfm").image.pixels[0] == Vec3{1.5f, -2, 3});
  write_text(folder / "grey.pfm", "Pf\n1 2\n-1\n" + little_endian(1) + little_endian(2));
  const LoadedImage grey = read_pfm(folder / "grey.pfm");
  CHECK(grey.image.pixels[0] == Vec3{2, 2, 2});
  CHECK(grey.image.pixels[1] == Vec3{1, 1, 1});
  write_text(folder / "scaled.pfm", "Pf\n1 1\n-2.5e0\n" + little_endian(4));
  CHECK(read_pfm(folder / "scaled.pfm").image.pixels[0] == Vec3{10, 10, 10});
  // Bytes of the data that look like white space are data.
  write_text(folder / "space.pfm", "Pf\n1 1\n-1\n\n\n\n\n");
  CHECK(read_pfm(folder / "space.pfm").image.pixels[0].x == std::bit_cast<float>(0x0a0a0a0aU));
}

TEST_CASE("files that are not exactly a PFM are refused with what was found and expected") {
  const TemporaryFolder folder;
  struct Row {
    const char* name;
    std::string content, fragment;
  };
  const std::string pixel(12, 'x');
  const Row rows[] = {
      {"empty", "", "starts with ''"},
      {"one byte", "P", "starts with 'P'"},
      {"another format", "\x89PNG\r\n\x1a\n", "starts with '?P'"},
      {"long magic", "PFF\n1 1\n-1\n" + pixel, "starts with 'PFF'"},
      {"magic alone", "PF", "header does not end"},
      {"width alone", "PF\n1 ", "header does not end"},
      {"no scale", "PF\n1 1\n", "header does not end"},
      {"scale cut off", "PF\n1 1\n-1", "header does not end"},
      {"endless header", "PF\n" + std::string(1000, ' ') + "1 1 -1\n" + pixel, "header does not end"},
      {"endless token", "PF\n" + std::string(1000, '1') + " 1 -1\n" + pixel, "header does not end"},
      {"width 0", "PF\n0 1\n-1\n", "the width is '0'; expected an integer from 1 to 65536"},
      {"height 0", "PF\n1 0\n-1\n", "the height is '0'"},
      {"negative width", "PF\n-1 1\n-1\n" + pixel, "the width is '-1'"},
      {"width too large", "PF\n65537 1\n-1\n" + pixel, "the width is '65537'"},
      {"width beyond 32 bits", "PF\n4294967297 1\n-1\n" + pixel, "the width is '4294967297'"},
      {"width beyond 64 bits", "PF\n99999999999999999999 1\n-1\n" + pixel, "the width is"},
      {"width with letters", "PF\n1x 1\n-1\n" + pixel, "the width is '1x'"},
      {"fraction as height", "PF\n1 1.5\n-1\n" + pixel, "the height is '1.5'"},
      {"NaN as scale", "PF\n1 1\nnan\n" + pixel, "the scale is 'nan'"},
      {"infinite scale", "PF\n1 1\n-inf\n" + pixel, "the scale is '-inf'"},
      {"scale beyond float", "PF\n1 1\n-1e999\n" + pixel, "the scale is '-1e999'"},
      {"scale 0", "PF\n1 1\n0\n" + pixel, "the scale is '0'"},
      {"scale with letters", "PF\n1 1\n-1f\n" + pixel, "the scale is '-1f'"},
      {"escape sequence", "PF\n\x1b[2J 1\n-1\n", "the width is '?[2J'"},
      {"no data", "PF\n1 1\n-1\n", "has 10 bytes; expected 22 for 1 x 1 pixels of 3 channels"},
      {"one byte short", "PF\n1 1\n-1\n" + pixel.substr(1), "has 21 bytes; expected 22"},
      {"one byte more", "PF\n1 1\n-1\n" + pixel + "x", "has 23 bytes; expected 22"},
      {"51 GB declared", "PF\n65536 65536\n-1\n" + pixel, "expected 51539607570"},
  };
  for (const Row& row : rows) {
    CAPTURE(row.name);
    const std::string path = folder / "hostile.pfm";
    write_text(path, row.content);
    CHECK_THROWS_AS(read_pfm(path), InputError);
    CHECK_THROWS_WITH(read_pfm(path), Catch::StartsWith(path) && Catch::Contains(row.fragment));
  }
}

TEST_CASE("only regular files are read as PFM, without waiting for others") {
  const TemporaryFolder folder;
  REQUIRE(::system(("mkfifo " + (folder / "pipe")).c_str()) == 0);
  CHECK_THROWS_WITH(read_pfm(folder / "pipe"), Catch::Contains("not a regular file"));
  CHECK_THROWS_WITH(read_pfm(folder.path().string()), Catch::Contains("not a regular file"));
  CHECK_THROWS_WITH(read_pfm("/dev/zero"), Catch::Contains("not a regular file"));
  CHECK_THROWS_WITH(read_pfm(folder / "missing"), Catch::Contains("No such file"));
}

TEST_CASE("the extension chooses the format, in any case of letters, and unknown ones list the known") {
  CHECK(image_format_of("a.png") == ImageFormat::png);
  CHECK(image_format_of("x.y/b.PfM") == ImageFormat::pfm);
  for (const char* path : {"a", "a.", ".png", "folder.png/a", "a.png.gz", ""}) {
    CAPTURE(path);
    CHECK_THROWS_WITH(image_format_of(path), Catch::Contains(".png, .pfm"));
  }
  CHECK_THROWS_WITH(image_format_of("a.pngg"), Catch::Contains("did you mean '.png'"));
}

TEST_CASE("writing a PFM to a full disk names the file") {
  const TemporaryFolder folder;
  std::filesystem::create_symlink("/dev/full", folder / "full.pfm");
  const ImageBuffer image = make_image(100, 100);
  CHECK_THROWS_AS(write_image(folder / "full.pfm", image.view(), {}), ResourceError);
  CHECK_THROWS_WITH(write_image(folder / "full.pfm", image.view(), {}),
                    Catch::Contains("full.pfm") && Catch::Contains("No space left"));
}

}  // namespace
}  // namespace mlt
