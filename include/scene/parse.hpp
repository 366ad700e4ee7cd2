// Entry point of the reader: scene file and everything that it includes or loads to a SceneDescription.
#pragma once

#include <string>

#include "scene/description.hpp"

namespace mlt {

/// Reads `path`. Throws InputError with up to 20 diagnostics, ResourceError when a stated limit on sizes or
/// counts is exceeded by a valid file.
SceneDescription parse_scene_file(const std::string& path);

}  // namespace mlt
