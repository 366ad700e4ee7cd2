#include "geometry/flat_cell.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/flat_list.hpp"

namespace mlt {
namespace {

/// Corners closer than this times the extent, by coordinate, count as one. What they are off is part of the
/// slabs' errors.
constexpr double kSameCorner = 0x1p-18;

/// Cells are so many times as thick.
constexpr double kLeastThickness = 64;

struct Face {
  DVec3 corners[4];
};

bool are_near(const DVec3& a, const DVec3& b, double distance) {
  return std::fabs(a.x - b.x) <= distance && std::fabs(a.y - b.y) <= distance &&
         std::fabs(a.z - b.z) <= distance;
}

Face face_of(const FlatPolygon& polygon) {
  Face face;
  for (int vertex = 0; vertex < 4; ++vertex) {
    for (int axis = 0; axis < 3; ++axis)
      face.corners[vertex][axis] = double{polygon.quad.corners[axis][vertex]};
  }
  return face;
}

bool is_parallelogram(const Face& f, double same) {
  return are_near(f.corners[0] + f.corners[2], f.corners[1] + f.corners[3], same);
}

/// The same corners in the same order, from any of them on, either way round.
bool are_same(const Face& p, const Face& q, double same) {
  for (int start = 0; start < 4; ++start) {
    for (const int step : {1, 3}) {
      bool all = true;
      for (int i = 0; i < 4 && all; ++i)
        all = are_near(p.corners[(start + step * i) % 4], q.corners[i], same);
      if (all) return true;
    }
  }
  return false;
}

/// A corner and the edges from there.
struct Parallelepiped {
  DVec3 corner{0, 0, 0}, edges[3] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};

  /// Face 2s + 1 is that of edge s, face 2s the one opposite to it.
  Face face(std::uint32_t index) const {
    const std::uint32_t s = index / 2;
    const DVec3 from = index % 2 == 1 ? corner + edges[s] : corner;
    const DVec3 &u = edges[(s + 1) % 3], &v = edges[(s + 2) % 3];
    return {{from, from + u, from + u + v, from + v}};
  }
  /// Whether all opposite faces are farther apart than this.
  bool is_thicker_than(double distance) const {
    const double volume = std::fabs(dot(cross(edges[0], edges[1]), edges[2]));
    bool thicker = true;
    for (std::uint32_t s = 0; s < 3; ++s)
      thicker = thicker && volume > distance * length(cross(edges[(s + 1) % 3], edges[(s + 2) % 3]));
    return thicker;
  }
};

/// The parallelepiped of a face and of a second one with which it shares an edge. Returns whether there is
/// one.
bool span(const Face& base, const Face& side, double same, Parallelepiped& result) {
  bool shared[4];
  int count = 0;
  for (int i = 0; i < 4; ++i) {
    shared[i] = std::any_of(std::begin(base.corners), std::end(base.corners),
                            [&](const DVec3& corner) { return are_near(side.corners[i], corner, same); });
    count += shared[i] ? 1 : 0;
  }
  if (count != 2) return false;
  for (int i = 0; i < 4; ++i) {
    const int next = (i + 1) % 4;
    if (shared[i] == shared[next]) continue;
    const DVec3 along = side.corners[next] - side.corners[i];
    result = {base.corners[0],
              {base.corners[1] - base.corners[0], base.corners[3] - base.corners[0],
               shared[i] ? along : DVec3{0, 0, 0} - along}};
    return result.is_thicker_than(kLeastThickness * same);
  }
  return false;
}

/// Looks for cells among polygons that are not in one yet.
class CellFinder {
 public:
  CellFinder(std::span<const FlatPolygon> polygons, std::span<const std::uint32_t> slots, float extent,
             std::span<bool> in_cell)
      : polygons_(polygons),
        slots_(slots),
        extent_(extent),
        same_(kSameCorner * double{extent}),
        in_cell_(in_cell) {
    for (const std::uint32_t slot : slots) faces_[slot] = face_of(polygons[slot]);
  }

  /// The cell with the most faces of which the polygon in `slot` is one. Returns how many it has.
  std::uint32_t best_at(std::uint32_t slot, Parallelepiped& best, std::uint32_t (&faces)[6]) const {
    std::uint32_t most = 0;
    if (!is_free(slot)) return 0;
    for (const std::uint32_t other : slots_) {
      Parallelepiped candidate;
      if (other == slot || !is_free(other) || !span(faces_[slot], faces_[other], same_, candidate)) continue;
      std::uint32_t found[6] = {};
      const std::uint32_t count = match(candidate, found);
      if (count <= most) continue;
      most = count;
      best = candidate;
      std::copy_n(found, 6, faces);
    }
    return most;
  }

