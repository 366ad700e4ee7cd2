// Cells of a flat list: which polygons make one, and that rays meet its faces where the bounds say.
#include "geometry/flat_cell.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "geometry/scene_fixture.hpp"
#include "geometry/wide_flat.hpp"

namespace mlt::test {
namespace {

/// A list of the quads, in scene order within each axis.
std::unique_ptr<FlatList> list_of(const std::vector<Quad>& quads, float extent) {
  auto list = std::make_unique<FlatList>();
  FlatListBuilder builder(*list, 0, extent);
  for (int part = 0; part < 6; ++part) {
    for (std::uint32_t i = 0; i < quads.size(); ++i) {
      const Quad& q = quads[i];
      if (FlatListBuilder::axis_of(q) != part / 2 || FlatListBuilder::is_aligned(q) != (part % 2 == 0))
        continue;
      FlatPolygon polygon{};
      const Vec3 corners[4] = {q.a, q.b, q.c, q.d};
      for (int axis = 0; axis < 3; ++axis) {
        for (int vertex = 0; vertex < 4; ++vertex) polygon.quad.corners[axis][vertex] = corners[vertex][axis];
      }
      polygon.quad.primitive = i;
      builder.add(part / 2, q, polygon);
    }
  }
  builder.finish();
  return list;
}

std::vector<std::uint32_t> primitives_of(const FlatCell& cell) {
  std::vector<std::uint32_t> primitives;
  for (std::uint32_t face = 0; face < 6; ++face) {
    if (cell.faces[face] != kOpenFace) primitives.push_back(cell.faces[face] >> kPrimitiveShift);
  }
  std::sort(primitives.begin(), primitives.end());
  return primitives;
}

std::vector<std::uint32_t> loose_of(const FlatList& list) {
  std::vector<std::uint32_t> primitives;
  for (std::uint32_t i = 0; i < list.loose_count; ++i) {
    for (std::uint32_t lane = 0; lane < list.loose[i].used; ++lane)
      primitives.push_back(list.loose[i].primitive[static_cast<int>(lane)]);
  }
  std::sort(primitives.begin(), primitives.end());
  return primitives;
}

/// Faces 2s and 2s + 1 of a parallelepiped, those opposite to edge s and through its end, but for `missing`
/// ones.
void add_faces(std::vector<Quad>& quads, const Vec3& corner, const Vec3 (&edges)[3], unsigned missing = 0) {
  for (unsigned i = 0; i < 6; ++i) {
    if ((missing >> i & 1U) != 0) continue;
    const Vec3 from = i % 2 == 1 ? corner + edges[i / 2] : corner;
    const Vec3 u = edges[(i / 2 + 1) % 3], v = edges[(i / 2 + 2) % 3];
    quads.push_back(Quad{from, from + u, from + u + v, from + v});
  }
}

const Vec3 kUnit[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
const Vec3 kLeaning[3] = {{0.5f, 0.25f, 0}, {-0.125f, 0.5f, 0.25f}, {0, 0.25f, 0.75f}};

TEST_CASE("a room and a block in it are cells, a lamp and a screen are not") {
  std::vector<Quad> quads{{{0.4f, 0.9f, 0.4f}, {0.6f, 0.9f, 0.4f}, {0.6f, 0.9f, 0.6f}, {0.4f, 0.9f, 0.6f}}};
  add_faces(quads, Vec3{0, 0, 0}, kUnit, 0x10);
  add_faces(quads, Vec3{0.125f, 0.0625f, 0.0625f}, kLeaning);
  quads.push_back(Quad{{0, 0.5f, 0.5f}, {1, 0.5f, 0.5f}, {1, 1, 0.75f}, {0, 1, 0.75f}});
  const auto list = list_of(quads, 2);
  REQUIRE(list->cell_count == 2);
  std::vector<std::vector<std::uint32_t>> found{primitives_of(list->cells[0]), primitives_of(list->cells[1])};
  std::sort(found.begin(), found.end());
  CHECK(found[0] == std::vector<std::uint32_t>{1, 2, 3, 4, 5});
  CHECK(found[1] == std::vector<std::uint32_t>{6, 7, 8, 9, 10, 11});
  CHECK(loose_of(*list) == std::vector<std::uint32_t>{0, 12});
}

TEST_CASE(
    "three faces make a cell, two do not, nor do faces without common corners, trapezoids or thin slabs") {
  const auto cells_of = [](const std::vector<Quad>& quads) { return list_of(quads, 2)->cell_count; };
  std::vector<Quad> corner, gutter, apart, trapezoid, thin;
  add_faces(corner, Vec3{0, 0, 0}, kLeaning, 0x2a);
  CHECK(cells_of(corner) == 1);
  add_faces(gutter, Vec3{0, 0, 0}, kLeaning, 0x3a);
  CHECK(cells_of(gutter) == 0);
  apart = corner;
  for (Quad* quad : {&apart[1], &apart[2]}) {
    for (Vec3* p : {&quad->a, &quad->b, &quad->c, &quad->d}) *p += Vec3{0.001f, 0.001f, 0.001f};
  }
  apart[2] = Quad{apart[2].a * 2.0f, apart[2].b * 2.0f, apart[2].c * 2.0f, apart[2].d * 2.0f};
  CHECK(cells_of(apart) == 0);
  trapezoid = corner;
  trapezoid[2].c = trapezoid[2].c * 1.01f;
  CHECK(cells_of(trapezoid) == 0);
  const Vec3 flat[3] = {{1, 0, 0}, {0, 0x1p-13f, 0}, {0, 0, 1}};
  add_faces(thin, Vec3{0, 0, 0}, flat);
  CHECK(cells_of(thin) == 0);
}

using F = WideFloat;

/// What the bounds of a cell say about one ray.
struct Bounds {
  float enters, leaves, error;
  std::uint32_t entry, exit;
  bool met, clear;
};

Bounds bounds_of(const FlatList& list, const FlatCell& cell, const Ray& ray, float extent) {
  RayOf<F> rays;
  for (int lane = 0; lane < kWideLanes; ++lane) {
    set_lane_of(rays.origin, lane, ray.origin);
    set_lane_of(rays.direction, lane, ray.direction);
  }
  const WideRayFrame<F> frame(rays);
  const FlatRayOf<F> flat(rays, frame.longest, frame.distance, extent);
  const CellCrossing<F> crossing(cell, flat, AxisSlopes<F>(list, flat));
  const CellFaces<F> faces(cell, crossing);
  return {crossing.enters[0],
          crossing.leaves[0],
          crossing.error[0],
          faces.entry[0],
          faces.exit[0],
          (lanes_of(crossing.met()) & 1U) != 0,
          (lanes_of(faces.clear) & 1U) != 0};
}

TEST_CASE("hits on faces of cells lie within the bounds, on the face that they name") {
  constexpr float kExtent = 2;
  std::vector<Quad> quads;
  add_faces(quads, Vec3{0.125f, 0.0625f, 0.0625f}, kLeaning);
  add_faces(quads, Vec3{-1, -1, -1}, kUnit, 0x08);
  const auto list = list_of(quads, kExtent);
  REQUIRE(list->cell_count == 2);
  Shapes shapes;
  Rng rng(7, StreamPurpose::kTest, 0);
  int hits = 0, unclear = 0;
  float worst = 0;
  for (std::uint32_t c = 0; c < 2; ++c) {
    const FlatCell& cell = list->cells[c];
    shapes.quads.clear();
    const std::vector<std::uint32_t> primitives = primitives_of(cell);
    for (const std::uint32_t primitive : primitives) shapes.quads.push_back(quads[primitive]);
    const BuiltGeometry built(shapes, kAlwaysFlat);
    for (int i = 0; i < 200000; ++i) {
      const Ray ray{point_in_cube(rng) * 1.5f, point_in_cube(rng), std::numeric_limits<float>::infinity()};
      const Hit hit = (*built).intersect<false>(ray);
      const Bounds bounds = bounds_of(*list, cell, ray, kExtent);
      if (!hit.found()) continue;
      ++hits;
      REQUIRE(bounds.met);
      if (!bounds.clear) ++unclear;
      const std::uint32_t primitive = primitives[hit.primitive];
      const bool enters = std::fabs(hit.t - bounds.enters) < std::fabs(hit.t - bounds.leaves);
      worst = std::max(worst, std::fabs(hit.t - (enters ? bounds.enters : bounds.leaves)) / bounds.error);
      if (bounds.clear) REQUIRE(primitive == (enters ? bounds.entry : bounds.exit) >> kPrimitiveShift);
    }
  }
  CAPTURE(worst, unclear);
  CHECK(hits > 20000);
  CHECK(worst <= 1.0f);
  // Bounds that were far too wide would send rays to be traced one by one.
  CHECK(unclear < hits / 250);
}

}  // namespace
}  // namespace mlt::test
