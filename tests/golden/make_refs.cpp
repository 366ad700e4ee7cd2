// Writes ref_images/: make_refs [SCENE... | --hashes], all scenes without arguments. `make refs` runs it. The
// pictures are estimates of their own: remaking them with the same code gives the same bits.
#include <sched.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "base/error.hpp"
#include "golden.hpp"
#include "image/image_io.hpp"

namespace mlt::test {
namespace {

constexpr const char* kIndexHeader =
    "# Golden images: NAME.pfm is the mean and NAME.variance.pfm the variance of that mean, by pixel and "
    "channel, of\n"
    "#   mlt render SCENE --integrator path --width 64 --height 64 --spp SPP --seed S -o S.pfm\n"
    "# for S = 1 to REPLICATES. Written by `make refs`; checked by tests/golden/golden_test.cpp.\n"
    "#   mean: of the picture's luminance, with its standard error relative to it\n"
    "#   pixel error: root mean square of the pixels' standard errors (luminance), relative to the mean\n"
    "# name scene replicates spp seconds | mean, error | pixel error\n";
constexpr const char* kHashesHeader =
    "# Film hashes of one job for each scene and integrator: 48 x 40 pixels, 4 samples a pixel, seed 7, all "
    "else\n"
    "# by default. A change needs a line in CHANGELOG.md with the reason and 'golden: ' and the first 16 "
    "digits of\n"
    "# this file's SHA-256. Written by `make refs`.\n"
    "# name integrator hash\n";

void write_table(const std::string& path, const char* header,
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
};

Errors errors_of(const std::vector<double>& means, const GoldenReference& reference) {
  const Moments film = moments(means);
  double squares = 0;
  for (const Vec3& variance : reference.variance.pixels) {
    // Channels of one path rise and fall together: the luminance's error is the weighted sum of theirs.
    const double error = 0.2126 * std::sqrt(static_cast<double>(variance.x)) +
                         0.7152 * std::sqrt(static_cast<double>(variance.y)) +
                         0.0722 * std::sqrt(static_cast<double>(variance.z));
    squares += error * error;
  }
  const double pixels = static_cast<double>(reference.variance.pixels.size());
  return {film.mean, film.standard_error() / film.mean, std::sqrt(squares / pixels) / film.mean};
}

GoldenReference reference_of(const std::vector<PixelSums>& sums) {
  constexpr double kCount = kReferenceReplicates;
  GoldenReference reference;
  reference.mean = reference.variance =
      ImageBuffer{kGoldenSide, kGoldenSide, std::vector<Vec3>(sums.size(), Vec3{0, 0, 0})};
  for (std::size_t i = 0; i < sums.size(); ++i) {
    for (int channel = 0; channel < 3; ++channel) {
      const double mean = sums[i].sum[channel] / kCount;
      const double variance = (sums[i].squares[channel] / kCount - mean * mean) / (kCount - 1);
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

/// Renders and writes a scene's reference; returns its line of the index.
std::string make_reference(const GoldenScene& golden) {
  const SceneDescription scene = parse_scene_file(golden.file);
  RenderRequest request = reference_request(golden);
  request.threads = available_threads();
  std::vector<PixelSums> sums(std::size_t{kGoldenSide} * kGoldenSide);
  std::vector<double> means;
  double seconds = 0;
  for (request.seed = 1; request.seed <= kReferenceReplicates; ++request.seed) {
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
  const GoldenReference reference = reference_of(sums);
  write_pfm(reference_path(golden), reference.mean.view());
  write_pfm(variance_path(golden), reference.variance.view());
  const Errors errors = errors_of(means, reference);
  char line[256];
  std::snprintf(line, sizeof line, "%s %u %llu %.0f | %.6g, %.2g %% | %.2g %%", golden.file.c_str(),
                kReferenceReplicates, static_cast<unsigned long long>(golden.samples_per_pixel), seconds,
                errors.mean, 100 * errors.mean_error, 100 * errors.pixel_error);
  return line;
}

int make_all(int argc, char** argv) {
  std::filesystem::create_directories("ref_images");
  std::map<std::string, std::string> index = read_table(kGoldenIndex, 1);
  std::map<std::string, std::string> hashes = read_table(kGoldenHashes, 2);
  // After a change of the random numbers the references, which are no function of these, stay as they are.
  const bool only_hashes = argc == 2 && std::string(argv[1]) == "--hashes";
  for (const GoldenScene& scene : golden_scenes()) {
    bool wanted = argc < 2;
    for (int i = 1; i < argc; ++i) wanted = wanted || scene.name == argv[i];
    if (!wanted && !only_hashes) continue;
    if (!only_hashes) index[scene.name] = make_reference(scene);
    for (const IntegratorKind kind : kIntegrators)
      hashes[hash_key(scene, kind)] = fixed_job_hash(scene, kind);
    std::printf("%s %s\n", scene.name.c_str(), index[scene.name].c_str());
    std::fflush(stdout);
    // After each scene, so that an interrupted run leaves matching files.
    write_table(kGoldenIndex, kIndexHeader, index);
    write_table(kGoldenHashes, kHashesHeader, hashes);
  }
  return 0;
}

}  // namespace
}  // namespace mlt::test

int main(int argc, char** argv) {
  try {
    return mlt::test::make_all(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
