#include "converge/report.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "converge/plot.hpp"

namespace mlt {
namespace {

constexpr char kStyle[] = R"(
body { font: 16px/1.5 Charter, "Bitstream Charter", Palatino, Georgia, "Liberation Serif", serif;
  color: #1c1c1c; max-width: 1120px; margin: 2.5rem auto; padding: 0 1.2rem; background: #fff; }
h1 { font-size: 1.7rem; margin: 0 0 .2rem; }
h2 { font-size: 1.3rem; margin: 3rem 0 .4rem; padding-top: .8rem; border-top: 1px solid #bbb; }
h3 { font-size: 1.02rem; margin: 1.6rem 0 .4rem; }
a { color: #1d4f8a; text-decoration: none; }
p { margin: .4rem 0; }
.quiet { color: #555; }
.small, figcaption { font-size: .88rem; }
table { border-collapse: collapse; margin: .7rem 0; border-top: 2px solid #222; width: 100%;
  border-bottom: 2px solid #222; font-size: .86rem; font-variant-numeric: tabular-nums lining-nums; }
th, td { padding: .18rem .4rem; text-align: right; white-space: nowrap; }
th { font-weight: 600; }
thead th { border-bottom: 1px solid #222; vertical-align: bottom; }
.l { text-align: left; }
tr.new td { border-top: 1px solid #ccc; }
tr.equal td { background: #f4f1e6; }
.range { color: #666; font-size: .92em; }
sup { line-height: 0; font-size: .75em; }
figure { margin: 1rem 0; break-inside: avoid; }
.wide { overflow-x: auto; }
.plots { display: grid; grid-template-columns: 1fr 1fr; gap: 1rem; }
.plots svg { width: 100%; height: auto; }
.pictures { display: grid; gap: .5rem .6rem; align-items: start; }
.pictures .head { font-weight: 600; font-size: .86rem; text-align: center; align-self: end;
  line-height: 1.3; }
.pictures .row { font-size: .86rem; writing-mode: vertical-rl; color: #444; transform: rotate(180deg);
  text-align: center; align-self: center; justify-self: center; }
.pictures img { width: 100%; display: block; image-rendering: pixelated; }
.warning { border-left: 3px solid #b5452a; padding-left: .7rem; }
code { font: .82em/1.4 "DejaVu Sans Mono", Menlo, monospace; overflow-wrap: anywhere; }
@media print { body { max-width: none; margin: 0; } h2 { break-before: page; } }
)";

std::string number(double value, const char* format = "{:.3g}") {
  if (std::isnan(value)) return "&#8211;";
  if (std::isinf(value)) return "&#8734;";
  std::string text = fmt::format(fmt::runtime(format), value);
  std::string exponent;
  if (const std::size_t at = text.find('e'); at != std::string::npos) {
    // "e-05" as a power of ten.
    std::string digits = text.substr(at + 2);
    digits.erase(0, std::min(digits.find_first_not_of('0'), digits.size() - 1));
    exponent = fmt::format(" &#215; 10<sup>{}{}</sup>", text[at + 1] == '-' ? "&#8722;" : "", digits);
    text.resize(at);
  }
  if (text.starts_with('-')) text = "&#8722;" + text.substr(1);
  return text + exponent;
}

std::string with_error(double value, double error, const char* format = "{:.2f}") {
  if (std::isnan(value)) return number(value);
  return number(value, format) + " &#177; " + number(error, format);
}

std::string with_interval(const Bounded& value) {
  if (std::isnan(value.value)) return number(value.value);
  return fmt::format("{} <span class=\"range\">[{}, {}]</span>", number(value.value), number(value.low),
                     number(value.high));
}

std::string effort(const Bounded& value) {
  if (value.value == 0) return "at once";
  if (std::isinf(value.value)) return "not reached";
  return with_interval(value);
}

const LevelSummary& equal_time_level(const MethodSummary& method) {
  return method.levels[static_cast<std::size_t>(method.equal_time_level)];
}

/// The scene's name without folder and extension, and the result's folder where that says more.
std::string title_of(const ReportEntry& entry) {
  std::string name = entry.summary.scene.substr(entry.summary.scene.rfind('/') + 1);
  if (name.rfind('.') != std::string::npos && name.rfind('.') > 0) name.resize(name.rfind('.'));
  if (!entry.folder.empty() && entry.folder != name) name += " (" + entry.folder + ")";
  return xml_text(name);
}

std::string error_name(const ConvergeSummary& summary) {
  return summary.reference.empty() ? "relative variance" : "relMSE";
}

/// A row a method and scene: what most readers look for.
std::string overview(const std::vector<ReportEntry>& entries) {
  std::string text =
      "<div class=\"wide\"><table><thead><tr><th class=\"l\">scene</th><th class=\"l\">method</th><th>time "
      "[s]</th>"
      "<th>error, median</th><th>95th percentile</th><th>efficiency over base [95 %]</th>"
      "<th>by processor time</th><th>slope over time</th></tr></thead><tbody>\n";
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const ReportEntry& entry = entries[i];
    for (const MethodSummary& method : entry.summary.methods) {
      const bool first = &method == &entry.summary.methods[0];
      const LevelSummary& level = equal_time_level(method);
      text += fmt::format(
          "<tr{}><td class=\"l\">{}</td><td class=\"l\">{}</td><td>{}</td><td>{}</td><td>{}</td>"
          "<td>{}</td><td>{}</td><td>{}</td></tr>\n",
          first ? " class=\"new\"" : "",
          first ? fmt::format("<a href=\"#s{}\">{}</a>", i, title_of(entry)) : "", xml_text(method.name),
          number(level.wall_seconds), number(level.rel_mse_median), number(level.rel_mse_p95),
          with_interval(method.ratio), number(method.ratio_cpu.value),
          with_error(method.slope_time, method.slope_time_error));
    }
  }
  return text + "</tbody></table></div>\n";
}

std::string conditions(const ConvergeSummary& summary) {
  std::string text = fmt::format(
      "<p><code>{}</code>, {:g} &#215; {:g} pixels, depth {:g}, {:g} thread{}, {:g} replicates with seeds "
      "from {:.0f}{}. ",
      xml_text(summary.scene), summary.width, summary.height, summary.depth, summary.threads,
      summary.threads == 1 ? "" : "s", summary.replicates, summary.first_seed,
      summary.interrupted ? " (stopped before the last)" : "");
  if (summary.reference.empty()) {
    text += "There is no reference: the error is the relative variance over replicates.";
  } else {
    text += fmt::format("Errors against <code>{}</code>, mean {}", xml_text(summary.reference),
                        number(summary.reference_mean, "{:.5g}"));
    text +=
        summary.reference_variance.empty()
            ? ", whose own noise is not known."
            : fmt::format(" &#177; {}, whose own relMSE of {} is taken off.",
                          number(summary.reference_mean_error, "{:.2g}"), number(summary.reference_rel_mse));
  }
  text += "</p>\n";
  for (const std::string& warning : summary.warnings) {
    text += fmt::format("<p class=\"warning small\">{}</p>\n", xml_text(warning));
  }
  return text;
}

std::string plots(const ConvergeSummary& summary) {
  return fmt::format(
      "<figure><div class=\"plots\">{}{}</div><figcaption>Error against wall time and against samples. Lines "
      "are "
      "medians over replicates, bands hold the middle 80 %.{}</figcaption></figure>\n",
      to_svg(plot_over_time(summary)), to_svg(plot_over_samples(summary)),
      std::isnan(summary.target) ? "" : " Bars on the target's line are 95 % intervals.");
}

std::string picture(const ReportEntry& entry, const std::string& name, const std::string& description) {
  const auto found = entry.pictures.find(name);
  if (found == entry.pictures.end()) return "<div></div>";
  return fmt::format("<img alt=\"{}\" src=\"data:image/png;base64,{}\">", xml_text(description),
                     base64(found->second));
}

std::string pictures(const ReportEntry& entry) {
  const ConvergeSummary& summary = entry.summary;
  const std::string base = summary.reference.empty() ? "mean of all" : "reference";
  std::string text = fmt::format(
      "<figure><div class=\"pictures\" style=\"grid-template-columns: 1.4rem repeat({}, minmax(0, {}px))\">\n"
      "<div></div>",
      summary.methods.size() + 1, summary.methods.size() <= 2 ? 300 : 250);
  for (const MethodSummary& method : summary.methods) {
    const LevelSummary& level = equal_time_level(method);
    text += fmt::format("<div class=\"head\">{}, {} s<br>{} {}</div>", xml_text(method.name),
                        number(level.wall_seconds), error_name(summary), number(level.rel_mse_median));
  }
  text += fmt::format("<div class=\"head\">{}</div>\n", base);
  struct Row {
    const char* name;
    std::string MethodSummary::*file;
    bool with_base;
  };
  constexpr Row kRows[] = {{"one render", &MethodSummary::picture, true},
                           {"mean of replicates", &MethodSummary::mean_picture, false},
                           {"error of one render", &MethodSummary::error_map, false},
                           {"mean against base", &MethodSummary::difference_map, false}};
  for (const Row& row : kRows) {
    const bool difference = row.file == &MethodSummary::difference_map;
    const std::string name = difference ? "mean &#8722; " + base : row.name;
    text += fmt::format("<div class=\"row\">{}</div>", name);
    for (const MethodSummary& method : summary.methods) {
      text += picture(entry, method.*row.file, fmt::format("{}: {}", method.name, row.name));
    }
    text += row.with_base ? picture(entry, summary.reference_picture, base) : "<div></div>";
    text += "\n";
  }
  return text +
         fmt::format(
             "</div><figcaption>About {} s of wall time for each method. Error of one render: root mean "
             "square over replicates of the difference from the {}, relative to it. Last row: signed "
             "relative difference of the mean over replicates; what is left there is bias or the mean's "
             "own noise. Each row of maps has one scale.</figcaption></figure>\n",
             number(summary.equal_time_seconds), base);
}

std::string level_table(const ConvergeSummary& summary) {
  std::string text = fmt::format(
      "<div class=\"wide\"><table><thead><tr><th "
      "class=\"l\">method</th><th>budget<br>[1/pixel]</th><th>wall<br>[s]</th>"
      "<th>processors<br>[s]</th><th>samples<br>[1/pixel]</th><th>{}, median<br>[10 %, 90 %]</th><th>95th<br>"
      "percentile</th><th>mean<br>error</th><th>bias of the<br>mean [%]</th><th>efficiency<br>[1/s]</th>"
      "<th>over<br>{}</th></tr></thead><tbody>\n",
      error_name(summary), xml_text(summary.base));
  for (const MethodSummary& method : summary.methods) {
    for (std::size_t i = 0; i < method.levels.size(); ++i) {
      const LevelSummary& level = method.levels[i];
      const bool equal = static_cast<double>(i) == method.equal_time_level;
      text += fmt::format(
          "<tr class=\"{}{}\"><td class=\"l\">{}</td><td>{:g}</td><td>{}</td><td>{}</td><td>{}</td><td>{} "
          "<span "
          "class=\"range\">[{}, "
          "{}]</span></td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
          i == 0 ? "new " : "", equal ? "equal" : "", i == 0 ? xml_text(method.name) : "", level.budget,
          number(level.wall_seconds), number(level.cpu_seconds), number(level.samples_per_pixel, "{:.4g}"),
          number(level.rel_mse_median), number(level.rel_mse_p10), number(level.rel_mse_p90),
          number(level.rel_mse_p95), number(level.rel_mse_mean),
          with_error(100 * level.bias, 100 * level.bias_standard_error), number(level.efficiency),
          number(level.ratio));
    }
  }
  return text +
         "</tbody></table></div>\n<p class=\"quiet small\">Shaded: the level whose pictures are shown. "
         "Efficiency is 1 / (median error &#215; median wall time); its ratio is to that of the base at the "
         "same time.</p>\n";
}

std::string method_table(const ConvergeSummary& summary) {
  const bool target = !std::isnan(summary.target);
  std::string text = fmt::format(
      "<div class=\"wide\"><table><thead><tr><th class=\"l\">method</th><th>slope over time</th>"
      "<th>slope over samples</th><th>efficiency over {}</th><th>by processor time</th>",
      xml_text(summary.base));
  if (target) {
    const std::string shown = number(summary.target);
    text += fmt::format("<th>wall s to {}</th><th>processor s to {}</th><th>samples/pixel to {}</th>", shown,
                        shown, shown);
  }
  text += "</tr></thead><tbody>\n";
  for (const MethodSummary& method : summary.methods) {
    text +=
        fmt::format("<tr><td class=\"l\">{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>",
                    xml_text(method.name), with_error(method.slope_time, method.slope_time_error, "{:.3f}"),
                    with_error(method.slope_samples, method.slope_samples_error, "{:.3f}"),
                    with_interval(method.ratio), with_interval(method.ratio_cpu));
    if (target) {
      text += fmt::format("<td>{}</td><td>{}</td><td>{}</td>", effort(method.seconds_to_target),
                          effort(method.cpu_seconds_to_target), effort(method.samples_per_pixel_to_target));
    }
    text += "</tr>\n";
  }
  return text +
         "</tbody></table></div>\n<p class=\"quiet small\">Slopes are least squares of log error on log "
         "effort over all replicates, &#177; standard error; intervals are 95 % bootstrap intervals over "
         "replicates. Efficiencies are compared with that of the base: the first path tracer, or else the "
         "first "
         "method.</p>\n";
}

}  // namespace

std::string base64(const std::string& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63] : '=';
    }
  }
  return text;
}

std::string report_page(const std::vector<ReportEntry>& entries) {
  std::string text = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width\">\n<title>Error against time and "
      "samples</title>\n<style>{}</style></head><body>\n"
      "<h1>Error against time and samples</h1>\n<p class=\"quiet\">{} run{} of <code>mlt converge</code>, "
      "mlt {}</p>\n"
      "<h3>At equal time</h3>\n",
      kStyle, entries.size(), entries.size() == 1 ? "" : "s",
      entries.empty() ? "" : xml_text(entries.front().summary.version));
  text += overview(entries);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const ReportEntry& entry = entries[i];
    text += fmt::format("<section id=\"s{}\"><h2>{}</h2>\n", i, title_of(entry));
    text += conditions(entry.summary) + plots(entry.summary) + method_table(entry.summary) + pictures(entry) +
            level_table(entry.summary);
    text +=
        fmt::format("<p class=\"small\"><code>{}</code></p></section>\n", xml_text(entry.summary.command));
  }
  return text + "</body></html>\n";
}

}  // namespace mlt
