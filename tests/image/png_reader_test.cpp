#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>

// After the standard headers, which libpng's setjmp would otherwise bring in first.
#include <png.h>

#include "base/error.hpp"
#include "image/image_io.hpp"
#include "support/temporary_folder.hpp"

namespace mlt {
namespace {

struct Kind {
  int colour_type;
  int depth;
  int interlace = PNG_INTERLACE_NONE;
};

/// A PNG whose rows hold `rows` as they are; grey palette of 2 bits where the colour type needs one.
void write_raw(const std::string& path, std::uint32_t width, const Kind& kind,
               std::vector<std::vector<std::uint8_t>> rows) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  REQUIRE(file != nullptr);
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_set_IHDR(png, info, width, static_cast<png_uint_32>(rows.size()), kind.depth, kind.colour_type,
               kind.interlace, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  const png_color palette[4] = {{0, 0, 0}, {255, 0, 0}, {0, 128, 0}, {0, 0, 64}};
  if (kind.colour_type == PNG_COLOR_TYPE_PALETTE) png_set_PLTE(png, info, palette, 4);
  std::vector<png_bytep> pointers;
  for (std::vector<std::uint8_t>& row : rows) pointers.push_back(row.data());
  png_set_rows(png, info, pointers.data());
  png_write_png(png, info, PNG_TRANSFORM_IDENTITY, nullptr);
  png_destroy_write_struct(&png, &info);
  std::fclose(file);
}

/// The standard's formula in long double [IEC 61966-2-1].
float linear(long double encoded) {
  return static_cast<float>(encoded <= 0.04045L ? encoded / 12.92L
                                                : std::pow((encoded + 0.055L) / 1.055L, 2.4L));
}

TEST_CASE("a PNG written by the project is read back to the same bytes") {
  const TemporaryFolder folder;
  Picture picture{16, 16, {}};
  for (int i = 0; i < 256; ++i) {
    picture.bytes.insert(picture.bytes.end(),
                         {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(255 - i),
                          static_cast<std::uint8_t>((i * 7) & 255)});
  }
  write_png(folder / "a.png", picture, {{"Title", "x"}});
  const LoadedImage read = read_image(folder / "a.png");
  CHECK(read.image.width == 16);
  CHECK(read.image.height == 16);
  for (std::size_t i = 0; i < 256; ++i) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const float value = read.image.pixels[i][static_cast<int>(channel)];
      const std::uint8_t byte = picture.bytes[3 * i + channel];
      REQUIRE(value == linear(byte / 255.0L));
      REQUIRE(srgb_byte(value) == byte);
    }
  }
  write_png(folder / "b.png", read.image.view(), {0, {{"Title", "x"}}});
  CHECK(read_text(folder / "a.png") == read_text(folder / "b.png"));
}

TEST_CASE("every colour type and depth of PNG is read") {
  const TemporaryFolder folder;
  const std::string path = folder / "x.png";
  const auto read = [&path] { return read_png(path).image.pixels; };
  write_raw(path, 2, {PNG_COLOR_TYPE_GRAY, 8}, {{51, 255}});
  CHECK(read() == std::vector<Vec3>{Vec3(linear(0.2L)), Vec3(1.0f)});
  write_raw(path, 2, {PNG_COLOR_TYPE_GRAY, 1}, {{0x40}});
  CHECK(read() == std::vector<Vec3>{Vec3(0.0f), Vec3(1.0f)});
  write_raw(path, 1, {PNG_COLOR_TYPE_GRAY, 16}, {{0x33, 0x34}});
  CHECK(read() == std::vector<Vec3>{Vec3(linear(0x3334 / 65535.0L))});
  write_raw(path, 4, {PNG_COLOR_TYPE_PALETTE, 2}, {{0x1b}});
  CHECK(read() == std::vector<Vec3>{Vec3(0.0f), Vec3(1, 0, 0), Vec3(0, linear(128 / 255.0L), 0),
                                    Vec3(0, 0, linear(64 / 255.0L))});
  write_raw(path, 1, {PNG_COLOR_TYPE_RGB, 16}, {{0xff, 0xff, 0, 0, 0x80, 0}});
  CHECK(read() == std::vector<Vec3>{Vec3(1, 0, linear(0x8000 / 65535.0L))});
  write_raw(path, 1, {PNG_COLOR_TYPE_RGB_ALPHA, 8}, {{255, 0, 51, 255}});
  CHECK(read() == std::vector<Vec3>{Vec3(1, 0, linear(0.2L))});
  write_raw(path, 2, {PNG_COLOR_TYPE_GRAY_ALPHA, 8}, {{51, 255, 255, 255}});
  CHECK(read() == std::vector<Vec3>{Vec3(linear(0.2L)), Vec3(1.0f)});
  const std::vector<std::vector<std::uint8_t>> rows(9, {0, 51, 102, 153, 204, 255, 7, 8, 9, 10, 11});
  write_raw(path, 11, {PNG_COLOR_TYPE_GRAY, 8}, rows);
  const std::vector<Vec3> plain = read();
  write_raw(path, 11, {PNG_COLOR_TYPE_GRAY, 8, PNG_INTERLACE_ADAM7}, rows);
  CHECK(read() == plain);
}

