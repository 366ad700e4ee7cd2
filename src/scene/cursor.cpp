#include "scene/cursor.hpp"

#include "scene/diagnostics.hpp"

namespace mlt {
namespace {

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

bool is_name_byte(char c) {
  return is_letter(c) || (c >= '0' && c <= '9') || c == '-' || c == '.';
}

std::string range_text(Range range) {
  return "in [" + format_number(range.low) + ", " + format_number(range.high) + "]";
}

std::vector<std::string> words_of(std::span<const Keyword> keywords) {
  std::vector<std::string> words;
  for (const Keyword& keyword : keywords) words.emplace_back(keyword.word);
  return words;
}

}  // namespace

StatementCursor::StatementCursor(const std::string& file, std::uint32_t line, std::span<const Token> tokens,
                                 std::uint32_t line_end, const char* form)
    : file_(file), line_(line), tokens_(tokens), line_end_(line_end), form_(form) {}

SourceLocation StatementCursor::here() const {
  return at_column(at_end() ? line_end_ : tokens_[next_].column);
}

SourceLocation StatementCursor::last() const {
  return at_column(next_ == 0 ? 1 : tokens_[next_ - 1].column);
}

const Token& StatementCursor::take(const char* what) {
  if (at_end()) {
    fail_at(here(), std::string("the line ends where ") + what + " is expected; the form is: " + form_);
  }
  return tokens_[next_++];
}

std::string_view StatementCursor::word(const char* what) {
  return take(what).text;
}

std::string StatementCursor::name(const char* what) {
  const std::string_view text = take(what).text;
  bool valid = !text.empty() && is_letter(text[0]);
  for (const char c : text) valid = valid && is_name_byte(c);
  if (!valid) {
    fail_at(last(), printable(text) + " cannot be " + what +
                        ": a letter or '_' is expected, then letters, digits, '_', '-' and '.'");
  }
  return std::string(text);
}

double StatementCursor::number(const char* what) {
  const std::string_view text = take(what).text;
  double value = 0;
  const NumberFault fault = parse_number(text, value);
  if (fault != NumberFault::kNone) {
    fail_at(last(), describe_fault(fault, text) + "; " + what + " is expected; the form is: " + form_);
  }
  return value;
}

double StatementCursor::number_in(const char* what, Range range) {
  const double value = number(what);
  if (!(value >= range.low && value <= range.high)) {
    fail_at(last(), std::string(what) + " is " + format_number(value) + "; allowed is " + range_text(range));
  }
  return value;
}

std::int64_t StatementCursor::integer_in(const char* what, std::int64_t low, std::int64_t high) {
  const std::string_view text = take(what).text;
  const std::string allowed = std::string("; ") + what + " is a whole number from " + std::to_string(low) +
                              " to " + std::to_string(high);
  std::int64_t value = 0;
  const NumberFault fault = parse_integer(text, value);
  double fraction = 0;
  if (fault == NumberFault::kNotANumber && parse_number(text, fraction) == NumberFault::kNone) {
    fail_at(last(), printable(text) + " is not a whole number" + allowed);
  }
  if (fault != NumberFault::kNone) fail_at(last(), describe_fault(fault, text) + allowed);
  if (value < low || value > high) {
    fail_at(last(), std::string(what) + " is " + std::to_string(value) + allowed);
  }
  return value;
}

DVec3 StatementCursor::vector(const char* what) {
  const double x = number(what);
  const double y = number(what);
  const double z = number(what);
  return DVec3{x, y, z};
}

DVec3 StatementCursor::colour(const char* what, Range range) {
  const double red = number_in(what, range);
  if (!number_follows()) return DVec3{red, red, red};
  const double green = number_in(what, range);
  const double blue = number_in(what, range);
  return DVec3{red, green, blue};
}

std::size_t StatementCursor::keyword(std::span<const Keyword> keywords, const char* of) {
  const std::string_view text = take(of).text;
  for (std::size_t i = 0; i < keywords.size(); ++i) {
    if (text == keywords[i].word) return i;
  }
  fail_at(last(), printable(text) + " is not " + of + allowed_words(text, words_of(keywords)));
}

std::size_t StatementCursor::choice(const std::vector<std::string>& names, const char* what) {
  const std::string_view text = take(what).text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (text == names[i]) return i;
  }
  fail_at(last(), printable(text) + " is not " + what + allowed_words(text, names));
}

void StatementCursor::expect_end() const {
  if (!at_end()) {
    fail_at(here(), printable(tokens_[next_].text) + " is one word too many; the form is: " + form_);
  }
}

}  // namespace mlt
