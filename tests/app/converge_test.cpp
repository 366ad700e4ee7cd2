// `mlt converge` and `mlt report` through the binary, on a room of 8 x 8 pixels.
#include <fmt/core.h>
#include <signal.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <sstream>

#include "converge/summary.hpp"
#include "image/image_io.hpp"
#include "program.hpp"

namespace mlt {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> converge(const std::vector<std::string>& more) {
  std::vector<std::string> words{"converge", "scene.txt", "--threads",   "1",
                                 "--chains", "2",         "--bootstrap", "64"};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

std::string names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : " ") + name;
  return text;
}

std::vector<std::vector<std::string>> read_csv(const std::string& path) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(read_text(path));
  for (std::string line; std::getline(lines, line);) {
    std::vector<std::string> fields;
    std::istringstream stream(line);
    for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
    rows.push_back(fields);
  }
  return rows;
}

void make_reference(const SceneFolder& folder) {
  REQUIRE(folder.run({"render", "scene.txt", "--integrator", "path", "--spp", "512", "-q", "-o", "ref.pfm"})
              .code == 0);
}

TEST_CASE("converge measures against a reference and report makes a page of it") {
  const SceneFolder folder;
  make_reference(folder);
  const ProgramResult result =
      folder.run(converge({"--reference", "ref.pfm", "--budgets", "2,8,32", "--replicates", "4", "--target",
                           "0.05", "-o", "results/room"}));
  CAPTURE(result.error, result.out);
  REQUIRE(result.code == code_of(ExitCode::kOk));
  const fs::path results = folder.path() / "results" / "room";
  CHECK(names_in(results) ==
        "converge.csv path.difference.png path.error.png path.mean.png path.png processor_time.svg "
        "pssmlt.difference.png pssmlt.error.png pssmlt.mean.png pssmlt.png reference.png samples.svg "
        "summary.json time.svg");
  CHECK_THAT(result.out, Catch::Contains("path: slope over time") && Catch::Contains("relMSE 0.05 after"));
  CHECK_THAT(result.error, Catch::Contains("replicate 4 of 4 done") && Catch::Contains("ref.variance.pfm"));

  const auto rows = read_csv((results / "converge.csv").string());
  REQUIRE(rows.size() == 1 + 2 * 3 * 4);
  CHECK(rows[0][1] == "method");
  for (const auto& row : rows) CHECK(row.size() == 14);
  // The last row can be rendered again from what it says.
  const std::vector<std::string>& last = rows.back();
  const ProgramResult again =
      folder.run({"render", "scene.txt", "--integrator", last[1], "--spp", last[3], "--seed", last[5],
                  "--chains", "2", "--bootstrap", "64", "-o", "again.pfm", "--stats", "again.json"});
  REQUIRE(again.code == 0);
  CHECK_THAT(read_text(folder / "again.json"), Catch::Contains(last[13]));
  // `compare` adds the same numbers in another order; its nine digits are more than the sum's rounding.
  const std::string compared = folder.run({"compare", "again.pfm", "ref.pfm"}).out;
  const std::size_t at = compared.find("relMSE");
  REQUIRE(at != std::string::npos);
  CHECK(std::stod(compared.substr(at + 6)) == Approx(std::stod(last[10])).epsilon(1e-6));

  const std::string json = (results / "summary.json").string();
  const ConvergeSummary summary = summary_from_json(read_text(json), json);
  REQUIRE(summary.methods.size() == 2);
  CHECK(summary.methods[0].levels.size() == 3);
  CHECK(summary.methods[0].levels[2].rel_mse_median < summary.methods[0].levels[0].rel_mse_median);
  CHECK_THAT(read_text((results / "time.svg").string()), Catch::Contains("wall time"));

  const ProgramResult report = folder.run({"report", "results"});
  CAPTURE(report.error);
  REQUIRE(report.code == code_of(ExitCode::kOk));
  CHECK(report.out == "results/report.html\n");
  const std::string page = read_text((folder.path() / "results" / "report.html").string());
  CHECK_THAT(page,
             Catch::Contains("<!DOCTYPE html>") && Catch::Contains("pssmlt") && Catch::Contains("</html>"));
}

TEST_CASE("converge without a reference says so") {
  const SceneFolder folder;
  const ProgramResult result = folder.run(
      converge({"--integrators", "pssmlt", "--budgets", "2,8", "--replicates", "3", "-q", "-o", "."}));
  CHECK(result.code == code_of(ExitCode::kOk));
  CHECK_THAT(result.error, Catch::Contains("without --reference the error is the variance over replicates"));
  CHECK_THAT(read_text(folder / "summary.json"), Catch::Contains("\"reference\": \"\""));
  CHECK(folder.run({"report", "."}).code == 0);
}

