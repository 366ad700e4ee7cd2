// Output files that appear whole or not at all: bytes go to a temporary file in the target's folder, which
// commit() syncs and renames over the target; every other way out removes it. Targets that are devices or
// pipes cannot be renamed over and are written in place. Not for use inside a render.
#pragma once

#include <cstddef>
#include <string>

namespace mlt {

/// Proves before a render that `path` can be written after it, by creating and removing the temporary file.
/// Throws InputError (named `path`) for a missing or read-only folder, a folder or protected file as target;
/// ResourceError when the disk or a quota refuses even an empty file.
void require_writable(const std::string& path);

class AtomicFile {
 public:
  /// Errors as require_writable. A symbolic link as `path` is followed: what it points to is replaced.
  explicit AtomicFile(std::string path);
  ~AtomicFile();  ///< discards what was written unless commit() returned
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Appends; false once any write has failed, and commit() then reports the first failure. Never throws, so
  /// that C libraries may call it.
  bool write(const void* bytes, std::size_t size) noexcept;

  /// Makes the file appear under its name. Throws ResourceError naming the target (full disk, quota, lost
  /// device); the target is then as it was before.
  void commit();

 private:
  std::string path_;       ///< as given, for messages
  std::string target_;     ///< with symbolic links resolved
  std::string temporary_;  ///< empty when the target is written in place
  int descriptor_ = -1;
  int failure_ = 0;  ///< errno of the first failed write
};

/// True when both paths name the same existing file, or would create the same file.
bool is_same_file(const std::string& a, const std::string& b);

}  // namespace mlt
