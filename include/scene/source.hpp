// The files of one scene. All of them lie in the folder of the scene file or below it, are regular files and
// have a size below a limit; whatever a scene names, nothing else is opened.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "scene/description.hpp"

namespace mlt {

/// A file's bytes, read once, so that a file which changes meanwhile cannot disturb the reader.
struct SourceFile {
  std::string shown_path;     ///< as diagnostics print it
  std::string relative_path;  ///< from the scene's folder, "." and ".." resolved
  std::string real_path;      ///< symbolic links resolved; equal for the same file
  std::unique_ptr<char[]> bytes;
  std::size_t size = 0;

  std::string_view text() const { return {bytes.get(), size}; }
  std::span<const char> span() const { return {bytes.get(), size}; }
};

class SourceFolder {
 public:
  /// Without files: every name is refused. For parsing from memory.
  SourceFolder() = default;

  /// The folder that `scene_path` lies in. Throws InputError when it cannot be resolved.
  explicit SourceFolder(const std::string& scene_path);

  /// The scene file itself.
  SourceFile read_scene(const std::string& scene_path);

  /// A file named by a statement of `from` (a relative_path). Throws InputError at `location` when the name
  /// is absolute, leaves the folder, or is no readable regular file; ResourceError above `max_bytes` or above
  /// the limits on all files together.
  SourceFile read(const std::string& name, const std::string& from, std::uint64_t max_bytes,
                  const SourceLocation& location);

 private:
  void load(SourceFile& file, std::uint64_t max_bytes, const SourceLocation& location);

  std::string shown_folder_;  ///< as written by the user, with a closing '/', or empty
  std::string real_folder_;   ///< with a closing '/'; empty when there are no files
  std::uint64_t bytes_read_ = 0;
  std::uint32_t files_read_ = 0;
};

}  // namespace mlt
