// Few polygons without a hierarchy. All are first met by a fast test in lanes that only says where they might
// be hit; the test that defines hits (polygon.hpp) then decides on the one that seems nearest, and on others
// only where the fast test cannot tell them apart. Most rays need it once, most shadow rays not at all.
//
// Blocks hold polygons whose normals have the same dominant axis k; i and j follow it cyclically. A polygon
// lies in the plane p_k + n_i p_i + n_j p_j = n_0, |n_i| and |n_j| <= 1, and two functions U, V of p_i and
// p_j map it into the square |U|, |V| <= 1/2, which a parallelogram fills.
//
// Error bounds, with u = 2^-24, o and d the ray, D = max |d|, m = max |o|, M = m + extent, G = 1 + |n_i| +
// |n_j| and det = d_k + n_i d_i + n_j d_j, so |det| <= GD. Where the defining test finds a hit, there is a
// point q of the polygon (ray_frame.hpp) whose distance from the ray's point at some depth s is 6uM or less
// by coordinate. Hence s det = (n_0 - n . o) + e with |e| <= 6uGM. Rounding adds 10uGM to n_0 - n . o, and
// 3uGD |s| <= 3uGM to det, so that t = (n_0 - n . o) / det as computed differs from s by at most 20uGM /
// |det|.
//
// The distance of the definition is a mean of corners' distances by weights that are each off by 4uQ, where
// Q <= 4 L^2 and L is the polygon's largest extent; their sum is |N_k det| / D for N = (b - a) x (c - a).
// That makes it differ from s by 48u L^3 / |N_k det| for the weights and by 6uM / D <= 6uGM / |det| for the
// rest; being raised to the entry of the padded box, which is <= s, cannot add to that. In all by less than
// (32uGM + 48u L^3 / |N_k|) / |det|, the depth error.
//
// The point o + t d differs from q by 20uGM D / |det| + 8uM, which the functions multiply by K, the sum of
// their absolute coefficients, and to which they add 4uKM: less than 32uKGM D / |det|, the position error.
//
// A hit at t > 0 has n_0 - n . o >= -(9uGM + 5uGm) in the direction of det, since near the plane rounding
// adds but 5uGm; as m <= M, that is less than 14uGM, the plane error. Rays that leave a polygon mostly start
// beyond that (surface.hpp), so that it need not be tested.
//
// Conversely, a point in the square by 9uKM (1 + GD / |det|) besides the position error lies in the sheared
// polygon, whose corners are off by 6uM by coordinate; twice the position error covers that, so a hit is
// sure. Corners off the plane count as part of G. All errors are in units of 32uM max(D, 1) / |det|, which is
// not less than what they were derived with. Comparisons are such that NaN counts as unsure.
#pragma once

#include <cstdint>
#include <cstring>

#include "geometry/flat_cell.hpp"
#include "geometry/quad_block.hpp"
#include "geometry/shapes.hpp"
#include "math/gather.hpp"
#include "math/wide.hpp"

