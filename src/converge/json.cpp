#include "converge/json.hpp"

#include <charconv>
#include <cmath>
#include <cstdint>

#include "base/error.hpp"

namespace mlt {
namespace {

class Parser {
 public:
  Parser(std::string_view text, const std::string& path) : text_(text), path_(path) {}

  JsonValue parse_all() {
    JsonValue value = parse_value(0);
    skip_blanks();
    if (at_ < text_.size()) fail("more text behind the JSON value; expected the end");
    return value;
  }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    std::uint32_t line = 1;
    std::size_t start = 0;
    for (std::size_t i = 0; i < at_ && i < text_.size(); ++i) {
      if (text_[i] != '\n') continue;
      ++line;
      start = i + 1;
    }
    throw InputError(Diagnostic{path_, line, static_cast<std::uint32_t>(at_ - start + 1), message});
  }

  void skip_blanks() {
    while (at_ < text_.size() && std::string_view(" \t\r\n").find(text_[at_]) != std::string_view::npos)
      ++at_;
  }

  bool take(std::string_view word) {
    if (text_.substr(at_, word.size()) != word) return false;
    at_ += word.size();
    return true;
  }

  void expect(char letter) {
    if (!take(std::string_view(&letter, 1))) fail(std::string("expected '") + letter + "'");
  }

  JsonValue parse_value(int depth) {
    if (depth > kMaxJsonDepth) fail("nested too deeply; expected at most " + std::to_string(kMaxJsonDepth));
    skip_blanks();
    JsonValue value;
    const char letter = at_ < text_.size() ? text_[at_] : '\0';
    if (letter == '{') {
      parse_object(value, depth);
    } else if (letter == '[') {
      parse_array(value, depth);
    } else if (letter == '"') {
      value.kind = JsonValue::Kind::kString;
      value.text = parse_string();
    } else if (take("true") || take("false")) {
      value.kind = JsonValue::Kind::kBool;
      value.boolean = letter == 't';
    } else if (!take("null")) {
      value.kind = JsonValue::Kind::kNumber;
      value.number = parse_number();
    }
    return value;
  }

  void parse_object(JsonValue& value, int depth) {
    value.kind = JsonValue::Kind::kObject;
    expect('{');
    skip_blanks();
    if (take("}")) return;
    do {
      skip_blanks();
      value.names.push_back(parse_string());
      skip_blanks();
      expect(':');
      value.items.push_back(parse_value(depth + 1));
      skip_blanks();
    } while (take(","));
    expect('}');
  }

  void parse_array(JsonValue& value, int depth) {
    value.kind = JsonValue::Kind::kArray;
    expect('[');
    skip_blanks();
    if (take("]")) return;
    do {
      value.items.push_back(parse_value(depth + 1));
      skip_blanks();
    } while (take(","));
    expect(']');
  }

  double parse_number() {
    const char* begin = text_.data() + at_;
    const char* end = text_.data() + text_.size();
    double number = 0;
    // from_chars also reads "inf" and "nan", which JSON has not.
    const bool starts = at_ < text_.size() && (*begin == '-' || (*begin >= '0' && *begin <= '9'));
    const auto [rest, error] = std::from_chars(begin, end, number);
    if (!starts || error != std::errc{} || !std::isfinite(number)) fail("expected a JSON value");
    at_ += static_cast<std::size_t>(rest - begin);
    return number;
  }

  std::string parse_string() {
    expect('"');
    std::string result;
    while (at_ < text_.size() && text_[at_] != '"') {
      const char letter = text_[at_];
      if (static_cast<unsigned char>(letter) < 0x20) fail("expected no control character in a string");
      ++at_;
      if (letter == '\\') {
        parse_escape(result);
      } else {
        result += letter;
      }
    }
    expect('"');
    return result;
  }

  void parse_escape(std::string& result) {
    constexpr std::string_view kLetters = "\"\\/bfnrt";
    constexpr std::string_view kMeanings = "\"\\/\b\f\n\r\t";
    const char letter = at_ < text_.size() ? text_[at_] : '\0';
    const std::size_t known = letter == '\0' ? std::string_view::npos : kLetters.find(letter);
    if (known != std::string_view::npos) {
      ++at_;
      result += kMeanings[known];
      return;
    }
    if (letter != 'u') fail("expected an escape of JSON");
    unsigned code = 0;
    const std::string_view digits = text_.substr(at_ + 1, 4);
    const auto [rest, error] = std::from_chars(digits.data(), digits.data() + digits.size(), code, 16);
    if (error != std::errc{} || digits.size() != 4 || rest != digits.data() + 4) {
      fail("expected four hexadecimal digits");
    }
    at_ += 5;
    // The program escapes control characters alone; what else could be written as UTF-8 is not needed back.
    result += code < 0x80 ? static_cast<char>(code) : '?';
  }

  std::string_view text_;
  const std::string& path_;
  std::size_t at_ = 0;
};

}  // namespace

const JsonValue* JsonValue::find(std::string_view name) const {
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) return &items[i];
  }
  return nullptr;
}

JsonValue parse_json(std::string_view text, const std::string& path) {
  return Parser(text, path).parse_all();
}

}  // namespace mlt
