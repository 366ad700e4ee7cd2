// The contract of a kind of small step, held by every registered kind, and the distributions of each.
#include "markov/mutation.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <vector>

#include "markov/primary_samples.hpp"
#include "markov/steps.hpp"
#include "markov/toy_chains.hpp"
#include "support/statistics.hpp"

namespace mlt::test {
namespace {

constexpr double kSignificance = 1e-4;  // of one test case, by Sidak's correction

/// Hands out a fixed list of draws, again and again.
struct ScriptedGenerator {
  std::vector<std::uint32_t> draws;
  std::size_t next = 0;

  std::uint32_t next_fixed(bool) { return draws[next++ % draws.size()]; }
};

/// Signed length of a step, a fraction of the circle in [-0.5, 0.5).
double signed_distance(std::uint32_t step) {
  return static_cast<std::int32_t>(step) * 0x1p-32;
}

TEST_CASE("pitfall 2: extreme draws give finite small steps") {
  const std::uint32_t extremes[] = {0,          1,          0xff,       0x100,      0x1ff,
                                    0x3fffffff, 0x40000000, 0x7fffffff, 0x80000000, 0x80000001,
                                    0xfffffeff, 0xffffff00, 0xfffffffe, 0xffffffff};
  for_each_mutation([&]<MutationKind kKind>(const char* name) {
    INFO(name);
    for (const std::uint32_t first : extremes) {
      for (const std::uint32_t second : extremes) {
        // Kinds that take two draws meet every pair.
        Steps<kKind, ScriptedGenerator> steps(ScriptedGenerator{{first, second}});
        for (int i = 0; i < 2; ++i) {
          // A step of NaN or infinite length would be cut to zero or be far: a small step is neither.
          const double distance = std::fabs(signed_distance(steps.next()));
          CHECK(distance < 1.0 / 16);
        }
      }
    }
    // The largest steps are not lost to a range check either.
    Steps<kKind, ScriptedGenerator> zeros(ScriptedGenerator{{0}});
    CHECK(std::fabs(signed_distance(zeros.next())) > 1.0 / 128);
  });
}

TEST_CASE("a step's length is in proportion to the step size, and wraps where it is longest") {
  for_each_mutation([&]<MutationKind kKind>(const char* name) {
    for (const float factor : {kMinStepSize, 0.3f, 1.0f, 3.0f, kMaxStepSize}) {
      INFO(name << ", " << factor);
      const Rng rng(6, StreamPurpose::kTest, 0);
      Steps<kKind> unit(rng), scaled(rng, factor);
      double most = 0;
      for (int i = 0; i < 100000; ++i) {
        const double expected = factor * signed_distance(unit.next());
        const double found = signed_distance(scaled.next());
        // Lengths beyond half the circle are those of the other way round.
        const double wrapped = expected - std::floor(expected + 0.5);
        // Both are cut to units of 2^-32, and the floats before that have 24 bits.
        REQUIRE(std::fabs(found - wrapped) <= (1 + factor) * 0x1p-32 + std::fabs(expected) * 0x1p-22);
        most = std::max(most, std::fabs(expected));
      }
      CHECK(most > factor / 65);
    }
    // The longest steps are those of the draw 0; none may be lost to the range of an integer.
    Steps<kKind, ScriptedGenerator> longest(ScriptedGenerator{{0}}, kMaxStepSize);
    CHECK(std::fabs(signed_distance(longest.next())) > 0.2);
  });
}

TEST_CASE("steps forwards and backwards are equally likely at every length") {
  const double threshold = sidak_threshold(kSignificance, 4);
  for_each_mutation([&]<MutationKind kKind>(const char* name) {
    INFO(name);
    Steps<kKind> steps(Rng(1, StreamPurpose::kTest, static_cast<std::uint64_t>(kKind)));
    std::array<std::uint64_t, 64> forwards{}, backwards{};
    constexpr int kSteps = 1000000;
    std::vector<double> samples(kSteps);
    for (double& distance : samples) {
      distance = signed_distance(steps.next());
      const auto cell = static_cast<std::size_t>(std::fabs(distance) * 1024);  // of 1/16 in 64 cells
      REQUIRE(cell < forwards.size());
      ++(distance < 0 ? backwards : forwards)[cell];
    }
    double statistic = 0;
    int cells = 0;
    for (std::size_t i = 0; i < forwards.size(); ++i) {
      const double total = static_cast<double>(forwards[i] + backwards[i]);
      if (total < 20) continue;
      const double difference = static_cast<double>(forwards[i]) - static_cast<double>(backwards[i]);
      statistic += difference * difference / total;
      ++cells;
    }
    CHECK(chi_square_p_value(statistic, cells) > threshold);
    CHECK(student_t_test(moments(samples), 0).p_value > threshold);
  });
}

TEST_CASE("a step leaves the uniform distribution uniform, and wraps exactly") {
  const double threshold = sidak_threshold(kSignificance, 2);
  for_each_mutation([&]<MutationKind kKind>(const char* name) {
    INFO(name);
    Rng rng(2, StreamPurpose::kTest, static_cast<std::uint64_t>(kKind));
    Steps<kKind> steps(Rng(2, StreamPurpose::kTest, 100 + static_cast<std::uint64_t>(kKind)));
    std::vector<std::uint64_t> cells(256);
    const std::vector<double> expected(256, 1000);
    for (int i = 0; i < 256000; ++i) {
      const std::uint32_t start = rng.next_fixed();
      const std::uint32_t step = steps.next();
      ++cells[(start + step) >> 24];
      // What goes over the end comes back by the same step.
      REQUIRE(start + step + (0U - step) == start);
    }
    CHECK(chi_square_test(cells, expected).p_value > threshold);
  });
}

/// Mutates two samples `mutations` times; the largest value that either form of a sample has taken.
template <MutationKind kKind>
float largest_sample(std::uint64_t mutations) {
  std::array<PrimarySampleOf<float>, 2> samples;
  std::array<ProposedSampleOf<float>, 2> saved;
  PrimarySampleVector vector(samples, saved, make_steps_of<float>(kKind), 1);
  vector.set_lane(0, Rng(3, StreamPurpose::kTest, 0));
  float largest = 0;
  float smallest = 1;
  for (std::uint64_t i = 0; i < mutations / 2; ++i) {
    vector.begin_proposal(false);
    const Vec2 pair = vector.next_2d();
    vector.accept();
    largest = std::max(largest, std::max(pair.x, pair.y));
    smallest = std::min(smallest, std::min(pair.x, pair.y));
  }
  return smallest >= 0.0f ? largest : 2.0f;
}

TEST_CASE("pitfall 1: 1e7 mutations stay below 1 and wrap at both ends") {
  for_each_mutation([]<MutationKind kKind>(const char* name) {
    INFO(name);
    const float largest = largest_sample<kKind>(10000000);
    CHECK(largest < 1.0f);
    CHECK(largest > 0.999f);
  });
}

TEST_CASE("pitfall 1, in full: 1e9 mutations stay below 1", "[.slow]") {
  for_each_mutation([]<MutationKind kKind>(const char* name) {
    INFO(name);
    CHECK(largest_sample<kKind>(1000000000) < 1.0f);
  });
}

TEST_CASE("pitfall 1: a sample at either end of the circle becomes no float outside [0,1)") {
  const std::uint32_t extremes[] = {0, 1, 0xff, 0x100, 0x7fffffff, 0xfffffeff, 0xffffff00, 0xffffffff};
  for (const std::uint32_t value : extremes) {
    CHECK(unit_float(value) >= 0.0f);
    CHECK(unit_float(value) < 1.0f);
    // One below zero, the step that a float's wrap-around maps to 1.
    CHECK(unit_float(value + 0xffffffffU) < 1.0f);
  }
}

TEST_CASE("lanes make the steps that each would make alone, and idle ones draw nothing") {
  using F = WideFloat;
  for_each_mutation([&]<MutationKind kKind>(const char* name) {
    INFO(name);
    RngOf<F> rngs;
    std::vector<Steps<kKind>> alone;
    for (int lane = 0; lane < kLaneCount<F>; ++lane) {
      const Rng rng(7, StreamPurpose::kTest, static_cast<std::uint64_t>(lane));
      rngs.set_lane(lane, rng);
      alone.emplace_back(rng, 3.0f);
    }
    Rng masks(8, StreamPurpose::kTest, 0);
    for (int i = 0; i < 10000; ++i) {
      const unsigned bits = masks.next_fixed() >> (32 - kLaneCount<F>);
      const MaskOf<F> active = mask_of<F>(bits);
      const UintOf<F> draws = rngs.next_fixed(active);
      const UintOf<F> steps = make_steps_of<F>(kKind)(draws, rngs, active, 3.0f);
      for_lanes(active, [&](int lane) {
        REQUIRE(lane_of(steps, lane) == alone[static_cast<std::size_t>(lane)].next());
      });
    }
  });
}

TEST_CASE("Kelemen's steps are log-uniform between 1/1024 and 1/64") {
  Steps<MutationKind::kelemen> steps(Rng(4, StreamPurpose::kTest, 0));
  std::vector<std::uint64_t> cells(100);
  for (int i = 0; i < 200000; ++i) {
    const double distance = std::fabs(signed_distance(steps.next()));
    const double position = std::log(distance * 1024) / std::log(16.0);
    // The polynomial's error and the cut to 32 bits, at the smallest distance of 2^22 units.
    REQUIRE(position > -1e-6);
    REQUIRE(position < 1 + 1e-6);
    ++cells[static_cast<std::size_t>(std::min(99.0, std::max(0.0, position * 100)))];
  }
  CHECK(chi_square_test(cells, std::vector<double>(100, 2000)).p_value > kSignificance);
}

TEST_CASE("Gaussian steps are normal with standard deviation 1/128") {
  Steps<MutationKind::gaussian> steps(Rng(5, StreamPurpose::kTest, 0));
  std::vector<std::uint64_t> cells(100);
  for (int i = 0; i < 200000; ++i) {
    const double z = signed_distance(steps.next()) * 128;
    const double quantile = 0.5 * std::erfc(-z / std::sqrt(2.0));
    ++cells[static_cast<std::size_t>(std::min(99.0, quantile * 100))];
  }
  CHECK(chi_square_test(cells, std::vector<double>(100, 2000)).p_value > kSignificance);
}

}  // namespace
}  // namespace mlt::test