namespace mlt {

/// kLanes polygons of one dominant axis. Unused lanes reject all rays, by a scale of minus infinity.
struct alignas(64) FlatBlock {
  LaneFloat normal_i, normal_j, offset;    ///< n_i, n_j, n_0
  LaneFloat u_i, u_j, u_0, v_i, v_j, v_0;  ///< U = u_i p_i + u_j p_j + u_0
  // In units of FlatRay::error / |det|; the last two negative.
  LaneFloat plane_error, depth_error, position_error;
  LaneFloat inner;  ///< the square within which hits can be sure: about 1/2, or none
  LaneInt slot;     ///< in FlatList::polygons
  LaneUint primitive;
  std::uint32_t axis;  ///< k
  std::uint32_t used;  ///< lanes
  /// So many of the first lanes have n_i = n_j = 0: rays cross their planes at distances that share a
  /// division.
  std::uint32_t aligned;
};

/// A polygon with its box.
struct alignas(64) FlatPolygon {
  QuadRecord quad;
  float low[3];
  std::uint32_t slot;  ///< counted over all lists
  float high[3];
  std::uint32_t padding;
};

/// Blocks of a list; their slots are bits of a float that do not matter.
inline constexpr int kFlatBlocks = 128 / kLanes;
inline constexpr std::int32_t kFlatSlots = kFlatBlocks * kLanes;
/// So many polygons fit, however they are spread over axes.
inline constexpr std::uint32_t kFlatPolygons = (kFlatBlocks - 2) * kLanes;

inline constexpr std::uint32_t kTableSlots = 64;
inline constexpr std::uint32_t kRowsOfPolygon = 6;  ///< of four floats each

/// The polygons of the first slots in columns, for registers that are tables (gather.hpp). Lists are built by
/// the same code for all sets of instructions with as many lanes, so that all of these have them.
template <bool kUsed>
struct PolygonColumns {
  alignas(64) float floats[kRowsOfPolygon * 4][kTableSlots];

  void set(std::uint32_t slot, const FlatPolygon& polygon) {
    float values[kRowsOfPolygon * 4];
    static_assert(sizeof(values) <= sizeof(FlatPolygon));
    std::memcpy(values, &polygon, sizeof(values));
    for (std::uint32_t i = 0; slot < kTableSlots && i < kRowsOfPolygon * 4; ++i) floats[i][slot] = values[i];
  }
  /// Row `index` of the polygon in slot[i], for lane i.
  template <class F>
  MLT_INLINE Rows<F> row(std::uint32_t index, const UintOf<F>& slot, bool beyond_32) const {
    const auto* const table = floats + 4 * index;
    return {{table_entries<F>(table[0], slot, beyond_32), table_entries<F>(table[1], slot, beyond_32),
             table_entries<F>(table[2], slot, beyond_32), table_entries<F>(table[3], slot, beyond_32)}};
  }
};
template <>
struct PolygonColumns<false> {
  void set(std::uint32_t, const FlatPolygon&) {}
  template <class F>
  Rows<F> row(std::uint32_t, const UintOf<F>&, bool) const {
    return {};
  }
};

struct FlatList {
  FlatBlock blocks[kFlatBlocks];
  FlatPolygon polygons[kFlatSlots];
  [[no_unique_address]] PolygonColumns<kLanes == 8> columns;
  std::uint32_t block_count;
  // For many rays: cells, and blocks of what lies in none of them.
  std::uint32_t cell_count, cell_axes;  ///< bit k: a slab across axis k
  std::uint32_t loose_count;
  FlatCell cells[kFlatCells];
  FlatBlock loose[kFlatBlocks];

  std::uint32_t slot_count() const { return block_count * kLanes; }
};

/// The part of depth_error that comes of the weights of corners a, b, c, d, in a block of axis `k`.
double depth_weight_error(const DVec3 (&corners)[4], int k, double extent);

/// Fills `list`, which lies in zeroed memory, by those polygons of `quads` that have an area.
class FlatListBuilder {
 public:
  /// `first_slot` is that of the list's first polygon. No coordinate is beyond `extent`.
  FlatListBuilder(FlatList& list, std::uint32_t first_slot, float extent);
  /// The block axis of a quad.
  static int axis_of(const Quad& quad);
  /// Whether the quad is aligned, in its block.
  static bool is_aligned(const Quad& quad);
  /// In order of axes, for each the aligned quads first; kFlatPolygons at most.
  void add(int axis, const Quad& quad, const FlatPolygon& polygon);
  /// After all have been added, once.
  void finish();

 private:
  void finish_axis();
  void find_cells();
  void add_loose(std::uint32_t slot);

  FlatList& list_;
  std::uint32_t first_slot_;
  float extent_;
  int axis_ = 0;
  std::uint32_t slot_ = 0;
};

/// What the fast test needs of a ray, in all lanes the same, or of as many rays as there are lanes.
template <class F>
struct FlatRayOf {
  F origin[5], direction[5];  ///< x, y, z, x, y
  F error;                    ///< 32uM max(D, 1)

