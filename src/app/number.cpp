#include "app/number.hpp"

#include <fmt/core.h>

#include <charconv>
#include <cmath>

namespace mlt {
namespace {

constexpr std::uint64_t kMaxBytes = std::uint64_t{1} << 47;  // beyond any address space in use
constexpr char kFactors[] = "KMGT";
constexpr std::size_t kMaxQuotedBytes = 80;

/// The number that `word` is as a whole; nothing when it is none or does not fit T.
template <class T>
std::optional<T> read_whole(const std::string& word) {
  T value{};
  const char* end = word.data() + word.size();
  const auto [rest, error] = std::from_chars(word.data(), end, value);
  if (error != std::errc{} || rest != end || word.empty()) return std::nullopt;
  return value;
}

template <class T>
std::optional<T> parse_floating(const std::string& option, const std::string& word, T min, T max,
                                Diagnostics& diagnostics) {
  const std::optional<T> value = read_whole<T>(word);
  if (value && std::isfinite(*value) && *value >= min && *value <= max) return value;
  report_value(option, word, fmt::format("a number from {} to {}", min, max), diagnostics);
  return std::nullopt;
}

}  // namespace

void report_value(const std::string& option, const std::string& word, const std::string& expected,
                  Diagnostics& diagnostics) {
  const std::string quoted = word.size() <= kMaxQuotedBytes ? word : word.substr(0, kMaxQuotedBytes) + "...";
  diagnostics.push_back({option, 0, 0, fmt::format("found '{}'; expected {}", quoted, expected)});
}

std::optional<std::uint64_t> parse_integer(const std::string& option, const std::string& word,
                                           std::uint64_t min, std::uint64_t max, Diagnostics& diagnostics) {
  const std::optional<std::uint64_t> value = read_whole<std::uint64_t>(word);
  if (value && *value >= min && *value <= max) return value;
  report_value(option, word, fmt::format("an integer from {} to {}", min, max), diagnostics);
  return std::nullopt;
}

std::optional<float> parse_real(const std::string& option, const std::string& word, float min, float max,
                                Diagnostics& diagnostics) {
  return parse_floating<float>(option, word, min, max, diagnostics);
}

std::optional<double> parse_double(const std::string& option, const std::string& word, double min, double max,
                                   Diagnostics& diagnostics) {
  return parse_floating<double>(option, word, min, max, diagnostics);
}

std::optional<std::size_t> parse_bytes(const std::string& option, const std::string& word,
                                       Diagnostics& diagnostics) {
  std::string digits = word;
  std::uint64_t factor = 1;
  if (!digits.empty()) {
    const char last = digits.back() >= 'a' && digits.back() <= 'z'
                          ? static_cast<char>(digits.back() - 'a' + 'A')
                          : digits.back();
    for (int i = 0; kFactors[i] != '\0'; ++i) {
      if (last == kFactors[i]) factor = std::uint64_t{1} << (10 * (i + 1));
    }
    if (factor > 1) digits.pop_back();
  }
  const std::optional<std::uint64_t> value = read_whole<std::uint64_t>(digits);
  if (value && *value >= 1 && *value <= kMaxBytes / factor) return static_cast<std::size_t>(*value * factor);
  report_value(option, word,
               "a number of bytes such as 512M, with K, M, G or T for powers of 1024, from 1 to 128T",
               diagnostics);
  return std::nullopt;
}

std::string format_bytes(std::size_t bytes) {
  if (bytes < 1024) return fmt::format("{} B", bytes);
  double value = static_cast<double>(bytes) / 1024;
  int unit = 0;
  while (value >= 1024 && kFactors[unit + 1] != '\0') {
    value /= 1024;
    ++unit;
  }
  return fmt::format("{:.1f} {}iB", value, kFactors[unit]);
}

}  // namespace mlt
