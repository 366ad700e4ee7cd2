// Entry points of the reader: scene file and everything that it includes or loads to a SceneDescription.
#pragma once

#include <string>
#include <string_view>

#include "scene/description.hpp"

namespace mlt {

/// Reads `path`. Throws InputError with up to 20 diagnostics, ResourceError when a stated limit on sizes or
/// counts is exceeded by a valid file. docs/SCENES.md describes the format, scene/limits.hpp the limits.
SceneDescription parse_scene_file(const std::string& path);

/// Reads a scene from memory; it cannot name other files. `name` stands for the file in diagnostics.
SceneDescription parse_scene_text(std::string_view text, const std::string& name);

}  // namespace mlt
