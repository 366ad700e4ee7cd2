#include "golden.hpp"

#include <algorithm>
#include <bit>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "bench/scene_table.hpp"
#include "image/image_io.hpp"

namespace mlt::test {
namespace {

// Closed forms bound the others better than pictures do, and these four are noisy.
constexpr std::uint64_t kSamples = 128;
constexpr std::uint64_t kSamplesOfHardScenes = 512;
constexpr const char* kHardScenes[] = {"CornellBox2", "cornell_hidden", "corridor", "spheres"};

constexpr const char* kGeneratedScene = "build/scenes/mesh.txt";

GoldenScene golden_scene(const std::filesystem::path& path) {
  const std::string name = path.stem().string();
  const bool hard = std::find(std::begin(kHardScenes), std::end(kHardScenes), name) != std::end(kHardScenes);
  return {name, path.string(), hard ? kSamplesOfHardScenes : kSamples};
}

}  // namespace

std::vector<GoldenScene> golden_scenes() {
  std::vector<GoldenScene> scenes;
  for (const auto& entry : std::filesystem::directory_iterator("scenes")) {
    if (entry.path().extension() == ".txt") scenes.push_back(golden_scene(entry.path()));
  }
  if (std::filesystem::exists(kGeneratedScene)) scenes.push_back(golden_scene(kGeneratedScene));
  std::sort(scenes.begin(), scenes.end(),
            [](const GoldenScene& a, const GoldenScene& b) { return a.name < b.name; });
  return scenes;
}

std::vector<GoldenScene> large_scenes() {
  std::vector<GoldenScene> scenes;
  for (const BenchScene& scene : read_bench_scenes()) {
    const SceneDescription description = parse_scene_file(scene.file);
    const std::uint32_t longer = std::max(description.film_width, description.film_height);
    scenes.push_back({scene.name, scene.file, scene.reference_samples, kLargeReferences,
                      kLargeSide * description.film_width / longer,
                      kLargeSide * description.film_height / longer, kLargeReplicates});
  }
  return scenes;
}

float round_mantissa(float value, int bits) {
  const std::uint32_t unit = std::uint32_t{1} << (23 - bits);
  return std::bit_cast<float>((std::bit_cast<std::uint32_t>(value) + unit / 2) & ~(unit - 1));
}

RenderRequest reference_request(const GoldenScene& scene) {
  RenderRequest request;
  request.integrator = IntegratorKind::path;
  request.roulette = 8;
  request.width = scene.width;
  request.height = scene.height;
  request.samples_per_pixel = scene.samples_per_pixel;
  return request;
}

std::string reference_path(const GoldenScene& scene) {
  return scene.folder + scene.name + ".pfm";
}
std::string variance_path(const GoldenScene& scene) {
  return scene.folder + scene.name + ".variance.pfm";
}

GoldenReference read_reference(const GoldenScene& scene) {
  return {read_pfm(reference_path(scene)).image, read_pfm(variance_path(scene)).image};
}

std::string fixed_job_hash(const GoldenScene& scene, IntegratorKind kind) {
  RenderRequest request;
  request.integrator = kind;
  request.width = 48;
  request.height = 40;
  request.samples_per_pixel = 4;
  request.seed = 7;
  request.threads = 3;
  return render(parse_scene_file(scene.file), request).statistics.film_hash;
}

std::string hash_key(const GoldenScene& scene, IntegratorKind kind) {
  return scene.name + " " + name_of(kind);
}

std::map<std::string, std::string> read_table(const std::string& path, int words) {
  std::map<std::string, std::string> table;
  std::ifstream file(path);
  std::string line;
  while (std::getline(file, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream stream(line);
    std::string key, word;
    for (int i = 0; i < words && stream >> word; ++i) key += (i == 0 ? "" : " ") + word;
    std::string rest;
    std::getline(stream >> std::ws, rest);
    table[key] = rest;
  }
  return table;
}

}  // namespace mlt::test
