#include <string>
#include <vector>

#include "app/commands.hpp"
#include "app/record.hpp"
#include "base/assert.hpp"

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + (argc > 0 ? 1 : 0), argv + argc);
  // Static, because failure reports refer to it until the process has ended.
  static std::string line = "mlt";
  for (const std::string& word : words) line += " " + mlt::shell_quote(word);
  mlt::set_replay_command(line.c_str());
  return static_cast<int>(mlt::run_program(words));
}
