// Text as JSON, for every file of results that the program writes.
#pragma once

#include <string>

namespace mlt {

/// `text` as a JSON string with its quotes: control characters, quotes and backslashes escaped; bytes that
/// are not UTF-8 become U+FFFD.
std::string json_string(const std::string& text);

}  // namespace mlt
