// Hostile input through files, as a user's scene would bring it.
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "hostile_cases.hpp"
#include "scene/limits.hpp"
#include "scene_text.hpp"

using namespace mlt;
using namespace mlt::test;

namespace {

/// A folder of its own, removed at the end.
class Folder {
 public:
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "mlt_hostile_XXXXXX").string();
    REQUIRE(::mkdtemp(pattern.data()) != nullptr);
    path_ = pattern + "/";
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() { std::filesystem::remove_all(path_); }

  std::string operator/(const std::string& name) const { return path_ + name; }

  std::string write(const std::string& name, const std::string& bytes) const {
    std::ofstream file(path_ + name, std::ios::binary);
    file << bytes;
    REQUIRE(file.good());
    return path_ + name;
  }

 private:
  std::string path_;
};

std::string expanded(std::string scene) {
  const std::size_t at = scene.find('@');
  return at == std::string::npos ? scene : scene.replace(at, 1, scene_with(""));
}

struct Outcome {
  Answer answer = Answer::kAccepted;
  std::string text;  ///< what is printed, the folder's name taken out
};

Outcome outcome_of(const Folder& folder, const std::string& name) {
  Outcome outcome;
  try {
    const SceneDescription scene = parse_scene_file(folder / name);
    if (!scene.warnings.empty()) outcome.answer = Answer::kWarning;
    for (const std::string& warning : scene.warnings) outcome.text += warning + "\n";
  } catch (const InputError& error) {
    outcome = {Answer::kInputError, error.what()};
  } catch (const ResourceError& error) {
    outcome = {Answer::kResourceError, error.what()};
  }
  const std::string prefix = folder / "";
  for (std::size_t at = 0; (at = outcome.text.find(prefix)) != std::string::npos;)
    outcome.text.erase(at, prefix.size());
  return outcome;
}

std::string name_of(Answer answer) {
  const char* const names[] = {"InputError", "ResourceError", "warning", "accepted"};
  return names[static_cast<int>(answer)];
}

/// Whether one printed line begins with the place and holds the fragment.
bool has_line(const std::string& text, const std::string& place, const std::string& fragment) {
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string line = text.substr(begin, end - begin);
    if (line.compare(0, place.size(), place) == 0 && line.find(fragment) != std::string::npos) return true;
    begin = end + 1;
  }
  return false;
}

void check(const HostileCase& hostile) {
  const Folder folder;
  folder.write("scene.txt", expanded(hostile.scene));
  if (!hostile.file_name.empty()) folder.write(hostile.file_name, hostile.file_bytes);
  const Outcome outcome = outcome_of(folder, "scene.txt");
  INFO("case: " << hostile.name << "\nsaid: " << outcome.text);
  CHECK(name_of(outcome.answer) == name_of(hostile.answer));
  if (hostile.answer != Answer::kAccepted) {
    INFO("expected: " << hostile.place << "..." << hostile.fragment);
    CHECK(has_line(outcome.text, hostile.place, hostile.fragment));
  }
  for (const char byte : outcome.text) CHECK((byte == '\n' || (byte >= 0x20 && byte < 0x7f)));
}

Outcome outcome_with_file_statement(const Folder& folder, const std::string& statement) {
  folder.write("scene.txt", scene_with(statement));
  return outcome_of(folder, "scene.txt");
}

}  // namespace

TEST_CASE("The table of hostile files has the size it is meant to have") {
  CHECK(hostile_scenes().size() + hostile_meshes().size() >= 60);
}

TEST_CASE("Hostile scene files") {
  for (const HostileCase& hostile : hostile_scenes()) check(hostile);
}

TEST_CASE("Hostile mesh files") {
  for (const HostileCase& hostile : hostile_meshes()) check(hostile);
}

TEST_CASE("Scene paths that lead to no regular file") {
  const Folder folder;
  CHECK(outcome_of(folder, "missing.txt").answer == Answer::kInputError);
  CHECK_THAT(outcome_of(folder, "missing.txt").text, Catch::Contains("No such file"));
  CHECK_THAT(outcome_of(folder, "no/folder.txt").text, Catch::Contains("No such file"));
  CHECK_THAT(outcome_of(folder, ".").text, Catch::Contains("is a directory"));
  CHECK_THAT(outcome_of(folder, "").text, Catch::Contains("is a directory"));
  CHECK_THROWS_AS(parse_scene_file(""), InputError);
  CHECK_THROWS_AS(parse_scene_file("/dev/zero"), InputError);
  CHECK_THROWS_AS(parse_scene_file("/dev/null"), InputError);
  CHECK_THROWS_AS(parse_scene_file(std::string(10000, 'a')), InputError);
}

