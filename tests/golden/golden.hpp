// The golden images in ref_images/: for each scene the path tracer's mean over many seeds with the variance
// of that mean, and the film hashes of one fixed job. make_refs.cpp writes them, golden_test.cpp compares.
// The larger ones in ref_images/256/ are made in the same way for the benchmark of time to an error.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "film/image_view.hpp"
#include "render/render_fixture.hpp"

namespace mlt::test {

inline constexpr std::uint32_t kGoldenSide = 64;  ///< pixels
inline constexpr std::uint32_t kLargeSide = 256;  ///< pixels of the longer side
inline constexpr const char* kGoldenFolder = "ref_images/";
inline constexpr const char* kIndexName = "INDEX.txt";  ///< in the folder of the references
inline constexpr const char* kGoldenHashes = "ref_images/hashes.txt";

/// Seeds 1, 2, ... of the reference; tests use seeds from kFirstTestSeed on.
inline constexpr std::uint32_t kReferenceReplicates = 32;
/// Fewer, since samples of one replicate are stratified; the mean of the variance over the picture stays
/// exact.
inline constexpr std::uint32_t kLargeReplicates = 8;
inline constexpr std::uint64_t kFirstTestSeed = 1000;

struct GoldenScene {
  std::string name;  ///< of the files in the folder
  std::string file;
  std::uint64_t samples_per_pixel = 0;  ///< of one replicate of the reference
  std::string folder = kGoldenFolder;   ///< of the reference, with its slash
  std::uint32_t width = kGoldenSide, height = kGoldenSide;
  std::uint32_t replicates = kReferenceReplicates;
};

/// Every scene in scenes/, and the generated mesh if `make scenes` has been run; by name.
std::vector<GoldenScene> golden_scenes();

/// The scenes of tests/bench/scenes.txt with kLargeSide as the longer side, in the shape that the scene asks
/// for; in the table's order.
std::vector<GoldenScene> large_scenes();

/// Rounds a value >= 0 to nearest with `bits` bits of mantissa after the leading one (1 to 22): the relative
/// error is at most 2^-(bits + 1). What is rounded so is stored in fewer bytes.
float round_mantissa(float value, int bits);

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
