#include "converge/plot.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/json_string.hpp"

namespace mlt {
namespace {

constexpr double kWidth = 640, kHeight = 440;
constexpr double kLeft = 76, kRight = 622, kTop = 40, kBottom = 376;
constexpr double kFewDecades = 2.6;    // below, ticks at 2 and 5 are labelled too
constexpr double kLeastDecades = 0.7;  // holds two labels wherever it begins
constexpr double kPadding = 0.05;      // of the range, free at either end
constexpr double kLegendLine = 20;
constexpr double kLegendLetter = 7.4;  // mean width of a letter at the font's size
constexpr double kLegendKey = 62;      // what a line of the legend needs besides its text
constexpr std::size_t kLinesInside = 4;
constexpr double kWidthInside = 260;  // a legend with more lines, or wider, stands below the frame

struct Style {
  const char* colour;
  const char* dashes;
};
constexpr Style kStyles[] = {{"#0072B2", "none"},     {"#D55E00", "8 4"}, {"#009E73", "2 3"},
                             {"#CC79A7", "10 3 2 3"}, {"#555555", "5 2"}, {"#E69F00", "12 3"},
                             {"#56B4E9", "6 2 2 2"}};

const Style& style_of(std::size_t index) {
  return kStyles[index % std::size(kStyles)];
}

/// A logarithmic axis: decades [low, high] onto [from, to].
struct Axis {
  double low = 0, high = 1;
  double from = 0, to = 1;

  double at_decade(double decade) const { return from + (decade - low) / (high - low) * (to - from); }
  double at(double value) const { return at_decade(std::clamp(log10_of(value), low, high)); }
  double decades() const { return high - low; }
};

/// The axis over all values that are positive and finite.
Axis axis_over(const std::vector<double>& values, double from, double to) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const double value : values) {
    if (!(value > 0) || !std::isfinite(value)) continue;
    low = std::min(low, log10_of(value));
    high = std::max(high, log10_of(value));
  }
  if (low > high) low = high = 0;
  const double missing = std::max(0.0, kLeastDecades - (high - low));
  const double padding = 0.5 * missing + kPadding * (high - low + missing);
  // Numbers so small or large that their powers of ten would leave double's range are cut off.
  return {std::max(low - padding, -290.0), std::min(high + padding, 290.0), from, to};
}

/// "0.02" where that is short, else "2 x 10" with its exponent raised.
std::string tick_label(int factor, int decade) {
  if (decade >= -3 && decade <= 3) return fmt::format("{:g}", factor * power_of_10(decade));
  const std::string power = fmt::format("10<tspan dy=\"-5\" font-size=\"9\">{}{}</tspan>",
                                        decade < 0 ? "&#8722;" : "", std::abs(decade));
  return factor == 1 ? power : fmt::format("{}&#215;{}", factor, power);
}

std::string line(double x1, double y1, double x2, double y2, const std::string& style) {
  return fmt::format("<line x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\" {}/>\n", x1, y1, x2, y2,
                     style);
}

std::string text_at(double x, double y, const std::string& style, const std::string& content) {
  return fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" {}>{}</text>\n", x, y, style, content);
}

/// Grid lines, ticks and numbers of one axis.
std::string draw_axis(const Axis& axis, bool horizontal) {
  std::string text;
  const bool few = axis.decades() < kFewDecades;
  const int step = std::max(1, static_cast<int>(axis.decades() / 8));
  for (int decade = static_cast<int>(std::floor(axis.low)); decade <= axis.high; ++decade) {
    for (int factor = 1; factor <= 9; ++factor) {
      const double place = decade + log10_of(factor);
      if (place < axis.low || place > axis.high) continue;
      const bool labelled = (factor == 1 && decade % step == 0) || (few && (factor == 2 || factor == 5));
      const double at = axis.at_decade(place);
      const double length = labelled ? 6 : 3;
      const std::string label = labelled ? tick_label(factor, decade) : "";
      if (horizontal) {
        if (labelled) text += line(at, kTop, at, kBottom, "stroke=\"#e4e4e4\"");
        text += line(at, kBottom, at, kBottom + length, "stroke=\"#333\"");
        if (labelled) text += text_at(at, kBottom + 20, "text-anchor=\"middle\"", label);
      } else {
        if (labelled) text += line(kLeft, at, kRight, at, "stroke=\"#e4e4e4\"");
        text += line(kLeft - length, at, kLeft, at, "stroke=\"#333\"");
        if (labelled) text += text_at(kLeft - 9, at + 4, "text-anchor=\"end\"", label);
      }
    }
  }
  return text;
}

