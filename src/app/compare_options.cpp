#include <fmt/core.h>

#include "app/compare_command.hpp"

namespace mlt {
namespace {

std::string flip_modes() {
  std::string text;
#define MLT_ITEM(name, help) text += std::string(text.empty() ? "" : "; ") + #name ": " + (help);
  MLT_FLIP_MODES(MLT_ITEM)
#undef MLT_ITEM
  return text;
}

std::string metric_keys() {
  std::string text;
  for (const MetricInfo& metric : kMetrics) text += (text.empty() ? "" : ", ") + std::string(metric.key);
  return text;
}

}  // namespace

std::string limit_option(const MetricInfo& metric) {
  std::string name = std::string(metric.bound == MetricBound::max ? "--max-" : "--min-") + metric.key;
  for (char& letter : name) {
    if (letter == '_') letter = '-';
  }
  return name;
}

void add_compare_options(std::vector<OptionSpec>& table) {
  const auto add = [&table](const char* name, const char* value, std::string help) {
    table.push_back({name, "", value, false, {CommandKind::compare}, std::move(help)});
  };
  for (const MetricInfo& metric : kMetrics) {
    add(limit_option(metric).c_str(), "X",
        fmt::format("{}, {}: exit with code 1 when it is {} X", metric.label, metric.help,
                    metric.bound == MetricBound::max ? "above" : "below"));
  }
  add("--json", "", "prints one JSON object instead of lines");
  add("--difference", "FILE",
      "writes the signed difference A - B: as .png its luminance in red and blue with a scale, as .pfm the "
      "values themselves; for folders, a folder of PNG files");
  add("--difference-range", "X",
      "difference at which --difference is darkest; default: from the differences");
  add("--heat-map", "FILE", "writes the error of each pixel as PNG with a scale; for folders, a folder");
  add("--heat-metric", "NAME", fmt::format("metric of --heat-map: {}. Default: flip", metric_keys()));
  add("--heat-range", "X",
      "error at which --heat-map is brightest; default: 1 for FLIP, else from the errors");
  add("--flip", "MODE",
      fmt::format("how FLIP looks at the images. {}. Default: ldr when one of them is a PNG, else hdr",
                  flip_modes()));
  add("--pixels-per-degree", "X",
      fmt::format("how large FLIP sees a pixel, {} to {}; default {:.2f}: 3840 pixels on 0.7 m, 0.7 m away",
                  kMinPixelsPerDegree, kMaxPixelsPerDegree, kPixelsPerDegree));
  add("--exposure", "EV", "brightens both images by 2^EV for PSNR and for FLIP's ldr, -64 to 64; default 0");
  add("--test", "",
      "compares two sets of replicates: Welch's t-test of the image means and of tile means with Sidak's "
      "correction, and a Kolmogorov-Smirnov test of the p-values; exit with code 1 when one of them rejects");
  add("--alpha", "P",
      fmt::format("--test: probability of rejecting sets that do not differ; default {}",
                  ReplicateTestOptions{}.alpha));
  add("--tile", "N",
      fmt::format("--test: side of the tiles in pixels, 1 to {}; default {}", kMaxTile,
                  ReplicateTestOptions{}.tile));
  add("--p-picture", "FILE", "--test: writes the p-value of each tile as PNG with a scale");
}

}  // namespace mlt
