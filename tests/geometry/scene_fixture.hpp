// Shapes and a Geometry over them, for tests: owns the arena, and makes meshes and rays that are hard on
// intersection code.
#pragma once

#include <memory>
#include <vector>

#include "geometry/geometry.hpp"
#include "math/rng.hpp"

namespace mlt::test {

inline constexpr FlatLimits kAlwaysFlat{1U << 30, 1U << 30, 1U << 30, 0, 0};
inline constexpr FlatLimits kAlwaysBounds{1U << 30, 1U << 30, 1U << 30, 1U << 30, 1U << 30};
inline constexpr FlatLimits kAlwaysTree{0, 0, 0, 0, 0};

struct Shapes {
  std::vector<Quad> quads;
  std::vector<Triangle> triangles;
  std::vector<Sphere> spheres;

  GeometryCounts counts() const {
    return {static_cast<std::uint32_t>(quads.size()), static_cast<std::uint32_t>(triangles.size()),
            static_cast<std::uint32_t>(spheres.size())};
  }
  std::size_t size() const { return quads.size() + triangles.size() + spheres.size(); }
};

/// Triangles as the geometry takes them, each with vertices of its own.
class TriangleSoup {
 public:
  explicit TriangleSoup(const std::vector<Triangle>& triangles) {
    for (const Triangle& t : triangles) {
      const auto first = static_cast<std::uint32_t>(vertices_.size());
      vertices_.insert(vertices_.end(), {t.a, t.b, t.c});
      corners_.push_back({first, first + 1, first + 2});
    }
  }
  TriangleList list() const { return {vertices_, corners_}; }

 private:
  std::vector<Vec3> vertices_;
  std::vector<TriangleCorners> corners_;
};

/// A Geometry with the memory that it lives in.
class BuiltGeometry {
 public:
  explicit BuiltGeometry(const Shapes& shapes, const FlatLimits& limits = {}) {
    MemoryPlan plan;
    const GeometrySlots slots = Geometry::plan(plan, shapes.counts(), limits);
    bytes_ = plan.total_bytes();
    scene_bytes_ = plan.bytes(Lifetime::kScene);
    arena_ = std::make_unique<Arena>(plan);
    const TriangleSoup soup(shapes.triangles);
    geometry_ = Geometry::build(*arena_, slots, {shapes.quads, soup.list(), shapes.spheres});
  }
  const Geometry& operator*() const { return geometry_; }
  const Geometry* operator->() const { return &geometry_; }
  std::size_t bytes() const { return bytes_; }
  std::size_t scene_bytes() const { return scene_bytes_; }

 private:
  std::unique_ptr<Arena> arena_;
  Geometry geometry_;
  std::size_t bytes_ = 0, scene_bytes_ = 0;
};

/// Uniform in [-1, 1).
inline float signed_unit(Rng& rng) {
  return rng.next_float() * 2.0f - 1.0f;
}

inline Vec3 point_in_cube(Rng& rng) {
  const float x = signed_unit(rng);
  const float y = signed_unit(rng);
  const float z = signed_unit(rng);
  return Vec3{x, y, z};
}

inline Vec3 unit_direction(Rng& rng) {
  for (;;) {
    const Vec3 p = point_in_cube(rng);
    const float squared = dot(p, p);
    if (squared > 0.01f && squared <= 1.0f) return normalize(p);
  }
}

inline std::uint32_t below(Rng& rng, std::size_t count) {
  return static_cast<std::uint32_t>(std::uint64_t{rng.next_fixed()} * count >> 32);
}

/// Triangles of all sizes from 1e-4 to 1, every third one a needle, some axis-parallel, some sharing corners
/// with the one before, and every tenth a duplicate in its plane with another vertex order.
inline std::vector<Triangle> triangle_soup(std::size_t count, std::uint64_t seed) {
  Rng rng(seed, StreamPurpose::kTest, 1);
  std::vector<Triangle> soup;
  const float sizes[] = {1.0f, 0.3f, 0.1f, 1e-2f, 1e-3f, 1e-4f};
  while (soup.size() < count) {
    const float size = sizes[below(rng, 6)];
    const Vec3 a = point_in_cube(rng) * 0.9f;
    Triangle t{a, a + point_in_cube(rng) * size, a + point_in_cube(rng) * size};
    if (soup.size() % 3 == 0) {
      // One draw a statement: compilers differ in the order of operands.
      const Vec3 along = (t.b - t.a) * signed_unit(rng);
      t.c = (t.b + along) + point_in_cube(rng) * (size * 1e-5f);
    }
    if (soup.size() % 7 == 1) t.a.z = t.b.z = t.c.z;
    if (soup.size() % 5 == 2) t.a = soup.back().b;
    if (soup.size() % 5 == 2) t.b = soup.back().c;
    soup.push_back(t);
    if (soup.size() % 10 == 0) soup.push_back(Triangle{t.b, t.a, t.c});
  }
  soup.resize(count);
  return soup;
}

/// Parallelograms of several sizes, thin ones among them, and duplicates that start at another corner.
inline std::vector<Quad> quad_soup(std::size_t count, std::uint64_t seed) {
  Rng rng(seed, StreamPurpose::kTest, 2);
  std::vector<Quad> soup;
  const float sizes[] = {1.0f, 0.3f, 0.1f, 1e-2f};
  while (soup.size() < count) {
    const float size = sizes[below(rng, 4)];
    const Vec3 a = point_in_cube(rng) * 0.7f;
    const Vec3 u = point_in_cube(rng) * size;
    const float stretch = signed_unit(rng);
    const Vec3 w = point_in_cube(rng) * size;
    const Vec3 v = soup.size() % 4 == 0 ? u * stretch + w * 1e-5f : w;
    const Quad q{a, a + u, (a + u) + v, a + v};
    soup.push_back(q);
    if (soup.size() % 10 == 0) soup.push_back(Quad{q.c, q.d, q.a, q.b});
  }
  soup.resize(count);
  return soup;
}

/// A grid of unit-spaced squares, each of two triangles, in several parallel planes at round coordinates, so
/// that axis-parallel rays meet edges and corners exactly and planes at equal distances.
inline std::vector<Triangle> lattice(int cells) {
  std::vector<Triangle> triangles;
  const float step = 2.0f / static_cast<float>(cells);
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < cells; ++i) {
      for (int j = 0; j < cells; ++j) {
        const auto corner = [&](int di, int dj) {
          Vec3 p{0, 0, 0};
          p[axis] = axis == 1 ? 0.5f : 0.0f;
          p[(axis + 1) % 3] = -1.0f + step * static_cast<float>(i + di);
          p[(axis + 2) % 3] = -1.0f + step * static_cast<float>(j + dj);
          return p;
        };
        triangles.push_back({corner(0, 0), corner(1, 0), corner(1, 1)});
        triangles.push_back({corner(0, 0), corner(1, 1), corner(0, 1)});
      }
    }
  }
  return triangles;
}

