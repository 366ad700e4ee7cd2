// The lazily mutated state: what it keeps, what it undoes, and that being lazy changes no distribution.
#include "markov/primary_samples.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <vector>

#include "base/error.hpp"
#include "integrator/sampler.hpp"
#include "markov/steps.hpp"
#include "markov/toy_chains.hpp"
#include "markov/toy_integrators.hpp"
#include "support/child_process.hpp"
#include "support/statistics.hpp"

namespace mlt::test {
namespace {

constexpr double kSignificance = 1e-4;  // of one test case, by Sidak's correction
constexpr std::size_t kCells = 64;

/// Steps of one unit.
struct UnitMutation {
  template <class F, class Generator>
  static std::uint32_t steps(const std::uint32_t&, Generator&, const bool&, float) {
    return 1;
  }
};

/// The n-th step of a chain has length n, so that lengths tell how many steps were taken.
struct CountingMutation {
  static inline std::uint32_t count = 0;
  template <class F, class Generator>
  static std::uint32_t steps(const std::uint32_t&, Generator&, const bool& wanted, float) {
    return wanted ? ++count : 0;
  }
};

template <class Mutation, std::size_t kCapacity = 4>
struct Fixture {
  std::array<PrimarySampleOf<float>, kCapacity> samples;
  std::array<ProposedSampleOf<float>, kCapacity> saved;
  PrimarySampleVector vector;

  explicit Fixture(std::uint64_t stream, std::uint32_t first_time = 1)
      : vector(samples, saved, &Mutation::template steps<float, Rng>, 1, first_time) {
    vector.set_lane(0, Rng(19, StreamPurpose::kTest, stream));
    vector.begin_initial(bootstrap_sampler(stream, 0, 1));
  }

