#include "app/record.hpp"

#include <fmt/core.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "app/options.hpp"
#include "app/version.hpp"

namespace mlt {
namespace {

const std::string& integrator_name(const RenderJob& job) {
  return integrator_kinds()[static_cast<std::size_t>(job.integrator)].name;
}

/// "1.27 M"
std::string with_factor(double value) {
  if (value >= 1e9) return fmt::format("{:.2f} G", value / 1e9);
  if (value >= 1e6) return fmt::format("{:.2f} M", value / 1e6);
  if (value >= 1e3) return fmt::format("{:.2f} k", value / 1e3);
  return fmt::format("{:.2f}", value);
}

class JsonObject {
 public:
  void add(const char* key, const std::string& text) { add_raw(key, json_string(text)); }
  void add(const char* key, bool value) { add_raw(key, value ? "true" : "false"); }
  void add(const char* key, std::uint64_t value) { add_raw(key, std::to_string(value)); }
  void add(const char* key, float value) { add_raw(key, fmt::format("{}", value)); }
  void add(const char* key, double value) {
    add_raw(key, std::isfinite(value) ? fmt::format("{}", value) : "null");
  }
  std::string finish() const { return "{\n" + text_ + "\n}\n"; }

 private:
  void add_raw(const char* key, const std::string& value) {
    text_ += (text_.empty() ? "" : ",\n") + fmt::format("  \"{}\": {}", key, value);
  }
  std::string text_;
};

}  // namespace

std::string shell_quote(const std::string& word) {
  const auto is_plain = [](char letter) {
    return (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') ||
           (letter >= '0' && letter <= '9') ||
           std::string_view("_-./,:=+@%").find(letter) != std::string_view::npos;
  };
  bool plain = !word.empty();
  for (const char letter : word) plain = plain && is_plain(letter);
  if (plain) return word;
  std::string quoted = "'";
  for (const char letter : word) {
    if (letter == '\'') {
      quoted += "'\\''";
    } else {
      quoted += letter;
    }
  }
  return quoted + "'";
}

std::string canonical_command(const std::string& scene, const RenderJob& job, float exposure,
                              std::uint64_t rounds) {
  // Behind "--", a name that starts with a hyphen is not taken for an option.
  const std::string name = (scene.starts_with("-") ? "./" : "") + scene;
  const bool is_pssmlt = job.integrator == IntegratorKind::pssmlt;
  std::string command =
      fmt::format("mlt render {} --integrator {} --{} {} --width {} --height {} --depth {} --seed {}",
                  shell_quote(name), integrator_name(job), is_pssmlt ? "mutations" : "spp",
                  job.samples_per_pixel, job.width, job.height, job.depth, job.seed);
  if (is_pssmlt) {
    command += fmt::format(
        " --chains {} --bootstrap {} --large-step {} --start {} --mutation {} --step-size {}", job.chains,
        job.bootstrap, job.large_step, start_kinds()[static_cast<std::size_t>(job.start)].name,
        mutation_kinds()[static_cast<std::size_t>(job.mutation)].name, job.step_size);
  }
  if (job.in_rounds) command += fmt::format(" --rounds {}", std::max<std::uint64_t>(rounds, 1));
  command += " --roulette " + (job.roulette == 0 ? std::string("off") : std::to_string(job.roulette));
  if (exposure != 0.0f) command += fmt::format(" --exposure {}", exposure);
  return command;
}

std::size_t peak_memory_bytes() {
  // The kernel's line counts this program alone; getrusage may still hold the peak of what called exec.
  if (std::FILE* status = std::fopen("/proc/self/status", "r")) {
    char line[256];
    unsigned long long kibibytes = 0;
    bool found = false;
    while (!found && std::fgets(line, sizeof line, status) != nullptr) {
      found = std::sscanf(line, "VmHWM: %llu kB", &kibibytes) == 1;
    }
    std::fclose(status);
    if (found) return static_cast<std::size_t>(kibibytes) * 1024;
  }
  rusage usage{};
  if (::getrusage(RUSAGE_SELF, &usage) != 0 || usage.ru_maxrss < 0) return 0;
  return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

std::vector<TextEntry> image_metadata(const RenderRecord& record) {
  return {{"Software", fmt::format("mlt {}", kVersion)},
          {"Version", kVersion},
          {"Command", record.command},
          {"Seed", std::to_string(record.job.seed)},
          {"Film-Hash", record.statistics.film_hash},
          {"Partial", record.statistics.partial ? "yes" : "no"}};
}

std::string to_json(const RenderRecord& record) {
  const RenderStatistics& statistics = record.statistics;
  JsonObject object;
  object.add("version", std::string(kVersion));
  object.add("command", record.command);
  object.add("film_hash", statistics.film_hash);
  object.add("partial", statistics.partial);
  object.add("integrator", integrator_name(record.job));
  if (record.pilot) {
    object.add("choice", describe(*record.pilot, record.job));
    object.add("pilot_advantage", record.pilot->advantage);
    object.add("pilot_paths", record.pilot->paths);
    object.add("pilot_wall_seconds", record.pilot->wall_seconds);
    object.add("pilot_cpu_seconds", record.pilot->cpu_seconds);
  }
  object.add("width", std::uint64_t{record.job.width});
  object.add("height", std::uint64_t{record.job.height});
  object.add("depth", std::uint64_t{record.job.depth});
  object.add("seed", record.job.seed);
  object.add("chains", std::uint64_t{record.job.chains});
  object.add("bootstrap", record.job.bootstrap);
  object.add("step_size", record.job.step_size);
  object.add("roulette", std::uint64_t{record.job.roulette});
  object.add("threads", std::uint64_t{record.job.threads});
  object.add("wall_seconds", statistics.wall_seconds);
  object.add("cpu_seconds", statistics.cpu_seconds);
  object.add("samples", statistics.samples);
  object.add("mutations", statistics.mutations);
  object.add("primary_samples", statistics.primary_samples);
  object.add("rounds", statistics.rounds);
  if (statistics.error.known) {
    object.add("rel_mse_estimate", statistics.error.rel_mse);
    object.add("rel_mse_standard_error", statistics.error.standard_error);
  }
  object.add("b", statistics.b);
  object.add("b_standard_error", statistics.b_standard_error);
  object.add("acceptance_large", statistics.acceptance_large);
  object.add("acceptance_small", statistics.acceptance_small);
  object.add("longest_rejection_run", statistics.longest_rejection_run);
  object.add("rejected_non_finite", statistics.rejected_non_finite());
  object.add("rejected_nan", statistics.rejected_nan);
  object.add("rejected_infinite", statistics.rejected_infinite);
  object.add("rejected_negative", statistics.rejected_negative);
  object.add("black", statistics.black);
  object.add("minor_faults", statistics.minor_faults);
  object.add("planned_memory_bytes", std::uint64_t{record.planned_memory_bytes});
  object.add("peak_memory_bytes", std::uint64_t{record.peak_memory_bytes});
  return object.finish();
}

std::string summary(const RenderRecord& record) {
  const RenderStatistics& statistics = record.statistics;
  const bool is_pssmlt = record.job.integrator == IntegratorKind::pssmlt;
  const double work = static_cast<double>(is_pssmlt ? statistics.mutations : statistics.samples);
  const double rate = statistics.wall_seconds > 0 ? work / statistics.wall_seconds : 0.0;
  std::string text;
  const auto add = [&text](const char* name, const std::string& value) {
    text += fmt::format("{:<22}{}\n", name, value);
  };
  if (record.pilot) add("integrator", describe(*record.pilot, record.job));
  if (record.pilot && record.pilot->paths > 0) {
    add("pilot", fmt::format("{:.3f} s, processors busy {:.3f} s", record.pilot->wall_seconds,
                             record.pilot->cpu_seconds));
  }
  if (statistics.partial) add("partial", "stopped before the end; the image shows what was done");
  add("time",
      fmt::format("{:.3f} s, processors busy {:.3f} s", statistics.wall_seconds, statistics.cpu_seconds));
  add("rate", fmt::format("{} {}/s", with_factor(rate), is_pssmlt ? "mutations" : "samples"));
  if (is_pssmlt) {
    add("acceptance, large", fmt::format("{:.2f} %", 100 * statistics.acceptance_large));
    add("acceptance, small", fmt::format("{:.2f} %", 100 * statistics.acceptance_small));
    add("longest rejection run", std::to_string(statistics.longest_rejection_run));
  }
  add("b", fmt::format("{:.6g} +- {:.2g}", statistics.b, statistics.b_standard_error));
  if (record.job.in_rounds) add("rounds", fmt::format("{}", statistics.rounds));
  if (statistics.error.known) {
    const double error = 1.96 * statistics.error.standard_error;
    add("estimated relMSE",
        fmt::format("{:.3g}, 95 % within {:.3g} and {:.3g}", statistics.error.rel_mse,
                    std::max(0.0, statistics.error.rel_mse - error), statistics.error.rel_mse + error));
  }
  add("rejected non-finite",
      fmt::format("{} (NaN {}, infinite {}, negative {})", statistics.rejected_non_finite(),
                  statistics.rejected_nan, statistics.rejected_infinite, statistics.rejected_negative));
  add("film hash", statistics.film_hash);
  if (record.job.in_rounds || record.pilot) add("same image by", record.command);
  return text;
}

}  // namespace mlt
