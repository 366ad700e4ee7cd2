// Short scenes for the tests: the lines that every scene needs, so that a test states only its own.
#pragma once

#include <string>
#include <vector>

#include "base/error.hpp"
#include "scene/parse.hpp"

namespace mlt::test {

inline constexpr char kCamera[] = "camera eye 0 0 5 target 0 0 0\n";
inline constexpr char kMaterial[] = "material m diffuse reflectance 0.5\n";
inline constexpr char kLight[] = "sphere 9 9 9 1 material m emit 1\n";

/// Camera, material and light in lines 1 to 3, `lines` from line 4 on.
inline std::string scene_with(const std::string& lines) {
  return std::string(kCamera) + kMaterial + kLight + lines;
}

inline SceneDescription parse_with(const std::string& lines) {
  return parse_scene_text(scene_with(lines), "test.txt");
}

/// The diagnostics of a scene as printed, or {"accepted"}.
inline std::vector<std::string> faults_of(const std::string& text) {
  try {
    parse_scene_text(text, "test.txt");
  } catch (const InputError& error) {
    std::vector<std::string> lines;
    for (const Diagnostic& diagnostic : error.diagnostics()) lines.push_back(diagnostic.to_string());
    return lines;
  }
  return {"accepted"};
}

}  // namespace mlt::test