TEST_CASE("A FIFO is refused without waiting for its other end") {
  const Folder folder;
  REQUIRE(::mkfifo((folder / "pipe.txt").c_str(), 0600) == 0);
  REQUIRE(::mkfifo((folder / "pipe.ply").c_str(), 0600) == 0);
  CHECK_THAT(outcome_of(folder, "pipe.txt").text, Catch::Contains("is no regular file"));
  CHECK_THAT(outcome_with_file_statement(folder, "include pipe.txt").text,
             Catch::StartsWith("scene.txt:4:9: 'pipe.txt' is no regular file"));
  CHECK_THAT(outcome_with_file_statement(folder, "mesh pipe.ply material m").text,
             Catch::Contains("is no regular file"));
}

TEST_CASE("Symbolic links may lead within the scene's folder, but not out of it") {
  const Folder outside;
  outside.write("secret.txt", "secret words\n");
  const Folder folder;
  folder.write("inner.txt", "sphere 0 0 0 1 material m\n");
  std::filesystem::create_symlink(outside / "secret.txt", folder / "out.txt");
  std::filesystem::create_symlink("inner.txt", folder / "in.txt");
  std::filesystem::create_directory_symlink(outside / "", folder / "door");
  std::filesystem::create_symlink("loop.txt", folder / "loop.txt");
  for (const char* name : {"out.txt", "door/secret.txt"}) {
    const Outcome outcome = outcome_with_file_statement(folder, std::string("include ") + name);
    CHECK(outcome.answer == Answer::kInputError);
    CHECK_THAT(outcome.text, Catch::Contains("a symbolic link leads out of it"));
    CHECK_THAT(outcome.text, !Catch::Contains("words"));
  }
  CHECK(outcome_with_file_statement(folder, "include in.txt").answer == Answer::kAccepted);
  CHECK(outcome_with_file_statement(folder, "include loop.txt").answer == Answer::kInputError);
  // A folder whose name merely begins like the scene's is outside, too.
  const std::string sibling = (folder / "").substr(0, (folder / "").size() - 1) + "_more";
  std::filesystem::create_directory(sibling);
  std::ofstream(sibling + "/a.txt") << "sphere 0 0 0 1 material m\n";
  std::filesystem::create_symlink(sibling + "/a.txt", folder / "sibling.txt");
  CHECK_THAT(outcome_with_file_statement(folder, "include sibling.txt").text,
             Catch::Contains("leads out of it"));
  std::filesystem::remove_all(sibling);
}

TEST_CASE("Paths are relative to the file that names them, below the scene's folder") {
  const Folder folder;
  std::filesystem::create_directories(folder / "a/b");
  folder.write("a/one.txt", "include b/two.txt\n");
  folder.write("a/b/two.txt", "mesh ../tri.obj material m\ninclude ../../three.txt\n");
  folder.write("a/tri.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  folder.write("three.txt", "sphere 0 0 0 1 material m\n");
  CHECK(outcome_with_file_statement(folder, "include a/one.txt").answer == Answer::kAccepted);
  folder.write("three.txt", "include ../four.txt\n");
  CHECK_THAT(outcome_with_file_statement(folder, "include a/one.txt").text,
             Catch::StartsWith("three.txt:1:9: the path '../four.txt' leaves"));
}

TEST_CASE("Includes are bounded in depth and in number") {
  const Folder folder;
  for (int i = 1; i < 40; ++i) {
    folder.write("n" + std::to_string(i) + ".txt", "include n" + std::to_string(i + 1) + ".txt\n");
  }
  CHECK_THAT(outcome_with_file_statement(folder, "include n1.txt").text,
             Catch::Contains("n15.txt:1:9: includes are nested more than 16 deep"));
  // Each file includes the next one twice: 2^15 readings if nothing stopped them.
  for (int i = 1; i < 15; ++i) {
    const std::string next = "include n" + std::to_string(i + 1) + ".txt\n";
    folder.write("n" + std::to_string(i) + ".txt", next + next);
  }
  folder.write("n15.txt", "");
  CHECK_THAT(outcome_with_file_statement(folder, "include n1.txt").text,
             Catch::Contains("more than 1024 files"));
}

TEST_CASE("Files above the limits are a matter of resources, and are not read") {
  const Folder folder;
  // Sparse: they take no room on the disk.
  folder.write("big.txt", "");
  std::filesystem::resize_file(folder / "big.txt", kMaxSceneFileBytes + 1);
  folder.write("big.ply", "ply\n");
  std::filesystem::resize_file(folder / "big.ply", kMaxMeshFileBytes + 1);
  CHECK(outcome_of(folder, "big.txt").answer == Answer::kResourceError);
  const Outcome include = outcome_with_file_statement(folder, "include big.txt");
  CHECK(include.answer == Answer::kResourceError);
  CHECK_THAT(include.text, Catch::Contains("has 67108865 bytes; at most 67108864"));
  CHECK(outcome_with_file_statement(folder, "mesh big.ply material m").answer == Answer::kResourceError);
}
