// Strict reading of numbers from the command line: the whole word must be the number, and what is refused is
// reported with the option's name, what was found and the allowed range. Faults are collected, so that one
// run reports all of them. Independent of the locale.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"

namespace mlt {

using Diagnostics = std::vector<Diagnostic>;

/// "found 'word'; expected ..." for `option`.
void report_value(const std::string& option, const std::string& word, const std::string& expected,
                  Diagnostics& diagnostics);

/// A decimal integer without sign in [min, max]; nothing, and a diagnostic, for any other word.
std::optional<std::uint64_t> parse_integer(const std::string& option, const std::string& word,
                                           std::uint64_t min, std::uint64_t max, Diagnostics& diagnostics);

/// A finite decimal number in [min, max], rounded to the nearest float.
std::optional<float> parse_real(const std::string& option, const std::string& word, float min, float max,
                                Diagnostics& diagnostics);

/// A finite decimal number in [min, max], rounded to the nearest double.
std::optional<double> parse_double(const std::string& option, const std::string& word, double min, double max,
                                   Diagnostics& diagnostics);

/// Bytes: an integer with an optional factor K, M, G or T (powers of 1024), in [1, 2^47].
std::optional<std::size_t> parse_bytes(const std::string& option, const std::string& word,
                                       Diagnostics& diagnostics);

/// Bytes for a reader, e.g. "512.0 MiB".
std::string format_bytes(std::size_t bytes);

}  // namespace mlt
