// A reader of JSON [RFC8259] for the program's own result files. It trusts nothing: nesting is limited, text
// must be one value without anything behind it, and every fault is an InputError with its line and column.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace mlt {

inline constexpr int kMaxJsonDepth = 32;

struct JsonValue {
  enum class Kind { kNull, kBool, kNumber, kString, kArray, kObject };
  Kind kind = Kind::kNull;
  bool boolean = false;
  double number = 0;
  std::string text;
  std::vector<JsonValue> items;    ///< of an array or an object, in the file's order
  std::vector<std::string> names;  ///< of an object's items

  /// The first member of that name; null when there is none or this is no object.
  const JsonValue* find(std::string_view name) const;
};

/// `path` names the text in errors.
JsonValue parse_json(std::string_view text, const std::string& path);

}  // namespace mlt
