// What `mlt compare` was asked for, and its parser.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/options.hpp"
#include "compare/compare.hpp"
#include "compare/replicates.hpp"

namespace mlt {

struct CompareCommand {
  std::string image;      ///< or a folder
  std::string reference;  ///< or a folder
  std::array<std::optional<double>, kMetricCount> limits;
  std::optional<FlipMode> flip_mode;  ///< nothing: chosen by the formats
  double pixels_per_degree = kPixelsPerDegree;
  float exposure = 0;  ///< EV
  bool json = false;
  std::optional<std::string> difference;  ///< .png or .pfm; with folders, a folder
  std::optional<std::string> heat_map;    ///< .png; with folders, a folder
  MetricKind heat_metric = MetricKind::flip;
  std::optional<double> difference_range, heat_range;

  bool test = false;  ///< instead of all of the above, except `json`:
  std::vector<std::string> first, second;
  ReplicateTestOptions test_options;
  std::optional<std::string> p_picture;
};

/// "--max-relmse", "--min-psnr", ...
std::string limit_option(const MetricInfo& metric);

inline constexpr std::uint32_t kMaxTile = 65536;  ///< pixels

/// `words` behind "compare"; nothing when --help is among them. Throws InputError with every fault found.
std::optional<CompareCommand> parse_compare(const std::vector<std::string>& words);

/// The options of compare, for the table of all options.
void add_compare_options(std::vector<OptionSpec>& table);

}  // namespace mlt
