// Nanoseconds per ray by kind (primary, cosine-distributed bounce, shadow segment) for a Cornell-like
// box of 18 quads, a box around one glassy-smooth ball of 131k triangles and a rough one of 1M: one thread,
// CPU time; medians of interleaved rounds, so that a change of the clock's frequency or another process meets
// all alike. Rays go one by one, and in groups of as many as renders trace together. And the time to build
// their hierarchies by 1, 2 and 4 threads. With the argument "crossover" it compares flat lists with trees
// for growing counts instead, which is where FlatLimits comes from. Where libembree-dev is there, Embree
// meets the same rays and builds from the same triangles. The Makefile compiles it once for each instruction
// set.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <functional>
#include <memory>

#include "embree.hpp"
#include "ray_sets.hpp"
#include "render/instruction_set.hpp"
#include "render/worker_pool.hpp"
#include "row.hpp"

namespace mlt::test {
namespace {

double seconds_since(double start) {
  return cpu_seconds() - start;
}

#ifndef MLT_BENCH_SET
#define MLT_BENCH_SET base
#endif
constexpr InstructionSet kSet = InstructionSet::MLT_BENCH_SET;

#if defined(__x86_64__)
#define MLT_CPU_HAS(feature) (__builtin_cpu_supports(feature) != 0)
#else
#define MLT_CPU_HAS(feature) false
#endif

/// Whether the processor can run what this source is compiled to.
bool can_run() {
  switch (kSet) {
#define MLT_CASE(name, help, condition) \
  case InstructionSet::name:            \
    return condition;
    MLT_INSTRUCTION_SETS(MLT_CASE)
#undef MLT_CASE
  }
  return false;
}

volatile std::uint32_t sink;

/// Nanoseconds of one of `count` items, of which run() does all and returns a result.
template <class Run>
double time_each(std::size_t count, Run&& run) {
  const double start = cpu_seconds();
  sink = run();
  return seconds_since(start) * 1e9 / static_cast<double>(count);
}

template <bool kGeneral>
double time_closest(const Geometry& geometry, const RaySet& set) {
  return time_each(set.rays.size(), [&] {
    std::uint32_t sum = 0;
    for (const Ray& ray : set.rays) sum += geometry.intersect<kGeneral>(ray).primitive;
    return sum;
  });
}

template <bool kGeneral>
double time_closest_groups(const Geometry& geometry, const RaySet& set) {
  return time_each(set.rays.size(), [&] {
    UintOf<WideFloat> sum{};
    for (const RayGroup& group : set.groups)
      sum += geometry.intersect_lanes<kGeneral, WideFloat>(group.ray, group.leaves, group.active).primitive;
    return lane_of(sum, 0);
  });
}

template <bool kGeneral>
double time_surface(const Geometry& geometry, const RaySet& set) {
  return time_each(set.rays.size(), [&] {
    float sum = 0;
    for (const Ray& ray : set.rays) {
      const Hit hit = geometry.intersect<kGeneral>(ray);
      if (hit.found()) sum += geometry.surface_point<kGeneral>(ray, hit).offset_bound;
    }
    return sum > 0;
  });
}

template <bool kGeneral>
double time_occluded(const Geometry& geometry, const RaySet& set) {
  return time_each(set.rays.size(), [&] {
    std::uint32_t sum = 0;
    for (const Ray& ray : set.rays) sum += geometry.occluded<kGeneral>(ray);
    return sum;
  });
}

template <bool kGeneral>
double time_occluded_groups(const Geometry& geometry, const RaySet& set) {
  return time_each(set.rays.size(), [&] {
    const auto nothing = broadcast_bits<UintOf<WideFloat>>(kNoPrimitive);
    MaskOf<WideFloat> blocked{};
    for (const RayGroup& group : set.groups) {
      const SegmentEnds<WideFloat> ends{group.leaves, nothing};
      blocked ^= geometry.occluded_lanes<kGeneral, WideFloat>(group.ray, ends, group.active);
    }
    return static_cast<std::uint32_t>(lane_of(blocked, 0));
  });
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
  std::vector<double> primary_groups, bounce_groups, shadow_groups;
};

template <bool kGeneral>
void measure(const Geometry& geometry, const RaySets& rays, Measurement& m) {
  m.primary.push_back(time_closest<kGeneral>(geometry, rays.primary));
  m.bounce.push_back(time_closest<kGeneral>(geometry, rays.bounce));
  m.bounce_surface.push_back(time_surface<kGeneral>(geometry, rays.bounce));
  m.shadow.push_back(time_occluded<kGeneral>(geometry, rays.shadow));
  m.primary_groups.push_back(time_closest_groups<kGeneral>(geometry, rays.primary));
  m.bounce_groups.push_back(time_closest_groups<kGeneral>(geometry, rays.bounce));
  m.shadow_groups.push_back(time_occluded_groups<kGeneral>(geometry, rays.shadow));
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
  double time(const RaySet& set, bool (EmbreeScene::*query)(const Ray&) const) const {
    return time_each(set.rays.size(), [&] {
      std::uint32_t sum = 0;
      for (const Ray& ray : set.rays) sum += (scene_.*query)(ray) ? 1 : 0;
      return sum;
    });
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
    print_row(
        {fmt::format("{} ({})", kind, instruction_set_name(kSet)), scene, "ns", {}, own, "Embree", rival});
  };
  print_kind("primary ray", m.primary, embree.primary);
  print_kind("bounce", m.bounce, embree.bounce);
  print_kind("bounce with surface point", m.bounce_surface, {});
  print_kind("shadow ray", m.shadow, embree.shadow);
  print_kind("primary ray of a group", m.primary_groups, embree.primary);
  print_kind("bounce of a group", m.bounce_groups, embree.bounce);
  print_kind("shadow ray of a group", m.shadow_groups, embree.shadow);
}

/// Wall time, since several threads build; the arena's pages are there before, as in a render.
void print_build(const std::string& scene, const Shapes& shapes, std::uint32_t threads) {
  BenchRow time{fmt::format("build of the hierarchy by {} threads ({})", threads, instruction_set_name(kSet)),
                scene, "ms"};
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

/// `count` small shapes of one kind in a closed box, as groups of rays meet them in a list and in a tree.
void compare_structures(const char* kind, int count, const std::function<void(Shapes&, Rng&)>& add) {
  Rng rng(2, StreamPurpose::kTest, 41);
  Shapes shapes;
  for (int i = 0; i < count; ++i) add(shapes, rng);
  const BuiltGeometry flat(shapes, kAlwaysBounds), tree(shapes, kAlwaysTree);
  const RaySets rays = make_rays<true>(*flat, 128);
  if (rays.bounce.rays.empty()) return;
  Measurement m[2];
  for (int round = 0; round < 15; ++round) {
    measure<true>(*flat, rays, m[0]);
    measure<true>(*tree, rays, m[1]);
  }
  std::printf("%4d %-9s flat %6.1f %6.1f %6.1f   tree %6.1f %6.1f %6.1f ns (primary, bounce, shadow)\n",
              count, kind, median(m[0].primary_groups), median(m[0].bounce_groups),
              median(m[0].shadow_groups), median(m[1].primary_groups), median(m[1].bounce_groups),
              median(m[1].shadow_groups));
}

void find_crossovers() {
  for (const int count : {8, 16, 32, 48, 64, 80, 96, 108}) {
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
  if (!mlt::test::can_run()) {
    std::fprintf(stderr, "the processor lacks %s\n", mlt::instruction_set_name(mlt::test::kSet));
    return 0;
  }
  if (argc > 1 && std::strcmp(argv[1], "crossover") == 0) {
    mlt::test::find_crossovers();
  } else {
    mlt::test::compare_scenes();
  }
  return 0;
}
