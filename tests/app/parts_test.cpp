#include <catch2/catch.hpp>
#include <limits>

#include "app/command_line.hpp"
#include "app/console.hpp"
#include "app/json.hpp"
#include "app/number.hpp"
#include "app/options.hpp"
#include "app/record.hpp"
#include "base/error.hpp"

namespace mlt {
namespace {

std::string progress_text(std::uint64_t done, std::uint64_t total, double seconds, std::size_t size = 160) {
  std::string buffer(size, '#');
  const std::size_t used = format_progress({done, total, seconds}, "mutations", std::span<char>(buffer));
  REQUIRE(used <= size);
  return buffer.substr(0, used);
}

TEST_CASE("the progress line shows share, rate and remaining time") {
  CHECK(progress_text(0, 1000, 0) == "0.0 %  0.00 mutations/s  ETA -");
  CHECK(progress_text(421, 1000, 1) == "42.1 %  421.00 mutations/s  ETA 0:01");
  CHECK(progress_text(1'270'000, 3'000'000, 1) == "42.3 %  1.27 M mutations/s  ETA 0:01");
  CHECK(progress_text(1000, 7'400'000, 1) == "0.0 %  1.00 k mutations/s  ETA 2:03:19");
  CHECK(progress_text(5'000'000'000, 10'000'000'000, 1) == "50.0 %  5.00 G mutations/s  ETA 0:01");
  CHECK(progress_text(10, 10, 2) == "100.0 %  5.00 mutations/s  ETA 0:00");
}

TEST_CASE("the progress line survives any numbers and any buffer") {
  const std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const std::uint64_t done : {std::uint64_t{0}, std::uint64_t{1}, most}) {
    for (const std::uint64_t total : {std::uint64_t{0}, std::uint64_t{1}, most}) {
      for (const double seconds : {0.0, -1.0, 1e-300, 1e300, nan, infinity}) {
        for (const std::size_t size : {0, 1, 20, 40, 160}) progress_text(done, total, seconds, size);
      }
    }
  }
  CHECK(progress_text(1, 2, 1, 5) == "50.0 ");
}

TEST_CASE("sizes in bytes take factors of 1024") {
  Diagnostics diagnostics;
  CHECK(parse_bytes("--memory", "1", diagnostics) == 1);
  CHECK(parse_bytes("--memory", "512M", diagnostics) == std::size_t{512} << 20);
  CHECK(parse_bytes("--memory", "3k", diagnostics) == 3072);
  CHECK(parse_bytes("--memory", "128T", diagnostics) == std::size_t{1} << 47);
  CHECK(diagnostics.empty());
  for (const char* word : {"", "K", "0", "0G", "129T", "-1", "1KB", "1 K", "99999999999999999999"}) {
    CAPTURE(word);
    CHECK_FALSE(parse_bytes("--memory", word, diagnostics));
  }
  CHECK(diagnostics.size() == 9);
  CHECK(format_bytes(1023) == "1023 B");
  CHECK(format_bytes(1536) == "1.5 KiB");
  CHECK(format_bytes(std::size_t{4} << 30) == "4.0 GiB");
}

TEST_CASE("JSON strings escape what JSON does not allow and repair what is not UTF-8") {
  CHECK(json_string("a/b") == "\"a/b\"");
  CHECK(json_string("a\"b\\c\n\t\x01\x7f") == "\"a\\\"b\\\\c\\u000a\\u0009\\u0001\\u007f\"");
  CHECK(json_string("\xC3\xA8\xE5\x85\x89\xF0\x9F\x94\xA6") == "\"\xC3\xA8\xE5\x85\x89\xF0\x9F\x94\xA6\"");
  const std::string replaced = "\xEF\xBF\xBD";
  // Cut off, overlong, a surrogate, beyond U+10FFFF, and bytes that start nothing.
  CHECK(json_string("\xC3") == "\"" + replaced + "\"");
  CHECK(json_string("\xC0\xAF") == "\"" + replaced + replaced + "\"");
  CHECK(json_string("\xE0\x80\x80") == "\"" + replaced + replaced + replaced + "\"");
  CHECK(json_string("\xED\xA0\x80") == "\"" + replaced + replaced + replaced + "\"");
  CHECK(json_string("\xF4\x90\x80\x80") == "\"" + replaced + replaced + replaced + replaced + "\"");
  CHECK(json_string("x\xFFy") == "\"x" + replaced + "y\"");
}

TEST_CASE("JSON objects and arrays nest, in the order of the calls") {
  JsonWriter json;
  json.add("text", "a\"b");
  json.begin_array("list");
  json.add(nullptr, 0.1);
  json.add(nullptr, std::numeric_limits<double>::infinity());
  json.begin_object();
  json.add("flag", true);
  json.add("count", std::numeric_limits<std::uint64_t>::max());
  json.end_object();
  json.end_array();
  json.begin_array("empty");
  json.end_array();
  CHECK(json.finish() ==
        "{\n  \"text\": \"a\\\"b\",\n  \"list\": [\n    0.1,\n    null,\n    {\n      \"flag\": true,\n"
        "      \"count\": 18446744073709551615\n    }\n  ],\n  \"empty\": []\n}\n");
  CHECK(JsonWriter().finish() == "{}\n");
}

TEST_CASE("statistics that are not finite become null") {
  RenderRecord record;
  record.statistics.b = std::numeric_limits<double>::quiet_NaN();
  record.statistics.b_standard_error = std::numeric_limits<double>::infinity();
  const std::string json = to_json(record);
  CHECK_THAT(json, Catch::Contains("\"b\": null") && Catch::Contains("\"b_standard_error\": null"));
}

TEST_CASE("words are quoted for a shell only where they must be") {
  CHECK(shell_quote("scenes/a-b_2.txt") == "scenes/a-b_2.txt");
  CHECK(shell_quote("") == "''");
  CHECK(shell_quote("a b") == "'a b'");
  CHECK(shell_quote("it's") == "'it'\\''s'");
  CHECK(shell_quote("$(x)") == "'$(x)'");
}

RenderCommand parse_render_words(const std::vector<std::string>& words) {
  return std::get<RenderCommand>(parse_command_line(words));
}

TEST_CASE("options reach the request") {
  const RenderCommand command =
      parse_render_words({"render",   "-o",          "a.png",     "--seed=18446744073709551615",
                          "s.txt",    "--output",    "b.pfm",     "--integrator",
                          "path",     "--spp",       "3",         "--width",
                          "10",       "--height",    "11",        "--depth",
                          "12",       "--threads",   "13",        "--chains",
                          "14",       "--bootstrap", "15",        "--large-step",
                          "0.25",     "--start",     "first-hit", "--mutation",
                          "gaussian", "--step-size", "0.5",       "--roulette",
                          "off",      "--memory",    "16M",       "--exposure",
                          "-1.5",     "-q",          "--stats",   "s.json"});
  CHECK(command.scene == "s.txt");
  CHECK(command.outputs == std::vector<std::string>{"a.png", "b.pfm"});
  CHECK(command.stats == std::string("s.json"));
  CHECK(command.exposure == -1.5f);
  CHECK(command.quiet);
  const RenderRequest& request = command.request;
  CHECK(request.seed == std::numeric_limits<std::uint64_t>::max());
  CHECK(request.integrator == IntegratorKind::path);
  CHECK(request.samples_per_pixel == 3);
  CHECK(request.width == 10);
  CHECK(request.height == 11);
  CHECK(request.depth == 12);
  CHECK(request.threads == 13);
  CHECK(request.chains == 14);
  CHECK(request.bootstrap == 15);
  CHECK(request.large_step == 0.25f);
  CHECK(request.start == StartKind::first_hit);
  CHECK(request.mutation == MutationKind::gaussian);
  CHECK(request.step_size == 0.5f);
  CHECK(request.roulette == 0);
  CHECK(request.memory_limit == std::size_t{16} << 20);
  CHECK(command.warnings.size() == 6);
}

TEST_CASE("what is not given stays open for the job to decide") {
  const RenderCommand command = parse_render_words({"render", "folder/s.txt"});
  CHECK(command.outputs == std::vector<std::string>{"s.png"});
  CHECK_FALSE(command.request.width);
  CHECK_FALSE(command.request.samples_per_pixel);
  CHECK_FALSE(command.request.depth);
  CHECK_FALSE(command.request.roulette);
  CHECK(command.request.integrator == IntegratorKind::automatic);
  // What PSSMLT alone has speaks for it, what both have does not.
  CHECK(parse_render_words({"render", "s", "--chains", "3"}).request.integrator == IntegratorKind::pssmlt);
  CHECK(parse_render_words({"render", "s", "--mutations", "3"}).request.integrator == IntegratorKind::pssmlt);
  CHECK(parse_render_words({"render", "s", "--spp", "3"}).request.integrator == IntegratorKind::automatic);
  CHECK(parse_render_words({"render", "s", "--start", "resampled"}).request.integrator ==
        IntegratorKind::pssmlt);
  CHECK(parse_render_words({"render", "s", "--roulette", "3"}).request.integrator ==
        IntegratorKind::automatic);
  CHECK(parse_render_words({"render", "s", "--chains", "3", "--integrator", "path"}).request.integrator ==
        IntegratorKind::path);
  CHECK_FALSE(command.stats);
}

TEST_CASE("words behind -- and unusual scene names are taken as they are") {
  CHECK(parse_render_words({"render", "-q", "--", "-s.txt"}).scene == "-s.txt");
  CHECK(parse_render_words({"render", "noextension"}).outputs.front() == "noextension.png");
  CHECK(parse_render_words({"render", "a/.hidden"}).outputs.front() == ".hidden.png");
}

TEST_CASE("the canonical command parses back to the job it was made from") {
  RenderJob job;
  job.width = 3;
  job.height = 4;
  job.samples_per_pixel = 5;
  job.depth = 6;
  job.threads = 7;
  job.seed = 8;
  job.chains = 9;
  job.bootstrap = 10;
  job.large_step = 0.1f;
  job.start = StartKind::first_hit;
  job.mutation = MutationKind::gaussian;
  job.step_size = 0.3f;
  job.roulette = 0;
  const std::string command = canonical_command("-a'b.txt", job, 0, 1);
  CHECK(
      command ==
      "mlt render './-a'\\''b.txt' --integrator pssmlt --mutations 5 --width 3 --height 4 --depth 6 --seed 8 "
      "--chains 9 --bootstrap 10 --large-step 0.1 --start first-hit --mutation gaussian --step-size 0.3 "
      "--roulette off");
  job.integrator = IntegratorKind::path;
  job.roulette = 5;
  CHECK(canonical_command("s", job, 0.5f, 1) ==
        "mlt render s --integrator path --spp 5 --width 3 --height 4 --depth 6 --seed 8 --roulette 5 "
        "--exposure 0.5");
  // Rounds that ended by error or time are counted.
  job.in_rounds = true;
  job.max_rounds = 100;
  CHECK(canonical_command("s", job, 0, 3) ==
        "mlt render s --integrator path --spp 5 --width 3 --height 4 --depth 6 --seed 8 --rounds 3 "
        "--roulette 5");
}

TEST_CASE("the peak of memory is that of this process") {
  // At least the program's own pages, at most what any test machine has.
  CHECK(peak_memory_bytes() > 1'000'000);
  CHECK(peak_memory_bytes() < std::size_t{1} << 40);
}

}  // namespace
}  // namespace mlt
