// The table of hostile scene and mesh files: what stands in the file, and what the reader must answer. Files
// are written to a temporary folder by the test, so that opening, sizes and paths are met as a user meets
// them.
#pragma once

#include <string>
#include <vector>

namespace mlt::test {

enum class Answer {
  kInputError,     ///< exit code 2
  kResourceError,  ///< exit code 3
  kWarning,        ///< accepted, with a warning
  kAccepted,       ///< accepted without one
};

struct HostileCase {
  std::string name;
  /// The scene; "@" stands for the three lines of a valid camera, material and light, so what follows is on
  /// line 4.
  std::string scene;
  Answer answer = Answer::kInputError;
  /// Printed "file:line:column: " without the folder, e.g. "scene.txt:4:1: "; for kAccepted empty.
  std::string place;
  std::string fragment;  ///< of the message
  /// File beside the scene: name and bytes.
  std::string file_name = {};
  std::string file_bytes = {};
};

const std::vector<HostileCase>& hostile_scenes();
const std::vector<HostileCase>& hostile_meshes();

}  // namespace mlt::test
