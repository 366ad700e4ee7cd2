// JSON as text, object by object: one key a line, indented, in the order of the calls.
#pragma once

#include <cstdint>
#include <string>

#include "app/record.hpp"

namespace mlt {

class JsonWriter {
 public:
  JsonWriter() { open(nullptr, '{'); }

  void begin_object(const char* key = nullptr) { open(key, '{'); }
  void begin_array(const char* key) { open(key, '['); }
  void end_object() { close('}'); }
  void end_array() { close(']'); }

  /// A key of the open object, or with null an item of the open array.
  void add(const char* key, const std::string& text) { add_raw(key, json_string(text)); }
  void add(const char* key, const char* text) { add_raw(key, json_string(text)); }
  void add(const char* key, bool value) { add_raw(key, value ? "true" : "false"); }
  void add(const char* key, std::uint64_t value) { add_raw(key, std::to_string(value)); }
  /// The shortest text that reads back to the same double; null when it is not finite.
  void add(const char* key, double value);

  /// Closes the outermost object.
  std::string finish();

 private:
  void open(const char* key, char bracket);
  void close(char bracket);
  void add_raw(const char* key, const std::string& value);
  void begin_item(const char* key);

  std::string text_;
  std::size_t depth_ = 0;
  bool first_ = true;  ///< nothing stands yet in the open object or array
};

}  // namespace mlt
