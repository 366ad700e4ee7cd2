#include <catch2/catch.hpp>
#include <filesystem>

#include "program.hpp"

namespace mlt {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kSmallJob{"render",      "scene.txt", "--mutations", "4",
                                         "--bootstrap", "1000",      "--quiet"};

std::vector<std::string> small_job(const std::vector<std::string>& more) {
  std::vector<std::string> words = kSmallJob;
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

TEST_CASE("outputs that cannot be written are refused before rendering, all at once") {
  const SceneFolder folder;
  fs::create_directory(folder / "folder.png");
  // A job of hours, which shows that the check comes first.
  const ProgramResult result =
      folder.run({"render", "scene.txt", "--mutations", "30000000", "-o", "missing/x.png", "-o", "folder.png",
                  "-o", "x.jpg", "-o", "noextension", "-o", "ok.png", "--stats", "scene.txt/s.json"});
  CHECK(result.code == code_of(ExitCode::kBadInput));
  CHECK_THAT(result.error,
             Catch::Contains("missing/x.png: the folder 'missing' cannot be used: No such file"));
  CHECK_THAT(result.error, Catch::Contains("folder.png: is a folder"));
  CHECK_THAT(result.error,
             Catch::Contains("x.jpg: unknown image format '.jpg'") && Catch::Contains(".png, .pfm"));
  CHECK_THAT(result.error, Catch::Contains("noextension: the name has no extension"));
  CHECK_THAT(result.error, Catch::Contains("scene.txt/s.json: 'scene.txt' is not a folder"));
  CHECK(folder.outputs() == "folder.png");
}

TEST_CASE("an output may be neither the scene nor another output") {
  const SceneFolder folder;
  const std::string scene = read_text(folder / "scene.txt");
  fs::create_symlink("scene.txt", folder / "link.png");
  const ProgramResult on_scene = folder.run(small_job({"--stats", "scene.txt"}));
  CHECK(on_scene.code == code_of(ExitCode::kBadInput));
  CHECK_THAT(on_scene.error, Catch::Contains("scene.txt: is the scene"));
  CHECK(folder.run(small_job({"-o", "link.png"})).code == code_of(ExitCode::kBadInput));
  const ProgramResult twice = folder.run(small_job({"-o", "a.png", "-o", "./a.png"}));
  CHECK(twice.code == code_of(ExitCode::kBadInput));
  CHECK_THAT(twice.error, Catch::Contains("./a.png: is given as output twice"));
  CHECK(read_text(folder / "scene.txt") == scene);
  CHECK(folder.outputs() == "link.png");
}

TEST_CASE("a full disk is a resource limit; the other outputs are still written") {
  const SceneFolder folder;
  fs::create_symlink("/dev/full", folder / "full.png");
  fs::create_symlink("/dev/full", folder / "full.pfm");
  for (const char* name : {"full.png", "full.pfm"}) {
    const ProgramResult result =
        folder.run(small_job({"-o", name, "-o", "good.png", "--stats", "good.json"}));
    CHECK(result.code == code_of(ExitCode::kResourceLimit));
    CHECK_THAT(result.error, Catch::Contains(name) && Catch::Contains("No space left"));
    CHECK(folder.outputs() == "full.pfm full.png good.json good.png");
    fs::remove(folder / "good.png");
    fs::remove(folder / "good.json");
  }
  const ProgramResult result = folder.run(small_job({"-o", "good.png", "--stats", "/dev/full"}));
  CHECK(result.code == code_of(ExitCode::kResourceLimit));
  CHECK_THAT(result.error, Catch::Contains("/dev/full"));
  CHECK(folder.outputs() == "full.pfm full.png good.png");
}

TEST_CASE("a file size limit leaves the old image as it was and nothing half-written") {
  const SceneFolder folder;
  write_text(folder / "x.pfm", "old");
  const ProgramResult result = run_shell(
      "ulimit -f 1; exec \"$MLT\" render scene.txt --mutations 1 --width 64 --height 64 -q -o x.pfm",
      folder.path().string());
  CHECK(result.code == code_of(ExitCode::kResourceLimit));
  CHECK_THAT(result.error, Catch::Contains("x.pfm: could not be written: File too large"));
  CHECK(read_text(folder / "x.pfm") == "old");
  CHECK(folder.outputs() == "x.pfm");
}

TEST_CASE("memory beyond --memory is a resource limit that names both sizes, before anything is written") {
  const SceneFolder folder;
  for (const char* command : {"render", "info"}) {
    const ProgramResult byte = folder.run({command, "scene.txt", "--memory", "1"});
    CHECK(byte.code == code_of(ExitCode::kResourceLimit));
    CHECK_THAT(byte.error, Catch::Contains("--memory") && Catch::Contains(" 1"));
    const ProgramResult large = folder.run({command, "scene.txt", "--width", "20000", "--height", "20000",
                                            "--mutations", "1", "--memory", "512M"});
    CHECK(large.code == code_of(ExitCode::kResourceLimit));
    CHECK_THAT(large.error, Catch::Contains("--memory") && Catch::Contains("536870912"));
  }
  // More mutations than the film's fixed point has room for.
  const ProgramResult headroom = folder.run({"render", "scene.txt", "--width", "65536", "--height", "65536",
                                             "--mutations", "1000000", "--bootstrap", "1000"});
  CHECK(headroom.code == code_of(ExitCode::kResourceLimit));
  CHECK(folder.outputs() == "");
}

TEST_CASE("standard output that cannot be written is a resource limit") {
  const SceneFolder folder;
  for (const char* command : {"--help", "info scene.txt"}) {
    const ProgramResult result =
        run_shell("exec \"$MLT\" " + std::string(command) + " >/dev/full", folder.path().string());
    CHECK(result.code == code_of(ExitCode::kResourceLimit));
    CHECK_THAT(result.error, Catch::Contains("standard output: could not be written: No space left"));
  }
}

TEST_CASE("the default output is the scene's base name with .png in the current folder") {
  const SceneFolder folder;
  fs::create_directory(folder / "scenes");
  fs::rename(folder / "scene.txt", folder / "scenes/my.room.v2.txt");
  const ProgramResult result =
      folder.run({"render", "scenes/my.room.v2.txt", "--mutations", "1", "--bootstrap", "500", "--quiet"});
  CHECK(result.error == "");
  CHECK(result.code == code_of(ExitCode::kOk));
  CHECK(folder.outputs() == "my.room.v2.png scenes");
}

}  // namespace
}  // namespace mlt
