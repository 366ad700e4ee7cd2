// Writes mesh.ply, a closed tube along a (2,3) torus knot with a twisted relief, 131,072 triangles, and
// mesh.txt, a scene that shows it, into the folder given as argument. `make scenes` runs it; the files are
// too large to be stored, and a mesh must lie in its scene's folder, so the scene is written along with it.
// The file's bits are the same from every machine: all angles are whole parts of a turn, whose sines and
// cosines follow from square roots and products alone.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

namespace {

constexpr std::uint32_t kAlong = 1024;  // rings
constexpr std::uint32_t kAround = 64;   // vertices of a ring
constexpr double kMajorRadius = 1.0;
constexpr double kMinorRadius = 0.45;
constexpr double kTubeRadius = 0.24;
constexpr double kReliefHeight = 0.018;
constexpr int kWindings = 2;  // around the torus' axis
constexpr int kTurns = 3;     // around its circle
constexpr int kReliefRidges = 8;
constexpr int kReliefTwists = 40;

struct Point {
  double x = 0, y = 0, z = 0;
};

Point operator+(const Point& a, const Point& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
Point operator*(const Point& a, double s) {
  return {a.x * s, a.y * s, a.z * s};
}
Point cross(const Point& a, const Point& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Point normalize(const Point& v) {
  return v * (1.0 / std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z));
}

struct SinCos {
  double sin = 0, cos = 1;
};

// Sine and cosine of all multiples of a 1024th of a turn: the quarter turn halved eight times, then added up.
std::array<SinCos, kAlong> circle() {
  SinCos step{1, 0};
  for (std::uint32_t parts = 4; parts < kAlong; parts *= 2) {
    const double half_cos = std::sqrt((1 + step.cos) / 2);
    step = SinCos{step.sin / (2 * half_cos), half_cos};
  }
  std::array<SinCos, kAlong> points{};
  for (std::uint32_t i = 1; i < kAlong; ++i) {
    const SinCos& last = points[i - 1];
    points[i] = SinCos{last.sin * step.cos + last.cos * step.sin, last.cos * step.cos - last.sin * step.sin};
  }
  return points;
}

// The knot lies on a torus; the torus' normal is perpendicular to the knot's tangent everywhere and, unlike
// the curve's own normal, returns to itself after one round, so rings built on it close without a twist.
Point tube_point(const std::array<SinCos, kAlong>& parts, std::uint32_t ring, std::uint32_t step) {
  const std::uint32_t around = step * (kAlong / kAround);
  const SinCos& p = parts[kWindings * ring % kAlong];
  const SinCos& q = parts[kTurns * ring % kAlong];
  const SinCos& a = parts[around];
  const SinCos& relief = parts[(kReliefRidges * around + kReliefTwists * ring) % kAlong];
  const double distance = kMajorRadius + kMinorRadius * q.cos;
  const Point center{distance * p.cos, kMinorRadius * q.sin, distance * p.sin};
  const Point normal{q.cos * p.cos, q.sin, q.cos * p.sin};
  const Point along_windings{-distance * p.sin, 0, distance * p.cos};
  const Point along_turns{-kMinorRadius * q.sin * p.cos, kMinorRadius * q.cos, -kMinorRadius * q.sin * p.sin};
  const Point tangent = normalize(along_windings * double{kWindings} + along_turns * double{kTurns});
  const Point outward = normal * a.cos + cross(tangent, normal) * a.sin;
  return center + outward * (kTubeRadius + kReliefHeight * relief.cos);
}

template <class T>
void append(std::vector<char>& bytes, T value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.insert(bytes.end(), raw, raw + sizeof value);
}

void append_triangle(std::vector<char>& bytes, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  append(bytes, std::uint8_t{3});
  append(bytes, a);
  append(bytes, b);
  append(bytes, c);
}

std::vector<char> knot() {
  const std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment torus knot for mlt\nelement vertex " +
      std::to_string(kAlong * kAround) +
      "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
      std::to_string(2 * kAlong * kAround) + "\nproperty list uchar uint vertex_indices\nend_header\n";
  std::vector<char> bytes(header.begin(), header.end());
  const std::array<SinCos, kAlong> parts = circle();
  for (std::uint32_t ring = 0; ring < kAlong; ++ring) {
    for (std::uint32_t step = 0; step < kAround; ++step) {
      const Point point = tube_point(parts, ring, step);
      append(bytes, static_cast<float>(point.x));
      append(bytes, static_cast<float>(point.y));
      append(bytes, static_cast<float>(point.z));
    }
  }
  for (std::uint32_t ring = 0; ring < kAlong; ++ring) {
    for (std::uint32_t step = 0; step < kAround; ++step) {
      const std::uint32_t next_ring = (ring + 1) % kAlong * kAround;
      const std::uint32_t next_step = (step + 1) % kAround;
      const std::uint32_t a = ring * kAround + step;
      const std::uint32_t b = ring * kAround + next_step;
      const std::uint32_t c = next_ring + next_step;
      const std::uint32_t d = next_ring + step;
      append_triangle(bytes, a, b, c);
      append_triangle(bytes, a, c, d);
    }
  }
  return bytes;
}

constexpr char kScene[] =
    R"(# A torus knot of 131,072 triangles under a square lamp, in a bay of three walls. Written by
# scenes/generate_mesh.cpp together with mesh.ply; lengths are in metres.
film 512 512
depth 8
camera eye 0 2.6 4.6 target 0 0.85 0 up 0 1 0 fov 46

material plaster diffuse reflectance 0.75 0.74 0.7
material blue diffuse reflectance 0.2 0.35 0.6
material clay diffuse reflectance 0.68 0.36 0.2

mesh mesh.ply material clay rotate -30 0 1 0 rotate 12 1 0 0 translate 0 1.1 0

quad -2.4 0 -2.4  -2.4 0 2.4  2.4 0 2.4  2.4 0 -2.4  material plaster
quad -2.4 0 -2.4  2.4 0 -2.4  2.4 3.6 -2.4  -2.4 3.6 -2.4  material plaster
quad -2.4 0 2.4  -2.4 0 -2.4  -2.4 3.6 -2.4  -2.4 3.6 2.4  material blue
quad 2.4 0 -2.4  2.4 0 2.4  2.4 3.6 2.4  2.4 3.6 -2.4  material plaster
quad -0.8 3.5 -0.8  0.8 3.5 -0.8  0.8 3.5 0.8  -0.8 3.5 0.8  material plaster emit 14 13 11
)";

bool write_file(const std::string& path, const char* bytes, std::size_t size) {
  std::FILE* const file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) return false;
  const bool written = std::fwrite(bytes, 1, size, file) == size;
  return (std::fclose(file) == 0) && written;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: generate_mesh FOLDER\n");
    return 2;
  }
  const std::string folder = argv[1];
  const std::vector<char> mesh = knot();
  const bool written = write_file(folder + "/mesh.ply", mesh.data(), mesh.size()) &&
                       write_file(folder + "/mesh.txt", kScene, sizeof kScene - 1);
  if (!written) {
    std::fprintf(stderr, "generate_mesh: cannot write to %s\n", folder.c_str());
    return 1;
  }
}
