#include "app/options.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "app/compare_command.hpp"
#include "app/converge_options.hpp"
#include "app/number.hpp"
#include "image/format.hpp"
#include "render/job.hpp"

namespace mlt {
namespace {

using Commands = std::vector<CommandKind>;

std::string with_hyphens(std::string identifier) {
  std::replace(identifier.begin(), identifier.end(), '_', '-');
  return identifier;
}

/// "name: help; name: help"
std::string list_of(const std::vector<NamedKind>& kinds) {
  std::string text;
  for (const NamedKind& kind : kinds) text += (text.empty() ? "" : "; ") + kind.name + ": " + kind.help;
  return text;
}

template <class Enum>
const std::string& name_of(const std::vector<NamedKind>& kinds, Enum kind) {
  return kinds[static_cast<std::size_t>(kind)].name;
}

std::string format_list() {
  std::string text;
#define MLT_ITEM(name, help) text += std::string(text.empty() ? "" : "; ") + "." #name ": " + (help);
  MLT_IMAGE_FORMATS(MLT_ITEM)
#undef MLT_ITEM
  return text;
}

void add_output_options(std::vector<OptionSpec>& table) {
  const Commands render{CommandKind::render};
  table.push_back({"--output", "-o", "FILE", true, render,
                   fmt::format("image to write, any number of times; the extension chooses the format ({}). "
                               "Default: the scene's base name with .png in the current folder",
                               format_list())});
  table.push_back({"--exposure", "", "EV", false, render,
                   "brightens PNG files by the factor 2^EV, -64 to 64; default 0"});
  table.push_back({"--stats", "", "FILE", false, render, "writes the render's statistics as JSON"});
  table.push_back({"--error-image", "", "FILE", false, render,
                   "image of the estimated standard error of each pixel and channel (docs/ESTIMATOR.md)"});
  table.push_back({"--quiet", "-q", "", false, render, "no progress line and no closing summary"});
}

/// Adds an option of render and info.
void add_job_option(std::vector<OptionSpec>& table, const char* name, const char* value, std::string help,
                    std::vector<IntegratorKind> integrators = {}) {
  table.push_back({name,
                   "",
                   value,
                   false,
                   {CommandKind::render, CommandKind::info},
                   std::move(help),
                   std::move(integrators)});
}

/// What decides the image, apart from the scene; all of these and of add_settings are in the command stored
/// with the image.
void add_job_options(std::vector<OptionSpec>& table) {
  const auto add = [&table](const char* name, const char* value, std::string help) {
    add_job_option(table, name, value, std::move(help));
  };
  add("--integrator", "NAME",
      fmt::format("{}. Default: {}, or {} where a setting of it alone is given", list_of(integrator_kinds()),
                  name_of(integrator_kinds(), IntegratorKind::automatic),
                  name_of(integrator_kinds(), IntegratorKind::pssmlt)));
  add("--spp", "N",
      fmt::format(
          "work per pixel: samples (path; every 16th pixel takes twice as many, which tells the image's "
          "error) or mutations (pssmlt), 1 to {}",
          kMaxSamplesPerPixel));
  add("--mutations", "N",
      "another name of --spp, of which only one may be given; without --integrator it asks for pssmlt");
  add("--rounds", "N",
      fmt::format(
          "repeats the work N times with new random numbers into one image. Default: 1, or without limit "
          "with --target-error or --time, of then {} a pixel by default",
          kDefaultPerRound));
  add("--target-error", "X",
      "ends after the first round whose estimated relMSE is at most X, a number above 0");
  add("--time", "SECONDS",
      "begins no further round after so many seconds; the summary names the rounds made, which give the same "
      "image "
      "as --rounds");
  add("--max-mutations", "N", "limit of samples or mutations a pixel over all rounds");
  add("--width", "N", fmt::format("image width in pixels, 1 to {}; default: the scene's", kMaxFilmSide));
  add("--height", "N", fmt::format("image height in pixels, 1 to {}; default: the scene's", kMaxFilmSide));
  add("--depth", "N",
      fmt::format(
          "maximal number of path edges from camera to light, 1 to {}: 1 shows only light that is seen "
          "directly, 2 adds direct illumination, each further one a bounce. Default: the scene's, else {}",
          kMaxDepth, kDefaultDepth));
  add("--seed", "N", "any 64-bit integer; another seed gives other noise. Default: 0");
}

/// How the integrators estimate the image.
void add_settings(std::vector<OptionSpec>& table) {
  const RenderRequest defaults;
  const std::vector<IntegratorKind> chains{IntegratorKind::pssmlt};
  const auto add_setting = [&table](const char* name, const char* value,
                                    const std::vector<IntegratorKind>& integrators, std::string help) {
    add_job_option(table, name, value, std::move(help), integrators);
  };
  add_setting("--chains", "N", chains,
              fmt::format("pssmlt: number of Markov chains, 1 to {}. Default: from the number of mutations",
                          kMaxChains));
  add_setting(
      "--bootstrap", "N", chains,
      fmt::format(
          "pssmlt: number of paths that seed the chains, 1 to {}. Default: from the number of mutations",
          kMaxBootstrap));
  add_setting("--large-step", "P", chains,
              fmt::format("pssmlt: probability of a large step, 0 to 1; default {}", defaults.large_step));
  add_setting(
      "--start", "NAME", chains,
      fmt::format("pssmlt: {}. Default: {}", list_of(start_kinds()), name_of(start_kinds(), defaults.start)));
  add_setting("--mutation", "NAME", chains,
              fmt::format("pssmlt: kind of small step. {}. Default: {}", list_of(mutation_kinds()),
                          name_of(mutation_kinds(), defaults.mutation)));
  add_setting("--step-size", "X", chains,
              fmt::format("pssmlt: factor on the sizes of small steps, {} to {}; default {}", kMinStepSize,
                          kMaxStepSize, defaults.step_size));
  add_setting("--roulette", "N|off", {IntegratorKind::path, IntegratorKind::pssmlt},
              fmt::format("first path edge that Russian roulette may end, 1 to {}, or off. Default: {}, or "
                          "with --integrator auto what its pilot finds better",
                          kMaxDepth, kDefaultRouletteEdge));
}

/// Where the render runs; without influence on the image.
void add_machine_options(std::vector<OptionSpec>& table) {
  const RenderRequest defaults;
  const auto add = [&table](const char* name, const char* value, std::string help) {
    add_job_option(table, name, value, std::move(help));
  };
  add("--threads", "N",
      fmt::format("1 to {}, without influence on the image; default: the machine's cores", kMaxThreads));
  add("--isa", "NAME",
      fmt::format("instruction set of the inner loops, without influence on the image: {}. Default: the best "
                  "that the processor has",
                  list_of(instruction_sets())));
  add("--memory", "SIZE",
      fmt::format(
          "limit of the render's fixed memory in bytes, with K, M, G or T for powers of 1024; default {}",
          format_bytes(defaults.memory_limit)));
}

std::vector<OptionSpec> make_table() {
  std::vector<OptionSpec> table;
  add_output_options(table);
  add_job_options(table);
  add_settings(table);
  add_machine_options(table);
  add_compare_options(table);
  table.push_back({"--help",
                   "-h",
                   "",
                   false,
                   {CommandKind::render, CommandKind::info, CommandKind::compare, CommandKind::help},
                   "prints this text"});
  add_converge_options(table);
  return table;
}

}  // namespace

const std::vector<OptionSpec>& option_table() {
  static const std::vector<OptionSpec> table = make_table();
  return table;
}

std::vector<OptionSpec> options_of(CommandKind command) {
  std::vector<OptionSpec> found;
  for (const OptionSpec& option : option_table()) {
    if (std::find(option.commands.begin(), option.commands.end(), command) != option.commands.end()) {
      found.push_back(option);
    }
  }
  return found;
}

bool OptionSpec::is_used_by(IntegratorKind kind) const {
  return integrators.empty() || kind == IntegratorKind::automatic ||
         std::find(integrators.begin(), integrators.end(), kind) != integrators.end();
}

std::vector<OptionSpec> method_options() {
  std::vector<OptionSpec> found = option_table();
  std::erase_if(found, [](const OptionSpec& option) { return option.integrators.empty(); });
  return found;
}

std::vector<std::string> command_names() {
  return {
#define MLT_NAME(name, help) #name,
      MLT_COMMANDS(MLT_NAME)
#undef MLT_NAME
  };
}

#define MLT_KIND(name, help, ...) NamedKind{with_hyphens(#name), help},
const std::vector<NamedKind>& integrator_kinds() {
  static const std::vector<NamedKind> kinds{
      MLT_INTEGRATOR_KINDS(MLT_KIND){"auto", "the one of them that a short pilot render finds better"}};
  return kinds;
}

const std::vector<NamedKind>& start_kinds() {
  static const std::vector<NamedKind> kinds{MLT_START_KINDS(MLT_KIND)};
  return kinds;
}

const std::vector<NamedKind>& instruction_sets() {
  static const std::vector<NamedKind> kinds{MLT_INSTRUCTION_SETS(MLT_KIND)};
  return kinds;
}

const std::vector<NamedKind>& mutation_kinds() {
  static const std::vector<NamedKind> kinds{MLT_MUTATION_KINDS(MLT_KIND)};
  return kinds;
}
#undef MLT_KIND

std::vector<std::string> names_of(const std::vector<NamedKind>& kinds) {
  std::vector<std::string> names;
  for (const NamedKind& kind : kinds) names.push_back(kind.name);
  return names;
}

}  // namespace mlt
