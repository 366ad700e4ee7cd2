#include "geometry/flat_list.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mlt {
namespace {

constexpr double kRoundoff = 0x1p-24;

/// Not below `value`, which is positive.
float rounded_up(double value) {
  return static_cast<float>(value * (1 + 2 * kRoundoff));
}

double largest_component(const DVec3& v) {
  return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
}

/// An affine function of two coordinates.
struct Functional {
  double i, j, at_0;  ///< i p_i + j p_j - at_0

  double operator()(double p_i, double p_j) const { return (i * p_i + j * p_j) - at_0; }
  double reach() const { return std::fabs(i) + std::fabs(j); }
};

/// Moved and scaled so that its values at the corners range from -1/2 to 1/2.
Functional centred(const Functional& f, const double (&p_i)[4], const double (&p_j)[4]) {
  double low = f(p_i[0], p_j[0]), high = low;
  for (int corner = 1; corner < 4; ++corner) {
    low = std::min(low, f(p_i[corner], p_j[corner]));
    high = std::max(high, f(p_i[corner], p_j[corner]));
  }
  const double scale = 1.0 / (high - low);
  return {f.i * scale, f.j * scale, (f.at_0 + 0.5 * (low + high)) * scale};
}

DVec3 area_vector(const DVec3& a, const DVec3& b, const DVec3& c) {
  return cross(b - a, c - a);
}
DVec3 area_vector(const Vec3& a, const Vec3& b, const Vec3& c) {
  return area_vector(DVec3{a}, DVec3{b}, DVec3{c});
}

void clear_block(FlatBlock& block, std::uint32_t index, int axis) {
  block = FlatBlock{};
  block.axis = static_cast<std::uint32_t>(axis);
  block.position_error = broadcast(std::numeric_limits<float>::infinity());
  block.inner = -block.position_error;
  for (int lane = 0; lane < kLanes; ++lane) {
    block.slot[lane] = static_cast<std::int32_t>(index) * kLanes + lane;
  }
}

/// A quad in the axes of its block.
struct Layout {
  double n_i, n_j, offset;  ///< the plane of a, b, c
  double p_i[4], p_j[4];    ///< corners
  double off_plane = 0;     ///< greatest distance of a corner from the plane, along k

  Layout(const Quad& q, int k, int i, int j) {
    const DVec3 corners[4] = {DVec3{q.a}, DVec3{q.b}, DVec3{q.c}, DVec3{q.d}};
    const DVec3 n = area_vector(q.a, q.b, q.c);
    n_i = n[i] / n[k];
    n_j = n[j] / n[k];
    offset = (corners[0][k] + n_i * corners[0][i]) + n_j * corners[0][j];
    for (int vertex = 0; vertex < 4; ++vertex) {
      const DVec3& p = corners[vertex];
      p_i[vertex] = p[i];
      p_j[vertex] = p[j];
      off_plane = std::max(off_plane, std::fabs(((p[k] + n_i * p[i]) + n_j * p[j]) - offset));
    }
  }
};

/// The coordinates U and V, of p - a in the edges b - a and c - b.
struct Square {
  Functional u{}, v{};
  double off_corner = 0;  ///< how far corners are off those of the square

  explicit Square(const Layout& at) {
    const double a_i = at.p_i[1] - at.p_i[0], a_j = at.p_j[1] - at.p_j[0];
    const double b_i = at.p_i[2] - at.p_i[1], b_j = at.p_j[2] - at.p_j[1];
    const double area = a_i * b_j - a_j * b_i;
    u = centred({b_j / area, -b_i / area, 0}, at.p_i, at.p_j);
    v = centred({-a_j / area, a_i / area, 0}, at.p_i, at.p_j);
    constexpr double kCorners[4][2] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
    for (int vertex = 0; vertex < 4; ++vertex) {
      off_corner = std::max({off_corner, std::fabs(u(at.p_i[vertex], at.p_j[vertex]) - kCorners[vertex][0]),
                             std::fabs(v(at.p_i[vertex], at.p_j[vertex]) - kCorners[vertex][1])});
    }
  }
};

void set_lane(FlatBlock& block, int lane, const Quad& q, double extent) {
  const auto k = static_cast<int>(block.axis);
  const Layout at(q, k, (k + 1) % 3, (k + 2) % 3);
  const Square square(at);
  const Functional &u = square.u, &v = square.v;

  const double plane_error =
      ((1 + std::fabs(at.n_i)) + std::fabs(at.n_j)) + at.off_plane / (6 * kRoundoff * extent);
  const DVec3 corners[4] = {DVec3{q.a}, DVec3{q.b}, DVec3{q.c}, DVec3{q.d}};
  const double weight_error = depth_weight_error(corners, k, extent);
  const double reach = std::max(u.reach(), v.reach());

  block.normal_i[lane] = static_cast<float>(at.n_i);
  block.normal_j[lane] = static_cast<float>(at.n_j);
  block.offset[lane] = static_cast<float>(at.offset);
  block.u_i[lane] = static_cast<float>(u.i);
  block.u_j[lane] = static_cast<float>(u.j);
  block.u_0[lane] = static_cast<float>(-u.at_0);
  block.v_i[lane] = static_cast<float>(v.i);
  block.v_j[lane] = static_cast<float>(v.j);
  block.v_0[lane] = static_cast<float>(-v.at_0);
  block.plane_error[lane] = rounded_up(plane_error * (14.1 / 32));
  block.depth_error[lane] = -rounded_up(plane_error + weight_error);
  block.position_error[lane] = -rounded_up(reach * plane_error);
  block.inner[lane] = square.off_corner < 0.01 ? static_cast<float>(0.5 - 2 * square.off_corner) : -1.0f;
}

/// Copies lane `from` of one block to lane `to` of another.
void copy_lane(const FlatBlock& source, int from, FlatBlock& block, int to) {
  constexpr LaneFloat FlatBlock::*kCoefficients[] = {
      &FlatBlock::normal_i, &FlatBlock::normal_j,    &FlatBlock::offset,      &FlatBlock::u_i,
      &FlatBlock::u_j,      &FlatBlock::u_0,         &FlatBlock::v_i,         &FlatBlock::v_j,
      &FlatBlock::v_0,      &FlatBlock::plane_error, &FlatBlock::depth_error, &FlatBlock::position_error,
      &FlatBlock::inner};
  for (const auto coefficient : kCoefficients) (block.*coefficient)[to] = (source.*coefficient)[from];
  block.slot[to] = source.slot[from];
  block.primitive[to] = source.primitive[from];
}

}  // namespace

