// Text to the standard streams, and the progress line.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "render/renderer.hpp"

namespace mlt {

/// Writes results to standard output. Throws ResourceError when not all of it could be written.
void print_output(const std::string& text);

/// Writes messages to standard error, one or more whole lines; failures are ignored, since there is no place
/// left to report them.
void print_message(const std::string& text);

/// Writes a progress line ("42.1 %  1.27 M mutations/s  ETA 0:31") to `buffer`, cut to its size; returns the
/// bytes used. Neither allocates, locks nor throws, since it runs inside a render.
std::size_t format_progress(const RenderProgress& progress, const char* unit, std::span<char> buffer);

/// Keeps one line of a terminal up to date; silent when not enabled.
class ProgressLine {
 public:
  /// `unit` is what is counted, e.g. "mutations"; it must outlive this object.
  ProgressLine(bool enabled, const char* unit) : enabled_(enabled), unit_(unit) {}
  ~ProgressLine();  ///< clears the line
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// A ProgressCallback whose context is a ProgressLine.
  static void update(const RenderProgress& progress, void* context);

 private:
  bool enabled_;
  bool shown_ = false;
  const char* unit_;
};

}  // namespace mlt
