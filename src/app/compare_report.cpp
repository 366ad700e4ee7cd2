#include "app/compare_report.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "app/json.hpp"

namespace mlt {
namespace {

const char* mode_name(FlipMode mode) {
  constexpr const char* kNames[] = {
#define MLT_NAME(name, help) #name,
      MLT_FLIP_MODES(MLT_NAME)
#undef MLT_NAME
  };
  return kNames[static_cast<std::size_t>(mode)];
}

void add_line(std::string& text, const std::string& label, const std::string& value) {
  text += fmt::format("{:<10} {}\n", label, value);
}

/// How FLIP looked at the images.
std::string flip_note(const FlipResult& flip) {
  std::string text =
      fmt::format("{}, {:.4g} pixels per degree", mode_name(flip.mode), flip.pixels_per_degree);
  if (flip.mode == FlipMode::hdr) {
    text += fmt::format(", {} exposures from {:.4f} to {:.4f} EV", flip.exposures, flip.start_exposure,
                        flip.stop_exposure);
  }
  return text;
}

void add_channels(JsonWriter& json, const char* key, const std::array<double, 3>& values) {
  json.begin_array(key);
  for (const double value : values) json.add(nullptr, value);
  json.end_array();
}

void add_metrics(JsonWriter& json, const char* key, const MetricValues& metrics) {
  json.begin_object(key);
  for (std::size_t i = 0; i < kMetricCount; ++i) json.add(kMetrics[i].key, metrics.all[i]);
  json.end_object();
}

void add_pair(JsonWriter& json, const PairResult& pair) {
  const ImageComparison& comparison = pair.comparison;
  json.add("image", pair.image);
  json.add("reference", pair.reference);
  json.add("width", std::uint64_t{pair.width});
  json.add("height", std::uint64_t{pair.height});
  add_metrics(json, "metrics", comparison.metrics);
  add_channels(json, "mean_image", comparison.mean_image);
  add_channels(json, "mean_reference", comparison.mean_reference);
  add_channels(json, "mean_ratio", comparison.mean_ratio);
  json.add("mean_ratio_all", comparison.mean_ratio_all);
  json.begin_object("flip");
  json.add("mode", mode_name(comparison.flip.mode));
  json.add("pixels_per_degree", comparison.flip.pixels_per_degree);
  json.add("start_exposure", comparison.flip.start_exposure);
  json.add("stop_exposure", comparison.flip.stop_exposure);
  json.add("exposures", std::uint64_t{comparison.flip.exposures});
  json.add("maximum", comparison.flip.maximum);
  json.end_object();
  json.begin_array("beyond_limit");
  for (const std::size_t i : pair.beyond) json.add(nullptr, kMetrics[i].key);
  json.end_array();
}

struct Summary {
  MetricValues mean, worst;
};

Summary summarise(const std::vector<PairResult>& pairs) {
  Summary summary;
  for (std::size_t i = 0; i < kMetricCount; ++i) {
    double sum = 0;
    double worst = pairs.front().comparison.metrics.all[i];
    for (const PairResult& pair : pairs) {
      const double value = pair.comparison.metrics.all[i];
      sum += value;
      worst = kMetrics[i].bound == MetricBound::max ? std::max(worst, value) : std::min(worst, value);
    }
    summary.mean.all[i] = sum / static_cast<double>(pairs.size());
    summary.worst.all[i] = worst;
  }
  return summary;
}

std::string table_row(const std::string& name, std::size_t width, const MetricValues& metrics) {
  std::string row = fmt::format("{:<{}}", name, width);
  for (const double value : metrics.all) row += fmt::format(" {:>11.5g}", value);
  return row + '\n';
}

}  // namespace

std::string pair_text(const PairResult& pair) {
  const ImageComparison& comparison = pair.comparison;
  std::string text;
  for (std::size_t i = 0; i < kMetricCount; ++i) {
    std::string value = fmt::format("{:.9g}", comparison.metrics.all[i]);
    if (i == static_cast<std::size_t>(MetricKind::psnr)) value += " dB";
    if (i == static_cast<std::size_t>(MetricKind::flip)) value += " (" + flip_note(comparison.flip) + ")";
    add_line(text, kMetrics[i].label, value);
  }
  const std::array<double, 3>& ratio = comparison.mean_ratio;
  add_line(text, "mean ratio",
           fmt::format("{:.9g} (red {:.9g}, green {:.9g}, blue {:.9g})", comparison.mean_ratio_all, ratio[0],
                       ratio[1], ratio[2]));
  return text;
}

std::string pair_json(const PairResult& pair) {
  JsonWriter json;
  add_pair(json, pair);
  return json.finish();
}

std::string folder_text(const std::vector<PairResult>& pairs) {
  std::size_t width = 5;
  for (const PairResult& pair : pairs) width = std::max(width, pair.name.size());
  std::string text = fmt::format("{:<{}}", "image", width);
  for (const MetricInfo& metric : kMetrics) text += fmt::format(" {:>11}", metric.label);
  text += '\n';
  for (const PairResult& pair : pairs) text += table_row(pair.name, width, pair.comparison.metrics);
  const Summary summary = summarise(pairs);
  text += table_row("mean", width, summary.mean);
  return text + table_row("worst", width, summary.worst);
}

std::string folder_json(const std::vector<PairResult>& pairs) {
  JsonWriter json;
  json.begin_array("pairs");
  for (const PairResult& pair : pairs) {
    json.begin_object();
    json.add("name", pair.name);
    add_pair(json, pair);
    json.end_object();
  }
  json.end_array();
  const Summary summary = summarise(pairs);
  add_metrics(json, "mean", summary.mean);
  add_metrics(json, "worst", summary.worst);
  return json.finish();
}

std::string limit_messages(const PairResult& pair, const CompareCommand& command) {
  std::string text;
  for (const std::size_t i : pair.beyond) {
    const MetricInfo& metric = kMetrics[i];
    text += fmt::format("mlt: {}: {} {:.9g} against {} {} {} {}\n", pair.image, metric.label,
                        pair.comparison.metrics.all[i], pair.reference,
                        metric.bound == MetricBound::max ? "exceeds" : "is below", limit_option(metric),
                        *command.limits[i]);
  }
  return text;
}

std::string test_text(const ReplicateTestResult& result, const CompareCommand& command) {
  std::string text;
  add_line(text, "replicates", fmt::format("{} against {}", command.first.size(), command.second.size()));
  add_line(text, "tiles",
           fmt::format("{} x {} of {} pixels, {} tests", result.tiles_x, result.tiles_y,
                       command.test_options.tile, result.tests));
  add_line(text, "mean p", fmt::format("{:.4g}", result.mean_p_value));
  add_line(text, "smallest p",
           fmt::format("{:.4g} in the tile at x {}, y {}", result.smallest_p_value, result.smallest_x,
                       result.smallest_y));
  add_line(text, "Sidak p", fmt::format("{:.4g}", result.sidak_p_value));
  add_line(text, "KS p",
           fmt::format("{:.4g} (distance {:.4g}, {} relabellings)", result.ks_p_value, result.ks_distance,
                       result.relabellings));
  if (1 / static_cast<double>(result.relabellings) >= result.level) {
    add_line(text, "", "too few replicates for the KS part to reject; 6 in each set suffice for alpha 0.01");
  }
  add_line(
      text, "verdict",
      fmt::format("{}, each test at {:.4g} for alpha {:.4g}",
                  result.rejected ? "rejected: the sets differ by more than noise" : "no difference found",
                  result.level, command.test_options.alpha));
  return text;
}

std::string test_json(const ReplicateTestResult& result, const CompareCommand& command) {
  JsonWriter json;
  for (const bool second : {false, true}) {
    json.begin_array(second ? "second" : "first");
    for (const std::string& path : second ? command.second : command.first) json.add(nullptr, path);
    json.end_array();
  }
  json.add("alpha", command.test_options.alpha);
  json.add("tile", std::uint64_t{command.test_options.tile});
  json.add("tiles_x", std::uint64_t{result.tiles_x});
  json.add("tiles_y", std::uint64_t{result.tiles_y});
  json.add("tests", result.tests);
  json.add("mean_p_value", result.mean_p_value);
  json.add("smallest_p_value", result.smallest_p_value);
  json.add("smallest_x", std::uint64_t{result.smallest_x});
  json.add("smallest_y", std::uint64_t{result.smallest_y});
  json.add("sidak_p_value", result.sidak_p_value);
  json.add("ks_distance", result.ks_distance);
  json.add("ks_p_value", result.ks_p_value);
  json.add("relabellings", result.relabellings);
  json.add("level", result.level);
  json.add("rejected", result.rejected);
  return json.finish();
}

}  // namespace mlt
