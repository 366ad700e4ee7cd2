#include "image/format.hpp"

#include <algorithm>
#include <vector>

#include "base/error.hpp"

namespace mlt {
namespace {

/// The last extension with its dot, lower case; empty when the name has none.
std::string extension_of(const std::string& path) {
  const std::size_t name = path.rfind('/') == std::string::npos ? 0 : path.rfind('/') + 1;
  const std::size_t dot = path.rfind('.');
  // A leading dot marks a hidden file, not an extension.
  if (dot == std::string::npos || dot <= name) return "";
  std::string extension = path.substr(dot);
  for (char& letter : extension) {
    if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
  }
  return extension;
}

const std::vector<std::string>& extensions() {
  static const std::vector<std::string> all{
#define MLT_EXTENSION(name, help) "." #name,
      MLT_IMAGE_FORMATS(MLT_EXTENSION)
#undef MLT_EXTENSION
  };
  return all;
}

}  // namespace

std::string image_extensions() {
  std::string text;
  for (const std::string& extension : extensions()) text += (text.empty() ? "" : ", ") + extension;
  return text;
}

bool has_image_extension(const std::string& path) {
  const std::vector<std::string>& all = extensions();
  return std::find(all.begin(), all.end(), extension_of(path)) != all.end();
}

ImageFormat image_format_of(const std::string& path) {
  const std::string extension = extension_of(path);
#define MLT_MATCH(name, help) \
  if (extension == "." #name) return ImageFormat::name;
  MLT_IMAGE_FORMATS(MLT_MATCH)
#undef MLT_MATCH
  const std::string found =
      extension.empty() ? "the name has no extension" : "unknown image format '" + extension + "'";
#if !defined(MLT_HAS_OPENEXR)
  if (extension == ".exr") {
    throw InputError(Diagnostic{path, 0, 0,
                                "this build has no OpenEXR (`make EXR=yes` has); "
                                "expected one of " +
                                    image_extensions()});
  }
#endif
  const std::string hint = suggest(extension, extensions());
  throw InputError(Diagnostic{
      path, 0, 0,
      found + (hint.empty() ? "; expected one of " : hint + " Expected one of ") + image_extensions()});
}

}  // namespace mlt
