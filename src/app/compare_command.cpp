#include "app/compare_command.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <thread>
#include <utility>

#include "app/commands.hpp"
#include "app/compare_report.hpp"
#include "app/console.hpp"
#include "app/version.hpp"
#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "compare/error_pictures.hpp"
#include "image/image_io.hpp"

namespace mlt {
namespace {

namespace fs = std::filesystem;

/// Faults of several files, thrown together.
class FaultList {
 public:
  template <class Check>
  void collect(const Check& check) {
    try {
      check();
    } catch (const InputError& error) {
      diagnostics_.insert(diagnostics_.end(), error.diagnostics().begin(), error.diagnostics().end());
    }
  }
  void add(const std::string& place, const std::string& message) {
    diagnostics_.push_back({place, 0, 0, message});
  }
  void throw_any() {
    if (!diagnostics_.empty()) throw InputError(std::move(diagnostics_));
  }

 private:
  std::vector<Diagnostic> diagnostics_;
};

void require_png(const std::string& path) {
  if (image_format_of(path) != ImageFormat::png) {
    throw InputError(Diagnostic{path, 0, 0, "cannot hold a drawing; expected a name that ends in .png"});
  }
}

/// What one pair reads and writes.
struct PairPaths {
  std::string name;  ///< empty for a pair given by its files
  std::string image, reference;
  std::optional<std::string> difference, heat_map;
};

/// Everything that can be known of the outputs before time is spent.
void check_outputs(const PairPaths& paths, FaultList& faults) {
  if (paths.heat_map) faults.collect([&] { require_png(*paths.heat_map); });
  if (paths.difference) faults.collect([&] { static_cast<void>(image_format_of(*paths.difference)); });
  for (const auto& output : {paths.difference, paths.heat_map}) {
    if (!output) continue;
    faults.collect([&] { require_writable(*output); });
    if (is_same_file(*output, paths.image) || is_same_file(*output, paths.reference)) {
      faults.add(*output, "is one of the images compared; expected another file to write");
    }
  }
  if (paths.difference && paths.heat_map && is_same_file(*paths.difference, *paths.heat_map)) {
    faults.add(*paths.heat_map, "is given as output twice; expected different files");
  }
}

void write_pictures(const CompareCommand& command, const PairPaths& paths, const ImageView& image,
                    const ImageView& reference, const ImageComparison& comparison,
                    const CompareOptions& options) {
  const std::vector<TextEntry> metadata{
      {"Software", fmt::format("mlt {}", kVersion)}, {"Image", paths.image}, {"Reference", paths.reference}};
  if (paths.difference && image_format_of(*paths.difference) == ImageFormat::pfm) {
    write_pfm(*paths.difference, difference_image(image, reference).view());
  } else if (paths.difference) {
    write_png(*paths.difference, draw_difference(image, reference, command.difference_range), metadata);
  }
  if (paths.heat_map) {
    write_png(*paths.heat_map,
              draw_heat_map(command.heat_metric, image, reference, comparison, options, command.heat_range),
              metadata);
  }
}

PairResult compare_pair(const CompareCommand& command, const PairPaths& paths) {
  FaultList faults;
  LoadedImage image;
  LoadedImage reference;
  faults.collect([&] { image = read_image(paths.image); });
  faults.collect([&] { reference = read_image(paths.reference); });
  faults.throw_any();
  const ImageView a = image.image.view();
  const ImageView b = reference.image.view();
  require_comparable(paths.image, a, paths.reference, b);
  CompareOptions options;
  const bool displayed = image_format_of(paths.image) == ImageFormat::png ||
                         image_format_of(paths.reference) == ImageFormat::png;
  options.flip.mode = command.flip_mode.value_or(displayed ? FlipMode::ldr : FlipMode::hdr);
  options.flip.pixels_per_degree = command.pixels_per_degree;
  options.flip.exposure = options.exposure = static_cast<double>(command.exposure);
  options.flip.threads = std::max(1U, std::thread::hardware_concurrency());
  PairResult result{paths.name, paths.image, paths.reference, a.width, a.height, {}, {}};
  result.comparison = compare_images(a, b, options);
  write_pictures(command, paths, a, b, result.comparison, options);
  result.comparison.flip.map = {};
  for (std::size_t i = 0; i < kMetricCount; ++i) {
    const std::optional<double>& limit = command.limits[i];
    if (limit && exceeds(kMetrics[i].bound, result.comparison.metrics.all[i], *limit)) {
      result.beyond.push_back(i);
    }
  }
  return result;
}

bool is_folder(const std::string& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

/// Names of the images in a folder, sorted. Throws InputError when it cannot be read.
std::vector<std::string> image_names(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (has_image_extension(name)) names.push_back(name);
  }
  if (error) throw InputError(Diagnostic{folder, 0, 0, "cannot be read: " + error.message()});
  std::sort(names.begin(), names.end());
  return names;
}

std::string inside(const std::string& folder, const std::string& name) {
  return (fs::path(folder) / name).string();
}

/// Makes a folder for pictures, which may not be one of those compared: the next run would compare them too.
void prepare_folder(const CompareCommand& command, const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !is_folder(folder)) {
    throw InputError(Diagnostic{
        folder, 0, 0,
        "cannot be used as a folder for pictures" + (error ? ": " + error.message() : std::string())});
  }
  for (const std::string& input : {command.image, command.reference}) {
    std::error_code ignored;
    if (fs::equivalent(folder, input, ignored)) {
      throw InputError(Diagnostic{folder, 0, 0, "is a folder compared; expected another one to write"});
    }
  }
}

std::vector<PairPaths> find_pairs(const CompareCommand& command) {
  FaultList faults;
  std::vector<std::string> names[2];
  faults.collect([&] { names[0] = image_names(command.image); });
  faults.collect([&] { names[1] = image_names(command.reference); });
  const std::string* folders[2] = {&command.image, &command.reference};
  for (int side = 0; side < 2; ++side) {
    for (const std::string& name : names[side]) {
      if (std::binary_search(names[1 - side].begin(), names[1 - side].end(), name)) continue;
      faults.add(inside(*folders[side], name),
                 "has no image of the same name in '" + *folders[1 - side] + "'");
    }
  }
  if (names[0].empty() && names[1].empty()) {
    faults.add(command.image, "holds no images; expected names that end in one of " + image_extensions());
  }
  for (const auto& folder : {command.difference, command.heat_map}) {
    if (folder) faults.collect([&] { prepare_folder(command, *folder); });
  }
  faults.throw_any();
  std::vector<PairPaths> pairs;
  for (const std::string& name : names[0]) {
    PairPaths paths{name, inside(command.image, name), inside(command.reference, name), {}, {}};
    if (command.difference) paths.difference = inside(*command.difference, name + ".png");
    if (command.heat_map) paths.heat_map = inside(*command.heat_map, name + ".png");
    pairs.push_back(std::move(paths));
  }
  return pairs;
}

/// Compares all pairs; the faults of all of them are reported together.
std::vector<PairResult> compare_pairs(const CompareCommand& command, const std::vector<PairPaths>& pairs) {
  FaultList faults;
  for (const PairPaths& paths : pairs) check_outputs(paths, faults);
  faults.throw_any();
  std::vector<PairResult> results;
  for (const PairPaths& paths : pairs) {
    faults.collect([&] { results.push_back(compare_pair(command, paths)); });
  }
  faults.throw_any();
  return results;
}

}  // namespace

ExitCode run_compare(const CompareCommand& command) {
  if (command.test) return run_replicate_test(command);
  const bool folders = is_folder(command.image);
  if (folders != is_folder(command.reference)) {
    throw InputError(Diagnostic{folders ? command.reference : command.image, 0, 0,
                                "is not a folder, but '" + (folders ? command.image : command.reference) +
                                    "' is; expected two images or two folders"});
  }
  std::vector<PairResult> results;
  if (folders) {
    results = compare_pairs(command, find_pairs(command));
    print_output(command.json ? folder_json(results) : folder_text(results));
  } else {
    results = compare_pairs(command,
                            {{"", command.image, command.reference, command.difference, command.heat_map}});
    print_output(command.json ? pair_json(results.front()) : pair_text(results.front()));
  }
  ExitCode code = ExitCode::kOk;
  for (const PairResult& result : results) {
    if (result.beyond.empty()) continue;
    print_message(limit_messages(result, command));
    code = ExitCode::kCompareFailed;
  }
  return code;
}

}  // namespace mlt
