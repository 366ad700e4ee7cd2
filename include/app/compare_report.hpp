// The results of `mlt compare` as text and as JSON.
#pragma once

#include <string>
#include <vector>

#include "app/compare_command.hpp"

namespace mlt {

struct PairResult {
  std::string name;       ///< of the file in both folders; empty for a pair given by its files
  std::string image;      ///< path
  std::string reference;  ///< path
  std::uint32_t width = 0, height = 0;
  ImageComparison comparison;       ///< without FLIP's map
  std::vector<std::size_t> beyond;  ///< metrics beyond their limit, by index
};

/// One metric a line.
std::string pair_text(const PairResult& pair);
std::string pair_json(const PairResult& pair);

/// A table: one pair a line, then the mean and the worst over all pairs.
std::string folder_text(const std::vector<PairResult>& pairs);
std::string folder_json(const std::vector<PairResult>& pairs);

/// One line for each metric beyond its limit, as messages for people.
std::string limit_messages(const PairResult& pair, const CompareCommand& command);

std::string test_text(const ReplicateTestResult& result, const CompareCommand& command);
std::string test_json(const ReplicateTestResult& result, const CompareCommand& command);

}  // namespace mlt
