// Embree on the same triangles and rays, in its default mode, as a measure of what a ray costs on this
// machine. Present when libembree-dev was installed at build time.
#pragma once

#if __has_include(<embree3/rtcore.h>)
#define MLT_HAS_EMBREE 1
#include <embree3/rtcore.h>

#include <chrono>
#include <string>
#include <vector>

#include "geometry/ray.hpp"
#include "geometry/shapes.hpp"

namespace mlt::test {

class EmbreeScene {
 public:
  explicit EmbreeScene(const std::vector<Triangle>& triangles, unsigned threads = 1)
      : device_(rtcNewDevice(("threads=" + std::to_string(threads)).c_str())), scene_(rtcNewScene(device_)) {
    const RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* corners = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 3 * triangles.size()));
    auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), triangles.size()));
    for (const Triangle& t : triangles) {
      for (const Vec3& corner : {t.a, t.b, t.c}) {
        for (int axis = 0; axis < 3; ++axis) *corners++ = corner[axis];
      }
    }
    for (unsigned i = 0; i < 3 * triangles.size(); ++i) indices[i] = i;
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    const auto start = std::chrono::steady_clock::now();
    rtcCommitScene(scene_);
    build_seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  ~EmbreeScene() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  bool intersect(const Ray& ray) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit query;
    query.ray = embree_ray(ray);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &context, &query);
    return query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
  }
  bool occluded(const Ray& ray) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRay query = embree_ray(ray);
    rtcOccluded1(scene_, &context, &query);
    return query.tfar < 0;
  }

  /// Of the clock on the wall.
  double build_seconds() const { return build_seconds_; }

 private:
  static RTCRay embree_ray(const Ray& ray) {
    RTCRay query{};
    query.org_x = ray.origin.x;
    query.org_y = ray.origin.y;
    query.org_z = ray.origin.z;
    query.dir_x = ray.direction.x;
    query.dir_y = ray.direction.y;
    query.dir_z = ray.direction.z;
    query.tfar = ray.t_max;
    query.mask = ~0U;
    return query;
  }

  RTCDevice device_;
  RTCScene scene_;
  double build_seconds_ = 0;
};

}  // namespace mlt::test
#endif
