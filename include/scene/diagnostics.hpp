// Faults and warnings of one scene, collected while the reader goes on, so that a person sees several at
// once. A statement's handler throws InputError; the statement loop absorbs it and continues with the next
// line.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "scene/description.hpp"

namespace mlt {

/// A word of the input as it may be shown on a terminal: in single quotes, bytes outside printable ASCII as
/// \xNN, cut after 80 bytes.
std::string printable(std::string_view text);

/// Shortest decimal text that reads back as the same number.
std::string format_number(double value);

Diagnostic diagnostic_at(const SourceLocation& location, std::string message);
[[noreturn]] void fail_at(const SourceLocation& location, std::string message);

class DiagnosticCollector {
 public:
  void absorb(const InputError& error);
  void add(Diagnostic diagnostic);
  void warn(const SourceLocation& location, const std::string& message);

  /// True when kMaxDiagnostics errors are held; the reader then stops.
  bool full() const;
  bool empty() const { return errors_.empty(); }

  /// Throws InputError with everything collected, unless there is nothing.
  void throw_if_any() const;
  /// The warnings as printed, with a closing line when some were only counted.
  std::vector<std::string> warnings() const;

 private:
  std::vector<Diagnostic> errors_;
  std::vector<std::string> warnings_;
  std::uint64_t warnings_not_kept_ = 0;
};

}  // namespace mlt