/// A closed sphere of `rings` x `segments` cells around the origin; edges and corners are shared exactly.
inline std::vector<Triangle> tessellated_sphere(int rings, int segments, float radius) {
  std::vector<Triangle> triangles;
  constexpr double kPi = 3.14159265358979323846;
  const auto corner = [&](int ring, int segment) {
    const double polar = kPi * ring / rings;
    const double azimuth = 2 * kPi * (segment % segments) / segments;
    // The poles are single points, whatever the segment.
    const double width = ring == 0 || ring == rings ? 0.0 : std::sin(polar);
    return Vec3{DVec3{width * std::cos(azimuth), width * std::sin(azimuth), std::cos(polar)} *
                double{radius}};
  };
  for (int ring = 0; ring < rings; ++ring) {
    for (int segment = 0; segment < segments; ++segment) {
      const Vec3 a = corner(ring, segment), b = corner(ring + 1, segment);
      const Vec3 c = corner(ring + 1, segment + 1), d = corner(ring, segment + 1);
      if (ring + 1 < rings) triangles.push_back({a, b, c});
      if (ring > 0) triangles.push_back({a, c, d});
    }
  }
  return triangles;
}

/// A ray from anywhere in [-1.5, 1.5]^3 of one of eight kinds: random; along an axis, with zeros of both
/// signs; with one zero component; at a corner, at an edge or at an inner point of a random polygon; from
/// such a point in a random direction; in a plane of round coordinates.
inline Ray hard_ray(Rng& rng, const std::vector<Triangle>& targets) {
  const std::uint32_t kind = rng.next_fixed() % 8;
  Vec3 origin = point_in_cube(rng) * 1.5f;
  Vec3 direction = unit_direction(rng);
  if (kind == 1 || kind == 2) {
    const std::uint32_t axis = below(rng, 3);
    const std::uint32_t signs = rng.next_fixed();
    for (std::uint32_t i = 0; i < 3; ++i) {
      const float sign = (signs >> (i + 4) & 1U) != 0 ? 1.0f : -1.0f;
      if (kind == 1 ? i != axis : i == axis) direction[static_cast<int>(i)] = 0.0f * sign;
    }
    if (is_zero(direction)) direction = Vec3{0, 0, 1};
  } else if (kind >= 3 && kind <= 6 && !targets.empty()) {
    const Triangle& t = targets[below(rng, targets.size())];
    const float v = kind == 3 ? 0.0f : rng.next_float();
    const float w = kind == 5 || kind == 6 ? rng.next_float() * (1.0f - v) : 0.0f;
    const Vec3 p = t.a + ((t.b - t.a) * v + (t.c - t.a) * w);
    if (kind == 6) {
      origin = p;
    } else {
      direction = p - origin;
    }
  } else if (kind == 7) {
    for (int i = 0; i < 3; ++i) origin[i] = std::floor(origin[i] * 8.0f) * 0.125f;
    for (int i = 0; i < 3; ++i) direction[i] = std::floor(direction[i] * 4.0f) * 0.25f;
    if (is_zero(direction)) direction = Vec3{0, 1, 0};
  }
  return Ray{origin, direction, 1e30f};
}

/// Two triangles in place of each quad, as targets.
inline std::vector<Triangle> halves_of(const std::vector<Quad>& quads) {
  std::vector<Triangle> triangles;
  for (const Quad& q : quads) {
    triangles.push_back({q.a, q.b, q.c});
    triangles.push_back({q.a, q.c, q.d});
  }
  return triangles;
}

}  // namespace mlt::test
