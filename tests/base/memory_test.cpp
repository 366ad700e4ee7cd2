#include "base/memory.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>

#include "base/error.hpp"
#include "base/render_zone.hpp"
#include "support/faults.hpp"

namespace mlt {
namespace {

struct Item {
  std::uint32_t number = 7;
  float weight = 0.5f;
};
struct alignas(64) Line {
  char bytes[64] = {};
};

std::uintptr_t address(const void* pointer) {
  return reinterpret_cast<std::uintptr_t>(pointer);
}

TEST_CASE("a memory plan is the sum of the scene and the larger of scratch and render") {
  MemoryPlan plan;
  plan.add<char>("scene", Lifetime::kScene, kPage + 1);    // two pages
  plan.add<char>("small scratch", Lifetime::kScratch, 1);  // one page
  plan.add<char>("scratch", Lifetime::kScratch, kPage);    // one page
  const std::size_t with_scratch = 4 * kPage;
  CHECK(plan.total_bytes() == with_scratch);
  plan.add<char>("render", Lifetime::kRender, kPage + 100);  // overlaps the scratch exactly
  CHECK(plan.total_bytes() == with_scratch);
  plan.add<char>("more render", Lifetime::kRender, 1);
  CHECK(plan.total_bytes() == with_scratch + kPage);
  CHECK(plan.bytes(Lifetime::kScene) == 2 * kPage);
  CHECK(plan.bytes(Lifetime::kScratch) == 2 * kPage);
  CHECK(plan.bytes(Lifetime::kRender) == 3 * kPage);
}

TEST_CASE("a memory plan names its blocks with their sizes") {
  MemoryPlan plan;
  plan.add<Item>("items", Lifetime::kRender, 3);
  REQUIRE(plan.lines().size() == 1);
  const PlanLine& line = plan.lines()[0];
  CHECK(line.name == "items");
  CHECK(line.lifetime == Lifetime::kRender);
  CHECK(line.count == 3);
  CHECK(line.item_bytes == sizeof(Item));
  CHECK(line.bytes == kPage);
}

TEST_CASE("a memory plan refuses sizes beyond any address space instead of wrapping") {
  constexpr std::size_t kHuge = std::numeric_limits<std::size_t>::max();
  MemoryPlan plan;
  CHECK_THROWS_AS(plan.add<char>("all", Lifetime::kScene, kHuge), ResourceError);
  // 2^61 items of 8 bytes are 0 bytes modulo 2^64.
  CHECK_THROWS_AS(plan.add<std::uint64_t>("wraps", Lifetime::kScene, std::size_t{1} << 61), ResourceError);
  MemoryPlan sum;
  const std::size_t half = (std::size_t{1} << 46) + 64;
  sum.add<char>("half", Lifetime::kScene, half);
  CHECK_THROWS_AS(sum.add<char>("other half", Lifetime::kRender, half), ResourceError);
  CHECK_THROWS_AS(plan.add<char>("rounds up beyond", Lifetime::kScene, (std::size_t{1} << 47) + 1),
                  ResourceError);
}

TEST_CASE("the arena hands out disjoint, aligned, initialised blocks") {
  MemoryPlan plan;
  const Slot<char> first = plan.add<char>("one byte", Lifetime::kScene, 1);
  const Slot<Line> lines = plan.add<Line>("lines", Lifetime::kScene, 3);
  const Slot<Item> items = plan.add<Item>("items", Lifetime::kScene, 5);
  const Slot<std::uint64_t> words = plan.add<std::uint64_t>("words", Lifetime::kRender, 9);
  const Slot<Item> none = plan.add<Item>("none", Lifetime::kScene, 0);
  Arena arena(plan);
  CHECK(arena.bytes() == plan.total_bytes());

  const auto byte_block = arena.take(first);
  const auto line_block = arena.take(lines);
  const auto item_block = arena.take(items);
  const auto word_block = arena.take(words);
  CHECK(byte_block.size() == 1);
  CHECK(line_block.size() == 3);
  CHECK(item_block.size() == 5);
  CHECK(word_block.size() == 9);
  CHECK(arena.take(none).empty());

  CHECK(std::all_of(item_block.begin(), item_block.end(),
                    [](const Item& item) { return item.number == 7 && item.weight == 0.5f; }));
  CHECK(std::all_of(word_block.begin(), word_block.end(), [](std::uint64_t word) { return word == 0; }));
  for (const void* start :
       {static_cast<const void*>(byte_block.data()), static_cast<const void*>(line_block.data()),
        static_cast<const void*>(item_block.data()), static_cast<const void*>(word_block.data())}) {
    CHECK(address(start) % kPage == 0);
  }

  // Each block is filled with a value of its own; afterwards every one must still hold it.
  std::memset(byte_block.data(), 1, byte_block.size_bytes());
  for (Line& line : line_block) std::memset(line.bytes, 2, sizeof line.bytes);
  for (Item& item : item_block) item = {3, 3.0f};
  for (std::uint64_t& word : word_block) word = 4;
  CHECK(byte_block[0] == 1);
  for (const Line& line : line_block) CHECK(std::count(line.bytes, line.bytes + 64, char{2}) == 64);
  for (const Item& item : item_block) CHECK(item.number == 3);
}

TEST_CASE("render blocks lie over scratch blocks and are initialised when first taken") {
  MemoryPlan plan;
  const Slot<std::uint32_t> scene = plan.add<std::uint32_t>("scene", Lifetime::kScene, 16);
  const Slot<std::uint32_t> scratch = plan.add<std::uint32_t>("scratch", Lifetime::kScratch, 64);
  const Slot<std::uint32_t> film = plan.add<std::uint32_t>("film", Lifetime::kRender, 32);
  Arena arena(plan);
  const auto scene_block = arena.take(scene);
  const auto scratch_block = arena.take(scratch);
  for (std::uint32_t& word : scene_block) word = 0xaaaaaaaaU;
  for (std::uint32_t& word : scratch_block) word = 0xffffffffU;
  const auto film_block = arena.take(film);
  CHECK(static_cast<const void*>(film_block.data()) == static_cast<const void*>(scratch_block.data()));
  CHECK(std::all_of(film_block.begin(), film_block.end(), [](std::uint32_t word) { return word == 0; }));
  CHECK(std::all_of(scene_block.begin(), scene_block.end(),
                    [](std::uint32_t word) { return word == 0xaaaaaaaaU; }));
}

TEST_CASE("a guest's arena lies over the host's render blocks if there is room") {
  MemoryPlan plan;
  const Slot<std::uint32_t> scene = plan.add<std::uint32_t>("scene", Lifetime::kScene, 16);
  const Slot<char> film = plan.add<char>("film", Lifetime::kRender, 3 * kPage);
  Arena host(plan);
  const auto scene_block = host.take(scene);
  for (std::uint32_t& word : scene_block) word = 0xaaaaaaaaU;
  const auto film_block = host.take(film);
  std::memset(film_block.data(), 1, film_block.size());
  for (const std::size_t pages : {1U, 2U, 3U, 4U, 5U}) {
    CAPTURE(pages);
    MemoryPlan guest_plan;
    const Slot<char> always = guest_plan.add<char>("image", Lifetime::kScene, 1);
    const Slot<char> render = guest_plan.add<char>("film", Lifetime::kRender, (pages - 1) * kPage);
    Arena guest(guest_plan, &host);
    const auto image = guest.take(always);
    const auto block = guest.take(render);
    CHECK((image.data() == film_block.data()) == (pages <= 3));
    CHECK(address(block.data()) == address(image.data()) + kPage);
    CHECK(image[0] == 0);
    std::memset(block.data(), 2, block.size());
    CHECK(film_block.back() == (pages == 3 ? 2 : 1));
    if (pages == 3) std::memset(film_block.data(), 1, film_block.size());
  }
  // The host's mapping outlives its guests.
  film_block[0] = 3;
  CHECK(std::all_of(scene_block.begin(), scene_block.end(),
                    [](std::uint32_t word) { return word == 0xaaaaaaaaU; }));
}

TEST_CASE("an empty plan makes an arena") {
  const MemoryPlan plan;
  const Arena arena(plan);
  CHECK(arena.bytes() >= plan.total_bytes());
}

TEST_CASE("the arena's pages are present before their first use") {
  MemoryPlan plan;
  constexpr std::size_t kBytes = std::size_t{4} << 20;
  const Slot<char> slot = plan.add<char>("block", Lifetime::kRender, kBytes);
  Arena arena(plan);
  const auto block = arena.take(slot);
  FaultCounter faults;
  faults.start();
  for (std::size_t i = 0; i < block.size(); i += 4096) static_cast<volatile char*>(block.data())[i] = 1;
  const std::uint64_t count = faults.count();
  if (MLT_FAULTS_ARE_OURS) CHECK(count == 0);
}

TEST_CASE("an arena larger than the machine's memory is refused, not overcommitted") {
  // A system told to grant everything grants this too, until it runs out.
  int policy = 0;
  std::ifstream("/proc/sys/vm/overcommit_memory") >> policy;
  if (policy == 1) return;
  MemoryPlan plan;
  plan.add<char>("100 TiB", Lifetime::kScene, std::size_t{100} << 40);
  CHECK_THROWS_AS(Arena(plan), ResourceError);
}

}  // namespace
}  // namespace mlt
