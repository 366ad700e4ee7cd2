// Nanoseconds per ray by kind (primary, cosine-distributed bounce, shadow segment) for a Cornell-like
// box of 18 quads, a box around one glassy-smooth ball of 131k triangles and a rough one of 1M: one thread,
// CPU time; medians of interleaved rounds, so that a change of the clock's frequency or another process meets
// all alike. And the time to build their hierarchies by 1, 2 and 4 threads. With the argument "crossover" it
// compares flat lists with trees for growing counts instead, which is where FlatLimits comes from. Where
// libembree-dev is there, Embree meets the same rays and builds from the same triangles.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <functional>
#include <memory>

#include "embree.hpp"
#include "geometry/scene_fixture.hpp"
#include "render/worker_pool.hpp"
#include "row.hpp"

namespace mlt::test {
namespace {

double seconds_since(double start) {
  return cpu_seconds() - start;
}

Quad quad(const Vec3& a, const Vec3& u, const Vec3& v) {
  return {a, a + u, (a + u) + v, a + v};
}

void add_block(std::vector<Quad>& quads, const Vec3& corner, const Vec3& x, const Vec3& z, float height) {
  const Vec3 y{0, height, 0};
  quads.push_back(quad(corner + y, x, z));
  quads.push_back(quad(corner, x, z));
  for (const Vec3& from : {corner, corner + z}) quads.push_back(quad(from, x, y));
  for (const Vec3& from : {corner, corner + x}) quads.push_back(quad(from, z, y));
}

/// Five walls, a light below the ceiling and two turned blocks; the open side is at z = 1.
std::vector<Quad> cornell_quads() {
  const Vec3 x{2, 0, 0}, y{0, 2, 0}, z{0, 0, 2};
  std::vector<Quad> quads{
      quad({-1, -1, -1}, x, z), quad({-1, 1, -1}, x, z),
      quad({-1, -1, -1}, x, y), quad({-1, -1, -1}, y, z),
      quad({1, -1, -1}, y, z),  quad({-0.25f, 0.99f, -0.25f}, {0.5f, 0, 0}, {0, 0, 0.5f})};
  add_block(quads, {-0.7f, -1, -0.4f}, {0.57f, 0, -0.17f}, {0.17f, 0, 0.57f}, 1.2f);
  add_block(quads, {0.1f, -1, 0.1f}, {0.57f, 0, 0.17f}, {-0.17f, 0, 0.57f}, 0.6f);
  return quads;
}

/// The walls of the box around a ball of about 2 * rings * segments triangles with bumps of the given height.
Shapes ball_in_box(int rings, int segments, float bumps) {
  Shapes shapes;
  shapes.quads = cornell_quads();
  shapes.quads.resize(6);
  shapes.triangles = tessellated_sphere(rings, segments, 0.7f);
  const auto displaced = [&](const Vec3& p) {
    const float wave = std::sin(17.0f * p.x) * std::sin(19.0f * p.y) * std::sin(23.0f * p.z);
    return p * (1.0f + bumps * wave);
  };
  for (Triangle& t : shapes.triangles) t = {displaced(t.a), displaced(t.b), displaced(t.c)};
  return shapes;
}

struct RaySets {
  std::vector<Ray> primary, bounce, shadow;
};

/// Rays as a path tracer makes them: a pinhole image in pixel order, then from each point hit a
/// cosine-distributed direction and a segment to the light.
template <bool kGeneral>
RaySets make_rays(const Geometry& geometry, int side) {
  RaySets rays;
  Rng rng(1, StreamPurpose::kTest, 40);
  for (int i = 0; i < side * side; ++i) {
    const float x = (static_cast<float>(i % side) + rng.next_float()) / static_cast<float>(side) - 0.5f;
    const float y = (static_cast<float>(i / side) + rng.next_float()) / static_cast<float>(side) - 0.5f;
    Ray ray{Vec3{0, 0, 3.2f}, normalize(Vec3{x * 0.85f, y * 0.85f, -1}), 1e30f};
    rays.primary.push_back(ray);
    // Bounces start anywhere along a path, not only at what the camera sees.
    for (int depth = 0; depth < 2; ++depth) {
      const Hit hit = geometry.intersect<kGeneral>(ray);
      if (!hit.found()) break;
      const SurfacePoint point = geometry.surface_point<kGeneral>(ray, hit);
      const Vec3 normal = dot(point.normal, ray.direction) < 0 ? point.normal : -point.normal;
      const Vec3 light = Vec3{-0.25f + 0.5f * rng.next_float(), 0.985f, -0.25f + 0.5f * rng.next_float()};
      const Vec3 origin = point.origin_towards(normal);
      rays.shadow.push_back({origin, light - origin, 1.0f});
      ray = {origin, normalize(normal + unit_direction(rng) * 0.9999f), 1e30f};
      rays.bounce.push_back(ray);
    }
  }
  return rays;
}

volatile std::uint32_t sink;

template <bool kGeneral>
double time_closest(const Geometry& geometry, const std::vector<Ray>& rays) {
  const auto start = cpu_seconds();
  std::uint32_t sum = 0;
  for (const Ray& ray : rays) sum += geometry.intersect<kGeneral>(ray).primitive;
  sink = sum;
  return seconds_since(start) * 1e9 / static_cast<double>(rays.size());
}

template <bool kGeneral>
double time_surface(const Geometry& geometry, const std::vector<Ray>& rays) {
  const auto start = cpu_seconds();
  float sum = 0;
  for (const Ray& ray : rays) {
    const Hit hit = geometry.intersect<kGeneral>(ray);
    if (hit.found()) sum += geometry.surface_point<kGeneral>(ray, hit).offset_bound;
  }
  sink = sum > 0;
  return seconds_since(start) * 1e9 / static_cast<double>(rays.size());
}

template <bool kGeneral>
double time_occluded(const Geometry& geometry, const std::vector<Ray>& rays) {
  const auto start = cpu_seconds();
  std::uint32_t sum = 0;
  for (const Ray& ray : rays) sum += geometry.occluded<kGeneral>(ray);
  sink = sum;
  return seconds_since(start) * 1e9 / static_cast<double>(rays.size());
}

/// The period of the core's clock as this process sees it: nanoseconds of one dependent addition.
double clock_period() {
  constexpr int kSteps = 10000000;
  const double start = cpu_seconds();
  std::uint32_t x = 1;
  for (int i = 0; i < kSteps; ++i) asm volatile("" : "+r"(x += 3));
  sink = x;
  return seconds_since(start) * 1e9 / kSteps;
}

struct Measurement {
  std::vector<double> primary, bounce, bounce_surface, shadow;
};

template <bool kGeneral>
void measure(const Geometry& geometry, const RaySets& rays, Measurement& m) {
  m.primary.push_back(time_closest<kGeneral>(geometry, rays.primary));
  m.bounce.push_back(time_closest<kGeneral>(geometry, rays.bounce));
  m.bounce_surface.push_back(time_surface<kGeneral>(geometry, rays.bounce));
  m.shadow.push_back(time_occluded<kGeneral>(geometry, rays.shadow));
}

#ifdef MLT_HAS_EMBREE
/// Quads as two triangles each; without the surface points.
class EmbreeMeter {
 public:
  explicit EmbreeMeter(const Shapes& shapes) : scene_(triangles_of(shapes)) {}

