// Range checks of material parameters while a scene is compiled. The parser has checked them already, with
// better places for its messages; these make the kernels' assumptions hold for any other source of scenes, by
// the same limits (scene/limits.hpp).
#pragma once

#include "math/vec.hpp"
#include "scene/description.hpp"

namespace mlt {

/// Throws InputError unless low <= value <= high (so also for NaN). `parameter` is the word of the scene
/// file.
void require_in_range(const MaterialDescription& material, const char* parameter, double value, double low,
                      double high);
/// The same for each channel.
void require_in_range(const MaterialDescription& material, const char* parameter, const DVec3& value,
                      double low, double high);

}  // namespace mlt
