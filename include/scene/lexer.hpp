// Lines and words of the scene format. A line is one statement; a word is a run of bytes without blanks, or
// anything but a line's end between double quotes; '#' outside quotes begins a comment. Tokens point into the
// text, which must outlive them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scene/description.hpp"

namespace mlt {

struct Token {
  std::string_view text;     ///< without the quotes
  std::uint32_t column = 0;  ///< of the first byte, from 1
  bool quoted = false;
};

enum class NumberFault { kNone, kNotANumber, kNotFinite, kOutOfRange };

/// The whole of `text` as a finite decimal number: digits with optional sign, point and exponent, whatever
/// the locale. kNotFinite: a spelling of NaN or infinity; kOutOfRange: beyond what a double can hold.
NumberFault parse_number(std::string_view text, double& value);

/// The whole of `text` as a decimal integer.
NumberFault parse_integer(std::string_view text, std::int64_t& value);

/// What is wrong with `text`, for a diagnostic: "'x' is not a number".
std::string describe_fault(NumberFault fault, std::string_view text);

/// True when a word begins as a number does: digit, sign or point.
bool looks_like_number(std::string_view text);

class LineReader {
 public:
  /// A UTF-8 byte order mark at the start is skipped.
  LineReader(std::string_view text, std::string file);

  /// The next line with at least one word, split into `tokens`; false at the end of the text. Throws
  /// InputError for a control byte, an open quote, an overlong line or word; the next call goes on after it.
  bool next(std::vector<Token>& tokens);

  const std::string& file() const { return file_; }
  std::uint32_t line() const { return line_; }              ///< of the tokens returned last, from 1
  std::uint32_t end_column() const { return end_column_; }  ///< one past that line's last word

 private:
  void split(std::string_view line, std::vector<Token>& tokens);
  std::size_t take_token(std::string_view line, std::size_t begin, Token& token) const;
  [[noreturn]] void fail(std::size_t offset, const std::string& message) const;

  std::string_view rest_;
  std::string file_;
  std::uint32_t line_ = 0;
  std::uint32_t end_column_ = 1;
};

}  // namespace mlt