  void measure(const RaySets& rays, Measurement& m) const {
    m.primary.push_back(time(rays.primary, &EmbreeScene::intersect));
    m.bounce.push_back(time(rays.bounce, &EmbreeScene::intersect));
    m.shadow.push_back(time(rays.shadow, &EmbreeScene::occluded));
  }

  static double build_seconds(const Shapes& shapes, unsigned threads) {
    return EmbreeScene(triangles_of(shapes), threads).build_seconds();
  }

 private:
  static std::vector<Triangle> triangles_of(const Shapes& shapes) {
    std::vector<Triangle> triangles = halves_of(shapes.quads);
    triangles.insert(triangles.end(), shapes.triangles.begin(), shapes.triangles.end());
    return triangles;
  }
  double time(const std::vector<Ray>& rays, bool (EmbreeScene::*query)(const Ray&) const) const {
    const auto start = cpu_seconds();
    std::uint32_t sum = 0;
    for (const Ray& ray : rays) sum += (scene_.*query)(ray) ? 1 : 0;
    sink = sum;
    return seconds_since(start) * 1e9 / static_cast<double>(rays.size());
  }

  EmbreeScene scene_;
};
#else
struct EmbreeMeter {
  explicit EmbreeMeter(const Shapes&) {}
  void measure(const RaySets&, Measurement&) const {}
};
#endif

/// The threads of a render, with stacks of their own.
class Workers {
 public:
  explicit Workers(std::uint32_t count) : stacks_(new WorkerStack[count]), threads_(count) {
    pool_.start({stacks_.get(), count}, threads_);
  }
  UnitRunner runner() { return pool_.runner(); }

