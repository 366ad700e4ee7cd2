// Results on disk and the page made of them.
#include "converge/report.hpp"

#include <catch2/catch.hpp>

#include "base/error.hpp"
#include "image/image_io.hpp"
#include "markup.hpp"
#include "support/temporary_folder.hpp"
#include "synthetic_run.hpp"

namespace mlt {
namespace {

namespace fs = std::filesystem;

ConvergeSummary example(const std::string& scene) {
  const ConvergeRun run = test::synthetic_run(
      {{IntegratorKind::path, "path", 0.8, -1, 0.01}, {IntegratorKind::pssmlt, "pssmlt", 0.4, -0.75, 0.02}},
      6, 5, 0.1);
  ConvergeSummary summary = summarise(run, nullptr, 0.1);
  summary.scene = scene;
  summary.methods[0].picture = "path.png";
  return summary;
}

void write_result(const fs::path& folder, const ConvergeSummary& summary) {
  fs::create_directories(folder);
  write_text((folder / "summary.json").string(), to_json(summary));
  write_png((folder / "path.png").string(), ImageBuffer{1, 1, {Vec3{1, 0, 0}}}.view(), {});
}

TEST_CASE("base64 agrees with the examples of RFC 4648") {
  CHECK(base64("") == "");
  CHECK(base64("f") == "Zg==");
  CHECK(base64("fo") == "Zm8=");
  CHECK(base64("foo") == "Zm9v");
  CHECK(base64("foob") == "Zm9vYg==");
  CHECK(base64("fooba") == "Zm9vYmE=");
  CHECK(base64("foobar") == "Zm9vYmFy");
  CHECK(base64("\xff\xfe\xfb") == "//77");
}

TEST_CASE("the page holds every result below the folder and needs nothing else") {
  const TemporaryFolder folder;
  write_result(folder.path() / "b", example("scenes/<script>alert(1)</script>.txt"));
  write_result(folder.path() / "a" / "deep", example("scenes/box.txt"));
  const std::vector<ReportEntry> entries = read_results(folder.path().string());
  REQUIRE(entries.size() == 2);
  CHECK(entries[0].folder == "a/deep");
  CHECK(entries[1].folder == "b");
  const std::string page = report_page(entries);
  const std::size_t style = page.find("<style>");
  const std::size_t style_end = page.find("</style>");
  test::require_well_formed(page.substr(0, style) + page.substr(style_end + 8), {"meta", "br", "img"});
  CHECK_THAT(page, Catch::Contains("data:image/png;base64,iVBORw0KGgo") && Catch::Contains("<svg") &&
                       Catch::Contains("box (a/deep)") && Catch::Contains("95 %"));
  for (const char* outside : {"<script", "href=\"http", "src=\"http", "url(", "@import"}) {
    CHECK_THAT(page, !Catch::Contains(outside));
  }
  CHECK(read_results((folder.path() / "b").string())[0].folder == "");
}

TEST_CASE("folders that hold no results, and results that name other files, are refused") {
  const TemporaryFolder folder;
  CHECK_THROWS_WITH(read_results(folder / "none"), Catch::Contains("is not a folder"));
  CHECK_THROWS_WITH(read_results(folder.path().string()), Catch::Contains("holds no summary.json"));
  write_text(folder / "secret.png", "secret");
  for (const char* name : {"../secret.png", "/etc/passwd", "..", "missing.png"}) {
    ConvergeSummary summary = example("s.txt");
    summary.methods[0].error_map = name;
    write_result(folder.path() / "r", summary);
    CAPTURE(name);
    CHECK_THROWS_AS(read_results(folder.path().string()), InputError);
  }
  ConvergeSummary summary = example("s.txt");
  write_result(folder.path() / "r", summary);
  CHECK_NOTHROW(read_results(folder.path().string()));
  write_text((folder.path() / "r" / "path.png").string(), "text");
  CHECK_THROWS_WITH(read_results(folder.path().string()), Catch::Contains("is no PNG file"));
}

}  // namespace
}  // namespace mlt
