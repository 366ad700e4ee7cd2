// --integrator auto through the binary: what it says, and that the command it names makes the same image
// without a pilot.
#include <catch2/catch.hpp>
#include <sstream>

#include "program.hpp"

namespace mlt {
namespace {

/// What follows `name` and blanks on its line.
std::string value_of(const std::string& text, const std::string& name) {
  const std::size_t at = text.find(name);
  REQUIRE(at != std::string::npos);
  const std::size_t begin = text.find_first_not_of(' ', at + name.size());
  return text.substr(begin, text.find('\n', begin) - begin);
}

const std::vector<std::string> kPiloted{"--integrator", "auto", "--width",  "64", "--height", "64",
                                        "--spp",        "256",  "--depth",  "3",  "--seed",   "5",
                                        "--threads",    "2",    "--chains", "16"};

std::vector<std::string> words_of(const std::string& command, const std::vector<std::string>& more) {
  std::vector<std::string> words{command, "scene.txt"};
  words.insert(words.end(), kPiloted.begin(), kPiloted.end());
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

TEST_CASE("the image of auto is that of the command it names, which needs no pilot") {
  const SceneFolder folder;
  const ProgramResult chosen = folder.run(words_of("render", {"-o", "a.pfm", "--stats", "a.json"}));
  CAPTURE(chosen.error);
  REQUIRE(chosen.code == code_of(ExitCode::kOk));
  CHECK_THAT(value_of(chosen.error, "integrator"), Catch::StartsWith("path: in a pilot of"));
  CHECK_THAT(chosen.error, !Catch::Contains("has no effect"));
  CHECK_THAT(value_of(chosen.error, "\npilot"), Catch::Contains(" s, processors busy "));
  const std::string statistics = read_text(folder / "a.json");
  for (const char* part : {"\"choice\": \"path: in a pilot of", "\"pilot_advantage\": 0.",
                           "\"pilot_paths\": ", "\"pilot_cpu_seconds\": ", "\"pilot_wall_seconds\": ",
                           "\"integrator\": \"path\"", "\"roulette\": 0"}) {
    CHECK_THAT(statistics, Catch::Contains(part));
  }
  const std::string command = value_of(chosen.error, "same image by");
  REQUIRE(command.starts_with("mlt render scene.txt --integrator path --spp 256 "));
  const ProgramResult again =
      run_shell("\"$MLT\"" + command.substr(3) + " -o b.pfm --stats b.json", folder.path().string());
  CAPTURE(again.error);
  REQUIRE(again.code == code_of(ExitCode::kOk));
  CHECK(value_of(again.error, "film hash") == value_of(chosen.error, "film hash"));
  CHECK(read_text(folder / "a.pfm") == read_text(folder / "b.pfm"));
  CHECK_THAT(read_text(folder / "b.json"), !Catch::Contains("pilot"));
  CHECK_THAT(again.error, !Catch::Contains("pilot"));

  const ProgramResult info = folder.run(words_of("info", {}));
  CHECK(value_of(info.out, "\nchoice") == value_of(chosen.error, "integrator"));
  CHECK(value_of(info.out, "\ncommand") == command);
}

TEST_CASE("jobs too small for a pilot say so, and faults are those of the integrators") {
  const SceneFolder folder;
  const ProgramResult small =
      folder.run({"render", "scene.txt", "--integrator", "auto", "--spp", "16", "-o", "a.pfm"});
  CHECK(small.code == code_of(ExitCode::kOk));
  CHECK_THAT(small.error, Catch::Contains("path: no pilot for a job of fewer than 524288 samples"));
  const ProgramResult timed = folder.run(
      {"render", "scene.txt", "--integrator", "auto", "--time", "0.001", "--spp", "4", "-o", "t.pfm"});
  CHECK(timed.code == code_of(ExitCode::kOk));
  CHECK_THAT(timed.error, Catch::Contains("--rounds "));
  const ProgramResult wrong =
      folder.run({"render", "scene.txt", "--integrator", "auto", "--chains", "0", "-o", "a.pfm"});
  CHECK(wrong.code == code_of(ExitCode::kBadInput));
}

TEST_CASE("converge measures auto as the integrator that it chose, with the pilot's paths") {
  const SceneFolder folder;
  const ProgramResult result =
      folder.run({"converge", "scene.txt", "--integrators", "path,auto", "--budgets", "256", "--replicates",
                  "2", "--width", "64", "--height", "64", "--depth", "3", "-q", "-o", "out"});
  CAPTURE(result.error);
  REQUIRE(result.code == code_of(ExitCode::kOk));
  // scene,method,level,budget,replicate,seed,samples,wall_seconds,cpu_seconds,...,film_hash
  std::string path, automatic;
  std::istringstream lines(read_text(folder / "out/converge.csv"));
  for (std::string line; std::getline(lines, line);) {
    if (line.find(",path,0,256,0,") != std::string::npos) path = line;
    if (line.find(",auto,0,256,0,") != std::string::npos) automatic = line;
  }
  REQUIRE(!path.empty());
  REQUIRE(!automatic.empty());
  CHECK(path.substr(path.rfind(',')) == automatic.substr(automatic.rfind(',')));
  // 256 samples a pixel, and as many again in every 16th.
  CHECK_THAT(path, Catch::Contains(",1114112,"));
  CHECK_THAT(automatic, !Catch::Contains(",1114112,"));
}

}  // namespace
}  // namespace mlt
