// The references of the benchmark of time to an error are good enough for the errors that it states.
#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>

#include "bench/scene_table.hpp"
#include "converge/reference.hpp"

namespace mlt::test {
namespace {

TEST_CASE("every reference of the benchmark is 100 times better than the error it serves to measure") {
  const std::vector<BenchScene> scenes = read_bench_scenes();
  REQUIRE(scenes.size() >= 10);
  for (const BenchScene& scene : scenes) {
    INFO(scene.name << ": `make refs256` remakes the reference");
    const Reference reference = read_reference(kLargeReferences + scene.name + ".pfm");
    CHECK(std::max(reference.image.width, reference.image.height) == 256);
    // Without its variance a reference would pass as one without noise.
    CHECK(reference.variance_path == kLargeReferences + scene.name + ".variance.pfm");
    CHECK(100 * reference.own_rel_mse <= scene.stated_error);
    CHECK(reference.mean > 0);
  }
}

TEST_CASE("the index names every reference of the benchmark with the samples of the table") {
  std::ostringstream text;
  text << std::ifstream(std::string(kLargeReferences) + "INDEX.txt").rdbuf();
  for (const BenchScene& scene : read_bench_scenes()) {
    std::ostringstream line;
    line << "\n" << scene.name << " " << scene.file << " 8 " << scene.reference_samples << " ";
    INFO(line.str());
    CHECK(text.str().find(line.str()) != std::string::npos);
  }
}

}  // namespace
}  // namespace mlt::test