  std::uint32_t propose(bool large_step, std::uint32_t index = 0) {
    vector.begin_proposal(large_step);
    vector.skip(index);
    return vector.next_fixed();
  }
};

/// p-value for two histograms with the same total to come from the same distribution.
double two_sample_p_value(const std::vector<std::uint64_t>& a, const std::vector<std::uint64_t>& b) {
  double statistic = 0;
  double dof = -1;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double total = static_cast<double>(a[i] + b[i]);
    if (total < 10) continue;
    const double difference = static_cast<double>(a[i]) - static_cast<double>(b[i]);
    statistic += difference * difference / total;
    dof += 1;
  }
  return chi_square_p_value(statistic, dof);
}

TEST_CASE("the first state is the bootstrap path's, sample for sample") {
  Fixture<UnitMutation> fixture(0);
  BootstrapSamplerOf<float> reference = bootstrap_sampler(0, 0, 1);
  CHECK(fixture.vector.next_fixed() == reference.next_fixed());
  fixture.vector.skip(1);
  reference.skip(1);
  const Vec2 pair = fixture.vector.next_2d();
  const Vec2 reference_pair = reference.next_2d();
  CHECK(pair.x == reference_pair.x);
  CHECK(pair.y == reference_pair.y);
}

TEST_CASE("a rejected proposal leaves no trace, an accepted one all of it") {
  Fixture<Mutation<MutationKind::kelemen>> fixture(1);
  std::uint32_t first = fixture.vector.next_fixed();
  std::uint32_t second = fixture.vector.next_fixed();
  fixture.vector.end_initial();
  Rng decisions(21, StreamPurpose::kTest, 0);
  for (int i = 0; i < 1000; ++i) {
    fixture.vector.begin_proposal(decisions.next_float() < 0.3f);
    const std::uint32_t proposed_first = fixture.vector.next_fixed();
    const std::uint32_t proposed_second = fixture.vector.next_fixed();
    CHECK(proposed_first != first);
    if (decisions.next_float() < 0.5f) {
      fixture.vector.accept();
      first = proposed_first;
      second = proposed_second;
    } else {
      fixture.vector.reject();
    }
    REQUIRE(fixture.samples[0].value == first);
    REQUIRE(fixture.samples[1].value == second);
  }
}

TEST_CASE("a sample catches up by one step for each accepted mutation, and not for rejected ones") {
  Fixture<UnitMutation> fixture(2);
  const std::uint32_t start = fixture.vector.next_fixed();
  fixture.vector.next_fixed();
  fixture.vector.end_initial();
  for (int i = 0; i < 100; ++i) {
    fixture.propose(false, 1);
    if (i % 4 == 3) {
      fixture.vector.accept();
    } else {
      fixture.vector.reject();
    }
  }
  // 25 accepted steps, and the proposal's own.
  CHECK(fixture.propose(false) - start == 26);
  fixture.vector.reject();
  // Catching up is part of the current state and outlives the rejection.
  CHECK(fixture.samples[0].value - start == 25);
}

TEST_CASE("a sample never asked for, or older than a large step, is drawn and not replayed") {
  CountingMutation::count = 0;
  Fixture<CountingMutation> fixture(3);
  std::uint32_t value = fixture.vector.next_fixed();
  fixture.vector.end_initial();
  for (std::uint32_t i = 1; i <= 1000; ++i) {
    const std::uint32_t moved = fixture.propose(false);
    REQUIRE(moved - value == i);
    value = moved;
    fixture.vector.accept();
  }
  // Step 1001 is for the sample that was never asked for; had it caught up, it would have taken 1001.
  fixture.propose(false, 3);
  fixture.vector.accept();
  // Catches up with one accepted step and takes its own.
  CHECK(fixture.propose(false) - value == 1002 + 1003);
}

TEST_CASE("pitfall 19: a sample untouched for n steps is distributed as after n explicit steps") {
  // 1000 steps spread around the whole circle: also the wrap-around must be that of single steps.
  const std::array<int, 3> skipped{1, 40, 1000};
  const std::array<int, 3> chains{40000, 10000, 2500};
  const double threshold = sidak_threshold(kSignificance, 6);
  for_each_mutation([&]<MutationKind kKind>(const char* name) {
    for (std::size_t k = 0; k < skipped.size(); ++k) {
      INFO(name << ", " << skipped[k] << " steps");
      // Cells as wide as the distances need: 64 of them cover a 32nd, an eighth or the whole of the circle.
      const std::uint32_t shift = k == 0 ? 21 : k == 1 ? 23 : 26;
      std::vector<std::uint64_t> lazy(kCells + 1), direct(kCells + 1);
      const auto cell = [&](std::uint32_t distance) {
        return std::min<std::size_t>((distance + (kCells / 2 << shift)) >> shift, kCells);
      };
      for (int chain = 0; chain < chains[k]; ++chain) {
        const auto stream = static_cast<std::uint64_t>(chain);
        Fixture<Mutation<kKind>> fixture(stream);
        const std::uint32_t start = fixture.vector.next_fixed();
        fixture.vector.next_fixed();
        fixture.vector.end_initial();
        for (int i = 0; i < skipped[k]; ++i) {
          fixture.propose(false, 1);
          fixture.vector.accept();
        }
        ++lazy[cell(fixture.propose(false) - start)];
        Steps<kKind> steps(Rng(22, StreamPurpose::kTest, stream));
        std::uint32_t distance = 0;
        for (int i = 0; i < skipped[k] + 1; ++i) distance += steps.next();
        ++direct[cell(distance)];
      }
      CHECK(two_sample_p_value(lazy, direct) > threshold);
    }
  });
}

TEST_CASE("pitfall 19: samples not asked for since a large step are uniform and forget what they were") {
  std::vector<std::uint64_t> values(kCells), differences(kCells), near(kCells);
  constexpr int kChains = 20000;
  for (int chain = 0; chain < kChains; ++chain) {
    Fixture<Mutation<MutationKind::kelemen>> fixture(100000 + static_cast<std::uint64_t>(chain));
    fixture.vector.next_fixed();
    const std::uint32_t old = fixture.vector.next_fixed();
    fixture.vector.end_initial();
    // A rejected large step must not count.
    fixture.propose(true);
    fixture.vector.reject();
    const std::uint32_t nearby = fixture.propose(false, 1);
    ++near[(nearby - old + 0x80000000U) >> 26];
    fixture.vector.accept();
    fixture.propose(true);
    fixture.vector.accept();
    for (int i = 0; i < 3; ++i) {
      fixture.propose(false);
      fixture.vector.accept();
    }
    const std::uint32_t value = fixture.propose(false, 1);
    ++values[value >> 26];
    ++differences[(value - nearby) >> 26];
  }
  const std::vector<double> expected(kCells, static_cast<double>(kChains) / kCells);
  const double threshold = sidak_threshold(kSignificance, 2);
  CHECK(chi_square_test(values, expected).p_value > threshold);
  CHECK(chi_square_test(differences, expected).p_value > threshold);
  // Within 1/64 on either side, the largest step.
  CHECK(near[31] + near[32] == kChains);
}

TEST_CASE("pitfall 18: the same film, bit for bit, when time ends just below 2^32, and never beyond") {
  const SmoothToy<> toy;
  for_each_mutation([&]<MutationKind kKind>(const char* name) {
    INFO(name);
    ToyJob job;
    job.chains = 4;
    job.mutations = 3000;
    job.large_step = 0.01f;
    const ToyBootstrap bootstrap = run_bootstrap(toy, job.seed, job.bootstrap);
    DoubleFilm reference(toy.kPixels);
    run_chains<Mutation<kKind>>(toy, job, bootstrap, reference);
    CHECK_FALSE(reference == DoubleFilm(toy.kPixels));
    constexpr std::uint32_t kLast = ~std::uint32_t{0} - 1;
    for (const std::uint32_t first_time : {0x80000000U - 100U, kLast - 3000U}) {
      job.first_time = first_time;
      DoubleFilm film(toy.kPixels);
      run_chains<Mutation<kKind>>(toy, job, bootstrap, film);
      CHECK(film == reference);
    }
    job.first_time = kLast - 2999U;
    const ChildResult beyond = run_in_child([&] {
      DoubleFilm film(toy.kPixels);
      run_chains<Mutation<kKind>>(toy, job, bootstrap, film);
    });
    CHECK(beyond.exit_code == static_cast<int>(ExitCode::kBug));
  });
}

/// A vector with a stream for each lane, past its first state.
template <class F, std::size_t kCapacity>
struct WideFixture {
  std::vector<PrimarySampleOf<F>> samples = std::vector<PrimarySampleOf<F>>(kCapacity);
  std::vector<ProposedSampleOf<F>> proposed = std::vector<ProposedSampleOf<F>>(kCapacity);
  PrimarySampleVectorOf<F> vector;

