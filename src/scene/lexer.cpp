#include "scene/lexer.hpp"

#include <charconv>
#include <cmath>
#include <system_error>
#include <utility>

#include "scene/diagnostics.hpp"
#include "scene/limits.hpp"

namespace mlt {
namespace {

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

bool is_control(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return (byte < 0x20 && !is_blank(c)) || byte == 0x7f;
}

std::string control_byte_message(char c) {
  return "control byte " + printable(std::string_view(&c, 1)) + " found; a scene file is plain text";
}

/// std::from_chars takes no plus sign; one is allowed here, but not before another sign.
std::string_view without_plus(std::string_view text) {
  const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-' && text[1] != '+';
  return plus ? text.substr(1) : text;
}

}  // namespace

NumberFault parse_number(std::string_view text, double& value) {
  const std::string_view digits = without_plus(text);
  const char* const end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, value, std::chars_format::general);
  if (error == std::errc::invalid_argument || stop != end) return NumberFault::kNotANumber;
  if (error == std::errc::result_out_of_range) return NumberFault::kOutOfRange;
  return std::isfinite(value) ? NumberFault::kNone : NumberFault::kNotFinite;
}

NumberFault parse_integer(std::string_view text, std::int64_t& value) {
  const std::string_view digits = without_plus(text);
  const char* const end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, value, 10);
  if (error == std::errc::invalid_argument || stop != end) return NumberFault::kNotANumber;
  return error == std::errc::result_out_of_range ? NumberFault::kOutOfRange : NumberFault::kNone;
}

std::string describe_fault(NumberFault fault, std::string_view text) {
  switch (fault) {
    case NumberFault::kNone:
      break;
    case NumberFault::kNotANumber:
      return printable(text) + " is not a number";
    case NumberFault::kNotFinite:
      return printable(text) + " is not a finite number";
    case NumberFault::kOutOfRange:
      return printable(text) + " is too large or too small for a number";
  }
  return printable(text) + " is a number";
}

bool looks_like_number(std::string_view text) {
  if (text.empty()) return false;
  const char c = text[0];
  return (c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.';
}

LineReader::LineReader(std::string_view text, std::string file) : rest_(text), file_(std::move(file)) {
  if (rest_.substr(0, 3) == "\xef\xbb\xbf") rest_.remove_prefix(3);
}

bool LineReader::next(std::vector<Token>& tokens) {
  while (!rest_.empty()) {
    const std::size_t length = rest_.find('\n');
    const std::string_view line = rest_.substr(0, length);
    rest_.remove_prefix(length == std::string_view::npos ? rest_.size() : length + 1);
    ++line_;
    split(line, tokens);
    if (!tokens.empty()) return true;
  }
  return false;
}

void LineReader::split(std::string_view line, std::vector<Token>& tokens) {
  tokens.clear();
  end_column_ = 1;
  if (line.size() > kMaxLineBytes) {
    fail(kMaxLineBytes, "the line has " + std::to_string(line.size()) + " bytes; at most " +
                            std::to_string(kMaxLineBytes) + " are allowed");
  }
  std::size_t at = 0;
  while (true) {
    while (at < line.size() && is_blank(line[at])) ++at;
    if (at == line.size() || line[at] == '#') return;
    Token token;
    at = take_token(line, at, token);
    if (token.text.size() > kMaxTokenBytes) {
      fail(token.column - 1, "the word " + printable(token.text) + " has " +
                                 std::to_string(token.text.size()) + " bytes; at most " +
                                 std::to_string(kMaxTokenBytes) + " are allowed");
    }
    if (tokens.size() == kMaxStatementTokens) {
      fail(token.column - 1,
           "more than " + std::to_string(kMaxStatementTokens) + " words in one statement are not allowed");
    }
    tokens.push_back(token);
    end_column_ = static_cast<std::uint32_t>(at + 1);
  }
}

/// Returns the offset behind the token that begins at `begin`.
std::size_t LineReader::take_token(std::string_view line, std::size_t begin, Token& token) const {
  token.column = static_cast<std::uint32_t>(begin + 1);
  token.quoted = line[begin] == '"';
  if (token.quoted) {
    std::size_t end = begin + 1;
    while (end < line.size() && line[end] != '"') {
      if (is_control(line[end]) || line[end] == '\t' || line[end] == '\r')
        fail(end, control_byte_message(line[end]));
      ++end;
    }
    if (end == line.size()) fail(begin, "the quote is not closed; a second '\"' is needed on the same line");
    token.text = line.substr(begin + 1, end - begin - 1);
    return end + 1;
  }
  std::size_t end = begin;
  while (end < line.size() && !is_blank(line[end]) && line[end] != '#' && line[end] != '"') {
    if (is_control(line[end])) fail(end, control_byte_message(line[end]));
    ++end;
  }
  token.text = line.substr(begin, end - begin);
  return end;
}

void LineReader::fail(std::size_t offset, const std::string& message) const {
  fail_at(SourceLocation{file_, line_, static_cast<std::uint32_t>(offset + 1)}, message);
}

}  // namespace mlt