 private:
  std::unique_ptr<WorkerStack[]> stacks_;
  std::vector<pthread_t> threads_;
  WorkerPool pool_;
};

/// By kind of ray, with what the rival needed for the same rays, if any.
void print(const std::string& scene, const Measurement& m, const Measurement& embree) {
  const auto print_kind = [&scene](const char* kind, const std::vector<double>& own,
                                   const std::vector<double>& rival) {
    print_row({fmt::format("{} ({} lanes)", kind, kLanes), scene, "ns", {}, own, "Embree", rival});
  };
  print_kind("primary ray", m.primary, embree.primary);
  print_kind("bounce", m.bounce, embree.bounce);
  print_kind("bounce with surface point", m.bounce_surface, {});
  print_kind("shadow ray", m.shadow, embree.shadow);
}

/// Wall time, since several threads build; the arena's pages are there before, as in a render.
void print_build(const std::string& scene, const Shapes& shapes, std::uint32_t threads) {
  BenchRow time{fmt::format("build of the hierarchy by {} threads ({} lanes)", threads, kLanes), scene, "ms"};
  BenchRow memory{"memory of the hierarchy", scene, "bytes/triangle"};
  Workers workers(threads);
  const TriangleSoup soup(shapes.triangles);
  for (int round = 0; round < (quick_bench() ? 5 : 11); ++round) {
    MemoryPlan plan;
    const GeometrySlots slots = Geometry::plan(plan, shapes.counts());
    memory.readings.push_back(static_cast<double>(plan.bytes(Lifetime::kScene)) /
                              static_cast<double>(shapes.triangles.size()));
    Arena arena(plan);
    const auto start = std::chrono::steady_clock::now();
    const Geometry geometry =
        Geometry::build(arena, slots, {shapes.quads, soup.list(), shapes.spheres}, workers.runner());
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    time.readings.push_back(taken.count() * 1e3);
    sink = geometry.extent() > 0;
#ifdef MLT_HAS_EMBREE
    time.rival = "Embree";
    time.rival_readings.push_back(EmbreeMeter::build_seconds(shapes, threads) * 1e3);
#endif
  }
  print_row(time);
  if (threads == 1) print_row(memory);
}

void compare_scenes() {
  Shapes cornell;
  cornell.quads = cornell_quads();
  const Shapes mesh = ball_in_box(256, 257, 0.0f);
  const Shapes rough = ball_in_box(707, 708, 0.1f);
  const BuiltGeometry a(cornell), b(mesh), c(rough);
  const RaySets rays_a = make_rays<false>(*a, 256), rays_b = make_rays<true>(*b, 256),
                rays_c = make_rays<true>(*c, 256);
  const EmbreeMeter embree_a(cornell), embree_b(mesh), embree_c(rough);
  Measurement m[4], embree[3];
  std::vector<double> periods;
  const int rounds = quick_bench() ? 3 : 11;
  for (int round = 0; round < rounds; ++round) {
    periods.push_back(clock_period());
    measure<false>(*a, rays_a, m[0]);
    measure<true>(*a, rays_a, m[1]);
    measure<true>(*b, rays_b, m[2]);
    measure<true>(*c, rays_c, m[3]);
    embree_a.measure(rays_a, embree[0]);
    embree_b.measure(rays_b, embree[1]);
    embree_c.measure(rays_c, embree[2]);
  }
  print_row({"dependent addition", "-", "ns", {}, periods});
  print("box of 18 quads", m[0], embree[0]);
  print("box of 18 quads (general)", m[1], embree[0]);
  print("131k triangles in 6 quads", m[2], embree[1]);
  print("1M triangles in 6 quads", m[3], embree[2]);
  for (const std::uint32_t threads : {1U, 2U, 4U}) {
    print_build("131k triangles in 6 quads", mesh, threads);
    print_build("1M triangles in 6 quads", rough, threads);
  }
}

/// `count` small shapes of one kind in a closed box, flat and as a tree.
void compare_structures(const char* kind, int count, const std::function<void(Shapes&, Rng&)>& add) {
  Rng rng(2, StreamPurpose::kTest, 41);
  Shapes shapes;
  for (int i = 0; i < count; ++i) add(shapes, rng);
  const BuiltGeometry flat(shapes, kAlwaysFlat), tree(shapes, kAlwaysTree);
  const RaySets rays = make_rays<true>(*flat, 128);
  if (rays.bounce.empty()) return;
  Measurement m[2];
  for (int round = 0; round < 15; ++round) {
    measure<true>(*flat, rays, m[0]);
    measure<true>(*tree, rays, m[1]);
  }
  std::printf("%4d %-9s flat %6.1f %6.1f %6.1f   tree %6.1f %6.1f %6.1f ns (primary, bounce, shadow)\n",
              count, kind, median(m[0].primary), median(m[0].bounce), median(m[0].shadow),
              median(m[1].primary), median(m[1].bounce), median(m[1].shadow));
}

void find_crossovers() {
  for (const int count : {8, 12, 16, 24, 32, 48, 64, 96, 128}) {
    const float size = 1.2f / std::cbrt(static_cast<float>(count));
    compare_structures("quads", count, [size](Shapes& shapes, Rng& rng) {
      const Vec3 a = point_in_cube(rng);
      const Vec3 u = unit_direction(rng) * size;
      shapes.quads.push_back(quad(a, u, unit_direction(rng) * size));
    });
    compare_structures("triangles", count, [size](Shapes& shapes, Rng& rng) {
      const Vec3 a = point_in_cube(rng);
      shapes.triangles.push_back({a, a + unit_direction(rng) * size, a + unit_direction(rng) * size});
    });
    compare_structures("spheres", count, [size](Shapes& shapes, Rng& rng) {
      shapes.spheres.push_back({point_in_cube(rng), size * 0.4f});
    });
  }
}

}  // namespace
}  // namespace mlt::test

int main(int argc, char** argv) {
  if (argc > 1 && std::strcmp(argv[1], "crossover") == 0) {
    mlt::test::find_crossovers();
  } else {
    mlt::test::compare_scenes();
  }
  return 0;
}