  MLT_INLINE FlatRayOf(const RayOf<F>& ray, F longest, F distance, float extent)
      : origin{ray.origin.x, ray.origin.y, ray.origin.z, ray.origin.x, ray.origin.y},
        direction{ray.direction.x, ray.direction.y, ray.direction.z, ray.direction.x, ray.direction.y},
        error((distance + extent) * (0x1p-19f * larger(longest, broadcast_to<F>(1.0f)))) {}
};

/// A ray in the order of a block's axes, k, i, j.
template <class F>
struct FlatAxes {
  const F* origin;
  const F* direction;
  F error;

  MLT_INLINE FlatAxes(const FlatRayOf<F>& ray, std::uint32_t axis)
      : origin(ray.origin + axis), direction(ray.direction + axis), error(ray.error) {}
};

/// One ray.
struct FlatRay : FlatRayOf<LaneFloat> {
  MLT_INLINE FlatRay(const Ray& ray, const RayLanes& lanes, float extent)
      : FlatRayOf({broadcast_to<LaneFloat>(ray.origin), broadcast_to<LaneFloat>(ray.direction), LaneFloat{}},
                  broadcast(lanes.longest[0]), broadcast(lanes.distance), extent) {}
};

/// The coefficients of a block's polygons, for one ray.
struct BlockCoefficients {
  const FlatBlock& block;
  MLT_INLINE LaneFloat operator()(LaneFloat FlatBlock::*coefficient) const { return block.*coefficient; }
};
/// Those of one of its polygons, for as many rays as there are lanes.
template <class F>
struct PolygonCoefficients {
  const FlatBlock& block;
  int lane;
  MLT_INLINE F operator()(LaneFloat FlatBlock::*coefficient) const {
    return broadcast_to<F>((block.*coefficient)[lane]);
  }
};

/// Where rays might hit polygons.
template <class F>
struct FlatBounds {
  F first;             ///< no hit lies before; 0 or more
  MaskOf<F> rejected;  ///< no hit at all
  MaskOf<F> sure;      ///< the ray meets the polygon at 0 < t < limit
};

/// What rays need of the direction of a plane: -1 / det, and the unit of all errors.
template <class F>
struct PlaneSlope {
  F inverse, error;

  MLT_INLINE PlaneSlope(F det, F ray_error) : inverse(-1.0f / det), error(magnitude(inverse) * ray_error) {}
};

/// Where rays cross the plane of a polygon, the first half of the fast test.
template <class F>
struct PlaneCrossing {
  F t, first, error;
  MaskOf<F> behind;  ///< no hit at t > 0

  template <class Coefficients>
  MLT_INLINE PlaneCrossing(const Coefficients& of, F height, const PlaneSlope<F>& slope)
      : t(height * slope.inverse),
        first(mul_add_bound(slope.error, of(&FlatBlock::depth_error), t)),
        error(slope.error),
        behind(mul_add_bound(slope.error, of(&FlatBlock::plane_error), t) <= F{}) {}

