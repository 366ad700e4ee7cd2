// Curves with bands on logarithmic axes, as SVG 1.1 [SVG11] that stands alone as a file and can be put into a
// page. Curves are told apart by colour [Okabe08], dashes and markers at once, so that a grey print is
// enough.
#pragma once

#include <string>
#include <vector>

#include "converge/summary.hpp"

namespace mlt {

struct PlotPoint {
  double x = 0, y = 0;
  double low = 0, high = 0;  ///< of the band
};

struct PlotSeries {
  std::string name;
  std::vector<PlotPoint> points;  ///< by x; those whose x or y is not positive are left out
  Bounded target_x;               ///< where y falls to Plot::target, drawn when it is finite and positive
};

struct Plot {
  std::string title, x_label, y_label;
  double target = kUnknown;  ///< a line across; NaN for none
  std::vector<PlotSeries> series;
};

/// An svg element without XML declaration. Points are placed to a hundredth of a pixel.
std::string to_svg(const Plot& plot);

Plot plot_over_time(const ConvergeSummary& summary);
Plot plot_over_processor_time(const ConvergeSummary& summary);
Plot plot_over_samples(const ConvergeSummary& summary);

/// `text` with the characters that XML and HTML reserve replaced, control characters left out, and bytes that
/// are not UTF-8 as U+FFFD.
std::string xml_text(const std::string& text);

}  // namespace mlt
