#include <png.h>

#include <csetjmp>
#include <cstdio>
#include <vector>

#include "image/image_io.hpp"
#include "image/input_file.hpp"
#include "math/srgb.hpp"
#include "scene/limits.hpp"

namespace mlt {
namespace {

// No deflate stream expands by more [RFC1951 section 3.2.5: 258 bytes from two bits].
constexpr std::uint64_t kMaxExpansion = 1032;

/// What libpng's callbacks need. No destructor may stand between setjmp and a jump, so it is plain data.
struct PngInput {
  const InputFile* file;
  std::uint64_t offset;
  std::uint32_t width;
  std::uint32_t height;
  int channels;  ///< after expansion: 3 or 4
  int depth;     ///< bits a channel: 8 or 16
  std::vector<std::uint8_t>* bytes;
  char message[160];
};

void read_bytes(png_structp png, png_bytep bytes, std::size_t size) {
  PngInput& input = *static_cast<PngInput*>(png_get_io_ptr(png));
  if (input.file->try_read(bytes, size, input.offset) != size) png_error(png, "the file ends too early");
  input.offset += size;
}

[[noreturn]] void on_error(png_structp png, png_const_charp message) {
  PngInput& input = *static_cast<PngInput*>(png_get_error_ptr(png));
  std::snprintf(input.message, sizeof input.message, "%s", message);
  png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

/// Refuses sizes that the file cannot hold, before anything of that size is allocated.
void check_size(png_structp png, png_infop info, const PngInput& input) {
  const std::uint64_t pixels = std::uint64_t{input.width} * input.height;
  if (pixels > kMaxPngPixels) png_error(png, "more than 2^27 pixels");
  const std::uint64_t raw = (std::uint64_t{png_get_rowbytes(png, info)} + 1) * input.height;
  if (raw / kMaxExpansion > input.file->size())
    png_error(png, "the file is too short for its size in pixels");
}

/// Every colour type as RGB or RGBA of 8 or 16 bits.
void expand(png_structp png, png_infop info, PngInput& input) {
  png_set_expand(png);
  png_set_gray_to_rgb(png);
  const int passes = png_set_interlace_handling(png);
  png_read_update_info(png, info);
  input.channels = png_get_channels(png, info);
  input.depth = png_get_bit_depth(png, info);
  const std::size_t row_bytes = png_get_rowbytes(png, info);
  input.bytes->resize(row_bytes * input.height);
  for (int pass = 0; pass < passes; ++pass) {
    for (std::uint32_t y = 0; y < input.height; ++y) {
      png_read_row(png, input.bytes->data() + row_bytes * y, nullptr);
    }
  }
  png_read_end(png, nullptr);
}

/// False on any error, which `input.message` then names; the caller destroys the structures.
bool decode(png_structp png, png_infop info, PngInput& input) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_read_fn(png, &input, read_bytes);
  png_set_user_limits(png, kMaxFilmSidePixels, kMaxFilmSidePixels);
  // Skips all chunks that the pixels do not need: libpng would allocate what their headers claim.
  png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
  png_read_info(png, info);
  input.width = png_get_image_width(png, info);
  input.height = png_get_image_height(png, info);
  check_size(png, info, input);
  expand(png, info, input);
  return true;
}

/// The linear value of every code, so that each is computed once.
std::vector<float> decode_table(int depth) {
  const std::size_t count = std::size_t{1} << depth;
  std::vector<float> table(count);
  for (std::size_t i = 0; i < count; ++i) {
    table[i] = static_cast<float>(srgb_decode(static_cast<double>(i) / static_cast<double>(count - 1)));
  }
  return table;
}

ImageBuffer to_linear(const PngInput& input) {
  const std::vector<float> table = decode_table(input.depth);
  ImageBuffer image{input.width, input.height, {}};
  image.pixels.resize(std::size_t{input.width} * input.height, Vec3{0, 0, 0});
  const std::size_t channels = static_cast<std::size_t>(input.channels);
  const std::size_t width = input.depth == 16 ? 2 : 1;
  const auto code = [&](std::size_t index) {
    const std::uint8_t* at = input.bytes->data() + index * width;
    return width == 1 ? std::size_t{at[0]} : std::size_t{at[0]} << 8 | std::size_t{at[1]};
  };
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      image.pixels[i][static_cast<int>(channel)] = table[code(i * channels + channel)];
    }
    if (channels == 4 && code(i * channels + 3) != table.size() - 1) {
      input.file->fail("is transparent at x " + std::to_string(i % input.width) + ", y " +
                       std::to_string(i / input.width) +
                       " from the top left; expected a picture that is opaque everywhere");
    }
  }
  return image;
}

}  // namespace

LoadedImage read_png(const std::string& path) {
  const InputFile file(path, "a PNG image");
  png_byte signature[8] = {};
  if (file.read(signature, sizeof signature, 0) != sizeof signature ||
      png_sig_cmp(signature, 0, sizeof signature) != 0) {
    file.fail("does not start as a PNG image does; expected a PNG image");
  }
  std::vector<std::uint8_t> bytes;
  PngInput input{&file, 0, 0, 0, 0, 0, &bytes, "no memory"};
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &input, on_error, on_warning);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  const bool done = info != nullptr && decode(png, info, input);
  png_destroy_read_struct(&png, &info, nullptr);
  if (!done) file.fail(std::string("is not a PNG image that can be read: ") + input.message);
  return {to_linear(input), 0};
}

LoadedImage read_image(const std::string& path) {
  switch (image_format_of(path)) {
    case ImageFormat::png:
      return read_png(path);
    case ImageFormat::pfm:
      return read_pfm(path);
#if defined(MLT_HAS_OPENEXR)
    case ImageFormat::exr:
      return read_exr(path);
#endif
  }
  return {};
}

}  // namespace mlt
