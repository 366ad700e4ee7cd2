// Summaries of runs whose laws are known, their JSON and CSV, and the errors of images made by hand.
#include "converge/summary.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "base/error.hpp"
#include "converge/json.hpp"
#include "synthetic_run.hpp"

namespace mlt {
namespace {

using test::Law;
using test::synthetic_run;

const Law kPath{IntegratorKind::path, "path", 0.8, -1, 0.01};
const Law kChains{IntegratorKind::pssmlt, "pssmlt", 0.4, -0.75, 0.02};

TEST_CASE("a summary finds the laws that the rows follow") {
  // Median of 1 + 0.1 (r - 2) over r = 0..4 is 1; its 95th percentile is 1.18, its mean 1.
  const ConvergeRun run = synthetic_run({kPath, kChains}, 6, 5, 0.1);
  const ConvergeSummary summary = summarise(run, nullptr, 0.1);
  REQUIRE(summary.methods.size() == 2);
  const MethodSummary& path = summary.methods[0];
  const MethodSummary& chains = summary.methods[1];
  CHECK(path.levels[3].rel_mse_median == Approx(0.1).epsilon(1e-12));
  CHECK(path.levels[3].rel_mse_p95 == Approx(0.118).epsilon(1e-12));
  CHECK(path.levels[3].rel_mse_mean == Approx(0.1).epsilon(1e-12));
  CHECK(path.levels[3].wall_seconds == Approx(0.08).epsilon(1e-12));
  CHECK(path.levels[3].cpu_seconds == Approx(0.16).epsilon(1e-12));
  CHECK(path.levels[3].samples_per_pixel == 8);
  CHECK(path.slope_time == Approx(-1).epsilon(1e-9));
  CHECK(chains.slope_samples == Approx(-0.75).epsilon(1e-9));
  // 0.8 / n = 0.1 at n = 8; 0.4 n^(-3/4) = 0.1 at n = 4^(4/3).
  CHECK(path.seconds_to_target.value == Approx(0.08).epsilon(1e-9));
  CHECK(path.cpu_seconds_to_target.value == Approx(0.16).epsilon(1e-9));
  CHECK(chains.samples_per_pixel_to_target.value == Approx(std::pow(4, 4 / 3.0)).epsilon(1e-9));
  // Resampled medians lie between the factors 0.8 and 1.2; 1e-9 is the logarithm's error.
  CHECK(path.seconds_to_target.low >= 0.8 * 0.08 * (1 - 1e-9));
  CHECK(path.seconds_to_target.low < 0.08);
  CHECK(path.seconds_to_target.high <= 1.2 * 0.08 * (1 + 1e-9));
  CHECK(path.seconds_to_target.high > 0.08);
  // Efficiency of path: 1 / (0.8 * 0.01) at any level. pssmlt at n = 32: 1 / (0.4 * 32^-0.75 * 0.64).
  CHECK(path.levels[2].efficiency == Approx(125).epsilon(1e-9));
  CHECK(path.levels[2].efficiency_cpu == Approx(62.5).epsilon(1e-9));
  CHECK(chains.ratio.value == Approx(std::pow(32, 0.75) / 0.256 / 125).epsilon(1e-9));
  // Each resample divides two medians of the same replicates, whose factors cancel.
  CHECK(chains.ratio.low == Approx(chains.ratio.value).epsilon(1e-9));
  CHECK(chains.ratio_cpu.value == Approx(chains.ratio.value).epsilon(1e-9));
  // path ends at 0.32 s, which is pssmlt's budget 16.
  CHECK(summary.equal_time_seconds == Approx(0.32).epsilon(1e-12));
  CHECK(path.equal_time_level == 5);
  CHECK(chains.equal_time_level == 4);
  CHECK(std::isnan(path.levels[0].bias));
  REQUIRE(summary.warnings.size() == 1);
  CHECK_THAT(summary.warnings[0], Catch::Contains("without --reference"));
}

TEST_CASE("the path tracer's efficiency is taken at the method's time") {
  // Its efficiency at budget n, that is at n / 100 seconds, is 100 n^-0.5; the method's time at budget m is
  // that of n = sqrt(2) m, between two budgets, and at the last one beyond all of them.
  const double root = std::sqrt(2.0);
  const ConvergeRun run = synthetic_run(
      {{IntegratorKind::path, "path", 1, -0.5, 0.01}, {IntegratorKind::pssmlt, "pssmlt", 1, -1, 0.01 * root}},
      6, 3, 0);
  const std::vector<LevelSummary> levels = summarise(run, nullptr, kUnknown).methods[1].levels;
  const double own = 100 / root;
  CHECK(levels[2].ratio == Approx(own / (100 / std::sqrt(4 * root))).epsilon(1e-9));
  CHECK(levels[5].ratio == Approx(own / (100 / std::sqrt(32.0))).epsilon(1e-9));
}

TEST_CASE("efficiencies are compared with the first path tracer, or else the first method") {
  const Law slow{IntegratorKind::pssmlt, "pssmlt --chains 4", 0.4, -1, 0.04};
  const Law fast{IntegratorKind::pssmlt, "pssmlt", 0.4, -1, 0.01};
  const Law path{IntegratorKind::path, "path", 0.4, -1, 0.02};
  const Law second{IntegratorKind::path, "path --roulette 2", 0.4, -1, 0.01};
  const ConvergeSummary chains = summarise(synthetic_run({slow, fast}, 3, 3, 0), nullptr, kUnknown);
  CHECK(chains.base == "pssmlt --chains 4");
  CHECK(chains.methods[0].ratio.value == 1);
  CHECK(chains.methods[1].ratio.value == Approx(4).epsilon(1e-9));
  CHECK_THAT(to_text(chains), Catch::Contains("pssmlt: efficiency against pssmlt --chains 4 at the last"));
  const ConvergeSummary all = summarise(synthetic_run({slow, path, second}, 3, 3, 0), nullptr, kUnknown);
  CHECK(all.base == "path");
  CHECK(all.methods[0].ratio.value == Approx(0.5).epsilon(1e-9));
  CHECK(all.methods[2].ratio.value == Approx(2).epsilon(1e-9));
}

TEST_CASE("targets out of reach are told from those met at once") {
  const ConvergeRun run = synthetic_run({kPath}, 4, 3, 0.1);
  const Bounded never = summarise(run, nullptr, 1e-3).methods[0].seconds_to_target;
  CHECK((std::isinf(never.value) && std::isinf(never.low) && std::isinf(never.high)));
  const Bounded at_once = summarise(run, nullptr, 2).methods[0].seconds_to_target;
  CHECK((at_once.value == 0 && at_once.low == 0 && at_once.high == 0));
  CHECK(std::isnan(summarise(run, nullptr, kUnknown).methods[0].seconds_to_target.value));
}

TEST_CASE("the bias carries the noise of the images and of the reference") {
  ConvergeRun run = synthetic_run({kPath}, 1, 4, 0);
  const double means[] = {1.1, 1.3, 1.1, 1.3};
  for (std::size_t i = 0; i < 4; ++i) run.rows[i].mean = means[i];
  Reference reference;
  reference.path = "r.pfm";
  reference.mean = 2;
  reference.mean_standard_error = 0.1;
  const LevelSummary level = summarise(run, &reference, kUnknown).methods[0].levels[0];
  CHECK(level.bias == Approx(-0.4).epsilon(1e-12));
  // Sum of squares 0.04 over 3 * 4 is the images' squared error; 0.01 the reference's.
  CHECK(level.bias_standard_error == Approx(std::sqrt(0.04 / 12 + 0.01) / 2).epsilon(1e-12));
}

TEST_CASE("one level has no slope, whatever the clock's noise") {
  ConvergeRun run = synthetic_run({kPath}, 1, 4, 0.1);
  for (Measurement& row : run.rows) row.wall_seconds *= 1 + 0.01 * row.replicate;
  const MethodSummary method = summarise(run, nullptr, kUnknown).methods[0];
  CHECK((std::isnan(method.slope_time) && std::isnan(method.slope_samples)));
  CHECK(method.ratio.value == 1);
}

TEST_CASE("a mean that is off is told when there are replicates enough") {
  const auto warnings = [](std::uint32_t replicates) {
    ConvergeRun run = synthetic_run({kPath}, 1, replicates, 0.01);
    for (Measurement& row : run.rows) row.mean = 1.1 + 0.001 * (row.replicate % 2);
    Reference reference;
    reference.path = "r.pfm";
    reference.variance_path = "r.variance.pfm";
    reference.mean = 1;
    reference.mean_standard_error = 0.001;
    return summarise(run, &reference, kUnknown).warnings;
  };
  CHECK(warnings(7).empty());
  REQUIRE(warnings(8).size() == 1);
  CHECK_THAT(warnings(8)[0], Catch::Contains("path: the image mean is off by +10.1 %"));
}

TEST_CASE("errors at or below the reference's noise spoil neither slopes nor efficiencies") {
  ConvergeRun run = synthetic_run({kPath, kChains}, 4, 3, 0.1);
  for (Measurement& row : run.rows) {
    if (row.method == 0 && row.level == 3) row.rel_mse = row.replicate == 0 ? 0.1 : -0.01;
  }
  const ConvergeSummary summary = summarise(run, nullptr, 0.05);
  CHECK(summary.methods[0].slope_time == Approx(-1).epsilon(1e-9));
  CHECK(std::isnan(summary.methods[0].levels[3].efficiency));
  CHECK(summary.methods[0].seconds_to_target.value == Approx(0.08).epsilon(1e-9));
  CHECK_NOTHROW(summary_from_json(to_json(summary), "x"));
}

TEST_CASE("JSON holds the summary and gives it back") {
  ConvergeSummary summary = summarise(synthetic_run({kPath, kChains}, 3, 3, 0.1), nullptr, 1e-6);
  summary.scene = "a \"quoted\"\n\\scene\x01.txt";
  summary.methods[0].picture = "path.png";
  const std::string text = to_json(summary);
  const JsonValue value = parse_json(text, "s.json");
  REQUIRE(value.find("methods") != nullptr);
  CHECK(value.find("methods")->items.size() == 2);
  CHECK(value.find("methods")->items[1].find("levels")->items.size() == 3);
  CHECK(value.find("reference_mean")->kind == JsonValue::Kind::kNull);
  CHECK(value.find("scene")->text == summary.scene);
  const ConvergeSummary back = summary_from_json(text, "s.json");
  CHECK(to_json(back) == text);
  CHECK(std::isinf(back.methods[0].seconds_to_target.high));
  CHECK(back.methods[0].picture == "path.png");
}

TEST_CASE("files that are no summary are refused with their place") {
  const auto refused = [](const std::string& text, const std::string& fragment) {
    CAPTURE(text.substr(0, 60));
    try {
      summary_from_json(text, "s.json");
      FAIL("accepted");
    } catch (const InputError& error) {
      CHECK_THAT(error.what(), Catch::Contains("s.json") && Catch::Contains(fragment));
    }
  };
  refused("", "expected a JSON value");
  refused("{\n \"a\": nan}", "s.json:2:7");
  refused("{\"a\": 1e999}", "expected a JSON value");
  refused("{\"a\": 1} x", "more text behind");
  refused("{\"a\": \"b", "expected '\"'");
  refused("{\"a\": \"\\u12\"}", "four hexadecimal digits");
  refused("{\"a\" 1}", "expected ':'");
  refused(std::string(100000, '['), "nested too deeply");
  refused("[1, 2]", "expected an object");
  refused("{}", "expected the member version");
  const std::string good = to_json(summarise(synthetic_run({kPath}, 2, 2, 0.1), nullptr, kUnknown));
  const auto replaced = [&good](const std::string& from, const std::string& to) {
    std::string text = good;
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    return text.replace(at, from.size(), to);
  };
  refused(replaced("\"equal_time_level\": 1", "\"equal_time_level\": 2"), "no level");
  refused(replaced("\"equal_time_level\": 1", "\"equal_time_level\": 0.5"), "no level");
  refused(replaced("\"width\": 2", "\"width\": \"2\""), "a number as width");
}

TEST_CASE("the CSV has one row a replicate and quotes what RFC 4180 says") {
  const ConvergeRun run = synthetic_run({kPath, kChains}, 3, 4, 0.1);
  std::istringstream lines(to_csv(run, "a,\"b\".txt"));
  std::string line;
  REQUIRE(std::getline(lines, line));
  CHECK(line ==
        "scene,method,level,budget,replicate,seed,samples,wall_seconds,cpu_seconds,rel_mse,rel_mse_raw,"
        "mse,mean,film_hash");
  std::size_t count = 0;
  while (std::getline(lines, line)) {
    if (count == 3) CHECK(line.substr(0, 38) == "\"a,\"\"b\"\".txt\",pssmlt,1,2,0,101,8,0.04,");
    ++count;
  }
  CHECK(count == 2 * 3 * 4);
}

TEST_CASE("without a reference the mean error of the replicates is their relative variance") {
  // One level, images of constant 1, 2, 3 and 6: mean 3, sample variance (4+1+0+9)/3, base 3^2 + 0.01.
  ConvergeRun run = synthetic_run({kPath}, 1, 4, 0);
  const float values[] = {1, 2, 3, 6};
  for (std::size_t i = 0; i < 4; ++i) run.images[i].pixels.assign(4, Vec3{values[i], values[i], values[i]});
  score(run, nullptr);
  double sum = 0;
  for (const Measurement& row : run.rows) sum += row.rel_mse / 4;
  CHECK(sum == Approx(14 / 3.0 / 9.01).epsilon(1e-12));
  CHECK(run.rows[0].mse == Approx(4 * 4 / 3.0).epsilon(1e-12));
  CHECK(run.rows[3].mean == 6);
}

TEST_CASE("with a reference its own noise is taken off") {
  ConvergeRun run = synthetic_run({kPath}, 1, 2, 0);
  Reference reference;
  reference.path = "r.pfm";
  reference.image = {2, 2, std::vector<Vec3>(4, Vec3{0.5f, 0.5f, 0.5f})};
  reference.own_rel_mse = 0.2;
  score(run, &reference);
  CHECK(run.rows[0].rel_mse_raw == Approx(0.25 / 0.26).epsilon(1e-12));
  CHECK(run.rows[0].rel_mse == Approx(0.25 / 0.26 - 0.2).epsilon(1e-12));
  CHECK(run.rows[0].mse == 0.25);
}

}  // namespace
}  // namespace mlt
