// A scene from text, compiled into an arena of its own, for tests of world and integrator. In a header
// because only the tests of stages from world on link what it needs.
#pragma once

#include <cstdint>
#include <limits>
#include <string_view>

#include "base/memory.hpp"
#include "scene/parse.hpp"
#include "world/world.hpp"

namespace mlt::test {

class CompiledScene {
 public:
  CompiledScene(const SceneDescription& description, std::uint32_t width, std::uint32_t height)
      : counts_(count_world(description)),
        slots_(plan_world(plan_, counts_)),
        arena_(plan_),
        world_(compile_world(description, counts_, width, height, arena_, slots_)) {}
  CompiledScene(std::string_view text, std::uint32_t width, std::uint32_t height)
      : CompiledScene(parse_scene_text(text, "test"), width, height) {}

  const World& world() const { return world_; }
  const WorldCounts& counts() const { return counts_; }

  /// What a camera ray through (x, y), in pixels from the upper left corner, meets first.
  Hit look(std::uint32_t x, std::uint32_t y, const Vec2& offset) const {
    return world_.geometry.intersect<true>(Ray{world_.camera.eye, world_.camera.direction({x, y, offset}),
                                               std::numeric_limits<float>::infinity()});
  }

 private:
  MemoryPlan plan_;
  WorldCounts counts_;
  WorldSlots slots_;
  Arena arena_;
  World world_;
};

}  // namespace mlt::test
