// `mlt compare` as a person runs it. The figures themselves are tested in tests/compare.
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <limits>

#include "app/compare_command.hpp"
#include "image/image_io.hpp"
#include "math/rng.hpp"
#include "program.hpp"

namespace mlt {
namespace {

namespace fs = std::filesystem;

ImageBuffer uniform(std::uint32_t width, std::uint32_t height, float value) {
  return {width, height, std::vector<Vec3>(std::size_t{width} * height, Vec3(value))};
}

ImageBuffer noise(std::uint64_t seed, float mean) {
  Rng rng(seed, StreamPurpose::kTest, 0);
  ImageBuffer image = uniform(20, 12, 0);
  for (Vec3& pixel : image.pixels) {
    const float value = mean * 2 * rng.next_float();
    pixel = Vec3{value, 0.8f * value, 0.6f * value};
  }
  return image;
}

/// A folder with a.pfm (all 2), b.pfm (all 1), and the noisy pictures x.pfm and y.pfm.
class ImageFolder : public SceneFolder {
 public:
  ImageFolder() {
    write_pfm(*this / "a.pfm", uniform(1, 1, 2).view());
    write_pfm(*this / "b.pfm", uniform(1, 1, 1).view());
    write_pfm(*this / "x.pfm", noise(1, 0.5f).view());
    write_pfm(*this / "y.pfm", noise(2, 0.5f).view());
  }
};

/// The number behind a key of a JSON object; its first occurrence counts.
double json_number(const std::string& json, const std::string& key) {
  const std::size_t at = json.find("\"" + key + "\": ");
  CAPTURE(json, key);
  REQUIRE(at != std::string::npos);
  const std::string value = json.substr(at + key.size() + 4, 40);
  return value.starts_with("null") ? std::numeric_limits<double>::infinity() : std::stod(value);
}

TEST_CASE("compare prints the metrics and exits with 1 above the limit and 2 for what cannot be compared") {
  const ImageFolder folder;
  const ImageBuffer bad{1, 1, {Vec3{1, NAN, 1}}};
  write_pfm(folder / "wide.pfm", uniform(2, 1, 1).view());
  write_pfm(folder / "bad.pfm", bad.view());
  const ProgramResult plain = folder.run({"compare", "a.pfm", "b.pfm"});
  CHECK(plain.code == code_of(ExitCode::kOk));
  // 1 / (1 + 0.01), 1 / (3 + 0.01); both are shown as white.
  CHECK_THAT(plain.out, Catch::StartsWith("MSE        1\nRMSE       1\nMAE        1\nrelMSE     0.99009901\n"
                                          "SMAPE      0.332225914\nPSNR       inf dB\nFLIP       ") &&
                            Catch::EndsWith("mean error 1\nmean ratio 2 (red 2, green 2, blue 2)\n"));
  CHECK(folder.run({"compare", "a.pfm", "b.pfm", "--max-relmse", "1"}).code == code_of(ExitCode::kOk));
  const ProgramResult above = folder.run({"compare", "--max-relmse", "0.99", "a.pfm", "b.pfm"});
  CHECK(above.code == code_of(ExitCode::kCompareFailed));
  CHECK_THAT(above.out, Catch::Contains("relMSE     0.99009901"));
  CHECK_THAT(above.error, Catch::Contains("exceeds --max-relmse 0.99"));
  CHECK(folder.run({"compare", "b.pfm", "b.pfm", "--max-relmse", "0"}).code == code_of(ExitCode::kOk));
  const ProgramResult sizes = folder.run({"compare", "wide.pfm", "b.pfm"});
  CHECK(sizes.code == code_of(ExitCode::kBadInput));
  CHECK_THAT(sizes.error, Catch::Contains("wide.pfm: has 2 x 1 pixels; expected 1 x 1 as in b.pfm"));
  const ProgramResult nan = folder.run({"compare", "bad.pfm", "b.pfm"});
  CHECK(nan.code == code_of(ExitCode::kBadInput));
  CHECK_THAT(nan.error, Catch::Contains("bad.pfm: 1 of 1 pixels are NaN or infinite (NaN 1, infinite 0), the "
                                        "first at x 0, y 0"));
  CHECK(folder.run({"compare", "scene.txt", "b.pfm"}).code == code_of(ExitCode::kBadInput));
  const ProgramResult both = folder.run({"compare", "gone.pfm", "gone.png"});
  CHECK_THAT(both.error, Catch::Contains("gone.pfm: cannot be read") && Catch::Contains("gone.png: cannot"));
}

TEST_CASE("every metric has a JSON key and a limit that decides the exit code") {
  const ImageFolder folder;
  const ProgramResult plain = folder.run({"compare", "x.pfm", "y.pfm", "--json"});
  CHECK(plain.code == code_of(ExitCode::kOk));
  CHECK(json_number(plain.out, "width") == 20);
  for (const MetricInfo& metric : kMetrics) {
    const double value = json_number(plain.out, metric.key);
    const std::string option = limit_option(metric);
    CAPTURE(option, value);
    CHECK(value > 0);
    const bool is_max = metric.bound == MetricBound::max;
    const std::string good = std::to_string(is_max ? value * 1.01 : value * 0.99);
    const std::string bad = std::to_string(is_max ? value * 0.99 : value * 1.01);
    CHECK(folder.run({"compare", "x.pfm", "y.pfm", option, good}).code == code_of(ExitCode::kOk));
    const ProgramResult result = folder.run({"compare", "x.pfm", "y.pfm", option, bad, "--json"});
    CHECK(result.code == code_of(ExitCode::kCompareFailed));
    CHECK_THAT(result.error, Catch::Contains(metric.label) && Catch::Contains(option + " "));
    CHECK_THAT(result.out, Catch::Contains("\"beyond_limit\": [\n    \"" + std::string(metric.key) + "\""));
  }
}

TEST_CASE("FLIP takes PNG files as displayed and PFM files over all exposures, unless told") {
  const ImageFolder folder;
  write_image(folder / "x.png", noise(1, 0.5f).view(), {});
  write_image(folder / "y.png", noise(2, 0.5f).view(), {});
  const auto run = [&folder](const char* a, const char* b, std::vector<std::string> more) {
    more.insert(more.begin(), {"compare", a, b, "--json"});
    return folder.run(more).out;
  };
  CHECK_THAT(run("x.png", "y.png", {}), Catch::Contains("\"mode\": \"ldr\""));
  CHECK_THAT(run("x.png", "y.pfm", {}), Catch::Contains("\"mode\": \"ldr\""));
  CHECK_THAT(run("x.pfm", "y.pfm", {}), Catch::Contains("\"mode\": \"hdr\""));
  CHECK_THAT(run("x.png", "y.png", {"--flip", "hdr"}), Catch::Contains("\"mode\": \"hdr\""));
  const double shown = json_number(run("x.png", "y.png", {}), "flip");
  // Rounding to bytes is below what the eye sees: some thousandths.
  CHECK(json_number(run("x.pfm", "y.pfm", {"--flip", "ldr"}), "flip") == Approx(shown).margin(0.005));
  const std::string near = run("x.png", "y.png", {"--pixels-per-degree", "20"});
  CHECK(json_number(near, "pixels_per_degree") == 20);
  CHECK(json_number(near, "flip") > shown);
  const std::string dark = run("x.png", "y.png", {"--exposure", "-6"});
  CHECK(json_number(dark, "flip") < shown);
  CHECK(json_number(dark, "psnr") > json_number(near, "psnr"));
}

TEST_CASE("pictures of the error are written, and only where they may be") {
  const ImageFolder folder;
  const ProgramResult result = folder.run({"compare", "x.pfm", "y.pfm", "--difference", "d.png", "--heat-map",
                                           "h.png", "--heat-metric", "relmse", "--heat-range", "2"});
  CHECK(result.code == code_of(ExitCode::kOk));
  CHECK(read_png(folder / "d.png").image.width > 240);
  CHECK(read_png(folder / "h.png").image.width > 240);
  CHECK(folder.run({"compare", "x.pfm", "y.pfm", "--difference", "d.pfm"}).code == code_of(ExitCode::kOk));
  const ImageBuffer difference = read_pfm(folder / "d.pfm").image;
  CHECK(difference.pixels[7] == noise(1, 0.5f).pixels[7] - noise(2, 0.5f).pixels[7]);
  fs::remove(folder / "d.pfm");
  const std::string before = folder.outputs();
  const ProgramResult bad =
      folder.run({"compare", "x.pfm", "y.pfm", "--difference", "x.pfm", "--heat-map", "h.pfm"});
  CHECK(bad.code == code_of(ExitCode::kBadInput));
  CHECK_THAT(bad.error, Catch::Contains("x.pfm: is one of the images compared") &&
                            Catch::Contains("h.pfm: cannot hold a drawing"));
  const ProgramResult twice =
      folder.run({"compare", "x.pfm", "y.pfm", "--difference", "n.png", "--heat-map", "./n.png"});
  CHECK_THAT(twice.error, Catch::Contains("given as output twice"));
  CHECK(folder.outputs() == before);
}

TEST_CASE("folders are compared by file name") {
  const ImageFolder folder;
  for (const char* name : {"one", "two"}) fs::create_directory(folder / name);
  write_pfm(folder / "one/p.pfm", noise(1, 0.5f).view());
  write_pfm(folder / "two/p.pfm", noise(2, 0.5f).view());
  write_image(folder / "one/q.png", noise(3, 0.5f).view(), {});
  write_image(folder / "two/q.png", noise(3, 0.5f).view(), {});
  write_text(folder / "one/notes.txt", "not an image");
  const ProgramResult text = folder.run({"compare", "one", "two"});
  CHECK(text.code == code_of(ExitCode::kOk));
  CHECK_THAT(text.out, Catch::Contains("\np.pfm ") && Catch::Contains("\nq.png ") &&
                           Catch::Contains("\nmean ") && Catch::Contains("\nworst "));
  const ProgramResult json = folder.run(
      {"compare", "one", "two", "--json", "--max-mse", "0.01", "--heat-map", "heat", "--difference", "diff"});
  CHECK(json.code == code_of(ExitCode::kCompareFailed));
  CHECK_THAT(json.error, Catch::Contains("one/p.pfm: MSE") && !Catch::Contains("q.png"));
  const double mse = json_number(json.out, "mse");
  CHECK(json_number(json.out.substr(json.out.find("\"mean\": ")), "mse") == Approx(0.5 * mse));
  CHECK(json_number(json.out.substr(json.out.find("\"worst\": ")), "mse") == Approx(mse));
  for (const char* name : {"heat/p.pfm.png", "heat/q.png.png", "diff/p.pfm.png", "diff/q.png.png"}) {
    CHECK(fs::exists(folder / name));
  }
  write_pfm(folder / "one/alone.pfm", noise(1, 0.5f).view());
  write_pfm(folder / "two/other.pfm", noise(1, 0.5f).view());
  const ProgramResult unpaired = folder.run({"compare", "one", "two", "--heat-map", "two"});
  CHECK(unpaired.code == code_of(ExitCode::kBadInput));
  CHECK_THAT(unpaired.error, Catch::Contains("one/alone.pfm: has no image of the same name in 'two'") &&
                                 Catch::Contains("two/other.pfm: has no image of the same name in 'one'") &&
                                 Catch::Contains("two: is a folder compared"));
  CHECK_THAT(folder.run({"compare", "one", "b.pfm"}).error, Catch::Contains("b.pfm: is not a folder"));
  CHECK_THAT(folder.run({"compare", "heat", "diff"}).error, !Catch::Contains("alone"));
  fs::create_directory(folder / "empty");
  CHECK_THAT(folder.run({"compare", "empty", "empty"}).error, Catch::Contains("empty: holds no images"));
}

TEST_CASE("sets of replicates are tested") {
  const ImageFolder folder;
  std::vector<std::string> words{"compare", "--test"};
  for (std::uint64_t i = 0; i < 12; ++i) {
    const std::string name = "r" + std::to_string(i) + ".pfm";
    write_pfm(folder / name, noise(100 + i, i < 8 ? 0.5f : 0.6f).view());
    if (i == 4) words.push_back("--");
    if (i < 8) words.push_back(name);
  }
  const ProgramResult same = folder.run(words);
  CHECK(same.code == code_of(ExitCode::kOk));
  CHECK_THAT(same.out, Catch::Contains("replicates 4 against 4") && Catch::Contains("no difference found"));
  // Options on both sides of the mark.
  const ProgramResult other =
      folder.run({"compare", "--test", "r0.pfm", "r1.pfm", "--tile", "4", "r2.pfm", "r3.pfm", "--", "r8.pfm",
                  "r9.pfm", "r10.pfm", "r11.pfm", "--json", "--p-picture", "p.png", "--alpha", "0.05"});
  CHECK(other.code == code_of(ExitCode::kCompareFailed));
  CHECK(other.error == "");
  CHECK_THAT(other.out, Catch::Contains("\"rejected\": true"));
  CHECK(json_number(other.out, "tiles_x") == 5);
  CHECK(json_number(other.out, "alpha") == 0.05);
  CHECK(json_number(other.out, "mean_p_value") < 0.01);
  CHECK(read_png(folder / "p.png").image.width > 240);
  const ProgramResult bad =
      folder.run({"compare", "--test", "a.pfm", "x.pfm", "--", "gone.pfm", "b.pfm", "--p-picture", "a.pfm"});
  CHECK(bad.code == code_of(ExitCode::kBadInput));
  CHECK_THAT(bad.error, Catch::Contains("a.pfm: cannot hold a drawing"));
  const ProgramResult sizes = folder.run({"compare", "--test", "a.pfm", "x.pfm", "--", "gone.pfm", "b.pfm"});
  CHECK_THAT(sizes.error, Catch::Contains("x.pfm: has 20 x 12 pixels; expected 1 x 1 as in a.pfm") &&
                              Catch::Contains("gone.pfm: cannot be read"));
}

}  // namespace
}  // namespace mlt