TEST_CASE("a PNG that cannot be read is refused with a reason") {
  const TemporaryFolder folder;
  const std::string path = folder / "x.png";
  write_raw(path, 2, {PNG_COLOR_TYPE_RGB_ALPHA, 8}, {{1, 2, 3, 255, 1, 2, 3, 254}});
  CHECK_THROWS_WITH(read_png(path), Catch::Contains("x.png: is transparent at x 1, y 0"));
  write_raw(path, 3, {PNG_COLOR_TYPE_RGB, 8}, {{1, 2, 3, 4, 5, 6, 7, 8, 9}, {9, 8, 7, 6, 5, 4, 3, 2, 1}});
  const std::string good = read_text(path);
  // Cut off anywhere, or with one byte changed: an error or, behind the pixels, no matter.
  for (std::size_t size = 0; size < good.size(); ++size) {
    write_text(path, good.substr(0, size));
    CHECK_THROWS_AS(read_png(path), InputError);
  }
  for (std::size_t at = 0; at < good.size() - 12; ++at) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 0x10);
    write_text(path, bad);
    try {
      const std::size_t pixels = read_png(path).image.pixels.size();
      CHECK(pixels == 6);
    } catch (const InputError& error) {
      CHECK_THAT(error.what(), Catch::Contains("x.png: "));
    }
  }
  write_text(path, "PF\n1 1\n-1\n");
  CHECK_THROWS_WITH(read_png(path), Catch::Contains("does not start as a PNG image does"));
  CHECK_THROWS_WITH(read_png(folder.path().string()), Catch::Contains("not a regular file; expected a PNG"));
  CHECK_THROWS_WITH(read_png(folder / "missing.png"), Catch::Contains("No such file"));
  CHECK_THROWS_WITH(read_image(folder / "x.jpg"), Catch::Contains("unknown image format"));
}

TEST_CASE("a small PNG that claims a huge size is refused before memory is taken") {
  const TemporaryFolder folder;
  // 65535 x 65535 exceeds the limit of pixels; 10000 x 10000 cannot stand in so few bytes.
  for (const std::uint32_t side : {65535U, 10000U}) {
    std::string bytes("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16);
    for (int copy = 0; copy < 2; ++copy) {
      for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(side >> shift & 255);
    }
    bytes += std::string("\x08\x02\0\0\0", 5);
    std::uint32_t crc = 0xffffffffU;
    for (std::size_t i = 12; i < bytes.size(); ++i) {
      crc ^= static_cast<unsigned char>(bytes[i]);
      for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ ((crc & 1) != 0 ? 0xedb88320U : 0U);
    }
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(~crc >> shift & 255);
    write_text(folder / "x.png", bytes + std::string("\0\0\0\1IDAT\0abcd", 13));
    CHECK_THROWS_WITH(read_png(folder / "x.png"),
                      Catch::Contains(side == 10000U ? "too short for its size" : "more than 2^27 pixels"));
  }
}

}  // namespace
}  // namespace mlt
