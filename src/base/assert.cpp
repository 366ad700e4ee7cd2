#include "base/assert.hpp"

#include <unistd.h>

#include <cstdio>

#include "base/error.hpp"

namespace mlt {
namespace {

const char* g_replay_command = "";

[[noreturn]] void report_and_exit(const char* text, int length) {
  if (length > 0) {
    const auto ignored = ::write(STDERR_FILENO, text, static_cast<std::size_t>(length));
    static_cast<void>(ignored);
  }
  ::_exit(static_cast<int>(ExitCode::kBug));
}

int append_context(char* buffer, std::size_t size, int used) {
  const ReplayContext& context = replay_context();
  if (used < 0 || static_cast<std::size_t>(used) >= size) return used;
  return used + std::snprintf(buffer + used, size - static_cast<std::size_t>(used),
                              "  while: %s, seed %llu, unit %llu, step %llu\n  replay: %s\n", context.stage,
                              static_cast<unsigned long long>(context.seed),
                              static_cast<unsigned long long>(context.unit),
                              static_cast<unsigned long long>(context.step), g_replay_command);
}

int clamp_length(int length, std::size_t size) {
  return length < 0 ? 0 : (static_cast<std::size_t>(length) < size ? length : static_cast<int>(size) - 1);
}

}  // namespace

ReplayContext& replay_context() {
  thread_local constinit ReplayContext context;
  return context;
}

void set_replay_command(const char* command) {
  g_replay_command = command;
}
const char* replay_command() {
  return g_replay_command;
}

void check_failed(const char* expression, const char* file, int line, double left, double right) {
  char buffer[4096];
  int used = std::snprintf(buffer, sizeof buffer, "mlt: bug: %s:%d: check failed: %s (%.9g against %.9g)\n",
                           file, line, expression, left, right);
  used = append_context(buffer, sizeof buffer, used);
  report_and_exit(buffer, clamp_length(used, sizeof buffer));
}

void check_failed(const char* expression, const char* file, int line) {
  char buffer[4096];
  int used =
      std::snprintf(buffer, sizeof buffer, "mlt: bug: %s:%d: check failed: %s\n", file, line, expression);
  used = append_context(buffer, sizeof buffer, used);
  report_and_exit(buffer, clamp_length(used, sizeof buffer));
}

}  // namespace mlt
