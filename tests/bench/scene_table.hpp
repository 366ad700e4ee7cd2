// The table of scenes.txt, which the benchmark of time to an error, the maker of its references and their
// test share.
#pragma once

#include <cstdint>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace mlt::test {

inline constexpr const char* kBenchScenes = "tests/bench/scenes.txt";
inline constexpr const char* kLargeReferences = "ref_images/256/";

struct BenchScene {
  std::string name;  ///< of the files in ref_images/256/
  std::string file;
  double stated_error = 0;              ///< relMSE
  std::uint64_t reference_samples = 0;  ///< a pixel, of one replicate of the reference
  std::uint64_t path_samples = 0;       ///< a pixel, near the stated error
  std::uint64_t mutations = 0;          ///< a pixel, near the stated error
};

/// From the checkout's root. Throws std::runtime_error when the table is missing or a line is incomplete.
inline std::vector<BenchScene> read_bench_scenes() {
  std::ifstream file(kBenchScenes);
  std::vector<BenchScene> scenes;
  std::string line;
  while (std::getline(file, line)) {
    if (line.empty() || line[0] == '#') continue;
    BenchScene scene;
    std::istringstream words(line);
    if (!(words >> scene.name >> scene.file >> scene.stated_error >> scene.reference_samples >>
          scene.path_samples >> scene.mutations)) {
      throw std::runtime_error(std::string(kBenchScenes) + ": not a scene: " + line);
    }
    scenes.push_back(scene);
  }
  if (scenes.empty()) throw std::runtime_error(std::string(kBenchScenes) + " is missing or empty");
  return scenes;
}

}  // namespace mlt::test
