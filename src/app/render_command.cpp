#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <exception>

#include "app/commands.hpp"
#include "app/console.hpp"
#include "app/number.hpp"
#include "app/record.hpp"
#include "app/stop_signal.hpp"
#include "base/atomic_file.hpp"
#include "image/image_io.hpp"
#include "render/pilot.hpp"
#include "render/renderer.hpp"
#include "scene/parse.hpp"

namespace mlt {
namespace {

/// Everything that can be known of the outputs before time is spent on rendering.
void check_outputs(const RenderCommand& command) {
  Diagnostics diagnostics;
  const auto collect = [&diagnostics](const auto& check) {
    try {
      check();
    } catch (const InputError& error) {
      diagnostics.insert(diagnostics.end(), error.diagnostics().begin(), error.diagnostics().end());
    }
  };
  std::vector<std::string> paths = command.outputs;
  if (command.error_image) paths.push_back(*command.error_image);
  for (const std::string& path : paths) collect([&path] { static_cast<void>(image_format_of(path)); });
  if (command.stats) paths.push_back(*command.stats);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    collect([&] { require_writable(paths[i]); });
    if (is_same_file(paths[i], command.scene)) {
      diagnostics.push_back({paths[i], 0, 0, "is the scene; expected another file to write"});
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (paths[i] == paths[j] || is_same_file(paths[i], paths[j])) {
        diagnostics.push_back({paths[i], 0, 0, "is given as output twice; expected different files"});
      }
    }
  }
  if (!diagnostics.empty()) throw InputError(std::move(diagnostics));
}

void write_statistics(const std::string& path, const RenderRecord& record) {
  const std::string text = to_json(record);
  AtomicFile file(path);
  file.write(text.data(), text.size());
  file.commit();
}

/// Writes all outputs; the first failure is thrown after the rest has been tried.
void write_outputs(const RenderCommand& command, const Renderer& renderer, RenderRecord& record) {
  std::exception_ptr first_failure;
  const auto attempt = [&first_failure](const auto& write) {
    try {
      write();
    } catch (const std::exception&) {
      if (!first_failure) first_failure = std::current_exception();
    }
  };
  const ImageOptions options{command.exposure, image_metadata(record)};
  for (const std::string& path : command.outputs)
    attempt([&] { write_image(path, renderer.image(), options); });
  if (command.error_image) {
    attempt([&] { write_image(*command.error_image, renderer.standard_errors().view(), options); });
  }
  // Taken last, so that it includes what writing images needs.
  record.peak_memory_bytes = peak_memory_bytes();
  if (command.stats) attempt([&] { write_statistics(*command.stats, record); });
  if (first_failure) std::rethrow_exception(first_failure);
}

/// The request with an integrator chosen, by a pilot where it asks for one, whose time counts.
RenderRequest decide(RenderRequest request, const SceneDescription& scene, RenderRecord& record) {
  if (request.integrator != IntegratorKind::automatic) return request;
  constexpr double kLeastSeconds = 1e-9;  // no further round, but the first
  record.pilot = run_pilot(scene, request, stop_requested());
  request = decided(request, *record.pilot);
  if (request.seconds) {
    request.seconds = std::max(kLeastSeconds, *request.seconds - record.pilot->wall_seconds);
  }
  return request;
}

void print_warnings(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) print_message("mlt: warning: " + warning + "\n");
}

}  // namespace

ExitCode run_render(const RenderCommand& command) {
  install_signal_handlers();
  print_warnings(command.warnings);
  check_outputs(command);
  const SceneDescription scene = parse_scene_file(command.scene);
  print_warnings(scene.warnings);
  RenderRecord record;
  const RenderJob job = resolve_job(decide(command.request, scene, record), scene);
  Renderer renderer(scene, job);
  renderer.prepare();

  record.job = job;
  record.planned_memory_bytes = renderer.memory_plan().total_bytes();
  {
    const bool enabled = !command.quiet && ::isatty(STDERR_FILENO) == 1;
    ProgressLine line(enabled, job.integrator == IntegratorKind::pssmlt ? "mutations" : "samples");
    record.statistics = renderer.run(stop_requested(), ProgressLine::update, &line);
  }
  record.command = canonical_command(command.scene, job, command.exposure, record.statistics.rounds);
  write_outputs(command, renderer, record);

  if (record.statistics.black) {
    print_warnings({command.scene + ": no path carried light; the image is black"});
  }
  if (!command.quiet) {
    std::string text = summary(record);
    for (const std::string& path : command.outputs) text += fmt::format("{:<22}{}\n", "wrote", path);
    print_message(text);
  }
  return record.statistics.partial ? ExitCode::kInterrupted : ExitCode::kOk;
}

ExitCode run_info(const InfoCommand& command) {
  print_warnings(command.warnings);
  const SceneDescription scene = parse_scene_file(command.scene);
  print_warnings(scene.warnings);
  RenderRecord record;
  const RenderJob job = resolve_job(decide(command.request, scene, record), scene);
  const Renderer renderer(scene, job);

  std::string text;
  for (const InfoLine& line : renderer.info()) text += fmt::format("{:<32}{}\n", line.name, line.value);
  if (record.pilot) {
    text += fmt::format("{:<32}{}\n", "choice", describe(*record.pilot, job));
    text += fmt::format("{:<32}{:.3f} s, processors busy {:.3f} s\n", "pilot", record.pilot->wall_seconds,
                        record.pilot->cpu_seconds);
  }
  text += fmt::format("{:<32}{}\n", "command", canonical_command(command.scene, job, 0, job.max_rounds));
  const MemoryPlan& plan = renderer.memory_plan();
  text += "\nmemory plan (blocks of the scene's compilation and of the render share their storage)\n";
  text +=
      fmt::format("  {:<38}{:<10}{:>14}{:>8}{:>16}\n", "block", "needed", "items", "bytes", "total bytes");
  constexpr const char* kLifetimes[] = {"always", "compile", "render"};
  for (const PlanLine& line : plan.lines()) {
    text += fmt::format("  {:<38}{:<10}{:>14}{:>8}{:>16}\n", line.name,
                        kLifetimes[static_cast<std::size_t>(line.lifetime)], line.count, line.item_bytes,
                        line.bytes);
  }
  text += fmt::format("  {:<70}{:>16}  {}\n", "total, with shared storage counted once", plan.total_bytes(),
                      format_bytes(plan.total_bytes()));
  text += fmt::format("  {:<70}{:>16}  {}\n", "limit (--memory)", job.memory_limit,
                      format_bytes(job.memory_limit));
  print_output(text);
  return ExitCode::kOk;
}

}  // namespace mlt
