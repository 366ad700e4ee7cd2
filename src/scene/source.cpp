#include "scene/source.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include "base/error.hpp"
#include "scene/diagnostics.hpp"
#include "scene/limits.hpp"

namespace mlt {
namespace {

std::string system_message(int error) {
  return std::generic_category().message(error);
}

/// Closes on every way out.
struct Descriptor {
  int number = -1;
  explicit Descriptor(int opened) : number(opened) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (number >= 0) ::close(number);
  }
};

/// Empty and errno set when the path does not lead to anything.
std::string resolve(const std::string& path) {
  char* const resolved = ::realpath(path.c_str(), nullptr);
  if (resolved == nullptr) return "";
  std::string result = resolved;
  ::free(resolved);
  return result;
}

std::string with_slash(std::string folder) {
  if (!folder.empty() && folder.back() != '/') folder += '/';
  return folder;
}

[[noreturn]] void fail_reading(const SourceLocation& location, const std::string& path, int error) {
  fail_at(location, "file " + printable(path) + " cannot be read: " + system_message(error));
}

/// Reads up to `capacity` bytes; a file that shrinks gives fewer.
std::size_t read_fully(int descriptor, char* bytes, std::size_t capacity, const std::string& path,
                       const SourceLocation& location) {
  std::size_t size = 0;
  while (size < capacity) {
    const ssize_t got = ::read(descriptor, bytes + size, capacity - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail_reading(location, path, errno);
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  return size;
}

}  // namespace

SourceFolder::SourceFolder(const std::string& scene_path) {
  const std::size_t slash = scene_path.rfind('/');
  shown_folder_ = slash == std::string::npos ? "" : scene_path.substr(0, slash + 1);
  real_folder_ = resolve(shown_folder_.empty() ? "." : shown_folder_);
  if (real_folder_.empty()) fail_reading(SourceLocation{scene_path, 0, 0}, scene_path, errno);
  real_folder_ = with_slash(real_folder_);
}

SourceFile SourceFolder::read_scene(const std::string& scene_path) {
  const SourceLocation whole{scene_path, 0, 0};
  SourceFile file;
  file.shown_path = scene_path;
  file.relative_path = scene_path.substr(shown_folder_.size());
  file.real_path = resolve(scene_path);
  if (file.real_path.empty()) fail_reading(whole, scene_path, errno);
  load(file, kMaxSceneFileBytes, whole);
  return file;
}

SourceFile SourceFolder::read(const std::string& name, const std::string& from, std::uint64_t max_bytes,
                              const SourceLocation& location) {
  if (real_folder_.empty()) fail_at(location, "a scene in memory cannot name the file " + printable(name));
  if (name.empty()) fail_at(location, "the file name is empty; a path relative to this file is expected");
  if (name[0] == '/') {
    fail_at(location,
            "the path " + printable(name) + " is absolute; a path relative to this file is expected");
  }
  const std::string outside =
      "the path " + printable(name) + " leaves the scene's folder; only files in it or below it may be named";
  const auto relative = (std::filesystem::path(from).parent_path() / name).lexically_normal();
  if (relative.begin() != relative.end() && *relative.begin() == "..") fail_at(location, outside);

  SourceFile file;
  file.relative_path = relative.string();
  file.shown_path = shown_folder_ + file.relative_path;
  file.real_path = resolve(real_folder_ + file.relative_path);
  if (file.real_path.empty()) fail_reading(location, name, errno);
  // Symbolic links inside the folder may lead anywhere; what counts is where they end.
  const bool inside = with_slash(file.real_path).compare(0, real_folder_.size(), real_folder_) == 0;
  if (!inside) fail_at(location, outside + " (a symbolic link leads out of it)");
  load(file, max_bytes, location);
  return file;
}

void SourceFolder::load(SourceFile& file, std::uint64_t max_bytes, const SourceLocation& location) {
  if (++files_read_ > kMaxFiles) {
    fail_at(location, "more than " + std::to_string(kMaxFiles) + " files are named by one scene, at most " +
                          std::to_string(kMaxFiles) + " are allowed");
  }
  // O_NONBLOCK: opening a FIFO or a device must not wait for its other end.
  const Descriptor opened(::open(file.real_path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  struct stat status {};
  if (opened.number < 0 || ::fstat(opened.number, &status) != 0) {
    fail_reading(location, file.shown_path, errno);
  }
  if (!S_ISREG(status.st_mode)) {
    const char* const what = S_ISDIR(status.st_mode) ? "a directory" : "no regular file";
    fail_at(location, printable(file.shown_path) + " is " + what + "; a regular file is expected");
  }
  const auto bytes = static_cast<std::uint64_t>(status.st_size);
  if (bytes > max_bytes) {
    throw ResourceError(diagnostic_at(location, printable(file.shown_path) + " has " + std::to_string(bytes) +
                                                    " bytes; at most " + std::to_string(max_bytes) +
                                                    " are allowed")
                            .to_string());
  }
  bytes_read_ += bytes;
  if (bytes_read_ > kMaxTotalFileBytes) {
    throw ResourceError(diagnostic_at(location, "the files of the scene have more than " +
                                                    std::to_string(kMaxTotalFileBytes) +
                                                    " bytes together, which is the limit")
                            .to_string());
  }
  file.bytes = std::make_unique_for_overwrite<char[]>(bytes);
  file.size = read_fully(opened.number, file.bytes.get(), bytes, file.shown_path, location);
}

}  // namespace mlt