  WideFixture() : vector(samples, proposed, make_steps_of<F>(MutationKind::kelemen), 1) {
    BootstrapSamplerOf<F> starts;
    for (int lane = 0; lane < kLaneCount<F>; ++lane) {
      const auto index = static_cast<std::uint64_t>(lane);
      vector.set_lane(lane, Rng(19, StreamPurpose::kTest, index));
      starts.set_lane(lane, BootstrapStreams(19, 64), index);
    }
    vector.begin_initial(starts);
  }
};

template <class F>
bool same_lanes(const F& a, const F& b, MaskOf<F> lanes) {
  return !any(MaskOf<F>(lanes & (as_bits(a) != as_bits(b))));
}

/// Vertices of paths whose lanes end at different edges and sample light at some vertices, asked for at once
/// and sample by sample.
template <class F, bool kLightChoice, bool kLobeChoice>
void check_vertices() {
  constexpr std::uint32_t kVertices = 5;
  constexpr std::size_t kCapacity = kVertices * 6;
  WideFixture<F, kCapacity> at_once, one_by_one;
  const auto vertex_of = [](auto& vector, MaskOf<F> lit, MaskOf<F> active) {
    using Floats = FloatSamples<PrimarySampleVectorOf<F>, F>;
    return static_cast<Floats&>(vector).template next_vertex<kLightChoice, kLobeChoice>(lit, active);
  };
  Rng masks(23, StreamPurpose::kTest, kLaneCount<F>);
  const auto random_mask = [&](unsigned bits) { return mask_of<F>(bits >> (32 - kLaneCount<F>)); };
  for (int proposal = 0; proposal < 2000; ++proposal) {
    if (proposal > 0) {
      const MaskOf<F> large_step = random_mask(masks.next_fixed() & masks.next_fixed());
      at_once.vector.begin_proposal(large_step);
      one_by_one.vector.begin_proposal(large_step);
    }
    MaskOf<F> active = not_in(MaskOf<F>{});
    for (std::uint32_t i = 0; i < kVertices && any(active); ++i) {
      const MaskOf<F> lit =
          active & (masks.next_float() < 0.2f ? MaskOf<F>{} : random_mask(masks.next_fixed()));
      const VertexSamples<F> a = at_once.vector.template next_vertex<kLightChoice, kLobeChoice>(lit, active);
      const VertexSamples<F> b = vertex_of(one_by_one.vector, lit, active);
      if (kLightChoice) REQUIRE(same_lanes<F>(a.light_choice, b.light_choice, lit));
      REQUIRE(same_lanes<F>(a.light.x, b.light.x, lit));
      REQUIRE(same_lanes<F>(a.light.y, b.light.y, lit));
      if (kLobeChoice) REQUIRE(same_lanes<F>(a.lobe, b.lobe, active));
      REQUIRE(same_lanes<F>(a.bsdf.x, b.bsdf.x, active));
      REQUIRE(same_lanes<F>(a.bsdf.y, b.bsdf.y, active));
      active &= random_mask(masks.next_fixed() | masks.next_fixed());
    }
    REQUIRE(all(at_once.vector.dimension() == one_by_one.vector.dimension()));
    if (proposal == 0) {
      at_once.vector.end_initial();
      one_by_one.vector.end_initial();
      continue;
    }
    const MaskOf<F> accepted = random_mask(masks.next_fixed());
    for (auto* vector : {&at_once.vector, &one_by_one.vector}) {
      vector->accept(accepted);
      vector->reject(not_in(accepted));
    }
  }
}

TEST_CASE("a vertex's samples asked for at once are those asked for one by one") {
  check_vertices<WideFloat, false, false>();
  check_vertices<WideFloat, true, true>();
  check_vertices<LaneFloat, true, false>();
  check_vertices<float, false, true>();
}

TEST_CASE("asking for more samples than the integrator stated is a bug, not a silent drop") {
  for (const bool initial : {true, false}) {
    const ChildResult child = run_in_child([&] {
      Fixture<UnitMutation, 2> fixture(4);
      if (!initial) {
        fixture.vector.end_initial();
        fixture.vector.begin_proposal(false);
      }
      for (int i = 0; i < 3; ++i) fixture.vector.next_fixed();
    });
    CHECK(child.exit_code == static_cast<int>(ExitCode::kBug));
    CHECK_THAT(child.errors, Catch::Contains("index < samples_.size()"));
  }
}

}  // namespace
}  // namespace mlt::test
