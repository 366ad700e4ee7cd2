#include "scene/lexer.hpp"

#include <catch2/catch.hpp>
#include <clocale>
#include <limits>

#include "base/error.hpp"
#include "scene/diagnostics.hpp"
#include "scene/limits.hpp"

using namespace mlt;

namespace {

std::vector<std::string> words(std::string_view text) {
  LineReader reader(text, "t");
  std::vector<Token> tokens;
  std::vector<std::string> all;
  while (reader.next(tokens)) {
    for (const Token& token : tokens) {
      all.push_back(std::to_string(reader.line()) + ":" + std::to_string(token.column) + ":" +
                    std::string(token.text));
    }
  }
  return all;
}

std::string fault(std::string_view text) {
  try {
    words(text);
  } catch (const InputError& error) {
    return error.diagnostics()[0].to_string();
  }
  return "accepted";
}

double number(std::string_view text) {
  double value = -1;
  REQUIRE(parse_number(text, value) == NumberFault::kNone);
  return value;
}

NumberFault number_fault(std::string_view text) {
  double value = 0;
  return parse_number(text, value);
}

}  // namespace

TEST_CASE("Words know their line and column; blanks, comments and line ends separate them") {
  using Words = std::vector<std::string>;
  CHECK(words("a bc\n\n  d#e f\r\n\t\"g # h\"i") == Words{"1:1:a", "1:3:bc", "3:3:d", "4:2:g # h", "4:9:i"});
  CHECK(words("").empty());
  CHECK(words("# only\n   \n").empty());
  CHECK(words("\xef\xbb\xbf"
              "film 1 2") == Words{"1:1:film", "1:6:1", "1:8:2"});
  CHECK(words("\"\"") == Words{"1:1:"});
  CHECK(words("a\"b\"") == Words{"1:1:a", "1:2:b"});
}

TEST_CASE("Bytes that are no text, open quotes and overlong lines and words are refused at their place") {
  CHECK_THAT(fault(std::string_view("a\n b\0c", 6)), Catch::StartsWith("t:2:3: control byte '\\x00' found"));
  CHECK_THAT(fault("a \x1b[2J"), Catch::StartsWith("t:1:3: control byte '\\x1b'"));
  CHECK_THAT(fault("a \"bc\n\""), Catch::StartsWith("t:1:3: the quote is not closed"));
  CHECK_THAT(fault("\"a\tb\""), Catch::StartsWith("t:1:3: control byte '\\x09'"));
  CHECK(fault("# \x01 in a comment") == "accepted");
  CHECK(fault(std::string(kMaxTokenBytes, 'x')) == "accepted");
  CHECK_THAT(fault("a " + std::string(kMaxTokenBytes + 1, 'x')), Catch::StartsWith("t:1:3: the word 'xxxx"));
  CHECK(fault(std::string(kMaxLineBytes, ' ')) == "accepted");
  CHECK_THAT(fault(std::string(kMaxLineBytes + 1, ' ')), Catch::Contains("at most 65536 are allowed"));
  std::string many;
  for (std::size_t i = 0; i < kMaxStatementTokens; ++i) many += "a ";
  CHECK(fault(many) == "accepted");
  CHECK_THAT(fault(many + "a"), Catch::StartsWith("t:1:2049: more than 1024 words"));
}

TEST_CASE("After a faulty line the reader goes on with the next") {
  LineReader reader("ok\n\"open\nlast", "t");
  std::vector<Token> tokens;
  CHECK(reader.next(tokens));
  CHECK_THROWS_AS(reader.next(tokens), InputError);
  REQUIRE(reader.next(tokens));
  CHECK(tokens[0].text == "last");
  CHECK(reader.line() == 3);
  CHECK_FALSE(reader.next(tokens));
}

TEST_CASE("Numbers are whole words, finite and independent of the locale") {
  CHECK(number("1") == 1.0);
  CHECK(number("+1.5e2") == 150.0);
  CHECK(number("-.25") == -0.25);
  CHECK(number("5.") == 5.0);
  CHECK(number("0.1") == 0.1);
  CHECK(number("1.7976931348623157e308") == std::numeric_limits<double>::max());
  CHECK(number("4.9406564584124654e-324") == std::numeric_limits<double>::denorm_min());
  for (const char* text : {"", "+", "-", ".", "1.0.0", "1e", "1e+", "0x10", "1,5", "1 ", " 1", "--1", "+-1",
                           "++1", "1f", "1_000", "one", "e5", "\xd9\xa1"}) {
    CAPTURE(text);
    CHECK(number_fault(text) == NumberFault::kNotANumber);
  }
  for (const char* text : {"nan", "NaN", "-nan", "inf", "-inf", "INFINITY", "+inf"}) {
    CAPTURE(text);
    CHECK(number_fault(text) == NumberFault::kNotFinite);
  }
  for (const char* text : {"1e999", "-1e999", "1e-999"}) {
    CAPTURE(text);
    CHECK(number_fault(text) == NumberFault::kOutOfRange);
  }
  // Where the machine has it, a locale whose decimal sign is the comma.
  const std::string before = std::setlocale(LC_ALL, nullptr);
  std::setlocale(LC_ALL, "de_DE.UTF-8");
  CHECK(number("1.5") == 1.5);
  CHECK(number_fault("1,5") == NumberFault::kNotANumber);
  CHECK(format_number(1.5) == "1.5");
  std::setlocale(LC_ALL, before.c_str());
}

TEST_CASE("Integers have no fraction, exponent or overflow") {
  std::int64_t value = 0;
  CHECK((parse_integer("+12", value) == NumberFault::kNone && value == 12));
  CHECK((parse_integer("-9223372036854775808", value) == NumberFault::kNone && value == INT64_MIN));
  CHECK(parse_integer("9223372036854775808", value) == NumberFault::kOutOfRange);
  for (const char* text : {"", "1.0", "1e3", "0x1", "1 ", "a"}) {
    CHECK(parse_integer(text, value) == NumberFault::kNotANumber);
  }
}

TEST_CASE("Shown words are short, quoted and free of control bytes") {
  CHECK(printable("a b") == "'a b'");
  CHECK(printable("\x1b[31m\xc3\xa4\x7f") == "'\\x1b[31m\\xc3\\xa4\\x7f'");
  CHECK(printable(std::string(100, 'x')) == "'" + std::string(80, 'x') + "...'");
}
