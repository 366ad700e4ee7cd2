// Materials as the world stores them and integrators see them: the compiled parameters, and what evaluating
// and sampling return. All directions are unit vectors in the local frame of the surface (z is the front
// normal) and point away from it; wo leads to where the path comes from (the camera), wi to where radiance
// comes from. Densities are with respect to solid angle. The functions are in material/bsdf.hpp.
#pragma once

#include <cstdint>

#include "math/gather.hpp"
#include "math/vec.hpp"
#include "math/wide.hpp"
#include "scene/description.hpp"

namespace mlt {

/// Compiled parameters; which are meaningful depends on the kind.
struct alignas(64) Material {
  // Rows of four floats, which lanes load together.
  Vec3 reflectance{0, 0, 0};
  float roughness = 0;  ///< GGX alpha; 0 makes the conductor a delta lobe
  Vec3 eta{0, 0, 0};
  float ior = 1;  ///< inside over outside index of refraction
  Vec3 k{0, 0, 0};
  std::uint32_t delta = 0;  ///< 1: all lobes are delta functions
  MaterialKind kind = MaterialKind::diffuse;

  /// True when all its lobes are delta functions, so that light sampling is pointless.
  bool is_delta() const { return delta != 0; }
};

/// The parameters of one material for each lane.
template <class F>
struct WideMaterial {
  F roughness, ior;
  WideVec3<F> reflectance, eta, k;
};

template <class F>
using MaterialOf = std::conditional_t<std::is_same_v<F, float>, Material, WideMaterial<F>>;

/// Where the materials of all lanes lie: row index[i] of a table for lane i.
template <class F>
class MaterialRefOf {
 public:
  MaterialRefOf(const Material* table, UintOf<F> index)
      : table_(table), offset_(index * static_cast<std::uint32_t>(sizeof(Material))) {}
  /// One material for all lanes.
  MaterialRefOf(const Material& material) : table_(&material), offset_(UintOf<F>{}) {}

  MLT_INLINE MaskOf<F> is(MaterialKind kind) const {
    return gather_bytes<F>(&table_->kind, offset_) == static_cast<std::uint32_t>(kind);
  }
  MLT_INLINE MaskOf<F> is_delta() const { return gather_bytes<F>(&table_->delta, offset_) != 0U; }
  /// Loads what is read of the result, provided that it is inlined.
  MLT_INLINE MaterialOf<F> load() const {
    if constexpr (VectorType<F>) {
      const Rows<F> reflectance = gather_rows<F>(&table_->reflectance.x, offset_);
      const Rows<F> eta = gather_rows<F>(&table_->eta.x, offset_);
      const Rows<F> k = gather_rows<F>(&table_->k.x, offset_);
      return {reflectance.column[3],
              eta.column[3],
              {reflectance.column[0], reflectance.column[1], reflectance.column[2]},
              {eta.column[0], eta.column[1], eta.column[2]},
              {k.column[0], k.column[1], k.column[2]}};
    } else {
      return *reinterpret_cast<const Material*>(reinterpret_cast<const std::byte*>(table_) + offset_);
    }
  }

 private:
  const Material* table_;
  UintOf<F> offset_;
};

/// f * |cos theta_i| and the density with which sample_bsdf draws wi; both 0 for delta lobes.
template <class F>
struct BsdfValueOf {
  Vec3Of<F> f_cos{F{}, F{}, F{}};
  F pdf_solid_angle{};
};
using BsdfValue = BsdfValueOf<float>;

/// `weight` is f * |cos theta_i| / pdf (for a delta lobe: its reflectance over its probability). An absorbed
/// sample has weight 0. `pdf_solid_angle` is 0 for a delta lobe and for an absorbed sample.
template <class F>
struct BsdfSampleOf {
  Vec3Of<F> wi{F{}, F{}, broadcast_to<F>(1)};
  Vec3Of<F> weight{F{}, F{}, F{}};
  F pdf_solid_angle{};
  /// (eta_t/eta_i)^2 on refraction, which Russian roulette takes out of the throughput.
  F eta_scale = broadcast_to<F>(1);
  MaskOf<F> is_delta{};
};
using BsdfSample = BsdfSampleOf<float>;

template <class F>
MLT_INLINE BsdfValueOf<F> select(MaskOf<F> mask, const BsdfValueOf<F>& a, const BsdfValueOf<F>& b) {
  return {select(mask, a.f_cos, b.f_cos), select(mask, a.pdf_solid_angle, b.pdf_solid_angle)};
}
template <class F>
MLT_INLINE BsdfSampleOf<F> select(MaskOf<F> mask, const BsdfSampleOf<F>& a, const BsdfSampleOf<F>& b) {
  return {select(mask, a.wi, b.wi), select(mask, a.weight, b.weight),
          select(mask, a.pdf_solid_angle, b.pdf_solid_angle), select(mask, a.eta_scale, b.eta_scale),
          MaskOf<F>((mask & a.is_delta) | (not_in(mask) & b.is_delta))};
}

/// Which primary samples sample_bsdf reads: the choice of a lobe, and the pair for the direction.
struct PrimarySampleUse {
  bool lobe = false;
  bool direction = false;
};

/// Checks the parameters of the description's kind against their ranges and converts them; allocates nothing
/// unless it fails. Throws InputError at the description's location.
Material compile_material(const MaterialDescription& description);

}  // namespace mlt
