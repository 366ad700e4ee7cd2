#include "app/json.hpp"

#include <fmt/core.h>

#include <cmath>

#include "base/assert.hpp"

namespace mlt {

void JsonWriter::begin_item(const char* key) {
  if (depth_ == 0) return;
  text_ += first_ ? "\n" : ",\n";
  text_.append(2 * depth_, ' ');
  if (key != nullptr) text_ += json_string(key) + ": ";
  first_ = false;
}

void JsonWriter::open(const char* key, char bracket) {
  begin_item(key);
  text_ += bracket;
  ++depth_;
  first_ = true;
}

void JsonWriter::close(char bracket) {
  MLT_CHECK_OP(depth_, >, 0u);
  --depth_;
  if (!first_) text_ += '\n' + std::string(2 * depth_, ' ');
  text_ += bracket;
  first_ = false;
}

void JsonWriter::add_raw(const char* key, const std::string& value) {
  begin_item(key);
  text_ += value;
}

void JsonWriter::add(const char* key, double value) {
  add_raw(key, std::isfinite(value) ? fmt::format("{}", value) : "null");
}

std::string JsonWriter::finish() {
  close('}');
  MLT_CHECK_OP(depth_, ==, 0u);
  return text_ + '\n';
}

}  // namespace mlt