  /// The signs of n, n_0, u_0 and v_0 are stored so that all are sums.
  template <class Coefficients>
  MLT_INLINE static PlaneCrossing inclined(const Coefficients& of, const FlatAxes<F>& ray) {
    const F normal_i = of(&FlatBlock::normal_i), normal_j = of(&FlatBlock::normal_j);
    const F* const o = ray.origin;
    const F* const d = ray.direction;
    const F height =
        mul_add_bound(normal_j, o[2], mul_add_bound(normal_i, o[1], o[0] - of(&FlatBlock::offset)));
    const F det = mul_add_bound(normal_j, d[2], mul_add_bound(normal_i, d[1], d[0]));
    return {of, height, PlaneSlope<F>(det, ray.error)};
  }
  /// The same for a polygon of the aligned ones, which share their slope.
  template <class Coefficients>
  MLT_INLINE static PlaneCrossing aligned(const Coefficients& of, const FlatAxes<F>& ray,
                                          const PlaneSlope<F>& slope) {
    return {of, ray.origin[0] - of(&FlatBlock::offset), slope};
  }
};

/// How far from the middle of a polygon rays cross its plane: up to 1/2 inside.
template <class F, class Coefficients>
MLT_INLINE F off_middle(const Coefficients& of, const FlatAxes<F>& ray, F t) {
  const F p_i = mul_add_bound(t, ray.direction[1], ray.origin[1]);
  const F p_j = mul_add_bound(t, ray.direction[2], ray.origin[2]);
  const F u =
      mul_add_bound(of(&FlatBlock::u_j), p_j, mul_add_bound(of(&FlatBlock::u_i), p_i, of(&FlatBlock::u_0)));
  const F v =
      mul_add_bound(of(&FlatBlock::v_j), p_j, mul_add_bound(of(&FlatBlock::v_i), p_i, of(&FlatBlock::v_0)));
  return larger(magnitude(u), magnitude(v));
}

/// The fast test for hits at any distance; `sure` is left open.
template <class F, class Coefficients>
MLT_INLINE FlatBounds<F> bound_hits(const Coefficients& of, const FlatAxes<F>& ray,
                                    const PlaneCrossing<F>& plane) {
  const F off = off_middle(of, ray, plane.t);
  FlatBounds<F> bounds;
  bounds.first = larger(plane.first, F{});
  bounds.rejected = plane.behind | (mul_add_bound(plane.error, of(&FlatBlock::position_error), off) > 0.5f);
  return bounds;
}

/// The fast test for hits before `limit`, outside `excluded`, which counts as rejected.
template <class F, class Coefficients>
MLT_INLINE FlatBounds<F> bound_hits(const Coefficients& of, const FlatAxes<F>& ray,
                                    const PlaneCrossing<F>& plane, F limit, MaskOf<F> excluded) {
  FlatBounds<F> bounds;
  bounds.first = plane.first;
  bounds.sure = MaskOf<F>{};
  bounds.rejected = excluded | plane.behind | (plane.first > limit);
  // Planes that bound the scene lie beyond the ends of all segments in it.
  if (all(bounds.rejected)) return bounds;
  const F off = off_middle(of, ray, plane.t);
  const F position_error = of(&FlatBlock::position_error);
  bounds.rejected |= mul_add_bound(plane.error, position_error, off) > 0.5f;
  // Twice the position error, and the depth error to the other side.
  const F sure_off = mul_add_bound(plane.error, -2.0f * position_error, off);
  bounds.sure = not_in(excluded) & (sure_off < of(&FlatBlock::inner)) & (plane.first > 0.0f) &
                ((plane.t + plane.t) - plane.first < limit);
  return bounds;
}

/// Where the ray enters the padded box.
MLT_INLINE float box_entry(const FlatPolygon& polygon, const RaySlabs& slabs) {
  const Float4 plane = select4(slabs.backwards, load_float4(polygon.high), load_float4(polygon.low));
  const Float4 entry = (plane - slabs.near_origin) * slabs.inverse;
  float most = entry[0] > 0.0f ? entry[0] : 0.0f;
  most = entry[1] > most ? entry[1] : most;
  return entry[2] > most ? entry[2] : most;
}

/// Smallest of all lanes.
MLT_INLINE float smallest_lane(LaneFloat v) {
#if defined(__AVX2__)
  v = min_lanes(v, __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3));
  v = min_lanes(v, __builtin_shufflevector(v, v, 2, 3, 0, 1, 6, 7, 4, 5));
  v = min_lanes(v, __builtin_shufflevector(v, v, 1, 0, 3, 2, 5, 4, 7, 6));
#else
  v = min_lanes(v, __builtin_shufflevector(v, v, 2, 3, 0, 1));
  v = min_lanes(v, __builtin_shufflevector(v, v, 1, 0, 3, 2));
#endif
  return v[0];
}

