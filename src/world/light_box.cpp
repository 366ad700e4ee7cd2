#include "world/light_box.hpp"

namespace mlt {
namespace {

void include_box(LightBox& box, const Vec3& low, const Vec3& high) {
  box.longest = std::numeric_limits<float>::max();
  for (float Vec3::*axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
    box.low.*axis = smaller(box.low.*axis, low.*axis - kLightBoxPadding);
    box.high.*axis = larger(box.high.*axis, high.*axis + kLightBoxPadding);
  }
}

}  // namespace

LightBox box_around(std::span<const Light> lights) {
  LightBox box;
  for (const Light& light : lights) {
    if (light.shape == LightShape::kSphere) {
      const Vec3 reach{light.radius, light.radius, light.radius};
      include_box(box, light.origin - reach, light.origin + reach);
      continue;
    }
    const Vec3 end_u = light.origin + light.edge_u;
    for (const Vec3& corner : {light.origin, end_u, light.origin + light.edge_v}) {
      include_box(box, corner, corner);
    }
    if (light.shape == LightShape::kQuad) include_box(box, end_u + light.edge_v, end_u + light.edge_v);
  }
  return box;
}

}  // namespace mlt
