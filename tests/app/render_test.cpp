#include <signal.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <sstream>

#include "image/image_io.hpp"
#include "program.hpp"
#include "support/faults.hpp"

namespace mlt {
namespace {

/// The statistics file: one "key": value a line between braces. Fails the test on any other form.
std::map<std::string, std::string> read_statistics(const std::string& path) {
  std::istringstream lines(read_text(path));
  std::map<std::string, std::string> values;
  std::string line;
  REQUIRE(std::getline(lines, line));
  REQUIRE(line == "{");
  bool last = false;
  while (std::getline(lines, line) && line != "}") {
    CAPTURE(line);
    REQUIRE_FALSE(last);
    const std::size_t colon = line.find("\": ");
    REQUIRE(line.starts_with("  \""));
    REQUIRE(colon != std::string::npos);
    last = line.back() != ',';
    const std::string key = line.substr(3, colon - 3);
    const std::size_t begin = colon + 3;
    REQUIRE(values.emplace(key, line.substr(begin, line.size() - begin - (last ? 0 : 1))).second);
  }
  CHECK(last);
  CHECK(line == "}");
  return values;
}

TEST_CASE("the classic form writes the image that the full form writes, byte for byte") {
  const SceneFolder folder;
  const ProgramResult classic = folder.run({"9", "7", "10", "2", "5", "scene.txt"});
  CHECK(classic.code == code_of(ExitCode::kOk));
  CHECK(classic.out == "");
  REQUIRE(folder.outputs() == "scene.png");
  const ProgramResult full =
      folder.run({"render", "scene.txt", "--integrator", "pssmlt", "--width", "9", "--height", "7",
                  "--mutations", "10", "--threads", "3", "--depth", "5", "-o", "full.png"});
  CHECK(full.code == code_of(ExitCode::kOk));
  CHECK(read_text(folder / "scene.png") == read_text(folder / "full.png"));
}

TEST_CASE("the statistics hold every promised key, and their command gives the same bits") {
  const SceneFolder folder;
  std::string integrator = GENERATE("pssmlt", "path");
  CAPTURE(integrator);
  const ProgramResult first =
      folder.run({"render", "scene.txt", "--integrator", integrator,   "--spp",     "6",  "--depth",
                  "4",      "--seed",    "77",           "--roulette", "3",         "-o", "a.png",
                  "-o",     "a.pfm",     "--stats",      "a.json",     "--threads", "2"});
  REQUIRE(first.code == code_of(ExitCode::kOk));
  const auto a = read_statistics(folder / "a.json");
  for (const char* key : {"film_hash",
                          "wall_seconds",
                          "cpu_seconds",
                          "samples",
                          "mutations",
                          "b",
                          "b_standard_error",
                          "acceptance_large",
                          "acceptance_small",
                          "rejected_non_finite",
                          "rejected_nan",
                          "rejected_infinite",
                          "rejected_negative",
                          "longest_rejection_run",
                          "peak_memory_bytes",
                          "planned_memory_bytes",
                          "minor_faults",
                          "partial",
                          "seed",
                          "chains",
                          "step_size",
                          "depth",
                          "width",
                          "height",
                          "integrator",
                          "version",
                          "command"}) {
    CAPTURE(key);
    CHECK(a.count(key) == 1);
  }
  CHECK(a.at("film_hash").size() == 66);
  CHECK(a.at("partial") == "false");
  CHECK(a.at("seed") == "77");
  CHECK(a.at("rejected_non_finite") == "0");
  CHECK(std::stod(a.at("b")) > 0);
  CHECK(std::stoull(a.at("peak_memory_bytes")) >= std::stoull(a.at("planned_memory_bytes")));
  // The summary names the same hash.
  CHECK_THAT(first.error, Catch::Contains(a.at("film_hash").substr(1, 64)));

  const std::string command = a.at("command");
  REQUIRE(command.starts_with("\"mlt render "));
  const ProgramResult second =
      run_shell("\"$MLT\" " + command.substr(5, command.size() - 6) + " -q -o b.png -o b.pfm --stats b.json",
                folder.path().string());
  CHECK(second.error == "");
  REQUIRE(second.code == code_of(ExitCode::kOk));
  CHECK(read_statistics(folder / "b.json").at("film_hash") == a.at("film_hash"));
  CHECK(read_text(folder / "b.pfm") == read_text(folder / "a.pfm"));
  CHECK(read_text(folder / "b.png") == read_text(folder / "a.png"));
}

TEST_CASE("PNGs carry what reproduces them") {
  const SceneFolder folder;
  REQUIRE(folder
              .run({"render", "scene.txt", "--integrator", "pssmlt", "--mutations", "2", "--seed", "5",
                    "--exposure", "1.5", "-q"})
              .code == 0);
  const std::string png = read_text(folder / "scene.png");
  for (const char* entry : {"Software", "Version", "Film-Hash", "sRGB"})
    CHECK_THAT(png, Catch::Contains(entry));
  // A keyword and its text are separated by a null byte.
  CHECK_THAT(png, Catch::Contains(std::string("Seed\0005", 6)));
  CHECK_THAT(png, Catch::Contains(std::string("Partial\0no", 10)));
  CHECK_THAT(png, Catch::Contains(std::string("Command\0mlt render scene.txt --integrator pssmlt", 48)));
  CHECK_THAT(png, Catch::Contains("--exposure 1.5"));
}

TEST_CASE("an image of one pixel, and one of one row, are rendered") {
  const SceneFolder folder;
  for (const char* integrator : {"path", "pssmlt"}) {
    const ProgramResult result =
        folder.run({"render", "scene.txt", "--width", "1", "--height", "1", "--integrator", integrator,
                    "--spp", "16", "-q", "-o", "one.pfm"});
    CHECK(result.error == "");
    CHECK(result.code == code_of(ExitCode::kOk));
    const LoadedImage image = read_pfm(folder / "one.pfm");
    CHECK(image.image.width == 1);
    CHECK(image.image.pixels[0].x > 0);
  }
  CHECK(folder.run({"render", "scene.txt", "--width", "33", "--height", "1", "--depth", "1", "-q"}).code ==
        0);
}

TEST_CASE("pitfall 6: a scene without light renders black with a warning and exits with 0") {
  const SceneFolder folder;
  for (const char* integrator : {"path", "pssmlt"}) {
    const ProgramResult result = folder.run(
        {"render", "dark.txt", "--integrator", integrator, "--spp", "2", "-o", "d.pfm", "--stats", "d.json"});
    CHECK(result.code == code_of(ExitCode::kOk));
    CHECK_THAT(result.error, Catch::Contains("warning") && Catch::Contains("black"));
    const LoadedImage image = read_pfm(folder / "d.pfm");
    CHECK(image.non_finite == 0);
    for (const Vec3& pixel : image.image.pixels) CHECK(is_zero(pixel));
    const auto statistics = read_statistics(folder / "d.json");
    CHECK(statistics.at("black") == "true");
    CHECK(statistics.at("b") == "0");
  }
}

TEST_CASE("--quiet silences everything but warnings, and without a terminal there is no progress line") {
  const SceneFolder folder;
  CHECK(folder.run({"render", "scene.txt", "--integrator", "pssmlt", "--mutations", "2", "--quiet"}).error ==
        "");
  const ProgramResult result =
      folder.run({"render", "scene.txt", "--integrator", "pssmlt", "--mutations", "2"});
  CHECK_THAT(result.error, !Catch::Contains("ETA"));
  for (const char* fragment :
       {"time", "rate", "acceptance, large", "acceptance, small", "longest rejection run", "b ",
        "rejected non-finite", "film hash", "wrote", "scene.png"}) {
    CHECK_THAT(result.error, Catch::Contains(fragment));
  }
  const ProgramResult path =
      folder.run({"render", "scene.txt", "--spp", "2", "--integrator", "path", "--chains", "3"});
  CHECK(path.code == code_of(ExitCode::kOk));
  CHECK_THAT(path.error, Catch::Contains("warning: --chains: has no effect with --integrator path"));
}

TEST_CASE("an interrupted render writes what it has, marked partial, and exits with 75") {
  const SceneFolder folder;
  struct Row {
    int signal;
    std::vector<std::string> job;
  };
  // Jobs of an hour or so, in chains and pixel blocks of a fraction of a second.
  const Row rows[] = {
      {SIGINT, {"--mutations", "30000000", "--chains", "1000000", "--bootstrap", "1000"}},
      {SIGTERM, {"--integrator", "path", "--spp", "10000", "--width", "2048", "--height", "2048"}},
  };
  for (const Row& row : rows) {
    std::vector<std::string> words{"render", "scene.txt", "--threads", "2",       "-o",
                                   "p.png",  "-o",        "p.pfm",     "--stats", "p.json"};
    words.insert(words.end(), row.job.begin(), row.job.end());
    const pid_t process = start_mlt(words, folder.path().string());
    REQUIRE(wait_until_caught(process, row.signal));
    ::kill(process, row.signal);
    CHECK(wait_for(process) == code_of(ExitCode::kInterrupted));
    CHECK(folder.outputs() == "error out p.json p.pfm p.png");
    CHECK(read_statistics(folder / "p.json").at("partial") == "true");
    CHECK_THAT(read_text(folder / "p.png"), Catch::Contains(std::string("Partial\0yes", 11)));
    CHECK(read_pfm(folder / "p.pfm").non_finite == 0);
    CHECK_THAT(read_text(folder / "error"), Catch::Contains("partial"));
  }
}

TEST_CASE("a film of 256 x 256 pixels and four threads take less than 16 MB in all") {
  const SceneFolder folder;
  const ProgramResult result = folder.run({"render", "scene.txt", "--integrator", "pssmlt", "--width", "256",
                                           "--height", "256", "--threads", "4", "--mutations", "1",
                                           "--bootstrap", "1048576", "--stats", "a.json", "-o", "a.png"});
  REQUIRE(result.code == code_of(ExitCode::kOk));
  const auto statistics = read_statistics(folder / "a.json");
  // The arena with the largest bootstrap that is taken unasked, and 9 MB of program and libraries: how
  // much of their files is resident differs by a megabyte between kernels, which count pages in batches.
  CHECK(std::stoull(statistics.at("planned_memory_bytes")) < 7'300'000);
  if (MLT_FAULTS_ARE_OURS) CHECK(std::stoull(statistics.at("peak_memory_bytes")) < 16 << 20);
}

TEST_CASE("the largest pilot needs little more memory than a render") {
  if (!MLT_FAULTS_ARE_OURS) return;
  const SceneFolder folder;
  const auto peak = [&folder](const std::string& integrator, const std::string& samples) {
    const ProgramResult result =
        folder.run({"render", "scene.txt", "--integrator", integrator, "--width", "256", "--height", "256",
                    "--threads", "4", "--spp", samples, "--stats", "a.json", "-o", "a.png"});
    REQUIRE(result.code == code_of(ExitCode::kOk));
    return std::stoull(read_statistics(folder / "a.json").at("peak_memory_bytes"));
  };
  // More samples make no larger pilot. Its chains have a film of the job's size; four images of 15 kilopixels
  // and what compares them take 1.1 MB, files that are resident in batches of pages the rest.
  CHECK(peak("auto", "256") < peak("pssmlt", "1") + 1'500'000);
}

TEST_CASE("info prints what was read, features, and the plan with its total") {
  const SceneFolder folder;
  const ProgramResult result = folder.run(
      {"info", "scene.txt", "--integrator", "pssmlt", "--width", "100", "--height", "50", "--threads", "3"});
  CHECK(result.code == code_of(ExitCode::kOk));
  CHECK(result.error == "");
  for (const char* fragment : {"100 x 50", "features found", "features skipped", "3, one for each worker",
                               "memory plan", "total", "--memory"}) {
    CHECK_THAT(result.out, Catch::Contains(fragment));
  }
  CHECK(folder.outputs() == "");
}

}  // namespace
}  // namespace mlt
