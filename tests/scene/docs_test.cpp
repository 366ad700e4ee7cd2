// docs/SCENES.md must name every word that the reader knows, and its examples must be valid. Run from the
// repository's root, as make does.
#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <string>

#include "scene/limits.hpp"
#include "scene/statements.hpp"
#include "scene_text.hpp"

using namespace mlt;

namespace {

std::string documentation() {
  std::ifstream file("docs/SCENES.md");
  REQUIRE(file.good());
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// The word in code style, alone or followed by its arguments.
bool mentions(const std::string& text, const std::string& word) {
  return text.find("`" + word + "`") != std::string::npos || text.find("`" + word + " ") != std::string::npos;
}

}  // namespace

TEST_CASE("docs/SCENES.md names every statement, clause, material kind and preset") {
  const std::string text = documentation();
  std::vector<std::string> words = material_kind_names();
  for (const Keyword& keyword : kStatements) words.emplace_back(keyword.word);
  for (const Keyword& keyword : kCameraClauses) words.emplace_back(keyword.word);
  for (const Keyword& keyword : kMaterialClauses) words.emplace_back(keyword.word);
  for (const Keyword& keyword : kShapeClauses) words.emplace_back(keyword.word);
  for (const ConductorPreset& preset : kConductorPresets) words.emplace_back(preset.name);
  for (const std::string& word : words) {
    CAPTURE(word);
    CHECK(mentions(text, word));
  }
}

TEST_CASE("docs/SCENES.md states the limits that the code has") {
  const std::string text = documentation();
  CHECK(text.find("| 64 MiB; 4 GiB; 8 GiB |") != std::string::npos);
  CHECK((kMaxSceneFileBytes == 64ULL << 20 && kMaxMeshFileBytes == 4ULL << 30 &&
         kMaxTotalFileBytes == 8ULL << 30));
  CHECK(text.find("| 1024; 16 |") != std::string::npos);
  CHECK((kMaxFiles == 1024 && kMaxIncludeDepth == 16));
  CHECK(text.find("| 65536, 1024; 1024 |") != std::string::npos);
  CHECK((kMaxLineBytes == 65536 && kMaxTokenBytes == 1024 && kMaxStatementTokens == 1024));
  CHECK(text.find("| 4096; 65536 |") != std::string::npos);
  CHECK((kMaxConstants == 4096 && kMaxMaterials == 65536));
  CHECK(text.find("4,194,304") != std::string::npos);
  CHECK(kMaxShapes == 4194304);
  CHECK(text.find("67,108,864 each") != std::string::npos);
  CHECK((kMaxMeshVertices == 67108864 && kMaxMeshTriangles == 67108864));
}

TEST_CASE("The first example of docs/SCENES.md is a valid scene") {
  const std::string text = documentation();
  const std::size_t begin = text.find("```\n") + 4;
  const std::string example = text.substr(begin, text.find("```", begin) - begin);
  const SceneDescription scene = parse_scene_text(example, "example.txt");
  CHECK(scene.polygons.size() == 2);
  CHECK(scene.spheres.size() == 1);
  CHECK(scene.warnings.empty());
}
