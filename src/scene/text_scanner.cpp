#include "scene/text_scanner.hpp"

#include <cstring>

namespace mlt {

void TextScanner::begin_line() {
  ++at_;
  ++line_;
  line_begin_ = at_;
}

bool TextScanner::skip_continuation() {
  const char* next = at_ + 1;
  if (next < end_ && *next == '\r') ++next;
  if (next >= end_ || *next != '\n') return false;
  at_ = next;
  begin_line();
  return true;
}

std::string_view TextScanner::word_on_line(bool continued) {
  while (at_ < end_) {
    if (is_blank(*at_)) {
      ++at_;
    } else if (!(continued && *at_ == '\\' && skip_continuation())) {
      break;
    }
  }
  word_begin_ = at_;
  while (at_ < end_ && *at_ != '\n' && !is_blank(*at_)) ++at_;
  return {word_begin_, static_cast<std::size_t>(at_ - word_begin_)};
}

std::string_view TextScanner::word() {
  while (true) {
    const std::string_view found = word_on_line();
    if (!found.empty() || at_ == end_) return found;
    begin_line();
  }
}

void TextScanner::skip_line() {
  if (at_ == end_) return;
  const void* const newline = std::memchr(at_, '\n', remaining());
  if (newline == nullptr) {
    at_ = end_;
  } else {
    at_ = static_cast<const char*>(newline);
    begin_line();
  }
}

SourceLocation TextScanner::location() const {
  const char* const place = word_begin_ != nullptr && word_begin_ >= line_begin_ ? word_begin_ : at_;
  return SourceLocation{*name_, line_, static_cast<std::uint32_t>(place - line_begin_ + 1)};
}

}  // namespace mlt
