// Writing and reading pictures. Writers stream rows through a buffer of one row into an AtomicFile, so that
// an image takes no second copy in memory and appears whole or not at all; equal pixels and metadata give
// equal bytes (no time stamps). Readers trust nothing: sizes are checked against the file's length before
// anything is allocated.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "film/image_view.hpp"
#include "image/format.hpp"

namespace mlt {

struct TextEntry {
  std::string keyword;  ///< 1 to 79 printable ASCII characters
  std::string text;     ///< UTF-8
};

struct ImageOptions {
  float exposure = 0;               ///< EV: PNG values are multiplied by 2^exposure before encoding
  std::vector<TextEntry> metadata;  ///< stored by formats that can (PNG, OpenEXR)
};

/// Writes `image` in the format that `path` names. Throws InputError when the place cannot be written,
/// ResourceError when writing fails (full disk).
void write_image(const std::string& path, const ImageView& image, const ImageOptions& options);

/// PNG [PNG03], 8-bit RGB with an sRGB chunk; text in tEXt chunks, in iTXt where it is not ASCII.
void write_png(const std::string& path, const ImageView& image, const ImageOptions& options);

/// PFM [Debevec PFM], three channels, little-endian, rows from bottom to top as the format demands.
void write_pfm(const std::string& path, const ImageView& image);

/// Display values as they stand in a file: 3 bytes a pixel, sRGB, rows from top to bottom. For drawings such
/// as heat maps, whose colours are chosen and not computed from radiance.
struct Picture {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::uint8_t> bytes;  ///< 3 * width * height
};

/// As above, with the bytes as they are.
void write_png(const std::string& path, const Picture& picture, const std::vector<TextEntry>& metadata);

/// The byte that stands for a linear channel value: clipped to [0,1] (NaN gives 0), sRGB-encoded, rounded to
/// nearest.
std::uint8_t srgb_byte(float linear);

struct LoadedImage {
  ImageBuffer image;             ///< linear; one channel becomes three equal
  std::uint64_t non_finite = 0;  ///< pixels with a NaN or infinite channel
};

/// Reads an image in the format that `path` names. Throws InputError, see the format's own function.
LoadedImage read_image(const std::string& path);

/// Reads a PFM of one (Pf) or three (PF) channels and either byte order; values are multiplied by the
/// header's scale. Throws InputError for anything that is not exactly such a file: not a regular file, bad
/// header, sides beyond kMaxFilmSidePixels, other length than the header says.
LoadedImage read_pfm(const std::string& path);

/// Most pixels of a PNG, which may be a thousandth of its picture's size.
inline constexpr std::uint64_t kMaxPngPixels = std::uint64_t{1} << 27;

/// Reads a PNG [PNG03] of any colour type and depth, interlaced or not, and decodes it as sRGB to linear
/// values in [0,1], whatever colour space its chunks name. Throws InputError for a file that libpng cannot
/// read, for transparent pixels, whose colour would depend on what lies behind, and beyond kMaxPngPixels.
LoadedImage read_png(const std::string& path);

#if defined(MLT_HAS_OPENEXR)
/// OpenEXR [Kainz09]: channels R, G and B of 32-bit float, compressed without loss; text in string
/// attributes.
void write_exr(const std::string& path, const ImageView& image, const ImageOptions& options);

/// Reads the data window of an OpenEXR image's first part: channels R, G and B, or Y, one sample a pixel, of
/// any type and compression; others are ignored. Throws InputError for anything else.
LoadedImage read_exr(const std::string& path);
#endif

}  // namespace mlt
