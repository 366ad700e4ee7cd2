// The floating-point contract at its root: a hash over the results of every function of math/ on a fixed
// dense set of arguments, compared with one constant in every build. It differs as soon as a compiler
// contracts to a fused multiply-add, reorders a sum, flushes a denormal or calls libm. A deliberate change of
// a function changes the constant; then every golden film hash changes with it.
#include <bit>
#include <catch2/catch.hpp>
#include <cstdint>

#include "math/elementary.hpp"
#include "math/rng.hpp"
#include "math/srgb.hpp"
#include "math/vec.hpp"
#include "math/warp.hpp"

using namespace mlt;

namespace {

class BitHash {
 public:
  void add(float value) {
    // The sign and payload of a NaN are the processor's; that it is one, is ours.
    add_bits(value != value ? 0x7fc00000U : std::bit_cast<std::uint32_t>(value));
  }
  void add(double value) {
    add_bits(value != value ? 0x7ff8000000000000ULL : std::bit_cast<std::uint64_t>(value));
  }
  void add(const Vec3& v) {
    add(v.x);
    add(v.y);
    add(v.z);
  }
  std::uint64_t value() const { return state_; }

 private:
  void add_bits(std::uint64_t bits) { state_ = mix64(state_ ^ bits) + 0x9e3779b97f4a7c15ULL; }
  std::uint64_t state_ = 0;
};

constexpr std::uint32_t kStride = 65521;  // a prime near 2^16: 65,552 floats of each kind, NaNs included

/// Over bit patterns of all magnitudes, then evenly over [low, high], where the function does its work.
template <class F>
std::uint64_t hash_of(F f, float low, float high) {
  BitHash hash;
  for (std::uint64_t bits = 0; bits <= 0xffffffffULL; bits += kStride) {
    hash.add(f(std::bit_cast<float>(static_cast<std::uint32_t>(bits))));
  }
  for (int i = 0; i <= 65536; ++i) hash.add(f(low + (high - low) * (static_cast<float>(i) * 0x1p-16f)));
  return hash.value();
}

}  // namespace

TEST_CASE("float functions have the same bits in every build") {
  CHECK(hash_of(exp_f, -104.0f, 89.0f) == 0x37e744130c98b7ebULL);
  CHECK(hash_of(exp2_f, -150.0f, 128.0f) == 0x085ef2afc8a0956aULL);
  CHECK(hash_of(log_f, 0.0f, 10.0f) == 0x57c9edceb7de48b7ULL);
  CHECK(hash_of(log2_f, 0.0f, 10.0f) == 0x470c527c90011151ULL);
  CHECK(hash_of(acos_f, -1.0f, 1.0f) == 0xf7f091a5259ea3bfULL);
  CHECK(hash_of(srgb_encode, 0.0f, 1.0f) == 0x9febbefc2d6fb08bULL);
  CHECK(hash_of([](float x) { return pow_f(x, 0.37f); }, 0.0f, 4.0f) == 0xbc22597a264c86f0ULL);
  CHECK(hash_of([](float x) { return atan2_f(x, -0.81f); }, -2.0f, 2.0f) == 0xe2d61ae53d5291d4ULL);
  // The double kernels as such, since a last bit of theirs hardly ever shows in a float.
  CHECK(hash_of(detail::log2_kernel, 0.0f, 10.0f) == 0x04cd6fbdce30251cULL);
  const auto exp2_of_small = [](float x) { return std::fabs(x) < 100.0f ? detail::exp2_kernel(x) : 0.0; };
  CHECK(hash_of(exp2_of_small, -100.0f, 100.0f) == 0xe60bb9c34e3b028eULL);
}

TEST_CASE("angles have the same bits in every build") {
  BitHash turns;
  for (std::uint32_t i = 0; i < (1U << 24); i += 127) {
    float s, c;
    sincos_2pi(static_cast<float>(i) * 0x1p-24f, s, c);
    turns.add(s);
    turns.add(c);
  }
  CHECK(turns.value() == 0x117f653a4b1d156eULL);

  BitHash degrees;
  for (int i = -50000; i < 50000; ++i) {
    const double angle = i * 0.0123456789;
    const DSinCos value = sincos_degrees(angle);
    degrees.add(value.sin);
    degrees.add(value.cos);
    degrees.add(tan_degrees(angle));
  }
  CHECK(degrees.value() == 0xb918be75dafabfc7ULL);
}

TEST_CASE("random streams, vectors and warps have the same bits in every build") {
  Rng rng(42, StreamPurpose::kTest, 7);
  BitHash draws;
  BitHash vectors;
  BitHash warps;
  for (int i = 0; i < 20000; ++i) {
    const Vec2 u{rng.next_float(), rng.next_float()};
    draws.add(u.x);
    draws.add(u.y);
    const Vec3 direction = uniform_sphere(u);
    warps.add(direction);
    warps.add(cosine_hemisphere(u));
    warps.add(uniform_triangle(u));
    warps.add(uniform_cone(u, 0.01f));
    const Vec3 v = direction * (100.0f * u.x) + Vec3{1.5f, -2.5f, 0.1f};
    vectors.add(normalize(v));
    vectors.add(cross(v, direction));
    vectors.add(dot(v, direction));
    vectors.add(luminance(v));
    vectors.add(Frame(normalize(v)).to_world(Frame(normalize(direction)).to_local(v)));
  }
  CHECK(draws.value() == 0xe6f83e6cf5812436ULL);
  CHECK(warps.value() == 0x052d35c4860a205eULL);
  CHECK(vectors.value() == 0x5414bd1281ffba4dULL);
}
