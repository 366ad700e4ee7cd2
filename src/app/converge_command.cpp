#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <optional>

#include "app/commands.hpp"
#include "app/console.hpp"
#include "app/record.hpp"
#include "app/stop_signal.hpp"
#include "app/version.hpp"
#include "base/atomic_file.hpp"
#include "converge/picture.hpp"
#include "converge/plot.hpp"
#include "converge/summary.hpp"
#include "image/image_io.hpp"
#include "scene/parse.hpp"

namespace mlt {
namespace {

/// The folder of the results. One that was made for a run that then wrote nothing is removed.
class OutputFolder {
 public:
  explicit OutputFolder(std::string path) : path_(std::move(path)) {
    struct stat status {};
    if (::stat(path_.c_str(), &status) == 0) {
      if (!S_ISDIR(status.st_mode)) refuse("is not a folder");
    } else {
      std::error_code error;
      made_ = std::filesystem::create_directories(path_, error);
      if (error) refuse("cannot be made: " + error.message());
    }
    require_writable(*this / "converge.csv");
  }
  ~OutputFolder() {
    if (made_) ::rmdir(path_.c_str());  // refused by the system unless the folder is empty
  }
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  [[noreturn]] void refuse(const std::string& fault) const {
    throw InputError(Diagnostic{
        "--output", 0, 0, fmt::format("'{}' {}; expected a folder, or a name that is free", path_, fault)});
  }
  std::string path_;
  bool made_ = false;
};

void write_text(const std::string& path, const std::string& text) {
  AtomicFile file(path);
  file.write(text.data(), text.size());
  file.commit();
}

/// One side of the film: as given, which must be the reference's, or the reference's.
void match_side(const char* option, std::uint32_t side, const std::string& reference,
                std::optional<std::uint32_t>& target, Diagnostics& diagnostics) {
  if (!target) target = side;
  if (*target == side) return;
  diagnostics.push_back(
      {option, 0, 0, fmt::format("found {}; expected {} as in {}, or nothing", *target, side, reference)});
}

std::optional<Reference> load_reference(ConvergeCommand& command) {
  if (!command.reference) return std::nullopt;
  Reference reference = read_reference(*command.reference);
  Diagnostics diagnostics;
  match_side("--width", reference.image.width, reference.path, command.request.width, diagnostics);
  match_side("--height", reference.image.height, reference.path, command.request.height, diagnostics);
  if (!diagnostics.empty()) throw InputError(std::move(diagnostics));
  return reference;
}

/// The options that make the same plan again, budgets written out.
std::string command_text(const ConvergeCommand& command, const ConvergeRun& run) {
  std::string text = fmt::format("mlt converge {}",
                                 shell_quote((command.scene.starts_with("-") ? "./" : "") + command.scene));
  for (const ConvergeMethod& method : run.methods) text += " --method " + shell_quote(method.name);
  text += command.times.empty() ? fmt::format(" --budgets {}", fmt::join(command.budgets, ","))
                                : fmt::format(" --times {}", fmt::join(command.times, ","));
  if (command.reference) text += " --reference " + shell_quote(*command.reference);
  text +=
      fmt::format(" --replicates {} --width {} --height {} --depth {} --seed {} --threads {}",
                  command.replicates, run.width, run.height, run.depth, command.request.seed, run.threads);
  const RenderRequest& request = command.request;
  const RenderRequest defaults;
  if (request.chains) text += fmt::format(" --chains {}", *request.chains);
  if (request.bootstrap) text += fmt::format(" --bootstrap {}", *request.bootstrap);
  if (request.large_step != defaults.large_step) text += fmt::format(" --large-step {}", request.large_step);
  if (request.start != defaults.start) {
    text += " --start " + start_kinds()[static_cast<std::size_t>(request.start)].name;
  }
  if (request.mutation != defaults.mutation) {
    text += " --mutation " + mutation_kinds()[static_cast<std::size_t>(request.mutation)].name;
  }
  if (request.step_size != defaults.step_size) text += fmt::format(" --step-size {}", request.step_size);
  if (request.roulette) {
    text += " --roulette " + (*request.roulette == 0 ? "off" : std::to_string(*request.roulette));
  }
  if (command.exposure != 0) text += fmt::format(" --exposure {}", command.exposure);
  if (command.target) text += fmt::format(" --target {}", *command.target);
  return text + " -o DIR";
}

void print_warnings(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) print_message("mlt: warning: " + warning + "\n");
}

/// Shares of the pixels that the maps' scales hold; the rest, fireflies mostly, has the colour of the end.
constexpr double kErrorShare = 0.99;
constexpr double kDifferenceShare = 0.995;

/// A method's name without blanks, for names of files.
std::string file_stem(std::string method) {
  std::replace(method.begin(), method.end(), ' ', '_');
  return method;
}

/// Pictures of every method at equal time, with maps of one scale for all of them; names their files and
/// scales in `summary`.
void write_pictures(const OutputFolder& folder, const ConvergeRun& run, const Reference* reference,
                    float exposure, ConvergeSummary& summary) {
  const ImageBuffer base = base_image(run, reference);
  const std::vector<TextEntry> metadata{{"Software", fmt::format("mlt {}", kVersion)},
                                        {"Command", summary.command}};
  const auto write = [&](const std::string& name, const ImageBuffer& image, float brightening) {
    write_png(folder / name, image.view(), {brightening, metadata});
    return name;
  };
  std::vector<ImageBuffer> means;
  std::vector<ErrorField> errors, differences;
  for (std::size_t i = 0; i < run.methods.size(); ++i) {
    const auto level = static_cast<std::size_t>(summary.methods[i].equal_time_level);
    means.push_back(mean_image(run, i, level));
    errors.push_back(error_field(run, i, level, base));
    differences.push_back(difference_field(means[i], base));
  }
  summary.error_map_high = scale_end(errors, kErrorShare);
  summary.difference_map_high = scale_end(differences, kDifferenceShare);
  for (std::size_t i = 0; i < run.methods.size(); ++i) {
    MethodSummary& method = summary.methods[i];
    const auto level = static_cast<std::size_t>(method.equal_time_level);
    const std::string stem = file_stem(method.name);
    method.picture = write(stem + ".png", run.images[run.index(i, level, 0)], exposure);
    method.mean_picture = write(stem + ".mean.png", means[i], exposure);
    method.error_map =
        write(stem + ".error.png", draw_field(errors[i], ColourMap::kSequential, summary.error_map_high), 0);
    method.difference_map =
        write(stem + ".difference.png",
              draw_field(differences[i], ColourMap::kDiverging, summary.difference_map_high), 0);
  }
  summary.reference_picture =
      write(reference != nullptr ? "reference.png" : "mean_of_all.png", base, exposure);
}

void write_results(const OutputFolder& folder, const ConvergeRun& run, const Reference* reference,
                   float exposure, ConvergeSummary& summary) {
  // Written last, the summary says that everything beside it belongs to it; so an old one goes first.
  ::unlink((folder / "summary.json").c_str());
  write_text(folder / "converge.csv", to_csv(run, summary.scene));
  write_pictures(folder, run, reference, exposure, summary);
  write_text(folder / "time.svg", to_svg(plot_over_time(summary)));
  write_text(folder / "processor_time.svg", to_svg(plot_over_processor_time(summary)));
  write_text(folder / "samples.svg", to_svg(plot_over_samples(summary)));
  write_text(folder / "summary.json", to_json(summary));
}

}  // namespace