/// A key, whose lowest bits are a slot, is not above this if what it stands for is not above `limit`.
MLT_INLINE float key_limit(float limit) {
  constexpr float kFarthest = 0x1p125f;
  const float finite = limit < kFarthest ? limit : kFarthest;
  return std::bit_cast<float>(std::bit_cast<std::int32_t>(finite) + kFlatSlots);
}

/// Calls test(polygon) -> new limit, for polygons of the list that the ray might meet before the limit, the
/// likeliest first.
template <class Test>
MLT_INLINE void visit_candidates(const FlatList& list, const FlatRay& ray, float limit, Test&& test) {
  // First distances with slots in the lowest bits.
  constexpr float kNever = 0x1p126f;
  LaneFloat keys[kFlatBlocks];
  LaneFloat least = broadcast(kNever), second = least;
  for (std::uint32_t i = 0; i < list.block_count; ++i) {
    const FlatBlock& block = list.blocks[i];
    const BlockCoefficients of{block};
    const FlatAxes<LaneFloat> axes(ray, block.axis);
    const auto bounds = bound_hits(of, axes, PlaneCrossing<LaneFloat>::inclined(of, axes));
    const LaneInt key = (bits_of(bounds.first) & ~(kFlatSlots - 1)) | block.slot;
    keys[i] = or_lanes(bounds.rejected, floats_of(key));
    // The order of arguments passes over NaN.
    second = min_lanes(max_lanes(least, keys[i]), second);
    least = min_lanes(keys[i], least);
  }
  for (;;) {
    const float nearest = smallest_lane(least);
    if (!(nearest <= key_limit(limit))) return;
    const std::int32_t slot = std::bit_cast<std::int32_t>(nearest) & (kFlatSlots - 1);
    limit = test(list.polygons[slot]);
    const LaneFloat rest = min_lanes(or_lanes(least == broadcast(nearest), least), second);
    if (lane_bits(rest <= broadcast(key_limit(limit))) == 0) [[likely]]
      return;
    least = second = broadcast(kNever);
    for (std::uint32_t i = 0; i < list.block_count; ++i) {
      const LaneFloat key = or_lanes(keys[i] <= broadcast(nearest), keys[i]);
      second = min_lanes(max_lanes(least, key), second);
      least = min_lanes(key, least);
    }
  }
}

/// Whether the list without `target` blocks the ray, where test(polygon) decides for polygons on which there
/// is doubt.
template <class Test>
MLT_INLINE bool blocks_ray(const FlatList& list, const FlatRay& ray, LaneFloat limit, std::uint32_t target,
                           Test&& test) {
  LaneInt rejected[kFlatBlocks];
  LaneInt all = bits_of(limit) | -1;
  LaneInt sure{};
  for (std::uint32_t i = 0; i < list.block_count; ++i) {
    const FlatBlock& block = list.blocks[i];
    const BlockCoefficients of{block};
    const FlatAxes<LaneFloat> axes(ray, block.axis);
    const auto bounds = bound_hits(of, axes, PlaneCrossing<LaneFloat>::inclined(of, axes), limit,
                                   MaskOf<LaneFloat>(block.primitive == target));
    sure |= bounds.sure;
    all &= bounds.rejected;
    rejected[i] = bounds.rejected;
  }
  if (lane_bits(sure) != 0) return true;
  constexpr unsigned kAll = (1U << kLanes) - 1;
  if (lane_bits(all) == kAll) return false;
  for (std::uint32_t i = 0; i < list.block_count; ++i) {
    unsigned bits = ~lane_bits(rejected[i]) & kAll;
    while (bits != 0) {
      if (test(list.polygons[static_cast<int>(i) * kLanes + take_lowest(bits)])) return true;
    }
  }
  return false;
}

}  // namespace mlt
