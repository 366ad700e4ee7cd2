// One HTML page of all results of `mlt converge` below a folder: pictures at equal time, maps of the error,
// plots and tables. It needs no other file: pictures are embedded, styles inline, and there is no script.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "converge/summary.hpp"

namespace mlt {

struct ReportEntry {
  std::string folder;  ///< below the report's; empty for that itself
  ConvergeSummary summary;
  std::map<std::string, std::string> pictures;  ///< bytes of the PNG files that the summary names
};

/// Every summary.json in `folder` and its subfolders, with the pictures beside it, in the order of their
/// paths. Symbolic links to folders are not followed. Throws InputError when there is none, when one is no
/// summary, or when a picture is not a PNG file of that folder.
std::vector<ReportEntry> read_results(const std::string& folder);

std::string report_page(const std::vector<ReportEntry>& entries);

/// [RFC4648 section 4], with padding.
std::string base64(const std::string& bytes);

}  // namespace mlt
