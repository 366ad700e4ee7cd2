// Reads the words of one statement from left to right, each as what is expected next, and fails with a
// diagnostic that says where, what was found, what is allowed and how the statement is written.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "math/vec.hpp"
#include "scene/description.hpp"
#include "scene/lexer.hpp"
#include "scene/statements.hpp"

namespace mlt {

/// Closed interval of allowed values.
struct Range {
  double low = 0;
  double high = 0;
};

/// Refers to its arguments, which must outlive it.
class StatementCursor {
 public:
  /// `form` is printed when words are missing. `line_end` is the column behind the last word.
  StatementCursor(const std::string& file, std::uint32_t line, std::span<const Token> tokens,
                  std::uint32_t line_end, const char* form);

  bool at_end() const { return next_ == tokens_.size(); }
  /// Where the next word stands, or where it is missing.
  SourceLocation here() const;
  /// Where the word read last stands.
  SourceLocation last() const;
  /// Where the statement begins.
  SourceLocation start() const { return at_column(tokens_.empty() ? 1 : tokens_[0].column); }

  /// `what` names the missing word in the diagnostic.
  std::string_view word(const char* what);
  /// A word that may name something: a letter or '_', then letters, digits, '_', '-', '.'.
  std::string name(const char* what);
  double number(const char* what);
  double number_in(const char* what, Range range);
  std::int64_t integer_in(const char* what, std::int64_t low, std::int64_t high);
  DVec3 vector(const char* what);
  /// Three numbers in `range`, or one that stands for all three.
  DVec3 colour(const char* what, Range range);
  /// The index of the next word in `keywords`; `of` names what they belong to.
  std::size_t keyword(std::span<const Keyword> keywords, const char* of);
  /// The index of the next word in `names`.
  std::size_t choice(const std::vector<std::string>& names, const char* what);
  bool number_follows() const { return !at_end() && looks_like_number(tokens_[next_].text); }
  void expect_end() const;

 private:
  SourceLocation at_column(std::uint32_t column) const { return SourceLocation{file_, line_, column}; }
  const Token& take(const char* what);

  const std::string& file_;
  std::uint32_t line_;
  std::span<const Token> tokens_;
  std::uint32_t line_end_;
  const char* form_;
  std::size_t next_ = 0;
};

}  // namespace mlt
