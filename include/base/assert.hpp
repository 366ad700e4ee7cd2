// Assertions, the third kind of failure: a bug of the renderer itself. A failing check prints the
// expression, both values, and what the thread was working on with the command that replays it, then
// ends the process with exit code 70. It never allocates, so it is allowed inside a render.
// MLT_CHECK is always on; MLT_DCHECK only with MLT_DEBUG and may stand in inner loops.
#pragma once

#include <cstdint>

namespace mlt {

/// What the calling thread is working on; printed by a failing check so that it can be replayed.
struct ReplayContext {
  const char* stage = "outside a render";
  std::uint64_t seed = 0;
  std::uint64_t unit = 0;  ///< chain, bootstrap chunk or pixel block index
  std::uint64_t step = 0;  ///< mutation or sample within the unit
};

ReplayContext& replay_context();

/// The command line that the failing process was started with; kept by reference for failure reports.
void set_replay_command(const char* command);
const char* replay_command();

[[noreturn]] void check_failed(const char* expression, const char* file, int line, double left, double right);
[[noreturn]] void check_failed(const char* expression, const char* file, int line);

}  // namespace mlt

#define MLT_CHECK(condition)                               \
  do {                                                     \
    if (!(condition)) [[unlikely]]                         \
      ::mlt::check_failed(#condition, __FILE__, __LINE__); \
  } while (false)

/// Compares two numbers and prints both when the relation does not hold.
#define MLT_CHECK_OP(left, op, right)                                                              \
  do {                                                                                             \
    if (!((left)op(right))) [[unlikely]]                                                           \
      ::mlt::check_failed(#left " " #op " " #right, __FILE__, __LINE__, static_cast<double>(left), \
                          static_cast<double>(right));                                             \
  } while (false)

#ifdef MLT_DEBUG
#define MLT_DCHECK(condition) MLT_CHECK(condition)
#else
#define MLT_DCHECK(condition) static_cast<void>(0)
#endif
