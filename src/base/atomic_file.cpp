#include "base/atomic_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <utility>

#include "base/assert.hpp"
#include "base/error.hpp"

namespace mlt {
namespace {

constexpr int kCreateAttempts =
    100;  // a temporary name is taken only by a crashed run with the same process id

/// Failures that say something about the machine rather than about the path that was given.
bool is_resource_failure(int code) {
  return code == ENOSPC || code == EDQUOT || code == EFBIG || code == EIO || code == ENOMEM ||
         code == EMFILE || code == ENFILE || code == EPIPE;
}

[[noreturn]] void throw_cannot_create(const std::string& path, int code) {
  const std::string reason = std::strerror(code);
  if (is_resource_failure(code)) throw ResourceError(path + ": cannot be written: " + reason);
  throw InputError(Diagnostic{
      path, 0, 0, "cannot be written: " + reason + "; expected a file in an existing, writable folder"});
}

std::string folder_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

std::string base_name_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? path : path.substr(slash + 1);
}

/// `path` without symbolic links; unchanged where nothing exists under that name.
std::string resolve_links(const std::string& path) {
  const std::unique_ptr<char, decltype(&std::free)> resolved(::realpath(path.c_str(), nullptr), &std::free);
  return resolved ? std::string(resolved.get()) : path;
}

void require_folder(const std::string& path) {
  const std::string folder = folder_of(path);
  struct stat status {};
  if (::stat(folder.c_str(), &status) != 0) {
    throw InputError(Diagnostic{path, 0, 0,
                                "the folder '" + folder + "' cannot be used: " + std::strerror(errno) +
                                    "; expected a file in an existing, writable folder"});
  }
  if (!S_ISDIR(status.st_mode)) {
    throw InputError(
        Diagnostic{path, 0, 0, "'" + folder + "' is not a folder; expected a file in an existing folder"});
  }
}

/// How the target must be written, found without changing anything.
struct Target {
  std::string path;       ///< links resolved
  bool in_place = false;  ///< a device or pipe
  bool exists = false;
  mode_t permissions = 0;
};

Target examine(const std::string& path) {
  if (path.empty() || path.back() == '/') {
    throw InputError(Diagnostic{"'" + path + "'", 0, 0, "does not name a file; expected a file to write"});
  }
  require_folder(path);
  Target target;
  target.path = resolve_links(path);
  struct stat status {};
  if (::stat(target.path.c_str(), &status) != 0) {
    if (errno != ENOENT) throw_cannot_create(path, errno);
    return target;
  }
  if (S_ISDIR(status.st_mode)) {
    throw InputError(Diagnostic{path, 0, 0, "is a folder; expected a file to write"});
  }
  // Checked although a rename would succeed: a file made read-only is meant to stay.
  if (::faccessat(AT_FDCWD, target.path.c_str(), W_OK, AT_EACCESS) != 0) throw_cannot_create(path, errno);
  target.exists = true;
  target.in_place = !S_ISREG(status.st_mode);
  target.permissions = status.st_mode & 07777;
  return target;
}

/// Creates a new file beside `target`; its name goes to `temporary`.
int create_beside(const std::string& target, std::string& temporary) {
  static std::atomic<unsigned> counter{0};
  for (int attempt = 0; attempt < kCreateAttempts; ++attempt) {
    temporary =
        folder_of(target) + "/.mlt-" + std::to_string(::getpid()) + "-" + std::to_string(counter++) + ".tmp";
    const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor >= 0) return descriptor;
    if (errno != EEXIST) break;
  }
  temporary.clear();
  return -1;
}

}  // namespace

void require_writable(const std::string& path) {
  const Target target = examine(path);
  if (target.in_place) return;
  // Too long a name is refused only under the real name, which must not be created here.
  if (base_name_of(target.path).size() > NAME_MAX) throw_cannot_create(path, ENAMETOOLONG);
  std::string temporary;
  const int descriptor = create_beside(target.path, temporary);
  if (descriptor < 0) throw_cannot_create(path, errno);
  ::close(descriptor);
  ::unlink(temporary.c_str());
}

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)) {
  const Target target = examine(path_);
  target_ = target.path;
  if (target.in_place) {
    descriptor_ = ::open(target_.c_str(), O_WRONLY | O_CLOEXEC);
  } else {
    descriptor_ = create_beside(target_, temporary_);
  }
  if (descriptor_ < 0) throw_cannot_create(path_, errno);
  // Best effort: on file systems without permissions the new file keeps what it has.
  if (target.exists && !target.in_place && ::fchmod(descriptor_, target.permissions) != 0) errno = 0;
}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

bool AtomicFile::write(const void* bytes, std::size_t size) noexcept {
  const char* next = static_cast<const char*>(bytes);
  while (failure_ == 0 && size > 0) {
    const ssize_t written = ::write(descriptor_, next, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      failure_ = written < 0 ? errno : ENOSPC;
    } else {
      next += written;
      size -= static_cast<std::size_t>(written);
    }
  }
  return failure_ == 0;
}

void AtomicFile::commit() {
  MLT_CHECK(descriptor_ >= 0);
  // Devices and pipes need no sync, and refuse it.
  if (failure_ == 0 && !temporary_.empty() && ::fsync(descriptor_) != 0) failure_ = errno;
  if (::close(std::exchange(descriptor_, -1)) != 0 && failure_ == 0 && errno != EINTR) failure_ = errno;
  if (failure_ == 0 && !temporary_.empty() && ::rename(temporary_.c_str(), target_.c_str()) != 0)
    failure_ = errno;
  if (failure_ != 0) throw ResourceError(path_ + ": could not be written: " + std::strerror(failure_));
  if (temporary_.empty()) return;
  temporary_.clear();
  // The rename itself lasts over a power failure only once the folder is synced; some file systems cannot.
  const int folder = ::open(folder_of(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return;
  ::fsync(folder);
  ::close(folder);
}

bool is_same_file(const std::string& a, const std::string& b) {
  struct stat status_a {};
  struct stat status_b {};
  const bool exists_a = ::stat(a.c_str(), &status_a) == 0;
  const bool exists_b = ::stat(b.c_str(), &status_b) == 0;
  if (exists_a != exists_b) return false;
  if (exists_a) return status_a.st_dev == status_b.st_dev && status_a.st_ino == status_b.st_ino;
  return resolve_links(folder_of(a)) == resolve_links(folder_of(b)) && base_name_of(a) == base_name_of(b);
}

}  // namespace mlt
