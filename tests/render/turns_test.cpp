// Chains in turns: that every group gets each of its turns once and in order, that nothing depends on who
// takes them, and that a stopped render keeps what its open chains have gathered.
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <vector>

#include "render/kernel.hpp"
#include "render_fixture.hpp"

namespace mlt::test {
namespace {

/// Sets the flag at the second report after the bootstrap: the first may come at its end.
struct StopInChains {
  std::uint64_t bootstrap;
  int reports = 0;
  std::atomic<bool> stop{false};
  static void progress(const RenderProgress& progress, void* context) {
    auto& own = *static_cast<StopInChains*>(context);
    if (progress.done >= own.bootstrap && ++own.reports == 2) own.stop.store(true);
  }
};

}  // namespace

TEST_CASE("every group of chains gets each of its turns once, in order, at one bench") {
  for (std::uint64_t chains = 1; chains <= 40; ++chains) {
    for (std::uint64_t benches = 1; benches <= 9; ++benches) {
      constexpr std::uint64_t kGroupSize = 3, kLength = 2 * kTurnMutations + 1;
      const ChainTurns turns(chains * kLength, chains, kGroupSize, benches);
      INFO(chains << " chains, " << benches << " benches");
      REQUIRE(turns.groups == (chains + 2) / 3);
      REQUIRE(turns.turns_of_group == 3);
      std::vector<std::uint64_t> taken(turns.groups), at_bench(benches);
      bool in_order = true;
      for (std::uint64_t turn = 0; turn < turns.count(); ++turn) {
        in_order &= turns.at_bench(turn) == at_bench[turns.bench(turn)]++;
        const std::uint64_t group = turns.group(turn);
        if (group >= turns.groups) continue;
        in_order &= turns.bench(turn) == group % benches && turns.of_group(turn) == taken[group]++;
        // The bench's group before has ended.
        in_order &= group < benches || taken[group - benches] == turns.turns_of_group;
      }
      REQUIRE(in_order);
      REQUIRE(taken == std::vector<std::uint64_t>(turns.groups, turns.turns_of_group));
    }
  }
}

TEST_CASE("a chain has as many turns as its length asks for") {
  CHECK(ChainTurns(1, 1, 1, 1).turns_of_group == 1);
  CHECK(ChainTurns(kTurnMutations, 1, 1, 1).turns_of_group == 1);
  CHECK(ChainTurns(kTurnMutations + 1, 1, 1, 1).turns_of_group == 2);
  // The first chains take the remainder.
  CHECK(ChainTurns(2 * kTurnMutations + 1, 2, 1, 1).turns_of_group == 2);
}

TEST_CASE("chains of several turns give the same film from any number of threads, and in rounds",
          "[threads]") {
  const SceneDescription scene = parse_scene_file("scenes/CornellBox.txt");
  // About 1500 mutations a chain, five groups of 16 lanes with one thread, the last of three chains.
  RenderRequest request = small_request(IntegratorKind::pssmlt, 16, 392, 5);
  request.chains = 67;
  for (const std::uint64_t rounds : {1, 2}) {
    request.rounds = rounds;
    request.threads = 1;
    const RenderResult reference = render(scene, request);
    CHECK(reference.statistics.mutations == rounds * 392 * 256);
    for (const std::uint32_t threads : {2U, 3U, 4U, 7U, 40U}) {
      request.threads = threads;
      const RenderResult result = render(scene, request);
      INFO(threads << " threads, " << rounds << " rounds");
      CHECK(result.statistics.film_hash == reference.statistics.film_hash);
      CHECK(result.statistics.b == reference.statistics.b);
      CHECK(result.statistics.acceptance_small == reference.statistics.acceptance_small);
      CHECK(result.statistics.longest_rejection_run == reference.statistics.longest_rejection_run);
      CHECK(result.statistics.primary_samples == reference.statistics.primary_samples);
      CHECK(result.image.pixels == reference.image.pixels);
    }
  }
}

TEST_CASE("chains are left where they are when the render is stopped", "[threads]") {
  RenderRequest request = small_request(IntegratorKind::pssmlt, 16, 1U << 20, 5);
  request.chains = 64;
  request.bootstrap = 4096;
  request.threads = 1;
  const SceneDescription scene = parse_scene_file("scenes/CornellBox.txt");
  Renderer renderer(scene, resolve_job(request, scene));
  renderer.prepare();
  StopInChains stopper{*request.bootstrap};
  const RenderStatistics statistics = renderer.run(stopper.stop, &StopInChains::progress, &stopper);
  CHECK(statistics.partial);
  // Less than the first chains would have made; that many take seconds.
  CHECK(statistics.mutations > 0);
  CHECK(statistics.mutations < 16ULL << 20);
  CHECK(mean_luminance(renderer.image()) > 0.0);
}

TEST_CASE("what open chains have gathered is in the picture of a stopped render", "[threads]") {
  // Inside a box that emits 1 everywhere, seen directly, all paths are alike: every proposal is accepted, and
  // a mutation adds the same to the film wherever the chain is. Without large steps nothing else does, and
  // the film's mean is 1 but for the pixels' rounding to float, 6e-8 each, if it counts exactly the mutations
  // that are said to be made. One state of one of the chains, all of which are open, would be missing by 1e-7
  // of them for 1e7 mutations, the 48 or more of three groups by 5e-6.
  const SceneDescription scene = parse_scene_text(
      "film 16 16\ncamera eye 0.2 -0.1 0.3 target 1 0.4 -0.6 up 0 1 0 fov 70\n"
      "material grey diffuse reflectance 0.5\nbox -1 -1 -1  1 1 1  inward  material grey emit 1\n",
      "test");
  RenderRequest request = small_request(IntegratorKind::pssmlt, 16, 1U << 22, 1);
  request.chains = 1024;
  request.bootstrap = 4096;
  request.large_step = 0.0f;
  request.threads = 3;
  Renderer renderer(scene, resolve_job(request, scene));
  renderer.prepare();
  StopInChains stopper{*request.bootstrap};
  const RenderStatistics statistics = renderer.run(stopper.stop, &StopInChains::progress, &stopper);
  CHECK(statistics.partial);
  CHECK(statistics.mutations > 0);
  CHECK(statistics.acceptance_small == 1.0);
  INFO(statistics.mutations << " mutations");
  CHECK(std::abs(mean_luminance(renderer.image()) - 1.0) < 2e-7);
}

}  // namespace mlt::test
