// A picture file opened for reading: regular files only, read at offsets, with errors that name the file.
// Shared by the readers of all formats.
#pragma once

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "base/error.hpp"

namespace mlt {

class InputFile {
 public:
  /// Throws InputError; `expected` ends its message, e.g. "a PFM image".
  InputFile(const std::string& path, const char* expected) : path_(path) {
    // Not blocking, since opening a pipe for reading would wait for a writer.
    descriptor_ = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (descriptor_ < 0)
      fail(std::string("cannot be read: ") + std::strerror(errno) + "; expected " + expected);
    struct stat status {};
    if (::fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) {
      ::close(descriptor_);
      fail(std::string("is not a regular file; expected ") + expected);
    }
    size_ = static_cast<std::uint64_t>(status.st_size);
  }
  ~InputFile() { ::close(descriptor_); }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  [[noreturn]] void fail(const std::string& message) const {
    throw InputError(Diagnostic{path_, 0, 0, message});
  }

  /// Up to `size` bytes from `offset`; fewer only at the file's end or on an error, which errno then names.
  std::size_t try_read(void* bytes, std::size_t size, std::uint64_t offset) const noexcept {
    std::size_t done = 0;
    errno = 0;
    while (done < size) {
      const ssize_t count = ::pread(descriptor_, static_cast<char*>(bytes) + done, size - done,
                                    static_cast<off_t>(offset + done));
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) break;
      done += static_cast<std::size_t>(count);
    }
    return done;
  }

  /// As try_read, but throws on an error.
  std::size_t read(void* bytes, std::size_t size, std::uint64_t offset) const {
    const std::size_t done = try_read(bytes, size, offset);
    if (done < size && errno != 0 && errno != EINTR) {
      fail(std::string("cannot be read: ") + std::strerror(errno));
    }
    return done;
  }
  std::uint64_t size() const { return size_; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace mlt
