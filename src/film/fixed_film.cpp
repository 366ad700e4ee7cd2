#include "film/fixed_film.hpp"

namespace mlt {

void add_films(std::span<FilmPixel> sum, std::span<const FilmPixel> source, std::size_t first,
               std::size_t last) {
  for (std::size_t i = first; i < last; ++i) {
    for (int channel = 0; channel < 3; ++channel) {
      sum[i].metropolis[channel] += source[i].metropolis[channel];
      sum[i].uniform[channel] += source[i].uniform[channel];
      sum[i].difference[channel] += source[i].difference[channel];
    }
  }
}

void develop_film(std::span<const FilmPixel> film, const FilmNormalisation& normalisation,
                  std::span<Vec3> image, std::size_t first, std::size_t last) {
  const double scale = film_scale(normalisation, film.size());
  const double metropolis = normalisation.b * scale;
  const double uniform = normalisation.weight_b * scale;
  for (std::size_t i = first; i < last; ++i) {
    const auto channel = [&](int c) {
      return static_cast<float>(metropolis * static_cast<double>(film[i].metropolis[c]) +
                                uniform * static_cast<double>(film[i].uniform[c]));
    };
    image[i] = Vec3{channel(0), channel(1), channel(2)};
  }
}

}  // namespace mlt
