// The golden images in ref_images/: for each scene the path tracer's mean over many seeds with the variance
// of that mean, and the film hashes of one fixed job. make_refs.cpp writes them, golden_test.cpp compares.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "film/image_view.hpp"
#include "render/render_fixture.hpp"

namespace mlt::test {

inline constexpr std::uint32_t kGoldenSide = 64;  ///< pixels
inline constexpr const char* kGoldenIndex = "ref_images/INDEX.txt";
inline constexpr const char* kGoldenHashes = "ref_images/hashes.txt";

struct GoldenScene {
  std::string name;  ///< of the files in ref_images
  std::string file;
  std::uint64_t samples_per_pixel = 0;  ///< of one replicate of the reference
};

/// Every scene in scenes/, and the generated mesh if `make scenes` has been run; by name.
std::vector<GoldenScene> golden_scenes();

/// Seeds 1, 2, ... of the reference; tests use seeds from kFirstTestSeed on.
inline constexpr std::uint32_t kReferenceReplicates = 32;
inline constexpr std::uint64_t kFirstTestSeed = 1000;

/// One replicate of a scene's reference, but for the seed: every default of `mlt render`.
RenderRequest reference_request(const GoldenScene& scene);

struct GoldenReference {
  ImageBuffer mean;
  ImageBuffer variance;  ///< of the mean, estimated from the replicates, by pixel and channel
};

std::string reference_path(const GoldenScene& scene);
std::string variance_path(const GoldenScene& scene);
/// Throws InputError when the files are missing or broken.
GoldenReference read_reference(const GoldenScene& scene);

/// The film hash of the fixed job of a scene and an integrator.
std::string fixed_job_hash(const GoldenScene& scene, IntegratorKind kind);
/// "scene integrator" of a line of hashes.txt.
std::string hash_key(const GoldenScene& scene, IntegratorKind kind);

/// A file of lines "key rest", where the key is the first `words` words; lines that begin with '#' are left
/// out.
std::map<std::string, std::string> read_table(const std::string& path, int words);

}  // namespace mlt::test
