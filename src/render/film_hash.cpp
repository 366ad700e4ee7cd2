#include "render/film_hash.hpp"

#include <bit>

#include "base/sha256.hpp"

namespace mlt {
namespace {

static_assert(std::endian::native == std::endian::little, "the hash is defined on little-endian bytes");

constexpr std::uint64_t kMetropolisFormat = 0x31746c6d74656dULL;  // "metmlt1"
constexpr std::uint64_t kPathFormat = 0x31746c6d687470ULL;        // "pthmlt1"

void update(Sha256& hash, std::uint64_t word) {
  hash.update(&word, sizeof word);
}

Sha256 begin(std::uint64_t format, const RenderStorage& storage) {
  Sha256 hash;
  update(hash, format);
  update(hash, storage.job.width);
  update(hash, storage.job.height);
  return hash;
}

}  // namespace

std::string hash_metropolis_film(const RenderStorage& storage, const FilmNormalisation& normalisation) {
  Sha256 hash = begin(kMetropolisFormat, storage);
  update(hash, normalisation.mutations);
  update(hash, normalisation.fraction_bits);
  update(hash, std::bit_cast<std::uint64_t>(normalisation.b));
  update(hash, std::bit_cast<std::uint64_t>(normalisation.weight_b));
  for (const FilmPixel& pixel : storage.film(0)) {
    hash.update(pixel.metropolis, sizeof pixel.metropolis);
    hash.update(pixel.uniform, sizeof pixel.uniform);
  }
  return to_hex(hash.finish());
}

std::string hash_path_film(const RenderStorage& storage, std::uint64_t rounds) {
  Sha256 hash = begin(kPathFormat, storage);
  update(hash, storage.job.samples_per_pixel * rounds);
  for (const PixelSum& pixel : storage.pixels) hash.update(pixel.channels, sizeof pixel.channels);
  return to_hex(hash.finish());
}

}  // namespace mlt
