#include "app/commands.hpp"
#include "app/compare_report.hpp"
#include "app/console.hpp"
#include "base/atomic_file.hpp"
#include "image/image_io.hpp"

namespace mlt {
namespace {

void collect_faults(const InputError& error, std::vector<Diagnostic>& diagnostics) {
  diagnostics.insert(diagnostics.end(), error.diagnostics().begin(), error.diagnostics().end());
}

/// Reads all images of both sets; the faults of all are reported together. The first image gives the size.
std::vector<ImageBuffer> read_all(const std::vector<std::string>& paths) {
  std::vector<ImageBuffer> images;
  std::vector<Diagnostic> diagnostics;
  std::size_t sized = 0;  // the first image that could be read
  for (const std::string& path : paths) {
    try {
      images.push_back(read_image(path).image);
    } catch (const InputError& error) {
      collect_faults(error, diagnostics);
      images.emplace_back();
    }
    if (images[sized].pixels.empty()) sized = images.size() - 1;
    const ImageView view = images.back().view();
    if (view.pixels.empty()) continue;
    // A reference without pixels: its own faults were reported when it was read.
    const ImageView size{images[sized].width, images[sized].height, {}};
    const std::vector<Diagnostic> faults = comparison_faults(path, view, paths[sized], size);
    diagnostics.insert(diagnostics.end(), faults.begin(), faults.end());
  }
  if (!diagnostics.empty()) throw InputError(std::move(diagnostics));
  return images;
}

void check_picture(const CompareCommand& command, const std::vector<std::string>& inputs) {
  if (!command.p_picture) return;
  std::vector<Diagnostic> diagnostics;
  const std::string& path = *command.p_picture;
  try {
    if (image_format_of(path) != ImageFormat::png) {
      diagnostics.push_back({path, 0, 0, "cannot hold a drawing; expected a name that ends in .png"});
    }
    require_writable(path);
  } catch (const InputError& error) {
    collect_faults(error, diagnostics);
  }
  for (const std::string& input : inputs) {
    if (!is_same_file(path, input)) continue;
    diagnostics.push_back({path, 0, 0, "is one of the images compared; expected another file to write"});
  }
  if (!diagnostics.empty()) throw InputError(std::move(diagnostics));
}

}  // namespace

ExitCode run_replicate_test(const CompareCommand& command) {
  std::vector<std::string> paths = command.first;
  paths.insert(paths.end(), command.second.begin(), command.second.end());
  check_picture(command, paths);
  const std::vector<ImageBuffer> images = read_all(paths);
  std::vector<ImageView> views;
  for (const ImageBuffer& image : images) views.push_back(image.view());
  const std::span<const ImageView> all(views);
  const std::size_t count = command.first.size();
  const ReplicateTestResult result =
      test_replicates(all.first(count), all.subspan(count), command.test_options);
  if (command.p_picture) {
    write_png(*command.p_picture,
              draw_p_values(result, views[0].width, views[0].height, command.test_options.tile), {});
  }
  print_output(command.json ? test_json(result, command) : test_text(result, command));
  return result.rejected ? ExitCode::kCompareFailed : ExitCode::kOk;
}

}  // namespace mlt