TEST_CASE("converge tells of options that none of its methods looks at") {
  const SceneFolder folder;
  const ProgramResult result =
      folder.run(converge({"--integrators", "path", "--budgets", "2", "--replicates", "2", "-q", "-o", "."}));
  CHECK(result.code == code_of(ExitCode::kOk));
  CHECK_THAT(result.error, Catch::Contains("--chains: has no effect on any of the methods"));
}

TEST_CASE("methods of one integrator stand side by side under their settings") {
  const SceneFolder folder;
  const ProgramResult result = folder.run(
      converge({"--method", "pssmlt  --step-size=4 --chains 3", "--method", "path --roulette off", "--method",
                "path --start first-hit", "--budgets", "2", "--replicates", "2", "-q", "-o", "results"}));
  CAPTURE(result.error);
  REQUIRE(result.code == code_of(ExitCode::kOk));
  CHECK_THAT(
      result.error,
      Catch::Contains("--method 'path --start first-hit': --start: has no effect with --integrator path"));
  const std::string name = "pssmlt --chains 3 --step-size 4";
  CHECK_THAT(result.out, Catch::Contains(name + ": efficiency against path --roulette off"));
  const auto rows = read_csv(folder / "results/converge.csv");
  REQUIRE(rows.size() == 1 + 3 * 2);
  CHECK(rows[1][1] == name);
  // The settings of the whole command hold where the method has none of its own.
  const ProgramResult again =
      folder.run({"render", "scene.txt", "--spp", "2", "--seed", rows[1][5], "--chains", "3", "--step-size",
                  "4", "--bootstrap", "64", "-o", "again.pfm", "--stats", "again.json"});
  REQUIRE(again.code == 0);
  CHECK_THAT(read_text(folder / "again.json"), Catch::Contains(rows[1][13]));
  const std::string json = read_text(folder / "results/summary.json");
  CHECK_THAT(json,
             Catch::Contains("--method 'pssmlt --chains 3 --step-size 4' --method 'path --roulette off'") &&
                 Catch::Contains("\"method\": \"" + name + "\"") &&
                 Catch::Contains("\"efficiency_base\": \"path --roulette off\""));
  CHECK(fs::exists(folder.path() / "results" / "pssmlt_--chains_3_--step-size_4.png"));
  REQUIRE(folder.run({"report", "results"}).code == 0);
  CHECK_THAT(read_text(folder / "results/report.html"), Catch::Contains(name));
}

TEST_CASE("converge chooses budgets for times") {
  const SceneFolder folder;
  const ProgramResult result =
      folder.run(converge({"--times", "0.001,0.004", "--replicates", "2", "-q", "-o", "out"}));
  CAPTURE(result.error);
  CHECK(result.code == code_of(ExitCode::kOk));
  CHECK(read_csv(folder / "out/converge.csv").size() == 1 + 2 * 2 * 2);
}

