// What a scene asks for beyond what numbers resolve. Positions are read in double and rendered in float,
// relative to the scene's own size and place; radiances are rendered in float. Inside the ranges of
// docs/STABILITY.md neither shows; outside a warning says what is lost.
#pragma once

#include <string>
#include <vector>

#include "scene/description.hpp"
#include "scene/diagnostics.hpp"

namespace mlt {

/// Warns of scenes so far from the origin that double positions are coarser than float ones near it, of a
/// camera so far from the scene that its rays are, of shapes so small or lights so narrow that rounded
/// corners change them by a percent, and of lights so dim that PSSMLT may take them for black.
void warn_of_lost_precision(const SceneDescription& scene, DiagnosticCollector& diagnostics);

/// For vertices that a file stores as 32-bit floats: a warning when these are much coarser than the mesh, for
/// it lies far from the origin; empty otherwise.
std::string warning_of_coarse_floats(const std::vector<DVec3>& vertices);

}  // namespace mlt
