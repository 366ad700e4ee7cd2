// What the contract tests run over: every kind of MLT_MATERIAL_KINDS with variations of every parameter, and
// directions to look from. A new kind takes part by being in the list; parameters that it does not read are
// recognised by compiling to the same material and make no cases of their own.
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "material/bsdf.hpp"
#include "math/rng.hpp"

namespace mlt::test {

struct MaterialCase {
  std::string name;
  MaterialDescription description;
  Material material;
};

inline const char* kind_name(MaterialKind kind) {
  switch (kind) {
#define MLT_CASE(name)     \
  case MaterialKind::name: \
    return #name;
    MLT_MATERIAL_KINDS(MLT_CASE)
#undef MLT_CASE
  }
  return "?";
}

inline bool same_material(const Material& a, const Material& b) {
  return a.kind == b.kind && a.delta == b.delta && a.roughness == b.roughness && a.ior == b.ior &&
         a.reflectance == b.reflectance && a.eta == b.eta && a.k == b.k;
}

inline std::vector<MaterialCase> material_cases() {
  using Change = std::function<void(MaterialDescription&)>;
  std::vector<std::pair<std::string, Change>> changes;
  changes.emplace_back("default", [](MaterialDescription&) {});
  changes.emplace_back("white", [](MaterialDescription& m) { m.reflectance = {1, 1, 1}; });
  changes.emplace_back("black and coloured", [](MaterialDescription& m) { m.reflectance = {0, 0.3, 0.9}; });
  for (const double ior : {1.0, 1.001, 1.33, 1.5, 3.0}) {
    changes.emplace_back("ior " + std::to_string(ior), [ior](MaterialDescription& m) { m.ior = ior; });
  }
  for (const double alpha : {0.0, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 0.3, 1.0}) {
    changes.emplace_back("roughness " + std::to_string(alpha),
                         [alpha](MaterialDescription& m) { m.roughness = alpha; });
  }
  for (const double alpha : {0.0, 1e-3, 0.3, 1.0}) {
    // Nearly everything is reflected, which is the hardest case for the energy test.
    changes.emplace_back("reflective, roughness " + std::to_string(alpha), [alpha](MaterialDescription& m) {
      m.roughness = alpha;
      m.eta = {0.001, 0.05, 0.01};
      m.k = {100, 20, 50};
    });
  }
  changes.emplace_back("transparent index, roughness 0.5", [](MaterialDescription& m) {
    m.roughness = 0.5;
    m.eta = {1, 1.5, 2};
    m.k = {0, 0, 0.001};
  });

  std::vector<MaterialCase> cases;
#define MLT_KIND(kind_word)                                                                     \
  for (const auto& [label, change] : changes) {                                                 \
    MaterialDescription description;                                                            \
    description.name = #kind_word;                                                              \
    description.kind = MaterialKind::kind_word;                                                 \
    change(description);                                                                        \
    const Material material = compile_material(description);                                    \
    bool known = false;                                                                         \
    for (const MaterialCase& other : cases) known |= same_material(other.material, material);   \
    if (!known) cases.push_back({std::string(#kind_word ", ") + label, description, material}); \
  }
  MLT_MATERIAL_KINDS(MLT_KIND)
#undef MLT_KIND
  return cases;
}

/// Unit direction with this cosine to the normal (negative: from behind), in double before the last rounding.
inline Vec3 direction_from(double cos_theta, double azimuth) {
  const double sin_theta = std::sqrt((1.0 - cos_theta) * (1.0 + cos_theta));
  return Vec3{static_cast<float>(sin_theta * std::cos(azimuth)),
              static_cast<float>(sin_theta * std::sin(azimuth)), static_cast<float>(cos_theta)};
}

/// From straight on to grazing, from both sides, at azimuths that no axis favours.
inline std::vector<Vec3> viewing_directions() {
  return {Vec3{0, 0, 1},
          direction_from(0.9, 2.0),
          direction_from(0.5, 0.7),
          direction_from(0.1, -1.1),
          direction_from(0.01, 4.0),
          direction_from(-0.6, 5.0),
          direction_from(-0.05, 0.3)};
}

/// Uniform direction of the whole sphere, by libm: a test's own.
inline Vec3 random_direction(Rng& rng) {
  const double z = 2.0 * rng.next_float() - 1.0;
  const double azimuth = 6.283185307179586 * rng.next_float();
  return direction_from(z, azimuth);
}

inline Vec2 random_pair(Rng& rng) {
  const float first = rng.next_float();
  const float second = rng.next_float();
  return Vec2{first, second};
}

/// One delta lobe as seen from a direction: its wi, and the radiance scale from wi to wo, which is the weight
/// times the probability of the lobe.
struct DeltaLobe {
  BsdfSample sample;
  double probability = 0;

  double coefficient(int channel) const { return probability * static_cast<double>(sample.weight[channel]); }
};

/// The lobes of a delta material from wo, found by scanning u_lobe and bisecting between different answers.
inline std::vector<DeltaLobe> delta_lobes(const Material& material, const Vec3& wo) {
  const auto at = [&](std::uint32_t step) {
    return sample_bsdf<false>(material, wo, static_cast<float>(step) * 0x1p-24f, Vec2{0.5f, 0.5f});
  };
  constexpr std::uint32_t kEnd = 1U << 24;
  constexpr std::uint32_t kStride = 1U << 18;
  std::vector<DeltaLobe> lobes;
  std::uint32_t begin = 0;
  while (begin < kEnd) {
    const BsdfSample current = at(begin);
    std::uint32_t same = begin;
    std::uint32_t other = begin;
    while (other < kEnd && at(other).wi == current.wi) {
      same = other;
      other += kStride;
    }
    if (other > kEnd) other = kEnd;
    while (other - same > 1) {
      const std::uint32_t middle = same + (other - same) / 2;
      (at(middle).wi == current.wi ? same : other) = middle;
    }
    lobes.push_back({current, static_cast<double>(other - begin) / kEnd});
    begin = other;
  }
  return lobes;
}

}  // namespace mlt::test
