// The words of one command split by the option table, and the messages about words that do not fit. Shared by
// the parsers of all commands.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/number.hpp"
#include "app/options.hpp"

namespace mlt {

/// Throws an InputError with one diagnostic.
[[noreturn]] void fail_words(const std::string& place, const std::string& message);

/// The end of a message: what may have been meant, then what is allowed.
std::string allowed_instead(const std::string& word, const std::vector<std::string>& allowed);

/// Options and positional words of one command, as strings.
struct Words {
  std::map<std::string, std::vector<std::string>> options;  ///< by long name
  std::vector<std::string> positional;

  bool has(const std::string& name) const { return options.count(name) > 0; }
  const std::string& get(const std::string& name) const { return options.at(name).front(); }
};

/// Splits `words` by `options`; behind "--" every word is positional. Throws InputError for unknown options,
/// and for options without their value or too often. `place` is e.g. "mlt render".
Words split_words(const std::string& place, const std::vector<OptionSpec>& options,
                  std::vector<std::string> words);

/// Reports a number of positional words other than `names`; returns whether it was right.
bool check_positional(const std::string& place, const std::vector<std::string>& words,
                      const std::vector<std::string>& names, Diagnostics& diagnostics);

/// The index of `word` among `allowed`; nothing, and a diagnostic for `option`, when it is not there.
std::optional<std::size_t> choose_word(const std::string& option, const std::string& word,
                                       const std::vector<std::string>& allowed, Diagnostics& diagnostics);

}  // namespace mlt
