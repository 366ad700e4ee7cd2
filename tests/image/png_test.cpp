#include <png.h>

#include <algorithm>
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

/// Names of a PNG's chunks in order, found by walking the file [PNG03 section 5.3].
std::vector<std::string> chunk_names(const std::string& bytes) {
  std::vector<std::string> names;
  const auto byte = [&bytes](std::size_t i) { return std::size_t{static_cast<unsigned char>(bytes[i])}; };
  for (std::size_t at = 8; at + 12 <= bytes.size();) {
    const std::size_t length = byte(at) << 24 | byte(at + 1) << 16 | byte(at + 2) << 8 | byte(at + 3);
    names.push_back(bytes.substr(at + 4, 4));
    at += 12 + length;
  }
  return names;
}

struct ReadPng {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> bytes;  ///< RGB
};

/// By libpng's simplified reader, which shares no code with the writer under test.
ReadPng read_png(const std::string& path) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  REQUIRE(png_image_begin_read_from_file(&image, path.c_str()) != 0);
  CHECK(image.format == PNG_FORMAT_RGB);
  ReadPng result{image.width, image.height, {}};
  result.bytes.resize(PNG_IMAGE_SIZE(image));
  REQUIRE(png_image_finish_read(&image, nullptr, result.bytes.data(), 0, nullptr) != 0);
  return result;
}

/// All text entries, tEXt and iTXt.
std::vector<TextEntry> read_texts(const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "rb");
  REQUIRE(file != nullptr);
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_read_png(png, info, PNG_TRANSFORM_IDENTITY, nullptr);
  png_textp texts = nullptr;
  int count = 0;
  png_get_text(png, info, &texts, &count);
  std::vector<TextEntry> result;
  for (int i = 0; i < count; ++i) result.push_back({texts[i].key, texts[i].text});
  png_destroy_read_struct(&png, &info, nullptr);
  std::fclose(file);
  return result;
}

/// The sRGB formula in long double, as the reference [IEC 61966-2-1].
double reference_srgb(double linear) {
  const long double value = std::min(1.0, std::max(0.0, linear));
  return static_cast<double>(value <= 0.0031308L ? 12.92L * value
                                                 : 1.055L * std::pow(value, 1.0L / 2.4L) - 0.055L);
}

TEST_CASE("srgb_byte rounds the sRGB curve to nearest and survives every float") {
  for (int i = 0; i <= 100000; ++i) {
    const float linear = static_cast<float>(i) / 100000.0f;
    const double exact = 255.0 * reference_srgb(linear);
    // Rounding to nearest is off by at most 1/2; srgb_encode's error of 1 ulp, 2^-24 of 255, is added.
    REQUIRE(std::fabs(srgb_byte(linear) - exact) <= 0.5 + 255.0 * 0x1p-23);
  }
  CHECK(srgb_byte(0.0f) == 0);
  CHECK(srgb_byte(1.0f) == 255);
  CHECK(srgb_byte(-1.0f) == 0);
  CHECK(srgb_byte(1e38f) == 255);
  CHECK(srgb_byte(std::numeric_limits<float>::infinity()) == 255);
  CHECK(srgb_byte(-std::numeric_limits<float>::infinity()) == 0);
  CHECK(srgb_byte(std::numeric_limits<float>::quiet_NaN()) == 0);
  CHECK(srgb_byte(std::nextafter(1.0f, 0.0f)) == 255);
  CHECK(srgb_byte(std::numeric_limits<float>::denorm_min()) == 0);
}

TEST_CASE("a PNG holds the pixels' sRGB bytes, top row first") {
  const TemporaryFolder folder;
  const ImageBuffer image{2, 2, {Vec3{1, 0, 0}, Vec3{0, 0.5f, 0}, Vec3{0, 0, 0.1f}, Vec3{2, -1, 0.002f}}};
  write_png(folder / "x.png", image.view(), {});
  const ReadPng read = read_png(folder / "x.png");
  CHECK(read.width == 2);
  CHECK(read.height == 2);
  // 0.5 encodes to 187.52 and 0.1 to 89.07 and 0.002 to 6.59 of 255, from the formula by hand.
  CHECK(read.bytes == std::vector<std::uint8_t>{255, 0, 0, 0, 188, 0, 0, 0, 89, 255, 0, 7});
}

