// The film's hash: SHA-256 over everything that determines the image, as little-endian numbers: a format
// word, width, height, then
//   pssmlt: mutations, fraction bits, the bits of b and of the weights' b as doubles, and the six int64 sums
//   of
//           each pixel in row order;
//   path:   samples a pixel of all rounds, and the three double sums of each pixel in row order.
// Equal hashes mean equal images to the last bit, and equal brightness estimates.
#pragma once

#include <string>

#include "film/fixed_film.hpp"
#include "render/kernel.hpp"

namespace mlt {

/// 64 hexadecimal digits. The films must be summed into the first worker's.
std::string hash_metropolis_film(const RenderStorage& storage, const FilmNormalisation& normalisation);
std::string hash_path_film(const RenderStorage& storage, std::uint64_t rounds);

}  // namespace mlt
