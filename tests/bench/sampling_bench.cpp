// What the low-discrepancy samples of the path tracer gain over independent random numbers: relMSE of
// pictures of 64 x 64 pixels at 64 samples a pixel, and processor time of a sample. Both take one stratum a
// pixel on the film. Start it from the checkout's root.
#include <string>
#include <vector>

#include "converge/reference.hpp"
#include "film/error_estimate.hpp"
#include "film/pixel_film.hpp"
#include "integrator/path.hpp"
#include "integrator/pixel_sampler.hpp"
#include "render/job.hpp"
#include "row.hpp"
#include "scene/parse.hpp"
#include "support/compiled_scene.hpp"

namespace mlt::test {
namespace {

constexpr std::uint32_t kSide = 64;
constexpr std::uint32_t kSamples = 64;
constexpr FeatureMask kAllButRoulette = (kFeatureMaskCount - 1) & ~feature(FeatureBit::roulette);

/// Jittered film coordinates within the pixel, all else independent.
class RandomPixelSampler : public FloatSamples<RandomPixelSampler, float> {
 public:
  explicit RandomPixelSampler(std::uint64_t seed) : rng_(seed, StreamPurpose::kTest, 0) {}
  void start(std::uint32_t x, std::uint32_t y, std::uint32_t) {
    x_ = x;
    y_ = y;
    dimension_ = 0;
  }
  std::uint32_t next_fixed(bool = true) {
    dimension_ += 1;
    if (dimension_ > 2) return rng_.next_fixed();
    const std::uint64_t pixel = dimension_ == 1 ? x_ : y_;
    return static_cast<std::uint32_t>((pixel << 32 | rng_.next_fixed()) / kSide);
  }
  void skip(std::uint32_t, bool = true) {}

 private:
  Rng rng_;
  std::uint32_t x_ = 0, y_ = 0, dimension_ = 0;
};

/// One sample after the other, of which the sampler makes blocks.
class BlockwisePixelSampler : public PixelSampler {
 public:
  explicit BlockwisePixelSampler(std::uint64_t seed) : PixelSampler(seed, kSide, kSide, kSamples) {}
  void start(std::uint32_t x, std::uint32_t y, std::uint32_t i) {
    if (i % kBlock == 0) {
      clear();
      place({x, y, 0, i}, kBlock);
    }
    PixelSampler::start(i % kBlock);
  }
};

struct Picture {
  double rel_mse = 0;
  double nanoseconds = 0;  ///< of processor time for a sample
};

template <class Sampler>
Picture render(const World& world, std::uint32_t depth, Sampler sampler, const Reference& reference) {
  const PathIntegrator<kAllButRoulette> integrator(world, PathSettings{depth, 0});
  std::vector<PixelSum> sums(std::size_t{kSide} * kSide);
  const double begin = cpu_seconds();
  for (std::uint32_t y = 0; y < kSide; ++y) {
    for (std::uint32_t x = 0; x < kSide; ++x) {
      for (std::uint32_t i = 0; i < kSamples; ++i) {
        sampler.start(x, y, i);
        integrator.evaluate(sampler,
                            [&](const Splat& splat, bool) { sums[splat.pixel].add(splat.value, 0, 1); });
      }
    }
  }
  Picture picture;
  picture.nanoseconds = 1e9 * (cpu_seconds() - begin) / (static_cast<double>(sums.size()) * kSamples);
  picture.rel_mse = -reference.own_rel_mse;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const DVec3 truth{reference.image.pixels[i]};
    const DVec3 error = DVec3{develop_pixel(sums[i], kSamples)} - truth;
    for (int c = 0; c < 3; ++c) {
      picture.rel_mse += error[c] * error[c] / (truth[c] * truth[c] + kRelativeErrorOffset) /
                         (3.0 * static_cast<double>(sums.size()));
    }
  }
  return picture;
}

int run() {
  const int runs = quick_bench() ? 3 : 9;
  for (const std::string name : {"CornellBox", "mesh", "glass_slab", "cornell_hidden"}) {
    const std::string folder = name == "mesh" ? "build/scenes/" : "scenes/";
    const SceneDescription description = parse_scene_file(folder + name + ".txt");
    const CompiledScene scene(description, kSide, kSide);
    const std::uint32_t depth = description.depth.value_or(kDefaultDepth);
    const Reference reference = read_reference("ref_images/" + name + ".pfm");
    BenchRow error{"relMSE of 64 samples", name, "", {}, {}, "independent", {}, ""};
    BenchRow time{"a sample of all features", name, "ns", {}, {}, "independent", {}, ""};
    for (int i = 0; i < runs; ++i) {
      const auto seed = static_cast<std::uint64_t>(i);
      const Picture own = render(scene.world(), depth, BlockwisePixelSampler(seed), reference);
      const Picture rival = render(scene.world(), depth, RandomPixelSampler(seed), reference);
      error.readings.push_back(own.rel_mse);
      error.rival_readings.push_back(rival.rel_mse);
      time.readings.push_back(own.nanoseconds);
      time.rival_readings.push_back(rival.nanoseconds);
    }
    print_row(error);
    print_row(time);
  }
  return 0;
}

}  // namespace
}  // namespace mlt::test

int main() {
  return mlt::test::run_bench(&mlt::test::run);
}
