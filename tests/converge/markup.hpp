// A check that markup nests: every element that opens closes in order, attributes are quoted, and text holds
// no bare reserved character. Stricter than XML where that is shorter.
#pragma once

#include <catch2/catch.hpp>
#include <cctype>
#include <string>
#include <vector>

namespace mlt::test {

/// Reads one tag, without its brackets, as name and quoted attributes; the name, or "" when it is neither.
inline std::string tag_name(const std::string& tag) {
  std::size_t at = 0;
  while (at < tag.size() && (std::isalnum(static_cast<unsigned char>(tag[at])) != 0)) ++at;
  const std::string name = tag.substr(0, at);
  while (at < tag.size()) {
    while (at < tag.size() && (tag[at] == ' ' || tag[at] == '\n')) ++at;
    if (at == tag.size()) break;
    const std::size_t quote = tag.find("=\"", at);
    const std::size_t end = quote == std::string::npos ? quote : tag.find('"', quote + 2);
    if (end == std::string::npos || tag.substr(at, quote - at).find_first_of(" \"<>&") != std::string::npos)
      return "";
    at = end + 1;
  }
  return name;
}

/// Elements in `empty` need no end, as in HTML.
inline void require_well_formed(const std::string& text, const std::vector<std::string>& empty = {}) {
  std::vector<std::string> open;
  std::size_t at = 0;
  while (at < text.size()) {
    if (text[at] == '&') {
      const std::size_t end = text.find(';', at);
      REQUIRE(end != std::string::npos);
      REQUIRE(end - at <= 8);
    }
    REQUIRE(text[at] != '>');
    if (text[at] != '<') {
      ++at;
      continue;
    }
    const std::size_t end = text.find('>', at);
    REQUIRE(end != std::string::npos);
    std::string tag = text.substr(at + 1, end - at - 1);
    CAPTURE(tag);
    if (tag[0] == '/') {
      REQUIRE(!open.empty());
      REQUIRE(open.back() == tag.substr(1));
      open.pop_back();
    } else if (tag[0] != '!') {
      const bool closed = tag.back() == '/';
      if (closed) tag.pop_back();
      const std::string name = tag_name(tag);
      REQUIRE(name != "");
      const bool is_empty = std::find(empty.begin(), empty.end(), name) != empty.end();
      if (!closed && !is_empty) open.push_back(name);
    }
    at = end + 1;
  }
  REQUIRE(open.empty());
}

}  // namespace mlt::test