std::string marker(std::size_t index, double x, double y) {
  const std::string style = fmt::format("fill=\"{}\" stroke=\"#fff\"", style_of(index).colour);
  switch (index % 4) {
    case 0:
      return fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"4.2\" {}/>\n", x, y, style);
    case 1:
      return fmt::format("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"8\" height=\"8\" {}/>\n", x - 4, y - 4,
                         style);
    case 2:
      return fmt::format("<path d=\"M{:.2f} {:.2f}l5 9h-10z\" {}/>\n", x, y - 5.5, style);
    default:
      return fmt::format("<path d=\"M{:.2f} {:.2f}l5.2 5.2l-5.2 5.2l-5.2 -5.2z\" {}/>\n", x, y - 5.2, style);
  }
}

std::vector<PlotPoint> drawable(const PlotSeries& series) {
  std::vector<PlotPoint> points;
  for (PlotPoint point : series.points) {
    const bool known = point.x > 0 && point.y > 0 && std::isfinite(point.x) && std::isfinite(point.y);
    if (!known) continue;
    // A band that reaches below every logarithm ends at the axis, which Axis::at sees to.
    point.low = point.low > 0 ? point.low : std::numeric_limits<double>::min();
    point.high = std::isfinite(point.high) ? std::max(point.high, point.y) : point.y;
    points.push_back(point);
  }
  return points;
}

struct Canvas {
  Axis x, y;
};

std::string draw_band(const Canvas& canvas, std::size_t index, const std::vector<PlotPoint>& points) {
  if (points.empty()) return "";
  std::string upper, lower;
  for (const PlotPoint& point : points) {
    upper += fmt::format("{:.2f},{:.2f} ", canvas.x.at(point.x), canvas.y.at(point.high));
    lower = fmt::format("{:.2f},{:.2f} ", canvas.x.at(point.x), canvas.y.at(point.low)) + lower;
  }
  lower.pop_back();
  return fmt::format("<polygon points=\"{}{}\" fill=\"{}\" fill-opacity=\"0.16\"/>\n", upper, lower,
                     style_of(index).colour);
}

std::string draw_curve(const Canvas& canvas, std::size_t index, const std::vector<PlotPoint>& points) {
  if (points.empty()) return "";
  std::string places, markers;
  for (const PlotPoint& point : points) {
    const double x = canvas.x.at(point.x);
    const double y = canvas.y.at(point.y);
    places += fmt::format("{}{:.2f},{:.2f}", places.empty() ? "" : " ", x, y);
    markers += marker(index, x, y);
  }
  return fmt::format(
             "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\" "
             "stroke-linejoin=\"round\" stroke-dasharray=\"{}\"/>\n",
             places, style_of(index).colour, style_of(index).dashes) +
         markers;
}

/// A dotted line of slope -1, half of the first curve's first point, to its end at a side of the frame.
std::string draw_guide(const Canvas& canvas, const std::vector<PlotPoint>& points) {
  if (points.empty()) return "";
  const double x = log10_of(points.front().x);
  const double y = log10_of(points.front().y) - log10_of(2);
  if (y <= canvas.y.low || x >= canvas.x.high) return "";
  const double length = std::min(canvas.x.high - x, y - canvas.y.low);
  return line(canvas.x.at_decade(x), canvas.y.at_decade(y), canvas.x.at_decade(x + length),
              canvas.y.at_decade(y - length),
              "stroke=\"#888\" stroke-dasharray=\"1 4\" stroke-linecap=\"round\"");
}

/// The target's line, and on it where the curves meet it with their intervals.
std::string draw_target(const Canvas& canvas, const Plot& plot) {
  if (!(plot.target > 0) || !std::isfinite(plot.target)) return "";
  const double y = canvas.y.at(plot.target);
  std::string text =
      line(kLeft, y, kRight, y, "stroke=\"#333\" stroke-width=\"0.8\" stroke-dasharray=\"3 3\"");
  text +=
      text_at(kLeft + 6, y - 5, "font-size=\"11\" fill=\"#333\"", fmt::format("target {:g}", plot.target));
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const Bounded& place = plot.series[i].target_x;
    if (!(place.value > 0) || !std::isfinite(place.value)) continue;
    const std::string style = fmt::format("stroke=\"{}\" stroke-width=\"1.6\"", style_of(i).colour);
    const double low = place.low > 0 ? canvas.x.at(place.low) : kLeft;
    const double high = std::isfinite(place.high) && place.high > 0 ? canvas.x.at(place.high) : kRight;
    text += line(low, y, high, y, style) + line(low, y - 5, low, y + 5, style) +
            line(high, y - 5, high, y + 5, style);
  }
  return text;
}

