// A scene as its file says it, in double precision and in the file's own units: what the parser produces and
// the world is compiled from. Plain data; transforms are already applied to all positions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "math/vec.hpp"

namespace mlt {

/// Where a statement stands, for diagnostics of later stages.
struct SourceLocation {
  std::string file;
  std::uint32_t line = 0;
  std::uint32_t column = 0;
};

/// Pinhole camera. `vertical_fov_degrees` in (0, 180) spans the film's height.
struct CameraDescription {
  DVec3 eye{0, 0, 0};
  DVec3 target{0, 0, -1};
  DVec3 up{0, 1, 0};
  double vertical_fov_degrees = 45;
  SourceLocation location;
};

/// One name per material; the order is the order of `mlt info` and of the contract tests.
#define MLT_MATERIAL_KINDS(X) \
  X(diffuse)                  \
  X(mirror)                   \
  X(dielectric)               \
  X(conductor)

enum class MaterialKind : std::uint32_t {
#define MLT_ENUMERATE(name) name,
  MLT_MATERIAL_KINDS(MLT_ENUMERATE)
#undef MLT_ENUMERATE
};

/// Parameters of all kinds; each kind reads its own and ignores the rest.
struct MaterialDescription {
  std::string name;
  MaterialKind kind = MaterialKind::diffuse;
  DVec3 reflectance{0.5, 0.5, 0.5};  ///< diffuse albedo or mirror reflectance, each channel in [0,1]
  double ior = 1.5;                  ///< dielectric: inside over outside index of refraction, in [1, 3]
  DVec3 eta{0.2, 0.92, 1.1};         ///< conductor: real part of the refractive index per channel, > 0
  DVec3 k{3.9, 2.45, 2.14};          ///< conductor: imaginary part per channel, >= 0
  double roughness = 0;              ///< conductor: GGX alpha itself; 0 (a mirror) or in [1e-5, 1]
  SourceLocation location;
};

/// A shape that emits has radiance in W/(m^2 sr) per channel, from its front side only.
struct ShapeAttributes {
  std::uint32_t material = 0;     ///< index into SceneDescription::materials
  std::optional<DVec3> emission;  ///< radiance, each channel >= 0
  SourceLocation location;
};

/// Convex planar quadrilateral or triangle by its corners, counter-clockwise seen from the front.
struct PolygonDescription {
  DVec3 corners[4];
  std::uint32_t corner_count = 4;  ///< 3 or 4; a quad is a parallelogram to within rounding
  ShapeAttributes attributes;
};

/// The front of a sphere is its outside.
struct SphereDescription {
  DVec3 center{0, 0, 0};
  double radius = 1;
  ShapeAttributes attributes;
};

/// Triangle mesh, inline or from an OBJ or PLY file.
struct MeshDescription {
  std::vector<DVec3> vertices;
  std::vector<std::uint32_t> indices;  ///< three per triangle, each < vertices.size()
  ShapeAttributes attributes;
};

/// Limits and defaults that the scene file may state; the command line overrides them.
struct SceneDescription {
  std::string path;
  CameraDescription camera;
  std::uint32_t film_width = 256;      ///< pixels
  std::uint32_t film_height = 256;     ///< pixels
  std::optional<std::uint32_t> depth;  ///< maximal number of path edges, camera to light
  std::vector<MaterialDescription> materials;
  std::vector<PolygonDescription> polygons;
  std::vector<SphereDescription> spheres;
  std::vector<MeshDescription> meshes;
  std::vector<std::string> warnings;  ///< "file:line:column: text" of what was accepted but dropped
};

}  // namespace mlt
