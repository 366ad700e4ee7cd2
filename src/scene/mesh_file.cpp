#include "scene/mesh_file.hpp"

#include <algorithm>
#include <cmath>

#include "scene/limits.hpp"

namespace mlt {

bool is_degenerate(const DVec3& a, const DVec3& b, const DVec3& c) {
  const DVec3 ab = b - a;
  const DVec3 ac = c - a;
  const DVec3 bc = c - b;
  const double longest = std::sqrt(std::max({dot(ab, ab), dot(ac, ac), dot(bc, bc)}));
  if (!(longest >= kMinLength)) return true;
  // Height over longest edge, from edges of about unit length so that nothing underflows.
  const double doubled_area = length(cross(ab / longest, ac / longest));
  return !(doubled_area > kDegenerateHeight);
}

bool append_fan(std::span<const std::uint32_t> corners, const std::vector<DVec3>& vertices,
                std::vector<std::uint32_t>& indices) {
  bool regular = true;
  DVec3 first_normal{0, 0, 0};
  for (std::size_t i = 2; i < corners.size(); ++i) {
    indices.insert(indices.end(), {corners[0], corners[i - 1], corners[i]});
    if (corners.size() == 3) continue;
    const DVec3& origin = vertices[corners[0]];
    const DVec3 normal = cross(vertices[corners[i - 1]] - origin, vertices[corners[i]] - origin);
    if (dot(first_normal, first_normal) == 0) first_normal = normal;
    regular = regular && !(dot(first_normal, normal) < 0);
  }
  return regular;
}

}  // namespace mlt