/// Whether a point of a curve lies in a box of the canvas.
bool covers_a_point(const Canvas& canvas, const std::vector<std::vector<PlotPoint>>& curves, double left,
                    double top, double width, double height) {
  for (const auto& points : curves) {
    for (const PlotPoint& point : points) {
      const double x = canvas.x.at(point.x) - left;
      const double y = canvas.y.at(point.y) - top;
      if (x >= 0 && x <= width && y >= 0 && y <= height) return true;
    }
  }
  return false;
}

struct Legend {
  double left, top, width, height;
  double scale = 1;    ///< of the letters, below 1 where the longest name would leave the picture
  bool below = false;  ///< the frame, where the picture is made higher for it
};

/// In the upper right corner, which falling curves leave free, or else the lower left one, or below.
Legend place_legend(const Plot& plot, const Canvas& canvas, const std::vector<std::vector<PlotPoint>>& curves,
                    bool has_guide) {
  std::size_t longest = 8;
  for (const PlotSeries& series : plot.series) longest = std::max(longest, series.name.size());
  const std::size_t lines = plot.series.size() + (has_guide ? 1 : 0);
  const double letters = kLegendLetter * static_cast<double>(longest);
  const double width = kLegendKey + letters;
  const double height = 10 + kLegendLine * static_cast<double>(lines);
  if (lines > kLinesInside || width > kWidthInside) {
    const double room = kWidth - kLeft - 8;
    return {kLeft, kHeight, std::min(width, room), height, std::min(1.0, (room - kLegendKey) / letters),
            true};
  }
  const Legend corner{kRight - width - 8, kTop + 8, width, height};
  const Legend other{kLeft + 8, kBottom - height - 8, width, height};
  const auto covers = [&](const Legend& legend) {
    return covers_a_point(canvas, curves, legend.left, legend.top, legend.width, legend.height);
  };
  return covers(corner) && !covers(other) ? other : corner;
}

std::string draw_legend(const Plot& plot, const Legend& legend, bool has_guide) {
  std::string text = fmt::format(
      "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"#fff\" "
      "fill-opacity=\"0.85\" "
      "stroke=\"#ccc\"/>\n",
      legend.left, legend.top, legend.width, legend.height);
  const double left = legend.left;
  const std::string font = legend.scale < 1 ? fmt::format("font-size=\"{:.2f}\"", 13 * legend.scale) : "";
  double y = legend.top + 5 + kLegendLine / 2;
  for (std::size_t i = 0; i < plot.series.size(); ++i, y += kLegendLine) {
    text += fmt::format(
        "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"36\" height=\"12\" fill=\"{}\" fill-opacity=\"0.16\"/>\n",
        left + 8, y - 6, style_of(i).colour);
    text += line(left + 8, y, left + 44, y,
                 fmt::format("stroke=\"{}\" stroke-width=\"2\" stroke-dasharray=\"{}\"", style_of(i).colour,
                             style_of(i).dashes));
    text += marker(i, left + 26, y) + text_at(left + 52, y + 4.5, font, xml_text(plot.series[i].name));
  }
  if (has_guide) {
    text +=
        line(left + 8, y, left + 44, y, "stroke=\"#888\" stroke-dasharray=\"1 4\" stroke-linecap=\"round\"");
    text += text_at(left + 52, y + 4.5, "fill=\"#555\"", "slope &#8722;1");
  }
  return text;
}

Canvas canvas_for(const Plot& plot, const std::vector<std::vector<PlotPoint>>& curves) {
  std::vector<double> xs, ys{plot.target};
  for (const auto& points : curves) {
    for (const PlotPoint& point : points) {
      xs.push_back(point.x);
      // A band that falls far below its line must not stretch the axis without end.
      ys.insert(ys.end(), {point.y, point.high, std::max(point.low, 0.05 * point.y)});
    }
  }
  return {axis_over(xs, kLeft, kRight), axis_over(ys, kBottom, kTop)};
}

