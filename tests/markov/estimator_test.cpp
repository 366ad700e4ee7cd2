// Chains against integrals known in closed form. Each case renders the same small job with many seeds; the
// scatter of these replicates is the only measure of error. Thresholds: all tests of one case together fail a
// correct renderer with probability 1e-4 [Sidak67]; seeds are fixed, so they pass or fail for good.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "markov/replicates.hpp"
#include "markov/toy_chains.hpp"
#include "markov/toy_integrators.hpp"

namespace mlt::test {
namespace {

constexpr double kSignificance = 1e-4;
using Kelemen = Mutation<MutationKind::kelemen>;

template <class Mutation, class Integrator>
Replicates render_replicates(const Integrator& integrator, ToyJob job, int replicates,
                             const std::vector<double>& expected) {
  Replicates images(expected);
  for (int i = 0; i < replicates; ++i) {
    job.seed += 1;
    images.add(render_toy<Mutation>(integrator, job));
  }
  return images;
}

/// As the image's mean: the test with the smallest error, because errors of pixels cancel in it.
double mean_p_value(const Replicates& images) {
  std::vector<double> means(images.values(0).size());
  double expected = 0;
  for (std::size_t i = 0; i < images.size(); ++i) {
    for (std::size_t r = 0; r < means.size(); ++r) means[r] += images.values(i)[r];
    expected += images.expected(i);
  }
  return student_t_test(moments(means), expected).p_value;
}

TEST_CASE("pitfall 8: a wrong b inside the weights leaves every pixel unbiased") {
  const SmoothToy<> toy;
  const float factors[] = {0.01f, 0.5f, 2.0f, 100.0f};
  const double threshold = sidak_threshold(kSignificance, 4 * (toy.expected().size() + 1));
  for (const float factor : factors) {
    ToyJob job;
    job.seed = 8000;
    job.weight_b = factor * static_cast<float>(toy.expected_b());
    const Replicates images = render_replicates<Kelemen>(toy, job, 160, toy.expected());
    INFO("weights with " << factor << " times b");
    CHECK(images.smallest_p_value() > threshold);
    CHECK(mean_p_value(images) > threshold);
  }
}

TEST_CASE("b of the bootstrap and of all large steps agree with the target's integral") {
  const SmoothToy<> toy;
  std::vector<double> from_bootstrap, from_large_steps;
  ToyJob job;
  for (int i = 0; i < 100; ++i) {
    job.seed = 8500 + static_cast<std::uint64_t>(i);
    const ToyBootstrap bootstrap = run_bootstrap(toy, job.seed, job.bootstrap);
    DoubleFilm film(toy.kPixels);
    const ChainStatistics statistics = run_chains<Kelemen>(toy, job, bootstrap, film);
    from_bootstrap.push_back(bootstrap.luminance.mean());
    from_large_steps.push_back(statistics.large_steps.mean());
    CHECK(statistics.large_steps.count + statistics.small_steps == job.chains * job.mutations);
  }
  const double threshold = sidak_threshold(kSignificance, 2);
  CHECK(student_t_test(moments(from_bootstrap), toy.expected_b()).p_value > threshold);
  CHECK(student_t_test(moments(from_large_steps), toy.expected_b()).p_value > threshold);
}

/// One half of all vectors is a little darker than the other.
struct TwoLevels {
  static constexpr std::uint32_t kPixels = 1, kCapacity = 1, kMaxSplats = 1;
  static constexpr float kDarker = 0.95f;

