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
  std::vector<TextEntry> metadata;  ///< stored by formats that can (PNG)
};

/// Writes `image` in the format that `path` names. Throws InputError when the place cannot be written,
/// ResourceError when writing fails (full disk).
void write_image(const std::string& path, const ImageView& image, const ImageOptions& options);

/// PNG [PNG03], 8-bit RGB with an sRGB chunk; text in tEXt chunks, in iTXt where it is not ASCII.
void write_png(const std::string& path, const ImageView& image, const ImageOptions& options);

/// PFM [Debevec PFM], three channels, little-endian, rows from bottom to top as the format demands.
void write_pfm(const std::string& path, const ImageView& image);

/// The byte that stands for a linear channel value: clipped to [0,1] (NaN gives 0), sRGB-encoded, rounded to
/// nearest.
std::uint8_t srgb_byte(float linear);

struct PfmImage {
  ImageBuffer image;             ///< values multiplied by the header's scale; one channel becomes three equal
  std::uint64_t non_finite = 0;  ///< pixels with a NaN or infinite channel
};

/// Reads a PFM of one (Pf) or three (PF) channels and either byte order. Throws InputError for anything that
/// is not exactly such a file: not a regular file, bad header, sides beyond kMaxFilmSide, other length than
/// the header says.
PfmImage read_pfm(const std::string& path);

}  // namespace mlt