std::string threads_of(const ConvergeSummary& summary) {
  return summary.threads == 1 ? "1 thread" : fmt::format("{:g} threads", summary.threads);
}

Plot plot_of(const ConvergeSummary& summary, const std::string& x_label, double LevelSummary::*x,
             Bounded MethodSummary::*target) {
  Plot plot;
  plot.title = fmt::format("{}, {:g} x {:g}, {:g} replicates", summary.scene, summary.width, summary.height,
                           summary.replicates);
  plot.x_label = x_label;
  plot.y_label = summary.reference.empty() ? "relative variance" : "relMSE";
  plot.target = summary.target;
  for (const MethodSummary& method : summary.methods) {
    PlotSeries series{method.name, {}, method.*target};
    for (const LevelSummary& level : method.levels) {
      series.points.push_back({level.*x, level.rel_mse_median, level.rel_mse_p10, level.rel_mse_p90});
    }
    plot.series.push_back(std::move(series));
  }
  return plot;
}

}  // namespace

std::string xml_text(const std::string& text) {
  std::string result;
  for (const char letter : valid_utf8(text)) {
    if (letter == '&') {
      result += "&amp;";
    } else if (letter == '<') {
      result += "&lt;";
    } else if (letter == '>') {
      result += "&gt;";
    } else if (letter == '"') {
      result += "&quot;";
    } else if (static_cast<unsigned char>(letter) >= 0x20 && letter != 0x7F) {
      result += letter;
    }
  }
  return result;
}

std::string to_svg(const Plot& plot) {
  std::vector<std::vector<PlotPoint>> curves;
  for (const PlotSeries& series : plot.series) curves.push_back(drawable(series));
  const Canvas canvas = canvas_for(plot, curves);
  const std::string guide = curves.empty() ? "" : draw_guide(canvas, curves.front());
  const Legend legend = place_legend(plot, canvas, curves, !guide.empty());
  const double height = legend.below ? kHeight + legend.height + 10 : kHeight;
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:g} {:g}\" width=\"{:g}\" height=\"{:g}\" "
      "role=\"img\" font-family=\"Helvetica, Arial, 'Liberation Sans', sans-serif\" font-size=\"13\" "
      "fill=\"#222\">\n<title>{}: {} over {}</title>\n<rect width=\"{:g}\" height=\"{:g}\" fill=\"#fff\"/>\n",
      kWidth, height, kWidth, height, xml_text(plot.title), xml_text(plot.y_label), xml_text(plot.x_label),
      kWidth, height);
  text += draw_axis(canvas.x, true) + draw_axis(canvas.y, false);
  text += guide;
  for (std::size_t i = 0; i < curves.size(); ++i) text += draw_band(canvas, i, curves[i]);
  text += draw_target(canvas, plot);
  for (std::size_t i = 0; i < curves.size(); ++i) text += draw_curve(canvas, i, curves[i]);
  text += fmt::format(
      "<rect x=\"{:g}\" y=\"{:g}\" width=\"{:g}\" height=\"{:g}\" fill=\"none\" stroke=\"#333\"/>\n", kLeft,
      kTop, kRight - kLeft, kBottom - kTop);
  text += draw_legend(plot, legend, !guide.empty());
  text +=
      text_at(0.5 * (kLeft + kRight), 24, "text-anchor=\"middle\" font-size=\"14\"", xml_text(plot.title));
  text += text_at(0.5 * (kLeft + kRight), 422, "text-anchor=\"middle\"", xml_text(plot.x_label));
  text +=
      fmt::format("<text transform=\"translate(20 {:.2f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                  0.5 * (kTop + kBottom), xml_text(plot.y_label + " (line: median, band: 10 % to 90 %)"));
  return text + "</svg>\n";
}

Plot plot_over_time(const ConvergeSummary& summary) {
  return plot_of(summary, "wall time per render [s], " + threads_of(summary), &LevelSummary::wall_seconds,
                 &MethodSummary::seconds_to_target);
}

Plot plot_over_processor_time(const ConvergeSummary& summary) {
  return plot_of(summary, "processor time per render [s], " + threads_of(summary), &LevelSummary::cpu_seconds,
                 &MethodSummary::cpu_seconds_to_target);
}

Plot plot_over_samples(const ConvergeSummary& summary) {
  return plot_of(summary, "samples per pixel [paths, bootstrap included]", &LevelSummary::samples_per_pixel,
                 &MethodSummary::samples_per_pixel_to_target);
}

}  // namespace mlt
