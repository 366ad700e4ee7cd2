#include <catch2/catch.hpp>
#include <sstream>

#include "app/options.hpp"
#include "app/version.hpp"
#include "image/format.hpp"
#include "program.hpp"

namespace mlt {
namespace {

ProgramResult run(const std::vector<std::string>& words) {
  const TemporaryFolder folder;
  return run_mlt(words, folder.path().string());
}

TEST_CASE("the help names every option, command, format, integrator, start and exit code") {
  const ProgramResult result = run({"--help"});
  CHECK(result.code == code_of(ExitCode::kOk));
  CHECK(result.error == "");
  for (const OptionSpec& option : option_table()) {
    const std::string label = "  " + (option.short_name.empty() ? "" : option.short_name + ", ") +
                              option.name + (option.value.empty() ? "" : " " + option.value);
    CHECK_THAT(result.out, Catch::Contains(label));
    CHECK(option.help.size() > 10);
  }
  for (const auto* kinds : {&integrator_kinds(), &start_kinds(), &mutation_kinds(), &instruction_sets()}) {
    for (const NamedKind& kind : *kinds) CHECK_THAT(result.out, Catch::Contains(kind.name + ":"));
  }
  for (const std::string& name : command_names())
    CHECK_THAT(result.out, Catch::Contains("\n  " + name + " "));
  for (const int code : {0, 1, 2, 3, 70, 75}) {
    CHECK_THAT(result.out, Catch::Contains("\n  " + std::to_string(code) + "  "));
  }
  CHECK_THAT(result.out, Catch::Contains(".png:") && Catch::Contains(".pfm:"));
  CHECK_THAT(result.out, Catch::Contains("mlt WIDTH HEIGHT MUTATIONS THREADS DEPTH SCENE"));
  std::istringstream lines(result.out);
  for (std::string line; std::getline(lines, line);) {
    CAPTURE(line);
    CHECK(line.size() <= 100);
    CHECK((line.empty() || line.back() != ' '));
  }
}

TEST_CASE("the issue's options all exist") {
  // Written out, so that an option lost from the table is noticed.
  const std::string help = run({"help", "render"}).out;
  for (const char* name :
       {"-o, --output FILE", "--integrator NAME", "--spp N",       "--mutations N",   "--width N",
        "--height N",        "--depth N",         "--threads N",   "--seed N",        "--chains N",
        "--bootstrap N",     "--large-step P",    "--start NAME",  "--mutation NAME", "--roulette N|off",
        "--step-size X",     "--isa NAME",        "--memory SIZE", "--exposure EV",   "--quiet",
        "--stats FILE"}) {
    CHECK_THAT(help, Catch::Contains(std::string("  ") + name) || Catch::Contains(std::string(", ") + name));
  }
}

TEST_CASE("every command explains itself in two ways") {
  for (const std::string& name : command_names()) {
    const ProgramResult first = run({"help", name});
    const ProgramResult second = run({name, "--help"});
    CAPTURE(name);
    CHECK(first.code == code_of(ExitCode::kOk));
    CHECK(second.code == code_of(ExitCode::kOk));
    CHECK(first.out == second.out);
    CHECK_THAT(first.out, Catch::Contains("mlt " + name));
  }
  CHECK(run({"help"}).out == run({"--help"}).out);
  CHECK(run({"-h"}).out == run({"--help"}).out);
}

TEST_CASE("the version is printed") {
  const ProgramResult result = run({"--version"});
  CHECK(result.code == code_of(ExitCode::kOk));
  CHECK(result.out == std::string("mlt ") + kVersion + "\n");
}

}  // namespace
}  // namespace mlt
