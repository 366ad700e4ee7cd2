// Writes ref_images/: make_refs [--large] [--threads N] [SCENE... | --hashes], all scenes when none is named.
// `make refs` runs it, and with --large, which writes ref_images/256/, `make refs256`. The pictures are
// estimates of their own: remaking them with the same code gives the same bits.
#include <sched.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "base/error.hpp"
#include "bench/scene_table.hpp"
#include "compare/compare.hpp"
#include "golden.hpp"
#include "image/image_io.hpp"

namespace mlt::test {
namespace {

constexpr const char* kIndexHeader =
    "# Golden images: NAME.pfm is the mean and NAME.variance.pfm the variance of that mean, by pixel and "
    "channel, of\n"
    "#   mlt render SCENE --integrator path --roulette 8 --width 64 --height 64 --spp SPP --seed S -o S.pfm\n"
    "# for S = 1 to REPLICATES. Written by `make refs`; checked by tests/golden/golden_test.cpp.\n";
constexpr const char* kLargeIndexHeader =
    "# References of the benchmark of time to an error (tests/bench/scenes.txt): NAME.pfm is the mean and\n"
    "# NAME.variance.pfm the variance of that mean, by pixel and channel, of\n"
    "#   mlt render SCENE --integrator path --roulette 8 --width 256 --height 256 --spp SPP --seed S "
    "-o S.pfm\n"
    "# for S = 1 to REPLICATES; 256 is the longer side where the scene's film is not square. Rounded, so "
    "that "
    "they are\n"
    "# stored in few bytes: means to 11 binary digits (a relMSE of 1e-7), variances to 4. Written by `make "
    "refs256`;\n"
    "# checked by tests/converge/large_references_test.cpp.\n";
constexpr const char* kIndexColumns =
    "#   mean: of the picture's luminance, with its standard error relative to it\n"
    "#   pixel error: root mean square of the pixels' standard errors (luminance), relative to the mean\n"
    "#   relMSE: expectation of the picture's own, the mean of variance / (mean^2 + 0.01)\n"
    "# name scene replicates spp seconds | mean, error | pixel error | relMSE\n";
constexpr const char* kHashesHeader =
    "# Film hashes of one job for each scene and integrator: 48 x 40 pixels, 4 samples a pixel, seed 7, all "
    "else\n"
    "# by default. A change needs a line in CHANGELOG.md with the reason and 'golden: ' and the first 16 "
    "digits of\n"
    "# this file's SHA-256. Written by `make refs`.\n"
    "# name integrator hash\n";

/// A folder of references.
struct ReferenceSet {
  std::vector<GoldenScene> scenes;
  std::string index;  ///< its path
  std::string header;
  int mean_bits = 0;  ///< for round_mantissa; 0: not rounded
  int variance_bits = 0;
};

ReferenceSet golden_set() {
  return {golden_scenes(), std::string(kGoldenFolder) + kIndexName,
          std::string(kIndexHeader) + kIndexColumns};
}
ReferenceSet large_set() {
  return {large_scenes(), std::string(kLargeReferences) + kIndexName,
          std::string(kLargeIndexHeader) + kIndexColumns, 10, 3};
}

void write_table(const std::string& path, const std::string& header,
                 const std::map<std::string, std::string>& table) {
  std::ofstream file(path);
  file << header;
  for (const auto& [key, value] : table) file << key << " " << value << "\n";
}

/// Sums of a channel and of its square over the replicates.
struct PixelSums {
  double sum[3] = {0, 0, 0};
  double squares[3] = {0, 0, 0};
};

struct Errors {
  double mean = 0;         ///< luminance
  double mean_error = 0;   ///< relative
  double pixel_error = 0;  ///< root mean square, relative to the mean
  double rel_mse = 0;      ///< expectation of the reference's own
};

Errors errors_of(const std::vector<double>& means, const GoldenReference& reference) {
  const Moments film = moments(means);
  double squares = 0;
  double relative = 0;
  for (std::size_t i = 0; i < reference.variance.pixels.size(); ++i) {
    const Vec3& variance = reference.variance.pixels[i];
    // Channels of one path rise and fall together: the luminance's error is the weighted sum of theirs.
    const double error = 0.2126 * std::sqrt(static_cast<double>(variance.x)) +
                         0.7152 * std::sqrt(static_cast<double>(variance.y)) +
                         0.0722 * std::sqrt(static_cast<double>(variance.z));
    squares += error * error;
    for (int channel = 0; channel < 3; ++channel) {
      const double radiance = reference.mean.pixels[i][channel];
      relative += variance[channel] / (radiance * radiance + kRelMseOffset);
    }
  }
  const double pixels = static_cast<double>(reference.variance.pixels.size());
  return {film.mean, film.standard_error() / film.mean, std::sqrt(squares / pixels) / film.mean,
          relative / (3 * pixels)};
}

GoldenReference reference_of(const std::vector<PixelSums>& sums, const GoldenScene& scene) {
  const double count = scene.replicates;
  GoldenReference reference;
  reference.mean = reference.variance =
      ImageBuffer{scene.width, scene.height, std::vector<Vec3>(sums.size(), Vec3{0, 0, 0})};
  for (std::size_t i = 0; i < sums.size(); ++i) {
    for (int channel = 0; channel < 3; ++channel) {
      const double mean = sums[i].sum[channel] / count;
      const double variance = (sums[i].squares[channel] / count - mean * mean) / (count - 1);
      reference.mean.pixels[i][channel] = static_cast<float>(mean);
      reference.variance.pixels[i][channel] = static_cast<float>(variance > 0 ? variance : 0);
    }
  }
  return reference;
}

std::uint32_t available_threads() {
  cpu_set_t set;
  CPU_ZERO(&set);
  return sched_getaffinity(0, sizeof set, &set) == 0 ? static_cast<std::uint32_t>(CPU_COUNT(&set)) : 1;
}

void round_picture(ImageBuffer& picture, int bits) {
  if (bits == 0) return;
  for (Vec3& pixel : picture.pixels) {
    for (int channel = 0; channel < 3; ++channel) pixel[channel] = round_mantissa(pixel[channel], bits);
  }
}

/// Renders and writes a scene's reference; returns its line of the index.
std::string make_reference(const GoldenScene& golden, const ReferenceSet& set, std::uint32_t threads) {
  const SceneDescription scene = parse_scene_file(golden.file);
  RenderRequest request = reference_request(golden);
  request.threads = threads;
  std::vector<PixelSums> sums(std::size_t{golden.width} * golden.height);
  std::vector<double> means;
  double seconds = 0;
  for (request.seed = 1; request.seed <= golden.replicates; ++request.seed) {
    const RenderResult result = render(scene, request);
    seconds += result.statistics.cpu_seconds;
    means.push_back(mean_luminance(result.image.view()));
    for (std::size_t i = 0; i < sums.size(); ++i) {
      for (int channel = 0; channel < 3; ++channel) {
        const double value = static_cast<double>(result.image.pixels[i][channel]);
        sums[i].sum[channel] += value;
        sums[i].squares[channel] += value * value;
      }
    }
  }
  GoldenReference reference = reference_of(sums, golden);
  round_picture(reference.mean, set.mean_bits);
  round_picture(reference.variance, set.variance_bits);
  write_pfm(reference_path(golden), reference.mean.view());
  write_pfm(variance_path(golden), reference.variance.view());
  const Errors errors = errors_of(means, reference);
  char line[256];
  std::snprintf(line, sizeof line, "%s %u %llu %.0f | %.6g, %.2g %% | %.2g %% | %.2g", golden.file.c_str(),
                golden.replicates, static_cast<unsigned long long>(golden.samples_per_pixel), seconds,
                errors.mean, 100 * errors.mean_error, 100 * errors.pixel_error, errors.rel_mse);
  return line;
}

struct Options {
  bool large = false;
  // After a change of the random numbers the references, which are no function of these, stay as they are.
  bool only_hashes = false;
  std::uint32_t threads = available_threads();
  std::vector<std::string> names;

