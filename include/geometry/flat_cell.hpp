// Cells of a flat list: parallelepipeds of whose faces at least three are polygons of the list, as walls
// of a room are, or the sides of a block. A line enters a cell once and leaves it once, so that many rays
// find the one face that each may meet first with two distances for each pair of planes (wide_cell.hpp),
// without looking at where on the faces they come. Rays one by one take the list's blocks.
//
// Error bounds, in the terms of flat_list.hpp: where the defining test finds a hit on a face, the ray's
// point at some depth s is 6uM or less from a point of the face, by coordinate. All corners of faces lie
// within e of one of a slab's planes, so that points of faces lie between them, to within e. Distances to
// planes as computed are off by less than 14uGM / |det|, or where a plane is crossed farther away than 4M
// / D by a fraction of them, which leaves them on the same side of s. Hence s is between the distances to
// the planes of each slab, to within (20uGM + e) / |det|; those to planes are E, what flat_list.hpp calls
// depth error, with e counted as part of G, which is more. And the distance that the hit is given is
// within E of that to the plane of its face.
//
// Conversely, a ray that crosses the plane of a face 2E or more, of all slabs together, from where it
// crosses the planes of the two other slabs is there 64uGM |det'| / |det| + 64uG'M or more inside of each
// of them (G', det'). It meets the face for sure: the crossing is off by 20uGM / |det| along the ray and
// 6uM by coordinate, and by as much again for corners that are off by 6uM, as the defining test sees them.
#pragma once

#include <cstdint>
#include <span>

#include "math/simd.hpp"

namespace mlt {

/// The space between two parallel planes low <= p_k + n_i p_i + n_j p_j <= high, |n_i| and |n_j| <= 1.
struct CellSlab {
  // Each in all lanes.
  LaneFloat normal_i, normal_j;
  LaneFloat low, high;
  LaneFloat error;     ///< in units of FlatRay::error / |det|
  std::uint32_t axis;  ///< k; i and j follow it cyclically
  bool aligned;        ///< n_i = n_j = 0
};

/// Of a face's word: it lies in a cell. Below are the bits of its slot, above those of its primitive.
inline constexpr std::uint32_t kOfCell = 128;
inline constexpr std::uint32_t kPrimitiveShift = 8;
/// The word of a face that is no polygon, and the least primitive that is not in any cell.
inline constexpr std::uint32_t kOpenFace = 0xffffffffU;
inline constexpr std::uint32_t kCellPrimitives = kOpenFace >> kPrimitiveShift;

struct FlatCell {
  /// Faces 2s and 2s + 1 are those of slab s at its high and its low plane; the rest is never looked up.
  alignas(64) std::uint32_t faces[16];
  CellSlab slabs[3];
};

inline constexpr std::uint32_t kFlatCells = 16;
inline constexpr std::uint32_t kLeastFacesOfCell = 3;

struct FlatPolygon;

/// Writes cells of the polygons of a list, in the order of their first ones, up to cells.size(), and returns
/// how many. `slots` says where in `polygons` there are any, `in_cell` for each place whether it is in a
/// cell. No coordinate is beyond `extent`.
std::uint32_t find_cells(std::span<const FlatPolygon> polygons, std::span<const std::uint32_t> slots,
                         float extent, std::span<FlatCell> cells, std::span<bool> in_cell);

}  // namespace mlt
