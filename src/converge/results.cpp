#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "base/error.hpp"
#include "converge/report.hpp"

namespace mlt {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxSummaryBytes = std::uintmax_t{16} << 20;
constexpr std::uintmax_t kMaxPictureBytes = std::uintmax_t{256} << 20;
constexpr int kMaxFolderDepth = 16;
constexpr char kPngSignature[] = "\x89PNG\r\n\x1a\n";

[[noreturn]] void fail(const std::string& place, const std::string& message) {
  throw InputError(Diagnostic{place, 0, 0, message});
}

std::string read_file(const fs::path& path, std::uintmax_t limit) {
  std::error_code error;
  if (!fs::is_regular_file(path, error))
    fail(path.string(), "is no regular file; expected a file of mlt converge");
  const std::uintmax_t size = fs::file_size(path, error);
  if (error || size > limit) {
    fail(path.string(),
         "cannot be read or is too large; expected at most " + std::to_string(limit) + " bytes");
  }
  std::ifstream file(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file || bytes.size() != size) fail(path.string(), "cannot be read");
  return bytes;
}

void read_picture(const fs::path& folder, const std::string& name, ReportEntry& entry) {
  if (name.empty() || entry.pictures.count(name) > 0) return;
  // A summary from elsewhere must not bring other files into the page.
  if (name.find('/') != std::string::npos || name == "." || name == "..") {
    fail((folder / "summary.json").string(), "names the picture '" + name + "'; expected a file beside it");
  }
  std::string bytes = read_file(folder / name, kMaxPictureBytes);
  if (!bytes.starts_with(kPngSignature)) fail((folder / name).string(), "is no PNG file");
  entry.pictures[name] = std::move(bytes);
}

ReportEntry read_result(const fs::path& file, const fs::path& root) {
  ReportEntry entry;
  const fs::path folder = file.parent_path();
  const fs::path relative = folder.lexically_relative(root);
  entry.folder = relative == "." ? "" : relative.string();
  entry.summary = summary_from_json(read_file(file, kMaxSummaryBytes), file.string());
  read_picture(folder, entry.summary.reference_picture, entry);
  for (const MethodSummary& method : entry.summary.methods) {
    for (const std::string* name :
         {&method.picture, &method.mean_picture, &method.error_map, &method.difference_map}) {
      read_picture(folder, *name, entry);
    }
  }
  return entry;
}

}  // namespace

std::vector<ReportEntry> read_results(const std::string& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) fail(folder, "is not a folder; expected results of mlt converge");
  std::vector<fs::path> files;
  fs::recursive_directory_iterator walk(folder, fs::directory_options::skip_permission_denied, error);
  while (!error && walk != fs::recursive_directory_iterator()) {
    if (walk->path().filename() == "summary.json") files.push_back(walk->path());
    if (walk.depth() >= kMaxFolderDepth) walk.disable_recursion_pending();
    walk.increment(error);
  }
  if (error) fail(folder, "cannot be read: " + error.message());
  if (files.empty()) fail(folder, "holds no summary.json; expected results of mlt converge in it or below");
  std::sort(files.begin(), files.end());
  std::vector<ReportEntry> entries;
  for (const fs::path& file : files) entries.push_back(read_result(file, folder));
  return entries;
}

}  // namespace mlt
