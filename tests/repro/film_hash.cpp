// Renders one job and prints the film's hash: what tools/repro.sh compares over compilers, flags, machines
// and thread counts, and what the proofs of fixed memory watch. It links every stage up to render and neither
// libpng nor the command line, so that it can be built for machines whose libraries are not installed.
//   film_hash SCENE integrator=pssmlt width=32 height=24 spp=8 depth=5 threads=2 seed=1 ... [statistics=1]

#include <atomic>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>

#include "base/assert.hpp"
#include "base/error.hpp"
#include "render/renderer.hpp"
#include "scene/parse.hpp"

namespace mlt {
namespace {

InputError fault(std::string_view option, const std::string& message) {
  return InputError(Diagnostic{std::string(option), 0, 0, message});
}

template <class T>
T number(std::string_view option, std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) {
    throw fault(option, "'" + std::string(text) + "' is not a number in range");
  }
  return value;
}

struct Options {
  RenderRequest request;
  bool statistics = false;
};

template <std::size_t N>
std::size_t choice(std::string_view option, std::string_view text, const std::string_view (&names)[N]) {
  for (std::size_t i = 0; i < N; ++i) {
    if (names[i] == text) return i;
  }
  throw fault(option, "unknown '" + std::string(text) + "'");
}

#define MLT_NAME(name, help, ...) #name,
constexpr std::string_view kIntegrators[] = {MLT_INTEGRATOR_KINDS(MLT_NAME)};
constexpr std::string_view kStarts[] = {MLT_START_KINDS(MLT_NAME)};
constexpr std::string_view kMutations[] = {MLT_MUTATION_KINDS(MLT_NAME)};
constexpr std::string_view kInstructionSets[] = {MLT_INSTRUCTION_SETS(MLT_NAME)};
#undef MLT_NAME

void set_option(Options& options, std::string_view name, std::string_view value) {
  RenderRequest& request = options.request;
  if (name == "integrator") {
    request.integrator = static_cast<IntegratorKind>(choice(name, value, kIntegrators));
  } else if (name == "start") {
    request.start = static_cast<StartKind>(choice(name, value, kStarts));
  } else if (name == "mutation") {
    request.mutation = static_cast<MutationKind>(choice(name, value, kMutations));
  } else if (name == "isa") {
    request.instruction_set = static_cast<InstructionSet>(choice(name, value, kInstructionSets));
  } else if (name == "width") {
    request.width = number<std::uint32_t>(name, value);
  } else if (name == "height") {
    request.height = number<std::uint32_t>(name, value);
  } else if (name == "spp") {
    request.samples_per_pixel = number<std::uint64_t>(name, value);
  } else if (name == "depth") {
    request.depth = number<std::uint32_t>(name, value);
  } else if (name == "threads") {
    request.threads = number<std::uint32_t>(name, value);
  } else if (name == "seed") {
    request.seed = number<std::uint64_t>(name, value);
  } else if (name == "chains") {
    request.chains = number<std::uint32_t>(name, value);
  } else if (name == "bootstrap") {
    request.bootstrap = number<std::uint64_t>(name, value);
  } else if (name == "roulette") {
    request.roulette = number<std::uint32_t>(name, value);
  } else if (name == "film_memory") {
    request.film_memory = number<std::size_t>(name, value);
  } else if (name == "large_step") {
    request.large_step = number<float>(name, value);
  } else if (name == "step_size") {
    request.step_size = number<float>(name, value);
  } else if (name == "statistics") {
    options.statistics = number<int>(name, value) != 0;
  } else {
    throw fault(name, "unknown option");
  }
}

int render(const std::string& path, const Options& options) {
  const SceneDescription scene = parse_scene_file(path);
  Renderer renderer(scene, resolve_job(options.request, scene));
  renderer.prepare();
  const std::atomic<bool> stop{false};
  const RenderStatistics statistics = renderer.run(stop, nullptr, nullptr);
  std::printf("%s\n", statistics.film_hash.c_str());
  if (options.statistics) {
    std::printf("minor_faults %llu\nsamples %llu\nblack %d\n",
                static_cast<unsigned long long>(statistics.minor_faults),
                static_cast<unsigned long long>(statistics.samples), statistics.black ? 1 : 0);
  }
  return static_cast<int>(ExitCode::kOk);
}

}  // namespace
}  // namespace mlt

int main(int argc, char** argv) {
  try {
    mlt::Options options;
    std::string scene;
    for (int i = 1; i < argc; ++i) {
      const std::string_view argument = argv[i];
      const std::size_t equals = argument.find('=');
      if (equals != std::string_view::npos) {
        mlt::set_option(options, argument.substr(0, equals), argument.substr(equals + 1));
      } else if (scene.empty()) {
        scene = argument;
      } else {
        throw mlt::fault(argument, "a second scene; expected option=value");
      }
    }
    if (scene.empty()) throw mlt::fault("film_hash", "expected: film_hash SCENE option=value...");
    return mlt::render(scene, options);
  } catch (const mlt::InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return static_cast<int>(mlt::ExitCode::kBadInput);
  } catch (const mlt::ResourceError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return static_cast<int>(mlt::ExitCode::kResourceLimit);
  }
}
