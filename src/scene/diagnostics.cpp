#include "scene/diagnostics.hpp"

#include <charconv>
#include <utility>

#include "scene/limits.hpp"

namespace mlt {

std::string printable(std::string_view text) {
  constexpr std::size_t kShown = 80;
  constexpr char kHexDigits[] = "0123456789abcdef";
  std::string out = "'";
  for (const char character : text.substr(0, kShown)) {
    const auto byte = static_cast<unsigned char>(character);
    if (byte >= 0x20 && byte < 0x7f) {
      out += character;
    } else {
      out += "\\x";
      out += kHexDigits[byte >> 4];
      out += kHexDigits[byte & 15];
    }
  }
  if (text.size() > kShown) out += "...";
  return out + "'";
}

std::string format_number(double value) {
  char text[32];
  const auto result = std::to_chars(text, text + sizeof text, value);
  return std::string(text, result.ptr);
}

Diagnostic diagnostic_at(const SourceLocation& location, std::string message) {
  return Diagnostic{location.file, location.line, location.column, std::move(message)};
}

void fail_at(const SourceLocation& location, std::string message) {
  throw InputError(diagnostic_at(location, std::move(message)));
}

void DiagnosticCollector::absorb(const InputError& error) {
  for (const Diagnostic& diagnostic : error.diagnostics()) add(diagnostic);
}

void DiagnosticCollector::add(Diagnostic diagnostic) {
  if (!full()) errors_.push_back(std::move(diagnostic));
}

void DiagnosticCollector::warn(const SourceLocation& location, const std::string& message) {
  if (warnings_.size() < kMaxWarnings) {
    warnings_.push_back(diagnostic_at(location, message).to_string());
  } else {
    ++warnings_not_kept_;
  }
}

bool DiagnosticCollector::full() const {
  return errors_.size() >= kMaxDiagnostics;
}

void DiagnosticCollector::throw_if_any() const {
  if (!errors_.empty()) throw InputError(errors_);
}

std::vector<std::string> DiagnosticCollector::warnings() const {
  std::vector<std::string> all = warnings_;
  if (warnings_not_kept_ > 0) all.push_back(std::to_string(warnings_not_kept_) + " more warnings not shown");
  return all;
}

}  // namespace mlt
