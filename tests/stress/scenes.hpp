// Scenes that the sweeps share, as text that goes through the parser, and their closed forms.
#pragma once

#include <complex>
#include <cstdint>
#include <string>
#include <vector>

#include "math/vec.hpp"

namespace mlt::test {

inline constexpr double kPiExact = 3.14159265358979323846;

/// Where a scene stands: a position p of the scene at home is at scale * p + offset.
struct Place {
  double scale = 1;
  DVec3 offset{0, 0, 0};
};

/// A room with slivers, glass and a rough metal, about 4 units wide; coordinates at home are multiples of
/// 1/64. Shapes are placed by clauses, the camera by its numbers.
std::string room_at(const Place& place);
inline constexpr double kRoomSize = 4;

/// A closed room from -1 to 1 with walls of one albedo that emit 1; its radiance is the same everywhere.
std::string furnace(const std::string& albedo, const std::string& emission = "1");
/// sum of albedo^k for k from 0 to depth - 1.
double furnace_radiance(double albedo, std::uint32_t depth);

/// Irradiance at `point`, with normal +y, from a polygon of radiance 1 wholly above the horizon
/// [Lambert1760].
double polygon_irradiance(const std::vector<DVec3>& corners, const DVec3& point);
/// The same from a sphere: as from the disc of its outline.
double sphere_irradiance(const DVec3& centre, double radius, const DVec3& point);

/// A floor of albedo 0.5 at y = 0 seen at the origin in a view so narrow (3e-4 wide) that the irradiance is
/// that of the origin: its slope cancels in the film's mean, its curvature is below 1e-6 of its value.
std::string floor_point(const std::string& more);
inline constexpr double kFloorPointRounding = 2e-6;

inline constexpr double kLitFloorFov = 60;  ///< degrees
/// A floor of albedo 0.5 seen from straight above, beside and under a lamp that the view does not show. For
/// depth 2 every pixel is known; the brightest is some ten times as bright as the mean.
std::string lit_floor(const std::string& emission = "10", double fov_degrees = kLitFloorFov);
/// Mean radiance over the part [u0, u1] x [v0, v1] of the film, from its upper left corner; lamp of 10.
double lit_floor_radiance(double u0 = 0, double v0 = 0, double u1 = 1, double v1 = 1);

/// Two such floors, divided by a wall: the right one under the lamp of 10, the left one, mirrored, under a
/// lamp `ratio` times dimmer.
std::string divided_floor(double ratio);

/// Walls of radiance 1 that reflect nothing: all that is seen is what the object in the middle lets through.
inline constexpr const char* kUniformLight =
    "material black diffuse reflectance 0\nbox -40 -40 -40 40 40 40 inward material black emit 1\n";

/// Reflectance of a plane surface of complex index for unpolarised light [Born99 section 14.2], by complex
/// arithmetic: a way of its own, for the renderer uses real sums of squares.
double reflectance(std::complex<double> index, double cos_i);
/// What a slab of glass shows of a uniform field of radiance 1: the reflection at its front (2 edges), and
/// all paths with k inner reflections (3 + k edges). Squeezing into and out of the glass cancels.
double slab_radiance(double ior, double cos_i, std::uint32_t depth);

/// A view of the origin from 10 units away at `degrees` off the z axis, so narrow that the angle is one.
std::string narrow_view(double degrees);

}  // namespace mlt::test
