// Text as JSON, for every file of results that the program writes.
#pragma once

#include <string>

namespace mlt {

/// `text` with every byte that is not part of valid UTF-8 [RFC3629] replaced by U+FFFD.
std::string valid_utf8(const std::string& text);

/// `text` as a JSON string with its quotes: control characters, quotes and backslashes escaped; bytes that
/// are not UTF-8 become U+FFFD.
std::string json_string(const std::string& text);

}  // namespace mlt
