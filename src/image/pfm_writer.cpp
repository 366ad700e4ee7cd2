#include <bit>
#include <string>
#include <vector>

#include "base/assert.hpp"
#include "base/atomic_file.hpp"
#include "image/image_io.hpp"

namespace mlt {
namespace {

void append_little_endian(float value, std::uint8_t* bytes) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  for (int i = 0; i < 4; ++i) bytes[i] = static_cast<std::uint8_t>(bits >> (8 * i));
}

}  // namespace

void write_pfm(const std::string& path, const ImageView& image) {
  MLT_CHECK_OP(image.pixels.size(), ==, std::size_t{image.width} * image.height);
  MLT_CHECK_OP(image.pixels.size(), >, 0u);
  AtomicFile file(path);
  // The sign of the scale states the byte order.
  const std::string header =
      "PF\n" + std::to_string(image.width) + " " + std::to_string(image.height) + "\n-1.0\n";
  file.write(header.data(), header.size());
  std::vector<std::uint8_t> row(std::size_t{12} * image.width);
  for (std::uint32_t y = image.height; y-- > 0;) {
    const Vec3* pixels = image.pixels.data() + std::size_t{y} * image.width;
    for (std::uint32_t x = 0; x < image.width; ++x) {
      for (int channel = 0; channel < 3; ++channel) {
        append_little_endian(pixels[x][channel],
                             row.data() + std::size_t{12} * x + static_cast<std::size_t>(4 * channel));
      }
    }
    if (!file.write(row.data(), row.size())) break;
  }
  file.commit();
}

void write_image(const std::string& path, const ImageView& image, const ImageOptions& options) {
  switch (image_format_of(path)) {
    case ImageFormat::png:
      return write_png(path, image, options);
    case ImageFormat::pfm:
      return write_pfm(path, image);
#if defined(MLT_HAS_OPENEXR)
    case ImageFormat::exr:
      return write_exr(path, image, options);
#endif
  }
}

}  // namespace mlt
