// Runs the built program as a person would: arguments, a current folder, captured output, exit code.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "app/commands.hpp"
#include "support/temporary_folder.hpp"

namespace mlt {

/// Absolute path of mlt: $MLT_BINARY, or the program beside the running test.
const std::string& program_path();

struct ProgramResult {
  int code = -1;      ///< exit code; 128 + signal when the program was killed
  std::string out;    ///< standard output
  std::string error;  ///< standard error
};

/// Runs `mlt` with `words` in `folder`, without a terminal.
ProgramResult run_mlt(const std::vector<std::string>& words, const std::string& folder);

/// Runs a shell command in `folder`; MLT holds the program's path.
ProgramResult run_shell(const std::string& command, const std::string& folder);

/// Starts `mlt` in `folder` with its output going to the files "out" and "error" there.
pid_t start_mlt(const std::vector<std::string>& words, const std::string& folder);
/// Waits for it; the code as in ProgramResult.
int wait_for(pid_t process);
/// True once `process` handles `signal` itself; false when it has not within a minute.
bool wait_until_caught(pid_t process, int signal);

inline int code_of(ExitCode code) {
  return static_cast<int>(code);
}

/// A folder that holds "scene.txt": a room of 10 quads and a light, 8 x 8 pixels; and "dark.txt", the same
/// without the light.
class SceneFolder : public TemporaryFolder {
 public:
  SceneFolder();
  ProgramResult run(const std::vector<std::string>& words) const { return run_mlt(words, path().string()); }
  /// Names other than the two scenes, sorted and separated by blanks.
  std::string outputs() const;
};

}  // namespace mlt
