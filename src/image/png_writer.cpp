#include <png.h>

#include <csetjmp>
#include <cstdio>
#include <vector>

#include "base/assert.hpp"
#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "image/image_io.hpp"
#include "math/elementary.hpp"
#include "math/srgb.hpp"

namespace mlt {
namespace {

/// What libpng's callbacks need. No destructor may stand between setjmp and a jump, so it is plain data.
struct PngJob {
  AtomicFile* file;
  std::uint32_t width;
  std::uint32_t height;
  const Vec3* pixels;  ///< encoded row by row into `row`; null when `bytes` are written
  float factor;
  std::uint8_t* row;          ///< 3 * width bytes
  const std::uint8_t* bytes;  ///< 3 * width * height, or null
  png_text* texts;
  int text_count;
  char message[160];
};

void write_bytes(png_structp png, png_bytep bytes, std::size_t size) {
  AtomicFile& file = *static_cast<PngJob*>(png_get_io_ptr(png))->file;
  if (!file.write(bytes, size)) png_error(png, "write failed");
}

/// AtomicFile::commit syncs; libpng need not.
void flush_nothing(png_structp) {}

[[noreturn]] void on_error(png_structp png, png_const_charp message) {
  PngJob& job = *static_cast<PngJob*>(png_get_error_ptr(png));
  std::snprintf(job.message, sizeof job.message, "%s", message);
  png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

void encode_row(const PngJob& job, std::uint32_t y) {
  const Vec3* pixels = job.pixels + std::size_t{y} * job.width;
  for (std::uint32_t x = 0; x < job.width; ++x) {
    for (int channel = 0; channel < 3; ++channel) {
      job.row[std::size_t{3} * x + static_cast<std::size_t>(channel)] =
          srgb_byte(pixels[x][channel] * job.factor);
    }
  }
}

/// False on any error, which `job.message` then names; the caller destroys the structures.
bool encode(png_structp png, png_infop info, PngJob& job) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_write_fn(png, &job, write_bytes, flush_nothing);
  png_set_IHDR(png, info, job.width, job.height, 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_set_text(png, info, job.texts, job.text_count);
  png_write_info(png, info);
  for (std::uint32_t y = 0; y < job.height; ++y) {
    if (job.bytes != nullptr) {
      png_write_row(png, job.bytes + std::size_t{3} * job.width * y);
    } else {
      encode_row(job, y);
      png_write_row(png, job.row);
    }
  }
  png_write_end(png, info);
  return true;
}

bool is_ascii(const std::string& text) {
  for (const char letter : text) {
    if (static_cast<unsigned char>(letter) >= 0x80) return false;
  }
  return true;
}

/// Views into `entries`; libpng's interface is not const-correct but does not write through them.
std::vector<png_text> to_png_texts(const std::vector<TextEntry>& entries) {
  std::vector<png_text> texts;
  for (const TextEntry& entry : entries) {
    png_text text{};
    text.compression = is_ascii(entry.text) ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE;
    text.key = const_cast<char*>(entry.keyword.c_str());
    text.text = const_cast<char*>(entry.text.c_str());
    text.text_length = text.compression == PNG_TEXT_COMPRESSION_NONE ? entry.text.size() : 0;
    text.itxt_length = text.compression == PNG_ITXT_COMPRESSION_NONE ? entry.text.size() : 0;
    texts.push_back(text);
  }
  return texts;
}

/// Fills in what is left of `job` and writes the file.
void write_job(const std::string& path, PngJob& job, const std::vector<TextEntry>& metadata) {
  AtomicFile file(path);
  std::vector<png_text> texts = to_png_texts(metadata);
  job.file = &file;
  job.texts = texts.data();
  job.text_count = static_cast<int>(texts.size());
  std::snprintf(job.message, sizeof job.message, "no memory");
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &job, on_error, on_warning);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  const bool written = info != nullptr && encode(png, info, job);
  png_destroy_write_struct(&png, &info);
  // A failed write is the file's to report, with the system's reason; what is left is libpng's own.
  if (written || !file.write(nullptr, 0)) return file.commit();
  throw ResourceError(path + ": could not be encoded as PNG: " + job.message);
}

}  // namespace

std::uint8_t srgb_byte(float linear) {
  // The negated comparison catches NaN.
  if (!(linear > 0.0f)) return 0;
  if (linear >= 1.0f) return 255;
  const float scaled = srgb_encode(linear) * 255.0f + 0.5f;
  return scaled >= 255.0f ? std::uint8_t{255} : static_cast<std::uint8_t>(scaled);
}

void write_png(const std::string& path, const ImageView& image, const ImageOptions& options) {
  MLT_CHECK_OP(image.pixels.size(), ==, std::size_t{image.width} * image.height);
  MLT_CHECK_OP(image.pixels.size(), >, 0u);
  std::vector<std::uint8_t> row(std::size_t{3} * image.width);
  PngJob job{};
  job.width = image.width;
  job.height = image.height;
  job.pixels = image.pixels.data();
  job.factor = exp2_f(options.exposure);
  job.row = row.data();
  write_job(path, job, options.metadata);
}

void write_png(const std::string& path, const Picture& picture, const std::vector<TextEntry>& metadata) {
  MLT_CHECK_OP(picture.bytes.size(), ==, std::size_t{3} * picture.width * picture.height);
  MLT_CHECK_OP(picture.bytes.size(), >, 0u);
  PngJob job{};
  job.width = picture.width;
  job.height = picture.height;
  job.bytes = picture.bytes.data();
  write_job(path, job, metadata);
}

}  // namespace mlt