TEST_CASE("what converge cannot do is refused with the option's name, and leaves nothing") {
  const SceneFolder folder;
  make_reference(folder);
  const std::string before = folder.outputs();
  struct Row {
    std::vector<std::string> words;
    std::string fragment;
    ExitCode code = ExitCode::kBadInput;
  };
  const Row rows[] = {
      {{}, "--output: is missing"},
      {{"-o", "out", "--integrators", "path,psmlt"}, "--integrators: found 'psmlt'"},
      {{"-o", "out", "--integrators", "psmlt"}, "did you mean 'pssmlt'"},
      {{"-o", "out", "--integrators", ""}, "--integrators: found ''"},
      {{"-o", "out", "--integrators", "path,path"}, "each method once"},
      {{"-o", "out", "--method", "psmlt"}, "--method: found 'psmlt', did you mean 'pssmlt'"},
      {{"-o", "out", "--method", " "}, "--method: found ''"},
      {{"-o", "out", "--method", "path path"}, "--method: found 'path'; expected settings"},
      {{"-o", "out", "--method", "pssmlt --large-step 2"},
       "--method 'pssmlt --large-step 2': --large-step: found '2'; expected a number from 0 to 1"},
      {{"-o", "out", "--method", "pssmlt --larg-step 1"},
       "--larg-step: unknown option, did you mean '--large-step'"},
      {{"-o", "out", "--method", "pssmlt --chains"}, "--chains: found no value; expected --chains N"},
      {{"-o", "out", "--method", "path --depth 4"}, "--depth: unknown option"},
      {{"-o", "out", "--method", "path --roulette=4", "--method", "path  --roulette 4"}, "each method once"},
      {{"-o", "out", "--method", "path", "--integrators", "path"},
       "--method: found together with --integrators"},
      {{"-o", "out", "--budgets", "0,1"}, "--budgets: found '0'; expected an integer from 1"},
      {{"-o", "out", "--budgets", "-4"}, "--budgets: found '-4'"},
      {{"-o", "out", "--budgets", "4,2"}, "--budgets: found '4,2'; expected numbers that increase"},
      {{"-o", "out", "--budgets", "1,,2"}, "--budgets: found ''"},
      {{"-o", "out", "--times", "0"}, "--times: found '0'; expected a number from"},
      {{"-o", "out", "--times", "nan"}, "--times: found 'nan'"},
      {{"-o", "out", "--times", "1", "--budgets", "1"}, "--times: found together with --budgets"},
      {{"-o", "out", "--replicates", "0", "--reference", "ref.pfm"},
       "--replicates: found '0'; expected an integer from 1"},
      {{"-o", "out", "--replicates", "1"}, "--replicates: found '1'; expected an integer from 2"},
      {{"-o", "out", "--target", "0"}, "--target: found '0'"},
      {{"-o", "out", "--reference", "none.pfm"}, "none.pfm: cannot be read"},
      {{"-o", "out", "--reference", "scene.txt"}, "scene.txt: starts with"},
      {{"-o", "out", "--reference", "ref.pfm", "--width", "9"}, "--width: found 9; expected 8 as in ref.pfm"},
      {{"-o", "out", "--reference", "ref.pfm", "--height", "7"}, "--height: found 7; expected 8"},
      {{"-o", "scene.txt"}, "--output: 'scene.txt' is not a folder"},
      {{"-o", "scene.txt/out"}, "--output: 'scene.txt/out' cannot be made"},
      {{"-o", "out", "--spp", "4"}, "--spp: unknown option"},
      {{"-o", "out", "--replicate", "4"}, "did you mean '--replicates'"},
      {{"-o", "out", "more"}, "found one word too many, 'more'"},
      {{"-o", "out", "--memory", "1K"}, "memory", ExitCode::kResourceLimit},
      {{"-o", "out", "--budgets", "1000000000"}, "budget 1000000000 of pssmlt", ExitCode::kResourceLimit},
  };
  for (const Row& row : rows) {
    const ProgramResult result = folder.run(converge(row.words));
    CAPTURE(row.fragment);
    CHECK(result.code == code_of(row.code));
    CHECK_THAT(result.error, Catch::Contains(row.fragment));
    CHECK(result.out == "");
    CHECK(folder.outputs() == before);
  }
}

TEST_CASE("report refuses what it cannot read or write") {
  const SceneFolder folder;
  CHECK_THAT(folder.run({"report"}).error, Catch::Contains("DIR is missing; expected mlt report DIR"));
  CHECK_THAT(folder.run({"report", "none"}).error, Catch::Contains("none: is not a folder"));
  CHECK_THAT(folder.run({"report", "."}).error, Catch::Contains("holds no summary.json"));
  write_text(folder / "summary.json", "{\"version\": 1}");
  const ProgramResult bad = folder.run({"report", "."});
  CHECK(bad.code == code_of(ExitCode::kBadInput));
  CHECK_THAT(bad.error, Catch::Contains("./summary.json: is not a summary"));
  CHECK_THAT(folder.run({"report", ".", "-o", "scene.txt"}).error,
             Catch::Contains("--output: found 'scene.txt'"));
  CHECK(folder.outputs() == "summary.json");
}

TEST_CASE("a converge that is interrupted writes complete replicates or nothing") {
  const SceneFolder folder;
  const pid_t process = start_mlt(converge({"--budgets", "1000000", "--replicates", "2", "-o", "results"}),
                                  folder.path().string());
  REQUIRE(wait_until_caught(process, SIGTERM));
  ::kill(process, SIGTERM);
  CHECK(wait_for(process) == code_of(ExitCode::kInterrupted));
  CHECK_THAT(read_text(folder / "error"), Catch::Contains("nothing is written"));
  CHECK_FALSE(fs::exists(folder.path() / "results"));
}

}  // namespace
}  // namespace mlt
