#include "scenes.hpp"

#include <array>
#include <cmath>

#include "support/statistics.hpp"
#include "sweep.hpp"

namespace mlt::test {
namespace {

std::string text_of(const DVec3& p) {
  return exact_text_of(p.x) + " " + exact_text_of(p.y) + " " + exact_text_of(p.z);
}

const std::vector<DVec3>& floor_lamp() {
  static const std::vector<DVec3> corners = {
      {0.7, 0.4, -0.3}, {1.1, 0.4, -0.3}, {1.1, 0.4, 0.3}, {0.7, 0.4, 0.3}};
  return corners;
}

}  // namespace

std::string room_at(const Place& place) {
  const auto at = [&place](const DVec3& p) { return text_of(p * place.scale + place.offset); };
  std::string text = "camera eye " + at({0.25, 1.5, 5.5}) + " target " + at({0, 1, 0}) +
                     " fov 45\n"
                     "material grey diffuse reflectance 0.7\n"
                     "material red diffuse reflectance 0.7 0.2 0.2\n"
                     "material glass dielectric ior 1.5\n"
                     "material metal conductor preset silver roughness 0.25\n";
  for (const char* shape : {
           "quad -2 0 -2  -2 0 2  2 0 2  2 0 -2 material grey",
           "quad -2 0 -2  2 0 -2  2 3 -2  -2 3 -2 material red",
           "quad -0.5 2.5 -0.5  0.5 2.5 -0.5  0.5 2.5 0.5  -0.5 2.5 0.5 material grey emit 12",
           "triangle -1 0 0  1 0 0  0 2 0.015625 material grey",
           "triangle -1.5 0 0.5  1.5 1.5 0.5  1.5 1.515625 0.5 material red",
           "sphere 1 0.5 0.5 0.5 material glass",
           "sphere -1 0.5 1 0.5 material metal",
       }) {
    text += shape;
    if (place.scale != 1) text += " scale " + exact_text_of(place.scale);
    if (place.offset != DVec3{0, 0, 0}) text += " translate " + text_of(place.offset);
    text += "\n";
  }
  return text;
}

std::string furnace(const std::string& albedo, const std::string& emission) {
  return "camera eye 0.2 -0.1 0.3 target 1 0.4 -0.6 fov 70\nmaterial wall diffuse reflectance " + albedo +
         "\nbox -1 -1 -1 1 1 1 inward material wall emit " + emission + "\n";
}

double furnace_radiance(double albedo, std::uint32_t depth) {
  double sum = 0;
  for (std::uint32_t k = 0; k < depth; ++k) sum = 1 + albedo * sum;
  return sum;
}

double polygon_irradiance(const std::vector<DVec3>& corners, const DVec3& point) {
  double sum = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const DVec3 a = normalize(corners[i] - point);
    const DVec3 b = normalize(corners[(i + 1) % corners.size()] - point);
    // For edges seen under small angles the sine comes from the edge itself.
    const DVec3 perpendicular = cross(a, b - a);
    sum += std::atan2(length(perpendicular), dot(a, b)) * normalize(perpendicular).y;
  }
  return std::fabs(sum) / 2;
}

double sphere_irradiance(const DVec3& centre, double radius, const DVec3& point) {
  const DVec3 to_centre = centre - point;
  const double squared_distance = dot(to_centre, to_centre);
  return kPiExact * radius * radius / squared_distance * to_centre.y / std::sqrt(squared_distance);
}

std::string floor_point(const std::string& more) {
  return "camera eye -4 1.5 0.5 target 0 0 0 fov 0.004\nmaterial grey diffuse reflectance 0.5\n"
         "material black diffuse reflectance 0\n"
         "quad -5 0 -5  -5 0 5  5 0 5  5 0 -5 material grey\n" +
         more;
}

std::string lit_floor(const std::string& emission, double fov_degrees) {
  std::string lamp = "quad";
  for (const DVec3& corner : floor_lamp()) lamp += " " + text_of(corner);
  return "camera eye 0 1 0 target 0 0 0 up 0 0 -1 fov " + exact_text_of(fov_degrees) +
         "\nmaterial grey diffuse reflectance 0.5\nmaterial black diffuse reflectance 0\n"
         "quad -1 0 -1  -1 0 1  1 0 1  1 0 -1 material grey\n" +
         lamp + " material black emit " + emission + "\n";
}

std::string divided_floor(double ratio) {
  std::string lamp = "quad";
  for (const DVec3& corner : floor_lamp()) lamp += " " + text_of(corner);
  return lit_floor() + "quad 0 0 -2  0 0 2  0 0.9 2  0 0.9 -2 material black\n" + lamp +
         " scale -1 1 1 material black emit " + exact_text_of(10 / ratio) + "\n";
}

double lit_floor_radiance(double u0, double v0, double u1, double v1) {
  const double half_width = std::tan(30 * kPiExact / 180);
  const auto radiance = [&](double u, double v) {
    const DVec3 point{half_width * (2 * u - 1), 0, half_width * (2 * v - 1)};
    return 10 * 0.5 / kPiExact * polygon_irradiance(floor_lamp(), point);
  };
  return integrate(radiance, u0, u1, v0, v1, 1e-9) / ((u1 - u0) * (v1 - v0));
}

double reflectance(std::complex<double> index, double cos_i) {
  const std::complex<double> cos_t = std::sqrt(1.0 - (1 - cos_i * cos_i) / (index * index));
  const std::complex<double> s = (cos_i - index * cos_t) / (cos_i + index * cos_t);
  const std::complex<double> p = (index * cos_i - cos_t) / (index * cos_i + cos_t);
  return (std::norm(s) + std::norm(p)) / 2;
}

double slab_radiance(double ior, double cos_i, std::uint32_t depth) {
  const double r = reflectance(ior, cos_i);
  double sum = depth >= 2 ? r : 0;
  for (std::uint32_t k = 0; k + 3 <= depth; ++k) sum += (1 - r) * (1 - r) * std::pow(r, k);
  return sum;
}

std::string narrow_view(double degrees) {
  const double angle = degrees * kPiExact / 180;
  return "camera eye " + exact_text_of(10 * std::sin(angle)) + " 0 " + exact_text_of(10 * std::cos(angle)) +
         " target 0 0 0 fov 0.002\n";
}

}  // namespace mlt::test
