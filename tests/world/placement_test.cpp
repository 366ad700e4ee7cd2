// Where the world puts a scene: centred and scaled by a power of two, so that float precision follows the
// scene's own size wherever it was modelled.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

#include "support/compiled_scene.hpp"
#include "support/moved_scene.hpp"

namespace mlt::test {
namespace {

// All coordinates are multiples of 1/64, so that a translation by 2^20 times the size is exact in double.
constexpr const char* kDyadic = R"(
camera eye 0 0.5 6 target 0 0 0 fov 45
material grey diffuse reflectance 0.5
material glass dielectric ior 1.5
box -2 -1.5 -2  2 1.75 1  material grey
sphere 0.25 0.5 1.5 0.625  material glass
quad -0.5 3 -0.5  0.5 3 -0.5  0.5 3 0.5  -0.5 3 0.5  material grey emit 3
inline_mesh material grey emit 1
vertex 1 2 1
vertex 2 2 1.5
vertex 1.5 2.75 1
face 0 1 2
end
)";

constexpr std::uint32_t kSide = 32;

/// What every pixel's centre ray meets.
std::vector<Hit> hits(const SceneDescription& description) {
  const CompiledScene scene(description, kSide, kSide);
  std::vector<Hit> result;
  for (std::uint32_t y = 0; y < kSide; ++y) {
    for (std::uint32_t x = 0; x < kSide; ++x) result.push_back(scene.look(x, y, Vec2{0.5f, 0.5f}));
  }
  return result;
}

bool same_bits(const std::vector<Hit>& a, const std::vector<Hit>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].primitive != b[i].primitive || a[i].t != b[i].t) return false;
  }
  return a.size() == b.size();
}

}  // namespace

TEST_CASE("pitfall 16: the compiled scene fills the unit cube, whatever its size and place") {
  const SceneDescription scene = parse_scene_text(kDyadic, "test");
  for (const double scale : {1e-20, 1e-6, 0.3, 1.0, 7.0, 1e6, 1e15}) {
    for (const double distance : {0.0, 1.0, 1e6}) {
      const DVec3 offset = DVec3{1, -0.7, 0.3} * (distance * scale);
      const CompiledScene compiled(moved(scene, scale, offset), kSide, kSide);
      INFO("scale " << scale << " distance " << distance);
      CHECK(compiled.world().geometry.extent() >= 0.499f);
      CHECK(compiled.world().geometry.extent() <= 1.001f);
    }
  }
}

TEST_CASE("pitfall 16: exact moves and powers of two change no bit of any hit") {
  const SceneDescription scene = parse_scene_text(kDyadic, "test");
  const std::vector<Hit> original = hits(scene);
  std::size_t found = 0;
  for (const Hit& hit : original) found += hit.found() ? 1 : 0;
  REQUIRE(found > kSide * kSide / 4);
  const double far = 0x1p20;  // about 1e6 times the scene's size
  CHECK(same_bits(hits(moved(scene, 1, DVec3{far, -far, far})), original));
  CHECK(same_bits(hits(moved(scene, 0x1p20, DVec3{0, 0, 0})), original));
  CHECK(same_bits(hits(moved(scene, 0x1p-20, DVec3{0, 0, 0})), original));
  CHECK(same_bits(hits(moved(scene, 0x1p20, DVec3{0x1p40, 0, -0x1p40})), original));
}

TEST_CASE("pitfall 16: inexact moves change hit distances by float rounding alone") {
  const SceneDescription scene = parse_scene_text(kDyadic, "test");
  const CompiledScene compiled(scene, kSide, kSide);
  const std::vector<Hit> original = hits(scene);
  struct Move {
    double scale;
    double offset;
  };
  for (const Move move : {Move{1, 1e6}, Move{1e-6, 0}, Move{1e6, 0}, Move{1e-4, 100}, Move{1e4, 1e10}}) {
    const std::vector<Hit> after = hits(moved(scene, move.scale, DVec3{move.offset, 0, -move.offset}));
    // Distances are in units of the placed scene, whose scale is another power of two.
    double ratio = 0;
    int other_primitive = 0;
    double largest = 0;
    for (std::size_t i = 0; i < after.size(); ++i) {
      if (after[i].primitive != original[i].primitive) {
        other_primitive += 1;
      } else if (after[i].found()) {
        const double own = static_cast<double>(after[i].t) / static_cast<double>(original[i].t);
        if (ratio == 0) ratio = own;
        largest = std::max(largest, std::fabs(own / ratio - 1));
      }
    }
    INFO("scale " << move.scale << " offset " << move.offset << " difference " << largest);
    // Vertices move by half a unit in the last place of 1, or by a few of double's at 1e6 sizes away; a
    // distance changes by that over the cosine to the surface, here above 0.05, and rays graze the sphere.
    CHECK(largest <= 1e-4);
    CHECK(other_primitive <= 2);  // rays within 1e-7 of an edge
  }
}

}  // namespace mlt::test
