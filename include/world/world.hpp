// The compiled scene: everything that rendering reads, in the arena, immutable after compile_world. World
// space is the scene centred on its bounding box and scaled by a power of two to about [-1,1]^3, which keeps
// float precision relative to the scene's size wherever and however large it was modelled. Radiance does not
// change under uniform scaling, so no result needs scaling back.
#pragma once

#include <cstdint>
#include <span>

#include "base/memory.hpp"
#include "geometry/geometry.hpp"
#include "light/light.hpp"
#include "light/light_table.hpp"
#include "material/material.hpp"
#include "math/rng.hpp"
#include "scene/description.hpp"
#include "world/light_box.hpp"

namespace mlt {

/// What a primitive index stands for.
struct PrimitiveRecord {
  std::uint32_t material = 0;      ///< index into World::materials
  std::uint32_t light = kNoLight;  ///< index into the light table
};

/// Where on the film a path starts: the pixel, and the position within it in [0,1).
template <class F>
struct FilmPositionOf {
  UintOf<F> x{}, y{};
  Vec2Of<F> offset{F{}, F{}};
};
using FilmPosition = FilmPositionOf<float>;

/// Pinhole camera: the direction through a film position (measured in pixels from the upper left corner) is
/// corner + x * step_x + y * step_y, not normalised.
struct Camera {
  Vec3 eye{0, 0, 0};
  Vec3 corner{0, 0, -1};
  Vec3 step_x{0, 0, 0};
  Vec3 step_y{0, 0, 0};
  std::uint32_t width = 1, height = 1;  ///< pixels

  /// The same view in another number of pixels, which are not square where the shape of the film changes.
  Camera resized(std::uint32_t new_width, std::uint32_t new_height) const {
    Camera camera = *this;
    camera.step_x *= static_cast<float>(width) / static_cast<float>(new_width);
    camera.step_y *= static_cast<float>(height) / static_cast<float>(new_height);
    camera.width = new_width;
    camera.height = new_height;
    return camera;
  }

  /// Primary samples (32-bit fixed point in [0,1)) to film position; exact.
  template <class F = float>
  FilmPositionOf<F> film_position(UintOf<F> sample_x, UintOf<F> sample_y) const {
    FilmPositionOf<F> position;
    scale(sample_x, width, position.x, position.offset.x);
    scale(sample_y, height, position.y, position.offset.y);
    return position;
  }

  /// Unit direction.
  template <class F = float>
  Vec3Of<F> direction(const FilmPositionOf<F>& position) const {
    const F x = to_float(position.x) + position.offset.x;
    const F y = to_float(position.y) + position.offset.y;
    return normalize((broadcast_to<F>(corner) + broadcast_to<F>(step_x) * x) + broadcast_to<F>(step_y) * y);
  }

 private:
  /// Integer part and fraction of sample * side, of 64 bits in halves since few lanes have as many.
  template <class F, class U>
  MLT_INLINE static void scale(U sample, std::uint32_t side, U& whole, F& fraction) {
    const U high = (sample >> 16) * side;
    const U low = (sample & 0xffffU) * side;
    whole = (high + (low >> 16)) >> 16;
    fraction = unit_float((high << 16) + low);
  }
};

struct World {
  Camera camera;
  Geometry geometry;
  std::span<const Material> materials;
  std::span<const PrimitiveRecord> primitives;
  LightTable lights;
  LightBox light_box;
};

/// What the scene contains, known before anything is compiled; fixes memory and features.
struct WorldCounts {
  GeometryCounts geometry;
  std::uint32_t triangle_vertices = 0;
  std::uint32_t materials = 0;
  std::uint32_t lights = 0;          ///< emitting primitives
  std::uint32_t used_kinds[8] = {};  ///< primitives per MaterialKind, indexed by the enum
  std::uint32_t multi_lobe_primitives = 0;
};

struct WorldSlots {
  GeometrySlots geometry;
  Slot<Quad> quads;
  Slot<Vec3> vertices;
  Slot<TriangleCorners> triangles;
  Slot<Sphere> spheres;
  Slot<Material> materials;
  Slot<PrimitiveRecord> primitives;
  Slot<Light> lights;
  Slot<float> light_cdf;
};

WorldCounts count_world(const SceneDescription& scene);

/// Adds the world's blocks; sizes follow from the counts alone.
WorldSlots plan_world(MemoryPlan& plan, const WorldCounts& counts);

/// Compiles `scene` for a film of width x height pixels. Uses the plan's scratch blocks, and no heap. The
/// result does not depend on `runner`.
World compile_world(const SceneDescription& scene, const WorldCounts& counts, std::uint32_t width,
                    std::uint32_t height, Arena& arena, const WorldSlots& slots,
                    const UnitRunner& runner = {});

}  // namespace mlt