  using Float = float;
  template <class Sampler, class Sink>
  void evaluate(Sampler& sampler, Sink&& sink, bool = true) const {
    sink(Splat{0, Vec3{part_of(sampler.next_fixed(), 2) == 0 ? 1.0f : kDarker}});
  }
};

TEST_CASE("a proposal a little darker is accepted with the quotient of the targets, however near 1") {
  ToyJob job;
  job.large_step = 1;
  job.mutations = 4000;
  const TwoLevels toy;
  DoubleFilm film(TwoLevels::kPixels);
  const ToyBootstrap bootstrap = run_bootstrap(toy, job.seed, job.bootstrap);
  const ChainStatistics statistics = run_chains<Kelemen>(toy, job, bootstrap, film);
  const double count = static_cast<double>(statistics.large_steps.count);
  REQUIRE(statistics.large_steps.count == job.chains * job.mutations);
  // Chains are at the brighter level with probability 1 / 1.95, and half of all proposals are the darker one.
  const double darker = static_cast<double>(TwoLevels::kDarker);
  const double rejected = (1 - darker) * 0.5 / (1 + darker);
  // Proposals are independent, but of three in a row a chain's level ties two; twice the variance covers
  // that.
  const double error = (1 - darker) * std::sqrt(2 * 0.25 / count);
  CHECK(normal_p_value((statistics.acceptance_large / count - (1 - rejected)) / error) > kSignificance);
}

TEST_CASE("pitfall 17: chains of one mutation averaged equal long chains") {
  const SmoothToy<> toy;
  ToyJob brief;
  brief.seed = 17000;
  brief.weight_b = static_cast<float>(toy.expected_b());
  brief.chains = 512;
  brief.mutations = 1;
  ToyJob lasting = brief;
  lasting.seed = 17500;
  lasting.chains = 2;
  lasting.mutations = 1024;
  const Replicates brief_images = render_replicates<Kelemen>(toy, brief, 100, toy.expected());
  const Replicates lasting_images = render_replicates<Kelemen>(toy, lasting, 100, toy.expected());
  const double threshold = sidak_threshold(kSignificance, 3 * toy.expected().size() + 2);
  CHECK(brief_images.smallest_p_value() > threshold);
  CHECK(lasting_images.smallest_p_value() > threshold);
  CHECK(mean_p_value(brief_images) > threshold);
  CHECK(mean_p_value(lasting_images) > threshold);
  double smallest = 1;
  for (std::size_t i = 0; i < brief_images.size(); ++i) {
    const TTestResult test = welch_t_test(moments(brief_images.values(i)), moments(lasting_images.values(i)));
    smallest = std::min(smallest, test.p_value);
  }
  CHECK(smallest > threshold);
}

TEST_CASE("samples that a path skips are distributed as if it had drawn them") {
  const SmoothToy<true> eager;
  const SmoothToy<false> lazy;
  const double threshold = sidak_threshold(kSignificance, 2 * (lazy.expected().size() + 1));
  // No large steps and long chains: skipped samples stay behind for long.
  ToyJob job;
  job.large_step = 0;
  job.weight_b = 1;
  job.chains = 8;
  job.mutations = 256;
  job.seed = 19000;
  const Replicates eager_images = render_replicates<Kelemen>(eager, job, 100, eager.expected());
  const Replicates lazy_images = render_replicates<Kelemen>(lazy, job, 100, lazy.expected());
  CHECK(eager_images.smallest_p_value() > threshold);
  CHECK(lazy_images.smallest_p_value() > threshold);
  CHECK(mean_p_value(eager_images) > threshold);
  CHECK(mean_p_value(lazy_images) > threshold);
}

/// Two spikes on black. Small steps hardly ever get from one to the other, and mostly leave the narrow one,
/// which is 200 times as bright: chains are stuck there, and must be.
struct TwoSpikes {
  static constexpr std::uint32_t kPixels = 2, kCapacity = 2, kMaxSplats = 1;

  using Float = float;
  template <class Sampler, class Sink>
  void evaluate(Sampler& sampler, Sink&& sink, bool = true) const {
    const float u = sampler.next();
    const float v = sampler.next();
    if (u >= 0.25f && u < 0.25f + kFirstWidth) sink(Splat{0, Vec3{kFirstHeight * 2.0f * v}});
    if (u >= 0.75f && u < 0.75f + kSecondWidth) sink(Splat{1, Vec3{kSecondHeight}});
  }

  static std::vector<double> expected() {
    const double first = kPixels * static_cast<double>(kFirstWidth) * kFirstHeight;
    const double second = kPixels * static_cast<double>(kSecondWidth) * kSecondHeight;
    return {first, first, first, second, second, second};
  }

 private:
  static constexpr float kFirstWidth = 0x1p-4f, kSecondWidth = 0x1p-9f;
  static constexpr float kFirstHeight = 10, kSecondHeight = 2000;
};

TEST_CASE("pitfall 5: two spikes keep their integrals over thousands of chains that get stuck") {
  const TwoSpikes toy;
  ToyJob job;
  job.bootstrap = 8192;
  job.chains = 16;
  job.mutations = 256;
  job.weight_b = 4.5f;
  std::uint64_t longest_run = 0;
  Replicates images(toy.expected());
  for (std::uint64_t seed = 5000; seed < 5256; ++seed) {
    job.seed = seed;
    const ToyBootstrap bootstrap = run_bootstrap(toy, seed, job.bootstrap);
    DoubleFilm film(toy.kPixels);
    longest_run = std::max(longest_run, run_chains<Kelemen>(toy, job, bootstrap, film).longest_rejection_run);
    images.add(film.develop(bootstrap.luminance.mean(), job.weight_b, job.chains * job.mutations));
  }
  const double threshold = sidak_threshold(kSignificance, toy.expected().size() + 1);
  CHECK(images.smallest_p_value() > threshold);
  CHECK(mean_p_value(images) > threshold);
  // No cap on rejections: some chain was stuck for longer than any usual cap.
  CHECK(longest_run > 50);
}

}  // namespace
}  // namespace mlt::test
