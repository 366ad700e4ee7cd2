// The queries of class Geometry for rays in lanes; included by geometry_inline.hpp alone. Flat lists meet all
// lanes' rays together, hierarchies then one ray after the other, or several in turn.
#pragma once

#include "geometry/geometry.hpp"
#include "geometry/turns.hpp"
#include "geometry/wide_flat.hpp"
#include "geometry/wide_sphere.hpp"

namespace mlt {

/// The closest hits of rays in the hierarchy of triangles, and of those that lists have found.
template <class F, class Record>
MLT_NOINLINE void Geometry::intersect_triangles(const LaneRays<F>& rays, const MaskOf<F>& active,
                                                const Record* records, HitOf<F>& hits) const {
  if (!takes_turns()) {
    for_lanes(active, [&](int lane) {
      BestHit best(lane_of(hits, lane), rays[lane].t_max);
      best.visit_list(triangles_, RayFrame(rays[lane], extent_));
      set_lane_of(hits, lane, best.hit);
    });
    return;
  }
  struct Way {
    int lane;
    RayFrame frame;
    BestHit best;
    ClosestWalk walk{};
  };
  take_turns<Way>(
      lanes_of(active),
      [&](std::byte* place, int lane) {
        const Ray& ray = rays[lane];
        return new (place) Way{lane, RayFrame(ray, extent_), BestHit(lane_of(hits, lane), ray.t_max)};
      },
      [&](Way & way) __attribute__((always_inline)) {
        if (way.best.template step<Fetch::ahead>(way.walk, triangles_, way.frame)) return true;
        set_lane_of(hits, way.lane, way.best.hit);
        if (records != nullptr && way.best.hit.found()) __builtin_prefetch(records + way.best.hit.primitive);
        return false;
      });
}

/// Which rays triangles block, likewise.
template <class F>
MLT_NOINLINE MaskOf<F> Geometry::triangles_occlude(const LaneRays<F>& rays, const UintOf<F>& targets,
                                                   const MaskOf<F>& active) const {
  MaskOf<F> blocked{};
  if (!takes_turns()) {
    for_lanes(active, [&](int lane) {
      const Ray& ray = rays[lane];
      if (list_occluded(triangles_, RayFrame(ray, extent_), broadcast(ray.t_max), lane_of(targets, lane)))
        set_lane_of(blocked, lane, kLaneTrue<F>);
    });
    return blocked;
  }
  struct Way {
    int lane;
    std::uint32_t target;
    RayFrame frame;
    LaneFloat limit;
    AnyWalk walk{};
  };
  take_turns<Way>(
      lanes_of(active),
      [&](std::byte* place, int lane) {
        const Ray& ray = rays[lane];
        return new (place) Way{lane, lane_of(targets, lane), RayFrame(ray, extent_), broadcast(ray.t_max)};
      },
      [&](Way & way) __attribute__((always_inline)) {
        const AnyWalk::Step step =
            step_to_any<Fetch::ahead>(way.walk, triangles_, way.frame, way.limit, way.target);
        if (step == AnyWalk::Step::found) set_lane_of(blocked, way.lane, kLaneTrue<F>);
        return step == AnyWalk::Step::goes_on;
      });
  return blocked;
}

template <bool kGeneral, class F, class Record>
MLT_NOINLINE HitOf<F> Geometry::intersect_lanes(const RayOf<F>& ray, const UintOf<F>& leaves,
                                                const MaskOf<F>& active, const Record* records) const {
  HitOf<F> hits;
  MaskOf<F> alone = active;
  if constexpr (VectorType<F>) {
    if (has_lanes<kGeneral>()) {
      alone = MaskOf<F>{};
      if (!flat_lists_.empty()) hits = intersect_flat<F>(flat_lists_[0], ray, extent_, leaves, active, alone);
      if constexpr (kGeneral) {
        if (spheres_.block_count > 0)
          intersect_spheres<F>(spheres_.blocks, spheres_.block_count, ray, extent_, hits);
        const MaskOf<F> rest = active & not_in(alone);
        if (triangles_.block_count > 0) intersect_triangles<F>(LaneRays<F>(ray, rest), rest, records, hits);
      }
    }
  }
  if (!any(alone)) return hits;
  const LaneRays<F> rays(ray, alone);
  for_lanes(alone, [&](int lane) { set_lane_of(hits, lane, intersect<kGeneral>(rays[lane])); });
  return hits;
}

template <bool kGeneral, class F>
MLT_NOINLINE MaskOf<F> Geometry::occluded_lanes(const RayOf<F>& ray, const SegmentEnds<F>& ends,
                                                const MaskOf<F>& active) const {
  MaskOf<F> blocked{};
  MaskOf<F> alone = active;
  if constexpr (VectorType<F>) {
    if (has_lanes<kGeneral>()) {
      alone = MaskOf<F>{};
      if (!flat_lists_.empty()) blocked = flat_occludes<F>(flat_lists_[0], ray, extent_, ends, active, alone);
      if constexpr (kGeneral) {
        if (spheres_.block_count > 0)
          blocked |= spheres_occlude<F>(spheres_.blocks, spheres_.block_count, ray, extent_);
        const MaskOf<F> rest = active & not_in(MaskOf<F>(alone | blocked));
        if (triangles_.block_count > 0 && any(rest))
          blocked |= triangles_occlude<F>(LaneRays<F>(ray, rest), ends.target, rest);
      }
    }
  }
  if (!any(alone)) return blocked;
  const LaneRays<F> rays(ray, alone);
  for_lanes(alone, [&](int lane) {
    if (occluded<kGeneral>(rays[lane], lane_of(ends.target, lane))) set_lane_of(blocked, lane, kLaneTrue<F>);
  });
  return blocked;
}

template <bool kGeneral, class F>
MLT_NOINLINE SurfacePointOf<F> Geometry::surface_points(const RayOf<F>& ray, const HitOf<F>& hits,
                                                        const MaskOf<F>& active) const {
  SurfacePointOf<F> points;
  MaskOf<F> alone = active;
  if constexpr (VectorType<F>) {
    if (has_lanes<kGeneral>()) {
      if (!flat_lists_.empty()) points = flat_points<F>(flat_lists_[0], hits);
      if constexpr (!kGeneral) return points;
      const MaskOf<F> on_sphere = active & hits.found() & (hits.primitive >= first_sphere_);
      if (any(on_sphere)) {
        const SurfacePointOf<F> round = sphere_points<F>(spheres_.blocks, ray, hits, on_sphere);
        points.position = select(on_sphere, round.position, points.position);
        points.normal = select(on_sphere, round.normal, points.normal);
        points.offset_bound = select(on_sphere, round.offset_bound, points.offset_bound);
      }
      alone = active & (hits.primitive >= first_in_triangles_) & (hits.primitive < first_sphere_);
    }
  }
  for_lanes(alone, [&](int lane) {
    const SurfacePoint point = surface_point<kGeneral>(lane_of(ray, lane), lane_of(hits, lane));
    set_lane_of(points.position, lane, point.position);
    set_lane_of(points.normal, lane, point.normal);
    set_lane_of(points.offset_bound, lane, point.offset_bound);
  });
  return points;
}

}  // namespace mlt
