// Every limit that scene, OBJ and PLY files meet, in one place. They bound the reader's time and memory
// whatever a file says; each lies far above what a real scene needs. docs/SCENES.md repeats them.
#pragma once

#include <cstddef>
#include <cstdint>

namespace mlt {

// Files.
inline constexpr std::uint64_t kMaxSceneFileBytes = std::uint64_t{64} << 20;  ///< one scene or include file
inline constexpr std::uint64_t kMaxMeshFileBytes = std::uint64_t{4} << 30;    ///< one OBJ or PLY file
inline constexpr std::uint64_t kMaxTotalFileBytes = std::uint64_t{8} << 30;   ///< all files of one scene
inline constexpr std::uint32_t kMaxFiles = 1024;       ///< files read for one scene, repeats included
inline constexpr std::uint32_t kMaxIncludeDepth = 16;  ///< the scene file itself is at depth 1

// Text.
inline constexpr std::size_t kMaxLineBytes = 65536;
inline constexpr std::size_t kMaxTokenBytes = 1024;
inline constexpr std::size_t kMaxStatementTokens = 1024;  ///< after constants are replaced
inline constexpr std::uint32_t kMaxConstants = 4096;

// Reports.
inline constexpr std::size_t kMaxDiagnostics = 20;  ///< errors collected before the reader gives up
inline constexpr std::size_t kMaxWarnings = 50;     ///< kept one by one; more are only counted

// Counts.
inline constexpr std::uint32_t kMaxMaterials = 65536;
inline constexpr std::uint32_t kMaxShapes = std::uint32_t{1} << 22;         ///< polygons, spheres and meshes
inline constexpr std::uint32_t kMaxMeshVertices = std::uint32_t{1} << 26;   ///< over all meshes
inline constexpr std::uint32_t kMaxMeshTriangles = std::uint32_t{1} << 26;  ///< over all meshes
inline constexpr std::uint32_t kMaxPlyElements = 32;                        ///< kinds of element in a header
inline constexpr std::uint32_t kMaxPlyProperties = 256;                     ///< of one kind of element
inline constexpr std::uint32_t kMaxPolygonCorners = 1024;                   ///< of one face of a mesh file

// Values. A length is in the scene's own unit.
inline constexpr std::uint32_t kMaxPathEdges = 256;
inline constexpr std::uint32_t kMaxFilmSidePixels = 65536;
inline constexpr double kMaxCoordinate = 1e18;  ///< of a position, after transforms
inline constexpr double kMinLength = 1e-30;   ///< shapes with a smaller longest edge or radius are degenerate
inline constexpr double kMaxRadiance = 1e12;  ///< W/(m^2 sr), per channel
inline constexpr double kMinFovDegrees = 0.001;
inline constexpr double kMaxFovDegrees = 179;
inline constexpr double kMaxIor = 3;
inline constexpr double kMinRoughness = 1e-5;  ///< or exactly 0
inline constexpr double kMinConductorEta = 1e-3;
inline constexpr double kMaxConductorEta = 100;  ///< also of k, which may be 0

// Values beyond which a warning says what is lost (scene/precision.hpp). Lengths are relative to the scene's
// size, the longest side of its bounding box.
inline constexpr double kFarScene = 0x1p27;      ///< reach from the origin; doubles are off by 2^-53 of it
inline constexpr double kFarFloatMesh = 0x1p13;  ///< the same for a mesh; its floats are off by 2^-24 of it
inline constexpr double kFarCamera = 0x1p13;     ///< distance of eye and scene; rays are off by 2^-24 of it
inline constexpr double kLeastDetail = 0x1p-18;  ///< of a light's width, a shape's side; corners: 2^-25
inline constexpr double kDimRadiance = 1e-18;    ///< W/(m^2 sr); 12 orders above the least target

// Tolerances, relative to a polygon's longest edge or diagonal.
inline constexpr double kParallelogramTolerance = 1e-6;  ///< a + c - b - d; float positions resolve 6e-8
inline constexpr double kPlanarTolerance = 1e-4;         ///< distance of the fourth corner from the plane
inline constexpr double kDegenerateHeight = 1e-12;       ///< least height of a triangle over its longest edge
inline constexpr double kParallelSine = 1e-6;            ///< least sine between camera direction and up
inline constexpr double kSimilarityTolerance = 1e-9;  ///< a sphere's transform: deviation from rotation * s

static_assert(kMaxFilmSidePixels <= 0xffffffffU / kMaxFilmSidePixels + 1,
              "width * height * channels of int64 must fit 64 bits");
static_assert(std::uint64_t{kMaxMeshTriangles} * 3 <= 0xffffffffU, "corner indices must fit 32 bits");

}  // namespace mlt
