// Words of a mesh file's text, without copies, and with the line and column of each for diagnostics.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "scene/description.hpp"
#include "scene/diagnostics.hpp"

namespace mlt {

class TextScanner {
 public:
  TextScanner(std::span<const char> bytes, const std::string& name)
      : begin_(bytes.data()), at_(begin_), end_(begin_ + bytes.size()), line_begin_(begin_), name_(&name) {}

  bool at_end() const { return at_ == end_; }
  std::size_t offset() const { return static_cast<std::size_t>(at_ - begin_); }
  std::size_t remaining() const { return static_cast<std::size_t>(end_ - at_); }
  std::uint32_t line() const { return line_; }

  /// The next word on this line; empty at the line's end. With `continued`, a backslash at a line's end joins
  /// the next line.
  std::string_view word_on_line(bool continued = false);

  /// The next word on this or a later line; empty at the end of the text.
  std::string_view word();

  /// Goes behind the line's end; the rest of the line is not looked at.
  void skip_line();

  /// Where the word returned last began; at a line's or the text's end, where the scanner stands.
  SourceLocation location() const;
  [[noreturn]] void fail(std::string message) const { fail_at(location(), std::move(message)); }

 private:
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }
  void begin_line();
  bool skip_continuation();

  const char* begin_;
  const char* at_;
  const char* end_;
  const char* line_begin_;
  const char* word_begin_ = nullptr;
  const std::string* name_;
  std::uint32_t line_ = 1;
};

}  // namespace mlt
