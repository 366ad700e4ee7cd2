// Runs code that is expected to end its process, in a child whose exit code and messages a test can look at.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <string>

namespace mlt::test {

struct ChildResult {
  int exit_code = -1;  ///< -1: ended by a signal
  std::string errors;  ///< what it wrote to stderr
};

/// Forks; the child runs `body` and exits with 0 if that returns. The test must be single-threaded here.
template <class Body>
ChildResult run_in_child(const Body& body) {
  std::array<int, 2> pipe_ends{};
  REQUIRE(::pipe(pipe_ends.data()) == 0);
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    ::dup2(pipe_ends[1], STDERR_FILENO);
    body();
    ::_exit(0);
  }
  ::close(pipe_ends[1]);
  ChildResult result;
  std::array<char, 1024> buffer{};
  for (ssize_t count = 0; (count = ::read(pipe_ends[0], buffer.data(), buffer.size())) > 0;) {
    result.errors.append(buffer.data(), static_cast<std::size_t>(count));
  }
  ::close(pipe_ends[0]);
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
  return result;
}

}  // namespace mlt::test
