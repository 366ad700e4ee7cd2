// Area lights as the world stores them. One record per emitting primitive; sampling is in
// light/light_table.hpp. Lights emit the same radiance in all directions of their front side.
#pragma once

#include <cstdint>

#include "math/gather.hpp"
#include "math/vec.hpp"
#include "math/wide.hpp"

namespace mlt {

struct Quad;
struct Triangle;
struct Sphere;

inline constexpr std::uint32_t kNoLight = 0xffffffffU;

enum class LightShape : std::uint32_t { kQuad, kTriangle, kSphere };

struct alignas(32) Light {
  // Rows of four floats, which lanes load together.
  Vec3 origin{0, 0, 0};  ///< corner a, or the sphere's centre
  float radius = 0;      ///< the sphere's; of a polygon, that of a sphere around its middle that holds it
  Vec3 edge_u{0, 0, 0};  ///< b - a
  float area = 0;
  Vec3 edge_v{0, 0, 0};          ///< quad: d - a; triangle: c - a
  float choice_probability = 0;  ///< exactly the length of its interval in LightTable::cdf
  Vec3 normal{0, 0, 1};          ///< front side, unit; unused for a sphere, whose front is its outside
  float offset_bound = 0;  ///< distance along the normal that keeps shadow segments off the light's surface
  Vec3 radiance{0, 0, 0};
  LightShape shape = LightShape::kQuad;
  std::uint32_t primitive = 0xffffffffU;  ///< whose surface it is; none as long as it is in no world
};

/// One light for each lane; lanes of no light may hold anything.
template <class F>
struct WideLight {
  WideVec3<F> origin, edge_u, edge_v, normal, radiance;
  F radius, area, choice_probability, offset_bound;
};

template <class F>
using LightOf = std::conditional_t<std::is_same_v<F, float>, Light, WideLight<F>>;

/// Where the lights of all lanes lie: row index[i] of a table for lane i.
template <class F>
class LightRefOf {
 public:
  LightRefOf(const Light* table, UintOf<F> index)
      : table_(table), offset_(index * static_cast<std::uint32_t>(sizeof(Light))) {}
  /// One light for all lanes.
  LightRefOf(const Light& light) : table_(&light), offset_(UintOf<F>{}), uniform_(true) {}

  MLT_INLINE MaskOf<F> is(LightShape shape) const {
    if (uniform_) return table_->shape == shape ? not_in(MaskOf<F>{}) : MaskOf<F>{};
    return gather_bytes<F>(&table_->shape, offset_) == static_cast<std::uint32_t>(shape);
  }
  MLT_INLINE UintOf<F> primitive() const {
    if (uniform_) return broadcast_bits<UintOf<F>>(table_->primitive);
    return gather_bytes<F>(&table_->primitive, offset_);
  }
  /// Loads what is read of the result, provided that it is inlined.
  MLT_INLINE LightOf<F> load() const {
    if constexpr (VectorType<F>) {
      const auto origin = row(table_->origin), edge_u = row(table_->edge_u), edge_v = row(table_->edge_v);
      const auto normal = row(table_->normal), radiance = row(table_->radiance);
      return {vec3(origin),     vec3(edge_u),     vec3(edge_v),     vec3(normal),    vec3(radiance),
              origin.column[3], edge_u.column[3], edge_v.column[3], normal.column[3]};
    } else {
      return *reinterpret_cast<const Light*>(reinterpret_cast<const std::byte*>(table_) + offset_);
    }
  }

 private:
  MLT_INLINE Rows<F> row(const Vec3& first) const {
    if (!uniform_) return gather_rows<F>(&first.x, offset_);
    const float* floats = &first.x;
    return {{broadcast_to<F>(floats[0]), broadcast_to<F>(floats[1]), broadcast_to<F>(floats[2]),
             broadcast_to<F>(floats[3])}};
  }
  MLT_INLINE static Vec3Of<F> vec3(const Rows<F>& row) {
    return {row.column[0], row.column[1], row.column[2]};
  }

  const Light* table_;
  UintOf<F> offset_;
  bool uniform_ = false;
};

/// Who looks at a light. The normal of its surface, on the side that gathers light, lets samples
/// prefer lights and points of quads that are high above its horizon; with none, (0, 0, 0), lights are chosen
/// by power alone and points uniformly by area. A surface that
/// gathers light on both sides must give none.
template <class F>
struct ReceiverOf {
  Vec3Of<F> position;
  Vec3Of<F> normal{F{}, F{}, F{}};

  ReceiverOf(const Vec3Of<F>& at) : position(at) {}
  ReceiverOf(const Vec3Of<F>& at, const Vec3Of<F>& surface_normal) : position(at), normal(surface_normal) {}
};
using Receiver = ReceiverOf<float>;

/// A point on a light as seen from a reference point.
template <class F>
struct LightSampleOf {
  Vec3Of<F> position{F{}, F{}, F{}};                  ///< off the light's surface, to the reference's side
  Vec3Of<F> direction{F{}, F{}, broadcast_to<F>(1)};  ///< unit, reference to light
  Vec3Of<F> radiance{F{}, F{}, F{}};                  ///< 0 when the reference point sees the back
  F pdf_solid_angle{};                                ///< including the light's choice; 0: no sample
  UintOf<F> light = broadcast_bits<UintOf<F>>(kNoLight);
};
using LightSample = LightSampleOf<float>;

template <class F>
MLT_INLINE LightSampleOf<F> select(MaskOf<F> mask, const LightSampleOf<F>& a, const LightSampleOf<F>& b) {
  return {select(mask, a.position, b.position), select(mask, a.direction, b.direction),
          select(mask, a.radiance, b.radiance), select(mask, a.pdf_solid_angle, b.pdf_solid_angle),
          select(mask, a.light, b.light)};
}

/// Lights from world space shapes, without a choice probability, which build_light_table sets. A shape of
/// area 0 gives a light of area 0, which is never chosen.
Light make_quad_light(const Quad& quad, const Vec3& radiance);
Light make_triangle_light(const Triangle& triangle, const Vec3& radiance);
Light make_sphere_light(const Sphere& sphere, const Vec3& radiance);

/// Radiance that the point of a light whose surface normal there is `normal` sends against `direction` (from
/// the receiver towards the light): nothing from the back side.
template <class F = float>
MLT_INLINE Vec3Of<F> emitted_radiance(const LightOf<F>& light, const Vec3Of<F>& normal,
                                      const Vec3Of<F>& direction) {
  return select(dot(normal, direction) < 0.0f, light.radiance, Vec3Of<F>{F{}, F{}, F{}});
}

}  // namespace mlt
