#include "app/console.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>

#include "base/error.hpp"

namespace mlt {
namespace {

constexpr char kClearLine[] = "\r\x1b[K";
constexpr std::uint64_t kMaxShown = 999'999'999'999'999;  // keeps every column and product in range

/// `value` as an integer; what does not fit, and NaN, as the nearest end of [0, kMaxShown].
std::uint64_t clamped(double value) {
  if (!(value > 0)) return 0;
  return value < static_cast<double>(kMaxShown) ? static_cast<std::uint64_t>(value) : kMaxShown;
}

/// Writes all bytes to a descriptor; false when that fails.
bool write_all(int descriptor, const char* bytes, std::size_t size) {
  while (size > 0) {
    const ssize_t written = ::write(descriptor, bytes, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes += written;
    size -= static_cast<std::size_t>(written);
  }
  return true;
}

struct Scaled {
  std::uint64_t hundredths;
  const char* factor;
};

Scaled scale(std::uint64_t value) {
  if (value >= 1'000'000'000) return {value / 10'000'000, "G "};
  if (value >= 1'000'000) return {value / 10'000, "M "};
  if (value >= 1'000) return {value / 10, "k "};
  return {value * 100, ""};
}

}  // namespace

void print_output(const std::string& text) {
  errno = 0;
  if (!write_all(STDOUT_FILENO, text.data(), text.size())) {
    throw ResourceError(std::string("standard output: could not be written: ") + std::strerror(errno));
  }
}

void print_message(const std::string& text) {
  static_cast<void>(write_all(STDERR_FILENO, text.data(), text.size()));
}

std::size_t format_progress(const RenderProgress& progress, const char* unit, std::span<char> buffer) {
  // Integers only: formatting a floating-point number may need memory that grows.
  const double total = progress.total > 0 ? static_cast<double>(progress.total) : 1.0;
  const double done = static_cast<double>(progress.done);
  const std::uint64_t permille = clamped(1000.0 * (done < total ? done : total) / total);
  const double rate = progress.seconds > 0 ? done / progress.seconds : 0.0;
  const Scaled scaled = scale(clamped(rate));
  const auto start =
      fmt::format_to_n(buffer.data(), buffer.size(), "{}.{} %  {}.{:02} {}{}/s  ETA ", permille / 10,
                       permille % 10, scaled.hundredths / 100, scaled.hundredths % 100, scaled.factor, unit);
  if (start.size >= buffer.size()) return buffer.size();
  const std::span<char> rest = buffer.subspan(start.size);
  if (!(rate > 0)) {
    const auto end = fmt::format_to_n(rest.data(), rest.size(), "-");
    return start.size + (end.size < rest.size() ? end.size : rest.size());
  }
  const std::uint64_t seconds = clamped((total > done ? total - done : 0.0) / rate + 0.5);
  const std::uint64_t hours = seconds / 3600;
  const auto end = hours > 0
                       ? fmt::format_to_n(rest.data(), rest.size(), "{}:{:02}:{:02}", hours,
                                          seconds / 60 % 60, seconds % 60)
                       : fmt::format_to_n(rest.data(), rest.size(), "{}:{:02}", seconds / 60, seconds % 60);
  return start.size + (end.size < rest.size() ? end.size : rest.size());
}

void ProgressLine::update(const RenderProgress& progress, void* context) {
  ProgressLine& line = *static_cast<ProgressLine*>(context);
  if (!line.enabled_) return;
  char buffer[160] = "\r\x1b[K";
  constexpr std::size_t kStart = sizeof kClearLine - 1;
  const std::size_t used = format_progress(progress, line.unit_, std::span<char>(buffer).subspan(kStart));
  static_cast<void>(write_all(STDERR_FILENO, buffer, kStart + used));
  line.shown_ = true;
}

ProgressLine::~ProgressLine() {
  if (shown_) static_cast<void>(write_all(STDERR_FILENO, kClearLine, sizeof kClearLine - 1));
}

}  // namespace mlt
