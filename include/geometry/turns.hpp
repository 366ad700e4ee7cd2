// Rays that take turns. A ray on its way through a hierarchy of a million triangles waits for memory most of
// the time; where a group of rays is to be traced, others go on meanwhile.
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <type_traits>
#include <utility>

#include "geometry/ray.hpp"
#include "math/simd.hpp"

namespace mlt {

/// Rays on their way at a time. Four gain half of what eight do (docs/MEASUREMENTS.md).
inline constexpr int kTurns = 8;
/// Hierarchies of fewer triangles, about 20 MB, lie in caches for the most part; rays are faster one by one.
inline constexpr std::uint32_t kLeastForTurns = 1U << 18;

/// Rays one by one. All are written before the first is traced: what reads a ray by vectors would wait for
/// what was just written by components.
template <class F>
class LaneRays {
 public:
  MLT_INLINE LaneRays(const RayOf<F>& ray, const MaskOf<F>& active) {
    for_lanes(active, [&](int lane) { new (place_[lane]) Ray(lane_of(ray, lane)); });
  }
  MLT_INLINE const Ray& operator[](int lane) const {
    return *std::launder(reinterpret_cast<const Ray*>(place_[lane]));
  }

 private:
  /// Rays that nobody asks for are not even cleared.
  alignas(Ray) std::byte place_[kLaneCount<F>][sizeof(Ray)];
};

/// Traces the ray of each lane whose bit is set: make(place, lane) constructs its way there and returns it,
/// then step(way) is called until it returns false, for several ways in turn.
template <class Way, class Make, class Step>
MLT_INLINE void take_turns(unsigned lanes, Make&& make, Step&& step) {
  static_assert(std::is_trivially_destructible_v<Way>);
  alignas(Way) std::byte storage[kTurns][sizeof(Way)];
  Way* ways[kTurns];
  int count = 0;
  for (; count < kTurns && lanes != 0; ++count) ways[count] = make(storage[count], take_lowest(lanes));
  while (count > 0) {
    for (int i = 0; i < count;) {
      if (step(*ways[i])) {
        ++i;
      } else if (lanes != 0) {
        make(reinterpret_cast<std::byte*>(ways[i]), take_lowest(lanes));
        ++i;
      } else {
        std::swap(ways[i], ways[--count]);
      }
    }
  }
}

}  // namespace mlt
