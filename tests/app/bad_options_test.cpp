#include <catch2/catch.hpp>

#include "program.hpp"

namespace mlt {
namespace {

struct Row {
  std::vector<std::string> words;
  std::vector<std::string> fragments;  ///< of standard error: the option, what was found, what is allowed
};

/// `mlt render scene.txt` with more words.
std::vector<std::string> render(const std::vector<std::string>& more) {
  std::vector<std::string> words{"render", "scene.txt"};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

void check_refused(const std::vector<Row>& rows) {
  const SceneFolder folder;
  for (const Row& row : rows) {
    std::string line = "mlt";
    for (const std::string& word : row.words) line += " " + word;
    CAPTURE(line);
    const ProgramResult result = folder.run(row.words);
    CHECK(result.code == code_of(ExitCode::kBadInput));
    for (const std::string& fragment : row.fragments) CHECK_THAT(result.error, Catch::Contains(fragment));
    CHECK(result.out == "");
    CHECK(folder.outputs() == "");
  }
}

TEST_CASE("numbers out of range or not numbers are refused with option, found and allowed") {
  const std::string sides = "an integer from 1 to 65536";
  check_refused({
      {render({"--width", "0"}), {"--width: found '0'; expected " + sides}},
      {render({"--width", "65537"}), {"--width: found '65537'; expected " + sides}},
      {render({"--width", "4294967297"}), {"--width: found '4294967297'"}},
      {render({"--width", "99999999999999999999999"}), {"--width: found '99999999999999999999999'"}},
      {render({"--width", "8x"}), {"--width: found '8x'"}},
      {render({"--width", " 8"}), {"--width: found ' 8'"}},
      {render({"--width", "+8"}), {"--width: found '+8'"}},
      {render({"--width", "0x8"}), {"--width: found '0x8'"}},
      {render({"--width", "8.5"}), {"--width: found '8.5'"}},
      {render({"--width", "1e2"}), {"--width: found '1e2'"}},
      {render({"--width", ""}), {"--width: found ''"}},
      {render({"--height", "-1"}), {"--height: found '-1'; expected " + sides}},
      {render({"--height=nan"}), {"--height: found 'nan'; expected " + sides}},
      {render({"--depth", "0"}), {"--depth: found '0'; expected an integer from 1 to 256"}},
      {render({"--depth", "1000"}), {"--depth: found '1000'; expected an integer from 1 to 256"}},
      {render({"--threads", "0"}), {"--threads: found '0'; expected an integer from 1 to 1024"}},
      {render({"--threads", "1025"}), {"--threads: found '1025'"}},
      {render({"--seed", "-1"}), {"--seed: found '-1'; expected an integer from 0 to 18446744073709551615"}},
      {render({"--seed", "18446744073709551616"}), {"--seed: found '18446744073709551616'"}},
      {render({"--spp", "0"}), {"--spp: found '0'; expected an integer from 1 to"}},
      {render({"--mutations", "0"}), {"--mutations: found '0'; expected an integer from 1 to"}},
      {render({"--mutations", "1e999"}), {"--mutations: found '1e999'"}},
      {render({"--chains", "0"}), {"--chains: found '0'; expected an integer from 1 to"}},
      {render({"--bootstrap", "0"}), {"--bootstrap: found '0'; expected an integer from 1 to"}},
      {render({"--large-step", "nan"}), {"--large-step: found 'nan'; expected a number from 0 to 1"}},
      {render({"--large-step", "inf"}), {"--large-step: found 'inf'; expected a number from 0 to 1"}},
      {render({"--large-step", "1.01"}), {"--large-step: found '1.01'"}},
      {render({"--large-step", "-0.1"}), {"--large-step: found '-0.1'"}},
      {render({"--large-step", "0,5"}), {"--large-step: found '0,5'"}},
      {render({"--step-size", "0"}), {"--step-size: found '0'; expected a number from 0.0009765625 to 16"}},
      {render({"--step-size", "16.01"}), {"--step-size: found '16.01'"}},
      {render({"--exposure", "nan"}), {"--exposure: found 'nan'; expected a number from -64 to 64"}},
      {render({"--exposure", "1e999"}), {"--exposure: found '1e999'"}},
      {render({"--roulette", "0"}), {"--roulette: found '0'; expected 'off' or an integer from 1 to 256"}},
      {render({"--roulette", "on"}), {"--roulette: found 'on'"}},
      {render({"--memory", "0"}), {"--memory: found '0'; expected a number of bytes such as 512M"}},
      {render({"--memory", "5Q"}), {"--memory: found '5Q'"}},
      {render({"--memory", "M"}), {"--memory: found 'M'"}},
      {render({"--memory", "16777216T"}), {"--memory: found '16777216T'"}},
      {render({"--memory", "1.5G"}), {"--memory: found '1.5G'"}},
      {render({"--width", std::string(100000, '9')}), {"--width: found '9999", "...'; expected " + sides}},
  });
}

TEST_CASE("words that are not known get the nearest valid ones") {
  check_refused({
      {{"rendr", "scene.txt"},
       {"unknown command 'rendr'", "did you mean 'render'", "info, compare, converge, report, help"}},
      {{"zzzzzzzz"}, {"unknown command 'zzzzzzzz'", "render, info, compare, converge, report, help"}},
      {{"--verson"}, {"unknown option '--verson'", "did you mean '--version'"}},
      {{"help", "rendr"}, {"did you mean 'render'"}},
      {{"help", "render", "info"}, {"one word too many, 'info'"}},
      {{}, {"no command given", "render, info, compare, converge, report, help"}},
      {{""}, {"unknown command ''"}},
      {{"scene.txt"}, {"expected 'mlt render scene.txt'"}},
      {render({"--sede", "1"}), {"--sede: unknown option", "did you mean '--seed'"}},
      {render({"--mutation-count=5"}), {"--mutation-count: unknown option"}},
      {render({"-x"}), {"-x: unknown option", "mlt render --help"}},
      {render({"--integrator", "psmlt"}),
       {"--integrator: found 'psmlt'", "did you mean 'pssmlt'", "path, pssmlt"}},
      {render({"--integrator", "PATH"}), {"--integrator: found 'PATH'", "path, pssmlt"}},
      {render({"--start", "first_hit"}),
       {"--start: found 'first_hit'", "did you mean 'first-hit'", "resampled"}},
      {render({"--mutation", "gausian"}),
       {"--mutation: found 'gausian'", "did you mean 'gaussian'", "kelemen"}},
      {render({"--isa", "avx3"}), {"--isa: found 'avx3'", "did you mean 'avx2'", "base, avx2"}},
      {{"info", "scene.txt", "--stats", "x"}, {"--stats: unknown option"}},
      {{"info", "scene.txt", "-o", "x.png"}, {"-o: unknown option"}},
      {{"compare", "a.pfm", "b.pfm", "--max-relms", "1"}, {"--max-relms: unknown option", "'--max-relmse'"}},
      {{"compare", "a.pfm", "b.pfm", "--max-relmse", "nan"},
       {"--max-relmse: found 'nan'; expected a number from 0"}},
      {{"compare", "a.pfm", "b.pfm", "--flip", "sdr"}, {"--flip: found 'sdr'", "ldr, hdr"}},
      {{"compare", "a.pfm", "b.pfm", "--heat-metric", "relmes"},
       {"--heat-metric: found 'relmes'", "did you mean 'relmse'", "mean_error"}},
      {{"compare", "a.pfm", "b.pfm", "--pixels-per-degree", "0.5"},
       {"--pixels-per-degree: found '0.5'; expected a number from 1 to 1000"}},
      {{"compare", "a.pfm", "b.pfm", "--heat-range", "0"}, {"--heat-range: found '0'"}},
      {{"compare", "a.pfm", "b.pfm", "--alpha", "0.1"}, {"--alpha: has a meaning only together with --test"}},
      {{"compare", "--test", "a.pfm", "b.pfm"}, {"found 2 and 0 images", "-- B1 B2"}},
      {{"compare", "--test", "a.pfm", "b.pfm", "--", "c.pfm"}, {"found 2 and 1 images"}},
      {{"compare", "--test", "a", "b", "--", "c", "d", "--max-mse", "1", "--tile", "0", "--alpha", "1"},
       {"--max-mse: has no meaning together with --test", "--tile: found '0'", "--alpha: found '1'"}},
      {{"compare", "--test", "a", "b", "--", "c", "d", "--tiel", "3"},
       {"--tiel: unknown option", "'--tile'"}},
      {{"compare", "a.pfm", "b.pfm", "--max-relmse", "-1"}, {"--max-relmse: found '-1'"}},
  });
}

TEST_CASE("missing, doubled and surplus words are refused") {
  check_refused({
      {{"render"}, {"mlt render: SCENE is missing; expected mlt render SCENE"}},
      {{"info"}, {"mlt info: SCENE is missing"}},
      {{"compare", "a.pfm"}, {"mlt compare: B is missing; expected mlt compare A B"}},
      {{"compare", "a", "b", "c"}, {"one word too many, 'c'"}},
      {render({"other.txt"}), {"one word too many, 'other.txt'"}},
      {render({"--spp"}), {"--spp: found no value; expected --spp N"}},
      {render({"-o"}), {"--output: found no value; expected --output FILE"}},
      {render({"--spp", "1", "--spp", "2"}), {"--spp: found 2 times; expected once"}},
      {render({"--spp", "1", "--mutations", "2"}), {"--mutations: found together with --spp"}},
      {render({"--quiet=3"}), {"quiet", "mlt render --help"}},
      {{"500", "500", "10", "4", "5"},
       {"SCENE is missing; expected mlt WIDTH HEIGHT MUTATIONS THREADS DEPTH SCENE"}},
      {{"500"}, {"HEIGHT is missing", "MUTATIONS is missing", "THREADS is missing", "DEPTH is missing"}},
      {{"8", "8", "1", "1", "5", "scene.txt", "more"}, {"one word too many, 'more'"}},
      {{"8", "8", "0", "0", "0", "scene.txt"},
       {"MUTATIONS: found '0'", "THREADS: found '0'", "DEPTH: found '0'"}},
      {{"8", "8", "1", "1", "1000", "scene.txt"}, {"DEPTH: found '1000'; expected an integer from 1 to 256"}},
      {{"8x", "8", "1", "1", "5", "scene.txt"}, {"WIDTH: found '8x'"}},
      {{"-8", "8", "1", "1", "5", "scene.txt"}, {"WIDTH: found '-8'; expected an integer from 1 to 65536"}},
  });
}

TEST_CASE("all faults of a command line are reported at once") {
  const SceneFolder folder;
  const ProgramResult result = folder.run(
      {"render", "--width", "0", "--depth", "x", "--start", "y", "--memory", "z", "--exposure", "w"});
  CHECK(result.code == code_of(ExitCode::kBadInput));
  for (const char* fragment :
       {"SCENE is missing", "--width", "--depth", "--start", "--memory", "--exposure"}) {
    CHECK_THAT(result.error, Catch::Contains(fragment));
  }
}

TEST_CASE("scenes that cannot be read are named") {
  const SceneFolder folder;
  for (const char* command : {"render", "info"}) {
    const ProgramResult result = folder.run({command, "missing.txt"});
    CHECK(result.code == code_of(ExitCode::kBadInput));
    CHECK_THAT(result.error, Catch::Contains("missing.txt"));
  }
  write_text(folder / "scene.txt", "film 8 8\nspere 0 0 0 1\n");
  const ProgramResult result = folder.run({"render", "scene.txt"});
  CHECK(result.code == code_of(ExitCode::kBadInput));
  CHECK_THAT(result.error, Catch::Contains("scene.txt:2:1: "));
  CHECK(folder.outputs() == "");
}

}  // namespace
}  // namespace mlt