ExitCode run_converge(const ConvergeCommand& given) {
  install_signal_handlers();
  ConvergeCommand command = given;
  print_warnings(command.warnings);
  const SceneDescription scene = parse_scene_file(command.scene);
  print_warnings(scene.warnings);
  const std::optional<Reference> reference = load_reference(command);
  const Reference* known = reference ? &*reference : nullptr;

  ConvergePlan plan;
  plan.methods = command.methods;
  plan.replicates = command.replicates;
  plan.request = command.request;
  for (ConvergeMethod& method : plan.methods) method.budgets = command.budgets;
  if (command.times.empty()) check_plan(scene, plan);
  const OutputFolder folder(command.folder);
  if (!command.times.empty()) {
    if (!budgets_for_times(scene, command.times, plan, stop_requested())) return ExitCode::kInterrupted;
    check_plan(scene, plan);
  }

  const auto begin = std::chrono::steady_clock::now();
  ConvergeRun run = measure(scene, plan, stop_requested(), [&](std::uint32_t done) {
    if (command.quiet) return;
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    print_message(fmt::format("replicate {} of {} done, {:.1f} s, {:.1f} s to go\n", done, plan.replicates,
                              seconds, seconds / done * (plan.replicates - done)));
  });
  if (run.replicates < (known != nullptr ? 1u : 2u)) {
    print_message("mlt: stopped before there were replicates enough; nothing is written\n");
    return ExitCode::kInterrupted;
  }
  score(run, known);
  ConvergeSummary summary = summarise(run, known, command.target.value_or(kUnknown));
  summary.version = kVersion;
  summary.scene = command.scene;
  summary.command = command_text(command, run);
  write_results(folder, run, known, command.exposure, summary);
  print_output(to_text(summary));
  print_warnings(summary.warnings);
  return run.interrupted ? ExitCode::kInterrupted : ExitCode::kOk;
}

}  // namespace mlt
