#include "program.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

namespace mlt {
namespace {

namespace fs = std::filesystem;

pid_t start(const std::vector<std::string>& words, const std::string& folder, const std::string& out,
            const std::string& error) {
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  const pid_t child = ::fork();
  if (child != 0) return child;
  const int input = ::open("/dev/null", O_RDONLY);
  const int output = ::open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  const int errors = ::open(error.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  if (input < 0 || output < 0 || errors < 0 || ::chdir(folder.c_str()) != 0) ::_exit(126);
  ::dup2(input, STDIN_FILENO);
  ::dup2(output, STDOUT_FILENO);
  ::dup2(errors, STDERR_FILENO);
  ::execv(argv[0], argv.data());
  ::_exit(127);
}

ProgramResult run(const std::vector<std::string>& words, const std::string& folder) {
  const TemporaryFolder captured;
  ProgramResult result;
  result.code = wait_for(start(words, folder, captured / "out", captured / "error"));
  result.out = read_text(captured / "out");
  result.error = read_text(captured / "error");
  return result;
}

std::vector<std::string> with_program(const std::vector<std::string>& words) {
  std::vector<std::string> all{program_path()};
  all.insert(all.end(), words.begin(), words.end());
  return all;
}

std::string find_program() {
  if (const char* given = std::getenv("MLT_BINARY")) return fs::absolute(given).string();
  return (fs::read_symlink("/proc/self/exe").parent_path() / "mlt").string();
}

constexpr char kRoom[] =
    "film 8 8\n"
    "camera eye 0 1 3.9 target 0 1 0 up 0 1 0 fov 45\n"
    "material white diffuse reflectance 0.7\n"
    "box -1 0 -1  1 2 4  inward  material white\n"
    "box -0.3 0 -0.3  0.3 0.6 0.3  material white\n";
constexpr char kLamp[] =
    "quad -0.3 1.99 -0.3  0.3 1.99 -0.3  0.3 1.99 0.3  -0.3 1.99 0.3  material white emit 9\n";

}  // namespace

const std::string& program_path() {
  static const std::string path = find_program();
  return path;
}

int wait_for(pid_t process) {
  int status = 0;
  if (process < 0 || ::waitpid(process, &status, 0) != process) return -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

ProgramResult run_mlt(const std::vector<std::string>& words, const std::string& folder) {
  return run(with_program(words), folder);
}

ProgramResult run_shell(const std::string& command, const std::string& folder) {
  return run({"/bin/sh", "-c", "MLT='" + program_path() + "'; " + command}, folder);
}

pid_t start_mlt(const std::vector<std::string>& words, const std::string& folder) {
  return start(with_program(words), folder, folder + "/out", folder + "/error");
}

bool wait_until_caught(pid_t process, int signal) {
  for (int attempt = 0; attempt < 6000; ++attempt) {
    // Before it executes the program, the child still has the handlers of the test.
    std::error_code ignored;
    const std::string folder = "/proc/" + std::to_string(process);
    const bool started = fs::equivalent(folder + "/exe", program_path(), ignored);
    const std::string status = read_text(folder + "/status");
    const std::size_t at = status.find("SigCgt:");
    if (started && at != std::string::npos) {
      const unsigned long long caught = std::strtoull(status.c_str() + at + 7, nullptr, 16);
      if ((caught >> (signal - 1) & 1) != 0) return true;
    }
    ::usleep(10000);
  }
  return false;
}

SceneFolder::SceneFolder() {
  write_text(*this / "scene.txt", std::string(kRoom) + kLamp);
  write_text(*this / "dark.txt", kRoom);
}

std::string SceneFolder::outputs() const {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(path())) {
    const std::string name = entry.path().filename().string();
    if (name != "scene.txt" && name != "dark.txt") names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : " ") + name;
  return text;
}

}  // namespace mlt