TEST_CASE("exposure multiplies by a power of two before encoding") {
  const TemporaryFolder folder;
  const ImageBuffer image{1, 1, {Vec3{0.25f, 0.125f, 0.6f}}};
  write_png(folder / "up.png", image.view(), {1.0f, {}});
  write_png(folder / "half.png", image.view(), {-0.5f, {}});
  CHECK(read_png(folder / "up.png").bytes ==
        std::vector<std::uint8_t>{srgb_byte(0.5f), srgb_byte(0.25f), 255});
  const float factor = std::sqrt(0.5f);
  CHECK(read_png(folder / "half.png").bytes == std::vector<std::uint8_t>{srgb_byte(0.25f * factor),
                                                                         srgb_byte(0.125f * factor),
                                                                         srgb_byte(0.6f * factor)});
}

TEST_CASE("a PNG's metadata can be read back, in any language, and no time stamp is among it") {
  const TemporaryFolder folder;
  const ImageBuffer image{1, 1, {Vec3{0, 0, 0}}};
  const std::vector<TextEntry> metadata{{"Software", "mlt"},
                                        {"Command", "mlt render 'a b.txt' --seed 1\nline"},
                                        {"Empty", ""},
                                        {"Scene", "sc\xC3\xA8ne \xE5\x85\x89.txt"}};
  write_png(folder / "x.png", image.view(), {0, metadata});
  const std::vector<TextEntry> read = read_texts(folder / "x.png");
  REQUIRE(read.size() == metadata.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    CHECK(read[i].keyword == metadata[i].keyword);
    CHECK(read[i].text == metadata[i].text);
  }
  const std::vector<std::string> names = chunk_names(read_text(folder / "x.png"));
  CHECK(names == std::vector<std::string>{"IHDR", "sRGB", "tEXt", "tEXt", "tEXt", "iTXt", "IDAT", "IEND"});
}

TEST_CASE("equal images give equal PNG bytes") {
  const TemporaryFolder folder;
  const ImageBuffer image{64, 64, std::vector<Vec3>(64 * 64, Vec3{0.2f, 0.4f, 0.7f})};
  write_png(folder / "a.png", image.view(), {0, {{"Seed", "1"}}});
  write_png(folder / "b.png", image.view(), {0, {{"Seed", "1"}}});
  CHECK(read_text(folder / "a.png") == read_text(folder / "b.png"));
}

TEST_CASE("a PNG that cannot be written whole is a resource limit and leaves nothing") {
  const TemporaryFolder folder;
  std::filesystem::create_symlink("/dev/full", folder / "full.png");
  const ImageBuffer image{300, 300, std::vector<Vec3>(300 * 300, Vec3{0.2f, 0.4f, 0.7f})};
  CHECK_THROWS_AS(write_image(folder / "full.png", image.view(), {}), ResourceError);
  CHECK_THROWS_WITH(write_image(folder / "full.png", image.view(), {}),
                    Catch::Contains("full.png") && Catch::Contains("No space left"));
  CHECK_THROWS_AS(write_image(folder / "missing/x.png", image.view(), {}), InputError);
  CHECK(folder.file_count() == 1);
}

TEST_CASE("what libpng itself refuses is reported with its words") {
  const TemporaryFolder folder;
  // Wider than libpng's default limit of a million pixels a row.
  const ImageBuffer image{1000001, 1, std::vector<Vec3>(1000001, Vec3{0, 0, 0})};
  CHECK_THROWS_WITH(write_png(folder / "wide.png", image.view(), {}), Catch::Contains("encoded as PNG"));
  CHECK(folder.file_count() == 0);
}

}  // namespace
}  // namespace mlt
