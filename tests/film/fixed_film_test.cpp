// Fixed-point sums: exact, independent of order and of how films are divided, and never beyond 63 bits.
#include "film/fixed_film.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <thread>
#include <vector>

#include "base/error.hpp"
#include "film/pixel_film.hpp"
#include "markov/toy_chains.hpp"
#include "markov/toy_integrators.hpp"
#include "support/child_process.hpp"

namespace mlt {

// Bit equality, for films.
bool operator==(const FilmPixel& a, const FilmPixel& b) {
  return std::equal(a.metropolis, a.metropolis + 3, b.metropolis) &&
         std::equal(a.uniform, a.uniform + 3, b.uniform) &&
         std::equal(a.difference, a.difference + 3, b.difference);
}

namespace test {
namespace {

constexpr std::int64_t kLargestSum = std::numeric_limits<std::int64_t>::max();
constexpr float kLargestChannel = 1 / 0.0722f;  ///< of a splat of luminance 1: pure blue

using Pixels = std::vector<FilmPixel>;

/// Sums `count` splats of 0.01 into one pixel; true when the sum is the exact multiple.
bool is_exact_sum(std::uint64_t count) {
  Pixels pixels(1);
  const std::uint32_t bits = film_fraction_bits(count);
  FixedFilm film(pixels, bits);
  for (std::uint64_t i = 0; i < count; ++i) film.splat(0, Vec3{0.01f, 0.02f, 0.03f}, 1.0, 0.0);
  const double unit = std::ldexp(1.0, static_cast<int>(bits));
  bool exact = pixels[0].uniform[0] == 0;
  const float values[] = {0.01f, 0.02f, 0.03f};
  for (int c = 0; c < 3; ++c) {
    const std::int64_t once = std::llround(static_cast<double>(values[c]) * unit);
    exact = exact && pixels[0].metropolis[c] == once * static_cast<std::int64_t>(count);
    // The error is half a unit for each splat.
    const double mean = static_cast<double>(pixels[0].metropolis[c]) / static_cast<double>(count) / unit;
    exact = exact && std::fabs(mean - static_cast<double>(values[c])) <= 0.5 / unit;
  }
  return exact;
}

TEST_CASE("pitfall 9: 1e7 splats into one pixel sum exactly") {
  CHECK(is_exact_sum(10000000));
}

TEST_CASE("pitfall 9, in full: 1e9 splats into one pixel sum exactly", "[.slow]") {
  CHECK(is_exact_sum(1000000000));
}

TEST_CASE("a splat is rounded to the nearest unit and goes to its pixel and its sums alone") {
  Pixels pixels(3);
  FixedFilm film(pixels, 28);
  film.splat(1, Vec3{1, 0x1p-28f, 0x1.7p-28f}, 1.0, 0.0);
  film.splat(1, Vec3{1, 0x1p-29f, 0x1.fp-30f}, 0.0, 1.0);
  film.splat(2, Vec3{0.5f, 0.25f, 3}, 2.5, 1.0);
  CHECK(pixels[0] == FilmPixel{});
  CHECK(pixels[1] == FilmPixel{.metropolis = {1 << 28, 1, 1}, .uniform = {1 << 28, 1, 0}});
  CHECK(pixels[2] == FilmPixel{.metropolis = {5 << 26, 5 << 25, std::int64_t{15} << 27},
                               .uniform = {1 << 27, 1 << 26, 3 << 28}});
}

TEST_CASE("pitfall 9: no number of mutations that leaves enough fraction bits can overflow a pixel") {
  std::vector<std::uint64_t> counts{1, 2, 3, 1000};
  for (int k = 10; k <= 31; ++k) {
    const std::uint64_t power = std::uint64_t{1} << k;
    counts.insert(counts.end(), {power - 1, power, power + 1});
  }
  for (const std::uint64_t mutations : counts) {
    const std::uint32_t bits = film_fraction_bits(mutations);
    if (bits < kMinFractionBits) continue;
    INFO(mutations << " mutations, " << bits << " bits");
    CHECK(bits <= kMaxFractionBits);
    // The worst film: all mutations in one pixel, as one state that is never left; then as single splats,
    // each of which rounds up by half a unit, twice as many as mutations (a chain splats at most one state
    // more than it makes mutations), each cut into 16.
    Pixels pixels(1);
    FixedFilm film(pixels, bits);
    film.splat(0, Vec3{kLargestChannel}, static_cast<double>(mutations), 0.0);
    const std::int64_t rounding = static_cast<std::int64_t>(mutations) * 16;
    CHECK(pixels[0].metropolis[0] > 0);
    CHECK(pixels[0].metropolis[0] <= kLargestSum - rounding);
    film.splat(0, Vec3{kLargestChannel}, 0.0, 1.0);
    CHECK(pixels[0].uniform[0] <= (kLargestSum - rounding) / static_cast<std::int64_t>(mutations));
  }
}

TEST_CASE("fraction bits follow from the mutations: as many as fit, at most 40") {
  CHECK(film_fraction_bits(1) == 40);
  CHECK(film_fraction_bits(1 << 19) == 40);
  CHECK(film_fraction_bits((1 << 19) + 1) == 39);
  CHECK(film_fraction_bits(std::uint64_t{1} << 31) == kMinFractionBits);
  CHECK(film_fraction_bits((std::uint64_t{1} << 31) + 1) == kMinFractionBits - 1);
  CHECK(film_fraction_bits(std::numeric_limits<std::uint64_t>::max()) == 0);
}

TEST_CASE("values that no splat can have, and pixels outside the film, are bugs") {
  Pixels pixels(2);
  FixedFilm film(pixels, 28);
  const auto exit_code = [&](std::uint32_t pixel, float value, double weight) {
    return run_in_child([&] { film.splat(pixel, Vec3{value}, weight, 0.0); }).exit_code;
  };
  const int bug = static_cast<int>(ExitCode::kBug);
  CHECK(exit_code(1, 13.9f, 1) == 0);
  CHECK(exit_code(2, 1, 1) == bug);
  CHECK(exit_code(0, -1e-6f, 1) == bug);
  CHECK(exit_code(0, std::numeric_limits<float>::quiet_NaN(), 1) == bug);
  CHECK(exit_code(0, std::numeric_limits<float>::infinity(), 1) == bug);
  CHECK(exit_code(0, 14.1f, 0x1p31) == bug);
}

/// Worker i splats to film i % `film_count`; which worker runs which chain is `schedule`, in its order.
Pixels run_scheduled(const std::vector<std::uint64_t>& schedule, std::size_t workers, std::size_t film_count,
                     const ToyJob& job, const ToyBootstrap& bootstrap) {
  const SmoothToy<> toy;
  const FilmWriters writers = film_count < workers ? FilmWriters::several : FilmWriters::one;
  std::vector<Pixels> films(film_count, Pixels(toy.kPixels));
  std::atomic<std::size_t> next{0};
  const auto work = [&](std::size_t worker) {
    FixedFilm film(films[worker % film_count], 40, 0, writers);
    for (std::size_t i = 0; (i = next.fetch_add(1)) < schedule.size();) {
      const SeedPath start = seed_path_of_chain(toy, job, bootstrap, schedule[i]);
      run_chain<Mutation<MutationKind::kelemen>>(toy, job, 1, schedule[i], start, film);
    }
  };
  std::vector<std::thread> threads;
  for (std::size_t worker = 0; worker < workers; ++worker) threads.emplace_back(work, worker);
  for (std::thread& thread : threads) thread.join();
  // Summed in two ranges, as the renderer's units do.
  Pixels sum(toy.kPixels);
  for (const Pixels& film : films) {
    add_films(sum, film, 0, 5);
    add_films(sum, film, 5, sum.size());
  }
  return sum;
}

TEST_CASE("pitfall 9: the same film for 1 to 64 threads, shuffled chains, and threads that share films") {
  ToyJob job;
  job.chains = 100;
  const ToyBootstrap bootstrap = run_bootstrap(SmoothToy<>{}, job.seed, job.bootstrap);
  std::vector<std::uint64_t> schedule(job.chains);
  std::iota(schedule.begin(), schedule.end(), 0);
  const Pixels reference = run_scheduled(schedule, 1, 1, job, bootstrap);
  CHECK_FALSE(reference == Pixels(reference.size()));
  Rng rng(9, StreamPurpose::kTest, 0);
  for (const std::size_t workers : {1U, 2U, 3U, 7U, 64U}) {
    for (std::size_t i = schedule.size() - 1; i > 0; --i) {
      std::swap(schedule[i], schedule[rng.next_fixed() % (i + 1)]);
    }
    for (const std::size_t films : {workers, std::size_t{1}, workers / 2 + 1}) {
      INFO(workers << " threads, " << films << " films");
      CHECK(run_scheduled(schedule, workers, films, job, bootstrap) == reference);
    }
  }
}

TEST_CASE("several writers add the same as one, to all sums of their pixel") {
  Pixels alone(2), shared(2);
  for (const int half : {1, -1, 0}) {
    FixedFilm(alone, 28, half).splat(1, Vec3{0.5f, 0.25f, 3}, 2.5, 1.0);
    FixedFilm(shared, 28, half, FilmWriters::several).splat(1, Vec3{0.5f, 0.25f, 3}, 2.5, 1.0);
    FixedFilm(shared, 28, half, FilmWriters::several).splat(0, Vec3{1}, 0.0, 0.0);
    CHECK(shared == alone);
  }
  CHECK(shared[0] == FilmPixel{});
}

TEST_CASE("splats in lanes add what they add one by one") {
  using F = WideFloat;
  constexpr std::uint32_t kPixels = 5;  // fewer than lanes
  Rng rng(10, StreamPurpose::kTest, 0);
  Pixels one_by_one(kPixels), in_lanes(kPixels);
  std::array<FixedFilm, kWideLanes> singles, films;
  for (int lane = 0; lane < kWideLanes; ++lane) {
    const int half = lane % 3 - 1;
    singles[static_cast<std::size_t>(lane)] = FixedFilm(one_by_one, 30, half);
    films[static_cast<std::size_t>(lane)] = FixedFilm(in_lanes, 30, half);
  }
  for (int i = 0; i < 2000; ++i) {
    const MaskOf<F> lanes = mask_of<F>(rng.next_fixed() >> (32 - kWideLanes));
    const MaskOf<F> uniform = mask_of<F>((rng.next_fixed() & rng.next_fixed()) >> (32 - kWideLanes));
    UintOf<F> pixels{};
    Vec3Of<F> values{F{}, F{}, F{}};
    double weights[kWideLanes];
    for (int lane = 0; lane < kWideLanes; ++lane) {
      weights[lane] = rng.next_float() < 0.2f ? 0.0 : 3.0 * static_cast<double>(rng.next_float());
      set_lane_of(pixels, lane, rng.next_fixed() % kPixels);
      if ((lanes_of(lanes) >> lane & 1U) == 0) continue;
      set_lane_of(values, lane, Vec3{rng.next_float(), 3 * rng.next_float(), 0x1p-20f * rng.next_float()});
    }
    FixedFilm::splat_lanes<F>(films, lanes, pixels, values, weights, uniform);
    for_lanes(lanes, [&](int lane) {
      const double uniform_weight = (lanes_of(uniform) >> lane & 1U) != 0 ? 1.0 : 0.0;
      singles[static_cast<std::size_t>(lane)].splat(lane_of(pixels, lane), lane_of(values, lane),
                                                    weights[lane], uniform_weight);
    });
  }
  CHECK(in_lanes == one_by_one);
  CHECK(one_by_one[0].uniform[2] != 0);
}

TEST_CASE("adding films changes only the range asked for") {
  Pixels sum(4, FilmPixel{.metropolis = {1, 2, 3}, .difference = {7, -8, 9}, .uniform = {4, 5, 6}});
  const Pixels source(
      4, FilmPixel{.metropolis = {10, 20, 30}, .difference = {-70, 80, 90}, .uniform = {40, 50, 60}});
  add_films(sum, source, 1, 3);
  const FilmPixel untouched{.metropolis = {1, 2, 3}, .difference = {7, -8, 9}, .uniform = {4, 5, 6}};
  const FilmPixel added{.metropolis = {11, 22, 33}, .difference = {-63, 72, 99}, .uniform = {44, 55, 66}};
  CHECK(sum == Pixels{untouched, added, added, untouched});
}

TEST_CASE("developing multiplies the Metropolis sums by b, the uniform sums by the weights' b") {
  Pixels film(4);
  const std::int64_t unit = std::int64_t{1} << 30;
  film[1] = FilmPixel{.metropolis = {unit, 2 * unit, 0}, .uniform = {0, 3 * unit, 5 * unit}};
  FilmNormalisation normalisation;
  normalisation.b = 7;
  normalisation.weight_b = 11;
  normalisation.mutations = 8;
  normalisation.fraction_bits = 30;
  const Vec3 untouched{-1, -1, -1};
  std::vector<Vec3> image(4, untouched);
  develop_film(film, normalisation, image, 1, 3);
  // Pixels / mutations = 1/2.
  CHECK(image[1] == Vec3{3.5f, 7.0f + 16.5f, 27.5f});
  CHECK(image[2] == Vec3{0});
  CHECK(image[0] == untouched);
  CHECK(image[3] == untouched);
}

TEST_CASE("a pixel's samples are summed in double and averaged") {
  PixelSum sum;
  for (int i = 0; i < 1000000; ++i) sum.add(Vec3{0.1f, 1e-3f, 4}, 0, 1);
  const Vec3 mean = develop_pixel(sum, 1000000);
  // A float sum would be off by percents; double by less than half a unit of a float's last place.
  CHECK(mean == Vec3{0.1f, 1e-3f, 4});
  CHECK(develop_pixel(PixelSum{}, 3) == Vec3{0});
}

}  // namespace
}  // namespace test
}  // namespace mlt
