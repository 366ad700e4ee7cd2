#include "app/request.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace mlt {
namespace {

constexpr double kMaxLimit = 1e30;

/// Parses the values of the options that make a RenderRequest.
class RequestReader {
 public:
  RequestReader(const Words& words, Diagnostics& diagnostics) : words_(words), diagnostics_(diagnostics) {}

  RenderRequest read(RenderRequest request) {
    choose("--integrator", integrator_kinds(), request.integrator);
    integer("--width", 1, kMaxFilmSide, request.width);
    integer("--height", 1, kMaxFilmSide, request.height);
    integer("--spp", 1, kMaxSamplesPerPixel, request.samples_per_pixel);
    integer("--mutations", 1, kMaxSamplesPerPixel, request.samples_per_pixel);
    if (words_.has("--spp") && words_.has("--mutations")) {
      diagnostics_.push_back(
          {"--mutations", 0, 0, "found together with --spp, which means the same; expected one"});
    }
    integer("--rounds", 1, kMaxSamplesPerPixel, request.rounds);
    integer("--max-mutations", 1, kMaxSamplesPerPixel, request.max_per_pixel);
    request.target_error = positive("--target-error");
    request.seconds = positive("--time");
    integer("--depth", 1, kMaxDepth, request.depth);
    integer("--threads", 1, kMaxThreads, request.threads);
    integer("--seed", 0, std::numeric_limits<std::uint64_t>::max(), request.seed);
    integer("--chains", 1, kMaxChains, request.chains);
    integer("--bootstrap", 1, kMaxBootstrap, request.bootstrap);
    real("--large-step", 0, 1, request.large_step);
    choose("--start", start_kinds(), request.start);
    choose("--mutation", mutation_kinds(), request.mutation);
    real("--step-size", kMinStepSize, kMaxStepSize, request.step_size);
    roulette(request.roulette);
    if (words_.has("--isa")) {
      request.instruction_set = best_instruction_set();
      choose("--isa", instruction_sets(), *request.instruction_set);
    }
    if (words_.has("--memory")) {
      request.memory_limit =
          parse_bytes("--memory", words_.get("--memory"), diagnostics_).value_or(request.memory_limit);
    }
    return request;
  }

 private:
  template <class Target>
  void integer(const char* name, std::uint64_t min, std::uint64_t max, Target& target) {
    if (!words_.has(name)) return;
    const auto value = parse_integer(name, words_.get(name), min, max, diagnostics_);
    if (value) target = static_cast<decltype(target_value(target))>(*value);
  }
  template <class T>
  static T target_value(const std::optional<T>&);
  static std::uint64_t target_value(const std::uint64_t&);

  void real(const char* name, float min, float max, float& target) {
    if (words_.has(name))
      target = parse_real(name, words_.get(name), min, max, diagnostics_).value_or(target);
  }

  std::optional<double> positive(const char* name) {
    if (!words_.has(name)) return std::nullopt;
    return parse_double(name, words_.get(name), std::numeric_limits<double>::min(), kMaxLimit, diagnostics_);
  }

  template <class Kind>
  void choose(const char* name, const std::vector<NamedKind>& kinds, Kind& chosen) {
    if (!words_.has(name)) return;
    const auto index = choose_word(name, words_.get(name), names_of(kinds), diagnostics_);
    if (index) chosen = static_cast<Kind>(*index);
  }

  void roulette(std::optional<std::uint32_t>& target) {
    if (!words_.has("--roulette")) return;
    const std::string& word = words_.get("--roulette");
    Diagnostics ignored;
    const auto value = parse_integer("--roulette", word, 1, kMaxDepth, ignored);
    if (word == "off") {
      target = 0;
    } else if (value) {
      target = static_cast<std::uint32_t>(*value);
    } else {
      report_value("--roulette", word, fmt::format("'off' or an integer from 1 to {}", kMaxDepth),
                   diagnostics_);
    }
  }

  const Words& words_;
  Diagnostics& diagnostics_;
};

}  // namespace

RenderRequest read_request(const Words& words, const RenderRequest& defaults, Diagnostics& diagnostics) {
  return RequestReader(words, diagnostics).read(defaults);
}

std::vector<std::string> unused_options(const Words& words, IntegratorKind integrator) {
  std::vector<std::string> warnings;
  for (const OptionSpec& option : option_table()) {
    if (!words.has(option.name) || option.is_used_by(integrator)) continue;
    warnings.push_back(fmt::format("{}: has no effect with --integrator {}", option.name,
                                   integrator_kinds()[static_cast<std::size_t>(integrator)].name));
  }
  return warnings;
}

}  // namespace mlt
