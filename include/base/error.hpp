// The two kinds of failure that are not bugs, and every exit code of the program. Errors are thrown only
// outside a render (between render begin and render end nothing throws) and are caught in app alone.
#pragma once

#include <cstdint>
#include <exception>
#include <string>
#include <vector>

namespace mlt {

/// Process exit codes; documented in README.md and printed by `mlt --help`.
enum class ExitCode : int {
  kOk = 0,
  kCompareFailed = 1,  ///< `mlt compare`: an error metric lies above its limit
  kBadInput = 2,       ///< command line, scene or image file not valid
  kResourceLimit = 3,  ///< memory, disk or a numeric capacity is not sufficient
  kBug = 70,           ///< an assertion of the renderer failed
  kInterrupted = 75,   ///< SIGINT or SIGTERM: the image is written and marked partial
};

/// One fault in an input, at a place. `line` and `column` count from 1; 0 means "the file (or option) as a
/// whole", and the number is then not printed. `file` holds the option's name for a command line fault.
struct Diagnostic {
  std::string file;
  std::uint32_t line = 0;
  std::uint32_t column = 0;
  std::string message;  ///< what was found, then what is allowed

  /// "file:line:column: message", leaving out what is 0.
  std::string to_string() const;
};

/// Bad input (exit code 2). Holds at least one diagnostic; readers collect several before they throw.
class InputError : public std::exception {
 public:
  explicit InputError(std::vector<Diagnostic> diagnostics);
  explicit InputError(Diagnostic diagnostic);
  const char* what() const noexcept override { return text_.c_str(); }
  const std::vector<Diagnostic>& diagnostics() const { return diagnostics_; }

 private:
  std::vector<Diagnostic> diagnostics_;
  std::string text_;
};

/// A limit of the machine or of the job (exit code 3); the text says what is needed and what is available.
class ResourceError : public std::exception {
 public:
  explicit ResourceError(std::string text) : text_(std::move(text)) {}
  const char* what() const noexcept override { return text_.c_str(); }

 private:
  std::string text_;
};

/// The entries of `allowed` closest to `word` in edit distance (at most three, nearest first), formatted as
/// ", did you mean 'a' or 'b'?"; empty when nothing is near.
std::string suggest(const std::string& word, const std::vector<std::string>& allowed);

}  // namespace mlt