  FlatCell make(const Parallelepiped& shape, const std::uint32_t (&faces)[6]) const {
    FlatCell cell{};
    std::fill(std::begin(cell.faces), std::end(cell.faces), kOpenFace);
    for (std::uint32_t s = 0; s < 3; ++s) {
      const bool turned = set_slab(cell.slabs[s], shape, s, faces);
      for (std::uint32_t side = 0; side < 2; ++side) {
        const std::uint32_t slot = faces[2 * s + side];
        if (slot == kOpenFace) continue;
        const std::uint32_t word = polygons_[slot].quad.primitive << kPrimitiveShift | kOfCell | slot;
        cell.faces[2 * s + (turned ? side : 1 - side)] = word;
      }
    }
    return cell;
  }

 private:
  bool is_free(std::uint32_t slot) const {
    return !in_cell_[slot] && polygons_[slot].quad.primitive < kCellPrimitives &&
           is_parallelogram(faces_[slot], same_);
  }

  /// The polygons at the faces of a parallelepiped, or kOpenFace; returns how many there are.
  std::uint32_t match(const Parallelepiped& shape, std::uint32_t (&found)[6]) const {
    std::uint32_t count = 0;
    for (std::uint32_t index = 0; index < 6; ++index) {
      const Face face = shape.face(index);
      const auto* const slot =
          std::find_if(slots_.data(), slots_.data() + slots_.size(),
                       [&](std::uint32_t i) { return is_free(i) && are_same(faces_[i], face, same_); });
      const bool is_there = slot != slots_.data() + slots_.size();
      found[index] = is_there ? *slot : kOpenFace;
      count += is_there ? 1 : 0;
    }
    return count;
  }

  /// Returns whether the low plane is that of face 2s + 1.
  bool set_slab(CellSlab& slab, const Parallelepiped& shape, std::uint32_t s,
                const std::uint32_t (&faces)[6]) const {
    const DVec3 normal = cross(shape.edges[(s + 1) % 3], shape.edges[(s + 2) % 3]);
    const DVec3 size{std::fabs(normal.x), std::fabs(normal.y), std::fabs(normal.z)};
    const int k = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    slab.axis = static_cast<std::uint32_t>(k);
    const auto normal_i = static_cast<float>(normal[i] / normal[k]);
    const auto normal_j = static_cast<float>(normal[j] / normal[k]);
    slab.aligned = normal_i == 0.0f && normal_j == 0.0f;

    const auto height = [&](const DVec3& p) {
      return (p[k] + double{normal_i} * p[i]) + double{normal_j} * p[j];
    };
    const double from = height(shape.corner), to = height(shape.corner + shape.edges[s]);
    const auto low = static_cast<float>(std::min(from, to)), high = static_cast<float>(std::max(from, to));
    double spread = 0, weight_error = 0;
    for (std::uint32_t index = 0; index < 6; ++index) {
      if (faces[index] == kOpenFace) continue;
      const Face& face = faces_[faces[index]];
      for (const DVec3& corner : face.corners) {
        const double at = height(corner);
        spread = std::max(spread, std::min(std::fabs(at - double{low}), std::fabs(at - double{high})));
      }
      if (index / 2 == s)
        weight_error = std::max(weight_error, depth_weight_error(face.corners, k, double{extent_}));
    }
    const double error =
        ((1 + std::fabs(normal_i)) + std::fabs(normal_j)) + spread / (6 * 0x1p-24 * double{extent_});
    slab.normal_i = broadcast(normal_i);
    slab.normal_j = broadcast(normal_j);
    slab.low = broadcast(low);
    slab.high = broadcast(high);
    slab.error = broadcast(static_cast<float>((error + weight_error) * (1 + 0x1p-20)));
    return from > to;
  }

  std::span<const FlatPolygon> polygons_;
  std::span<const std::uint32_t> slots_;
  float extent_;
  double same_;
  std::span<bool> in_cell_;
  Face faces_[kFlatSlots];
};

}  // namespace

std::uint32_t find_cells(std::span<const FlatPolygon> polygons, std::span<const std::uint32_t> slots,
                         float extent, std::span<FlatCell> cells, std::span<bool> in_cell) {
  std::fill(in_cell.begin(), in_cell.end(), false);
  const CellFinder finder(polygons, slots, extent, in_cell);
  std::uint32_t count = 0;
  for (const std::uint32_t slot : slots) {
    Parallelepiped shape;
    std::uint32_t faces[6] = {};
    if (count == cells.size() || finder.best_at(slot, shape, faces) < kLeastFacesOfCell) continue;
    cells[count++] = finder.make(shape, faces);
    for (const std::uint32_t face : faces) {
      if (face != kOpenFace) in_cell[face] = true;
    }
  }
  return count;
}

}  // namespace mlt
