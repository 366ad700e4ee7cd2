// What a compiled scene contains, as a bit mask. Kernels are compiled for each mask and chosen once before
// rendering, so that a scene pays neither a branch nor a primary sample for what it does not contain.
#pragma once

#include <cstdint>

namespace mlt {

/// bit, what it means in `mlt info` when present, and when absent.
#define MLT_FEATURES(X)                                                                       \
  X(general_geometry, "spheres or a bounding volume hierarchy", "flat list of polygons only") \
  X(general_materials, "materials other than diffuse", "diffuse materials only")              \
  X(lobe_choice, "materials with several lobes", "no choice between lobes")                   \
  X(many_lights, "several emitting primitives", "at most one emitting primitive")             \
  X(roulette, "Russian roulette", "no Russian roulette")

enum class FeatureBit : std::uint32_t {
#define MLT_ENUMERATE(name, present, absent) name,
  MLT_FEATURES(MLT_ENUMERATE)
#undef MLT_ENUMERATE
      count
};

using FeatureMask = std::uint32_t;

constexpr FeatureMask feature(FeatureBit bit) {
  return FeatureMask{1} << static_cast<std::uint32_t>(bit);
}

// For tools/feature_cost.sh, each the name of a feature: builds that have never heard of one, and builds in
// which every scene pays for one.
#ifdef MLT_WITHOUT_FEATURE
inline constexpr FeatureMask kUnknownFeatures = feature(FeatureBit::MLT_WITHOUT_FEATURE);
#else
inline constexpr FeatureMask kUnknownFeatures = 0;
#endif
#ifdef MLT_ALWAYS_FEATURE
inline constexpr FeatureMask kForcedFeatures = feature(FeatureBit::MLT_ALWAYS_FEATURE);
#else
inline constexpr FeatureMask kForcedFeatures = 0;
#endif

constexpr bool has(FeatureMask mask, FeatureBit bit) {
  return (mask & feature(bit) & ~kUnknownFeatures) != 0;
}
inline constexpr FeatureMask kFeatureMaskCount = FeatureMask{1}
                                                 << static_cast<std::uint32_t>(FeatureBit::count);

/// Whether there is a kernel for it. A choice between lobes exists only among materials other than diffuse.
constexpr bool is_consistent(FeatureMask mask) {
  if ((mask & kUnknownFeatures) != 0) return false;
  return !has(mask, FeatureBit::lobe_choice) || has(mask, FeatureBit::general_materials);
}

}  // namespace mlt
