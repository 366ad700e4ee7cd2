// The image formats, in one list: file extension, help text and errors come from here. The format of an
// output is chosen by the extension of its name, in any case of letters.
#pragma once

#include <cstdint>
#include <string>

namespace mlt {

/// A format that not every build has.
#if defined(MLT_HAS_OPENEXR)
#define MLT_EXR_FORMAT(X) \
  X(exr, "OpenEXR: 32-bit float, linear radiance as rendered, compressed, with metadata")
#else
#define MLT_EXR_FORMAT(X)
#endif

/// name (the extension is the name with a dot), one-line description for the help text.
#define MLT_IMAGE_FORMATS(X)                                                       \
  X(png, "8 bits a channel, sRGB, brightened by --exposure, clipped to [0,1]")     \
  X(pfm, "32-bit float, linear radiance as rendered, for measuring and comparing") \
  MLT_EXR_FORMAT(X)

enum class ImageFormat : std::uint8_t {
#define MLT_ENUMERATE(name, help) name,
  MLT_IMAGE_FORMATS(MLT_ENUMERATE)
#undef MLT_ENUMERATE
};

/// Throws InputError, with `path` as place and the known extensions in the message.
ImageFormat image_format_of(const std::string& path);

/// Whether image_format_of would find one.
bool has_image_extension(const std::string& path);

/// ".png, .pfm"
std::string image_extensions();

}  // namespace mlt
