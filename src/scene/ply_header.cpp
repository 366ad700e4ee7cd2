#include "scene/ply_header.hpp"

#include "base/error.hpp"
#include "scene/lexer.hpp"
#include "scene/limits.hpp"
#include "scene/statements.hpp"

namespace mlt {
namespace {

std::string_view require(TextScanner& scanner, const char* what) {
  const std::string_view word = scanner.word_on_line();
  if (word.empty()) scanner.fail(std::string("the line ends where ") + what + " is expected");
  return word;
}

PlyType read_type(TextScanner& scanner) {
  const std::string_view word = require(scanner, "a type");
  std::vector<std::string> known;
  int index = 0;
#define MLT_PLY_ROW(type, name, sized_name)                                       \
  if (word == (name) || word == (sized_name)) return static_cast<PlyType>(index); \
  known.emplace_back(name);                                                       \
  ++index;
  MLT_PLY_TYPES(MLT_PLY_ROW)
#undef MLT_PLY_ROW
  scanner.fail(printable(word) + " is not a type" + allowed_words(word, known));
}

void read_format(TextScanner& scanner, PlyHeader& header) {
  const std::string_view format = require(scanner, "a format");
  if (format != "ascii" && format != "binary_little_endian") {
    scanner.fail("the format is " + printable(format) + "; ascii and binary_little_endian are allowed");
  }
  header.ascii = format == "ascii";
  const std::string_view version = require(scanner, "the version 1.0");
  if (version != "1.0") scanner.fail("the version is " + printable(version) + "; 1.0 is allowed");
}

void read_element(TextScanner& scanner, PlyHeader& header) {
  PlyElement element;
  element.name = require(scanner, "the name of an element");
  element.location = scanner.location();
  for (const PlyElement& other : header.elements) {
    if (other.name == element.name) scanner.fail("a second element " + printable(element.name));
  }
  if (header.elements.size() == kMaxPlyElements) {
    scanner.fail("more than " + std::to_string(kMaxPlyElements) + " kinds of element, which is the limit");
  }
  const std::string_view count = require(scanner, "the number of elements");
  std::int64_t value = 0;
  const NumberFault fault = parse_integer(count, value);
  if (fault != NumberFault::kNone || value < 0) {
    scanner.fail(printable(count) + " is not a number of elements; a whole number from 0 is expected");
  }
  element.count = static_cast<std::uint64_t>(value);
  header.elements.push_back(element);
}

void read_property(TextScanner& scanner, PlyHeader& header) {
  if (header.elements.empty()) scanner.fail("a property stands before the first element");
  std::vector<PlyProperty>& properties = header.elements.back().properties;
  if (properties.size() == kMaxPlyProperties) {
    scanner.fail("more than " + std::to_string(kMaxPlyProperties) +
                 " properties of an element, which is the limit");
  }
  PlyProperty property;
  TextScanner ahead = scanner;
  if (ahead.word_on_line() == "list") {
    scanner = ahead;
    property.is_list = true;
    property.count_type = read_type(scanner);
    if (!is_integer(property.count_type)) scanner.fail("the length of a list must have an integer type");
  }
  property.type = read_type(scanner);
  property.name = require(scanner, "the name of a property");
  for (const PlyProperty& other : properties) {
    if (other.name == property.name)
      scanner.fail("a second property " + printable(property.name) + " of an element");
  }
  properties.push_back(property);
}

/// One line of the header; false behind end_header.
bool read_header_line(TextScanner& scanner, PlyHeader& header, bool& format_seen) {
  const std::string_view keyword = scanner.word_on_line();
  if (keyword == "end_header") return false;
  if (keyword == "format") {
    if (format_seen) scanner.fail("a second format line");
    read_format(scanner, header);
    format_seen = true;
  } else if (keyword == "element") {
    read_element(scanner, header);
  } else if (keyword == "property") {
    read_property(scanner, header);
  } else if (keyword == "comment" || keyword == "obj_info" || (keyword.empty() && !scanner.at_end())) {
    return true;
  } else if (keyword.empty()) {
    scanner.fail("the file ends inside the header; end_header is expected");
  } else {
    scanner.fail(
        printable(keyword) + " is not a line of a PLY header" +
        allowed_words(keyword, {"format", "element", "property", "comment", "obj_info", "end_header"}));
  }
  const std::string_view extra = scanner.word_on_line();
  if (!extra.empty()) scanner.fail(printable(extra) + " is one word too many");
  return true;
}

/// The rest of the file must be able to hold every declared record; checked before any memory is taken.
void check_sizes(const PlyHeader& header, std::uint64_t remaining) {
  std::uint64_t left = remaining;
  for (const PlyElement& element : header.elements) {
    if (element.properties.empty()) {
      fail_at(element.location, "the element " + printable(element.name) + " has no properties");
    }
    const std::uint64_t record = element.least_record_bytes(header.ascii);
    if (element.count > left / record) {
      fail_at(element.location, std::to_string(element.count) + " elements " + printable(element.name) +
                                    " are declared, each of at least " + std::to_string(record) +
                                    " bytes, but only " + std::to_string(left) + " bytes follow");
    }
    left -= element.count * record;
  }
}

}  // namespace

std::uint64_t PlyElement::least_record_bytes(bool ascii) const {
  // In ascii a value has at least one digit and one byte that separates it from the next; the last value of
  // the file may go without, so that byte is not counted for one property.
  if (ascii) return properties.size() * 2 - 1;
  std::uint64_t bytes = 0;
  for (const PlyProperty& property : properties) {
    bytes += property.is_list ? bytes_of(property.count_type) : bytes_of(property.type);
  }
  return bytes;
}

PlyHeader read_ply_header(TextScanner& scanner) {
  if (scanner.word_on_line() != "ply" || !scanner.word_on_line().empty() || scanner.at_end()) {
    scanner.fail("the file does not begin with a line 'ply'");
  }
  PlyHeader header;
  bool format_seen = false;
  do {
    scanner.skip_line();
  } while (read_header_line(scanner, header, format_seen));
  if (!format_seen) {
    scanner.fail("the header has no format line; ascii 1.0 or binary_little_endian 1.0 is expected");
  }
  // What follows is data from the first byte of the next line, whatever that byte is.
  scanner.skip_line();
  check_sizes(header, scanner.remaining());
  return header;
}

}  // namespace mlt