  bool wants(const std::string& name) const {
    return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
  }
};

Options read_options(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--large") {
      options.large = true;
    } else if (word == "--hashes") {
      options.only_hashes = true;
    } else if (word == "--threads" && i + 1 < argc) {
      options.threads = static_cast<std::uint32_t>(std::stoul(argv[++i]));
    } else {
      options.names.push_back(word);
    }
  }
  return options;
}

int make_all(const Options& options) {
  const ReferenceSet set = options.large ? large_set() : golden_set();
  std::filesystem::create_directories(std::filesystem::path(set.index).parent_path());
  std::map<std::string, std::string> index = read_table(set.index, 1);
  std::map<std::string, std::string> hashes = read_table(kGoldenHashes, 2);
  for (const GoldenScene& scene : set.scenes) {
    if (!options.wants(scene.name)) continue;
    if (!options.only_hashes) index[scene.name] = make_reference(scene, set, options.threads);
    std::printf("%s %s\n", scene.name.c_str(), index[scene.name].c_str());
    std::fflush(stdout);
    // After each scene, so that an interrupted run leaves matching files.
    write_table(set.index, set.header, index);
    if (options.large) continue;
    for (const IntegratorKind kind : kIntegrators)
      hashes[hash_key(scene, kind)] = fixed_job_hash(scene, kind);
    write_table(kGoldenHashes, kHashesHeader, hashes);
  }
  return 0;
}

}  // namespace
}  // namespace mlt::test

int main(int argc, char** argv) {
  try {
    return mlt::test::make_all(mlt::test::read_options(argc, argv));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
