// Plots as well-formed XML with their labels, and maps of errors whose colours and scales are known.
#include "converge/plot.hpp"

#include <fmt/core.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "converge/picture.hpp"
#include "image/image_io.hpp"
#include "markup.hpp"
#include "synthetic_run.hpp"

namespace mlt {
namespace {

using test::require_well_formed;

ConvergeSummary example(double target) {
  const ConvergeRun run = test::synthetic_run(
      {{IntegratorKind::path, "path", 0.8, -1, 0.01}, {IntegratorKind::pssmlt, "pssmlt", 0.4, -0.75, 0.02}},
      6, 5, 0.1);
  ConvergeSummary summary = summarise(run, nullptr, target);
  summary.scene = "scenes/<a & \"b\">.txt";
  return summary;
}

TEST_CASE("plots are well-formed and name axes, units, methods and the target") {
  const std::string time = to_svg(plot_over_time(example(0.1)));
  require_well_formed(time);
  for (const char* part :
       {"wall time per render [s], 1 thread", "relative variance (line", "median", "10 % to 90 %", ">path<",
        ">pssmlt<", "target 0.1", "scenes/&lt;a &amp; &quot;b&quot;&gt;.txt", "stroke-dasharray=\"8 4\""}) {
    CHECK_THAT(time, Catch::Contains(part));
  }
  ConvergeSummary summary = example(kUnknown);
  summary.reference = "r.pfm";
  const std::string processors = to_svg(plot_over_processor_time(summary));
  require_well_formed(processors);
  CHECK_THAT(processors, Catch::Contains("processor time per render [s], 1 thread"));
  CHECK(processors != time);
  const std::string samples = to_svg(plot_over_samples(summary));
  require_well_formed(samples);
  CHECK_THAT(samples, Catch::Contains("samples per pixel") && Catch::Contains("relMSE"));
  CHECK_THAT(samples, !Catch::Contains("target"));
}

TEST_CASE("text of XML holds neither reserved characters nor what is no text") {
  CHECK(xml_text("a<b>&\"c\"") == "a&lt;b&gt;&amp;&quot;c&quot;");
  CHECK(xml_text("\x01\n\x7f") == "");
  CHECK(xml_text("\xC3\xA8\xFF") == "\xC3\xA8\xEF\xBF\xBD");
}

TEST_CASE("points stand where their logarithms say") {
  // Decades 0 to 2 in x and -2 to 0 in y, with 5 % of them free at each end, in a frame from 76 to 622 and 40
  // to 376: the middle point is in the middle.
  Plot plot;
  plot.series = {{"a", {{1, 1, 1, 1}, {10, 0.1, 0.1, 0.1}, {100, 0.01, 0.01, 0.01}}, {}}};
  const std::string text = to_svg(plot);
  CHECK_THAT(text, Catch::Contains("<circle cx=\"349.00\" cy=\"208.00\""));
  CHECK_THAT(text, Catch::Contains(fmt::format("<circle cx=\"{:.2f}\"", 76 + 546 * 0.1 / 2.2)));
}

TEST_CASE("legends that the frame cannot hold stand below it, and no name leaves the picture") {
  const auto svg_with = [](const std::vector<std::string>& names) {
    Plot plot;
    for (const std::string& name : names)
      plot.series.push_back({name, {{1, 1, 1, 1}, {10, 0.1, 0.1, 0.1}}, {}});
    const std::string text = to_svg(plot);
    require_well_formed(text);
    return text;
  };
  CHECK_THAT(svg_with({"path", "pssmlt"}), Catch::Contains("viewBox=\"0 0 640 440\""));
  // Six names and the guide are 7 lines of 20 pixels, with 5 above, 5 below, and 10 to the picture's end.
  CHECK_THAT(svg_with({"a", "b", "c", "d", "e", "f"}), Catch::Contains("viewBox=\"0 0 640 600\""));
  CHECK_THAT(svg_with({std::string(40, 'x')}),
             Catch::Contains("viewBox=\"0 0 640 500\"") && !Catch::Contains("font-size=\"12"));
  // 494 pixels for 200 letters of 7.4 pixels.
  const double scale = (640 - 76 - 8 - 62) / (7.4 * 200);
  CHECK_THAT(svg_with({std::string(200, 'x')}),
             Catch::Contains(fmt::format("font-size=\"{:.2f}\">xxx", 13 * scale)));
}

TEST_CASE("plots take what has no logarithm, and nothing at all") {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Plot plot;
  plot.title = "t";
  plot.target = 0.5;
  plot.series = {
      {"a", {{0, 1, 1, 1}, {1, -1, -2, 1}, {2, kUnknown, 1, 1}, {3, 1, -1, kInfinity}}, {2, 0, kInfinity}},
      {"b", {}, {}},
      {"c", {{1e-300, 1e300, 1e-300, 1e300}}, {kInfinity, kInfinity, kInfinity}}};
  const std::string text = to_svg(plot);
  require_well_formed(text);
  CHECK_THAT(text, !Catch::Contains("nan") && !Catch::Contains("inf"));
  require_well_formed(to_svg(Plot{}));
}

TEST_CASE("the fields of error and difference are those of their formulas") {
  ConvergeRun run = test::synthetic_run({{IntegratorKind::path, "path", 1, -1, 1}}, 1, 2, 0);
  run.images[0].pixels[0] = Vec3{2, 1, 1};
  run.images[1].pixels[0] = Vec3{0, 1, 1};
  const ImageBuffer base{2, 2, std::vector<Vec3>(4, Vec3{1, 1, 1})};
  const ErrorField error = error_field(run, 0, 0, base);
  // Two of six channels are off by 1 over 1.01.
  CHECK(error.values[0] == Approx(std::sqrt(1 / 1.01 / 3)).epsilon(1e-12));
  CHECK(error.values[1] == 0);
  CHECK(difference_field(run.images[0], base).values[0] == Approx(1 / std::sqrt(1.01) / 3).epsilon(1e-12));
  CHECK(difference_field(mean_image(run, 0, 0), base).values[0] == 0);
}

TEST_CASE("scales end at 1, 2 or 5 times a power of ten") {
  const auto end = [](std::vector<double> values) {
    return scale_end({{static_cast<std::uint32_t>(values.size()), 1, values}}, 1);
  };
  CHECK(end({0.3, -0.42}) == Approx(0.5).epsilon(1e-8));
  CHECK(end({0.5}) == Approx(0.5).epsilon(1e-8));
  CHECK(end({0.51}) == Approx(1).epsilon(1e-8));
  CHECK(end({1100}) == Approx(2000).epsilon(1e-8));
  CHECK(end({0, 0}) == Approx(1e-9).epsilon(1e-8));
}

TEST_CASE("maps show their ends' colours and a scale below") {
  const ErrorField field{2, 1, {0, 5}};
  const ImageBuffer image = draw_field(field, ColourMap::kSequential, 1);
  CHECK(image.width == 320);
  CHECK(image.height > 160 + 20);
  const auto is_colour = [&image](std::uint32_t x, std::uint32_t y, int r, int g, int b) {
    const Vec3& pixel = image.pixels[std::size_t{y} * image.width + x];
    CHECK((srgb_byte(pixel.x) == r && srgb_byte(pixel.y) == g && srgb_byte(pixel.z) == b));
  };
  is_colour(10, 10, 68, 1, 84);
  is_colour(310, 10, 253, 231, 37);
  is_colour(0, 162, 255, 255, 255);
  const ImageBuffer middle = draw_field({1, 1, {0}}, ColourMap::kDiverging, 2);
  CHECK(srgb_byte(middle.pixels[0].x) == 247);
  const ImageBuffer unknown = draw_field({1, 1, {std::nan("")}}, ColourMap::kDiverging, 2);
  CHECK(srgb_byte(unknown.pixels[0].x) == 33);
}

}  // namespace
}  // namespace mlt