double depth_weight_error(const DVec3 (&corners)[4], int k, double extent) {
  DVec3 low = corners[0], high = corners[0];
  for (const DVec3& corner : corners) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], corner[axis]);
      high[axis] = std::max(high[axis], corner[axis]);
    }
  }
  const double size = largest_component(high - low);
  // A second triangle without area is never hit.
  const double other = std::fabs(area_vector(corners[0], corners[2], corners[3])[k]);
  double smallest = std::fabs(area_vector(corners[0], corners[1], corners[2])[k]);
  if (other != 0) smallest = std::min(smallest, other);
  return 48.0 / 32.0 * size * size * (size / smallest) / extent;
}

int FlatListBuilder::axis_of(const Quad& q) {
  const DVec3 n = area_vector(q.a, q.b, q.c);
  const DVec3 size{std::fabs(n.x), std::fabs(n.y), std::fabs(n.z)};
  return size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
}

bool FlatListBuilder::is_aligned(const Quad& q) {
  const int k = axis_of(q), i = (k + 1) % 3, j = (k + 2) % 3;
  const Layout at(q, k, i, j);
  return static_cast<float>(at.n_i) == 0.0f && static_cast<float>(at.n_j) == 0.0f;
}

FlatListBuilder::FlatListBuilder(FlatList& list, std::uint32_t first_slot, float extent)
    : list_(list), first_slot_(first_slot), extent_(extent) {}

void FlatListBuilder::add(int axis, const Quad& quad, const FlatPolygon& polygon) {
  if (axis != axis_) finish_axis();
  axis_ = axis;
  MLT_CHECK_OP(slot_, <, std::uint32_t{kFlatSlots});
  FlatBlock& block = list_.blocks[slot_ / kLanes];
  if (slot_ % kLanes == 0) clear_block(block, slot_ / kLanes, axis);
  const auto lane = static_cast<int>(slot_ % kLanes);
  set_lane(block, lane, quad, double{extent_});
  if (block.normal_i[lane] == 0.0f && block.normal_j[lane] == 0.0f) {
    MLT_CHECK_OP(block.aligned, ==, slot_ % kLanes);
    ++block.aligned;
  }
  block.primitive[lane] = polygon.quad.primitive;
  block.used = slot_ % kLanes + 1;
  list_.polygons[slot_] = polygon;
  list_.polygons[slot_].slot = first_slot_ + slot_;
  list_.columns.set(slot_, list_.polygons[slot_]);
  ++slot_;
}

void FlatListBuilder::finish() {
  finish_axis();
  find_cells();
}

void FlatListBuilder::finish_axis() {
  for (; slot_ % kLanes != 0; ++slot_) list_.polygons[slot_] = FlatPolygon{};
  list_.block_count = slot_ / kLanes;
}

void FlatListBuilder::find_cells() {
  std::uint32_t slots[kFlatSlots];
  std::uint32_t count = 0;
  for (std::uint32_t slot = 0; slot < slot_; ++slot) {
    const FlatBlock& block = list_.blocks[slot / kLanes];
    if (slot % kLanes < block.used) slots[count++] = slot;
  }
  bool in_cell[kFlatSlots];
  list_.cell_count = mlt::find_cells(list_.polygons, {slots, count}, extent_, list_.cells, in_cell);
  list_.cell_axes = 0;
  for (std::uint32_t cell = 0; cell < list_.cell_count; ++cell) {
    for (const CellSlab& slab : list_.cells[cell].slabs)
      list_.cell_axes |= slab.aligned ? 1U << slab.axis : 0U;
  }
  list_.loose_count = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (!in_cell[slots[i]]) add_loose(slots[i]);
  }
}

/// The order of blocks, by axes and with the aligned polygons first, is that of loose ones too.
void FlatListBuilder::add_loose(std::uint32_t slot) {
  const FlatBlock& source = list_.blocks[slot / kLanes];
  const auto lane = static_cast<int>(slot % kLanes);
  FlatBlock* block = list_.loose_count > 0 ? &list_.loose[list_.loose_count - 1] : nullptr;
  if (block == nullptr || block->axis != source.axis || block->used == kLanes) {
    block = &list_.loose[list_.loose_count++];
    clear_block(*block, 0, static_cast<int>(source.axis));
  }
  const bool is_aligned = slot % kLanes < source.aligned;
  MLT_CHECK(!is_aligned || block->aligned == block->used);
  copy_lane(source, lane, *block, static_cast<int>(block->used));
  ++block->used;
  if (is_aligned) ++block->aligned;
}

}  // namespace mlt
