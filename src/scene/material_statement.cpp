// The material statement: which parameters a kind takes, and the named conductors.
#include "scene/limits.hpp"
#include "scene/parser_state.hpp"

namespace mlt {
namespace {

/// Which clauses a material kind takes; the switch makes a new kind state its own.
bool takes(MaterialKind kind, MaterialClause clause) {
  switch (kind) {
    case MaterialKind::diffuse:
    case MaterialKind::mirror:
      return clause == MaterialClause::reflectance;
    case MaterialKind::dielectric:
      return clause == MaterialClause::ior;
    case MaterialKind::conductor:
      return clause == MaterialClause::eta || clause == MaterialClause::k ||
             clause == MaterialClause::preset || clause == MaterialClause::roughness;
  }
  return false;
}

/// Set bit i: clause i was given.
using ClauseSet = std::uint32_t;

constexpr ClauseSet bit(MaterialClause clause) {
  return 1U << static_cast<unsigned>(clause);
}

/// What a kind cannot do without, in words; empty when it is there.
const char* missing_parameter(MaterialKind kind, ClauseSet given) {
  switch (kind) {
    case MaterialKind::diffuse:
    case MaterialKind::mirror:
      return (given & bit(MaterialClause::reflectance)) != 0 ? "" : "reflectance";
    case MaterialKind::dielectric:
      return "";
    case MaterialKind::conductor: {
      const bool constants = (given & bit(MaterialClause::eta)) != 0 && (given & bit(MaterialClause::k)) != 0;
      return constants || (given & bit(MaterialClause::preset)) != 0 ? "" : "preset, or both eta and k";
    }
  }
  return "";
}

void read_preset(MaterialDescription& material, StatementCursor& cursor) {
  std::vector<std::string> names;
  for (const ConductorPreset& preset : kConductorPresets) names.emplace_back(preset.name);
  const ConductorPreset& preset = kConductorPresets[cursor.choice(names, "a named conductor")];
  material.eta = DVec3{preset.eta[0], preset.eta[1], preset.eta[2]};
  material.k = DVec3{preset.k[0], preset.k[1], preset.k[2]};
}

double read_roughness(StatementCursor& cursor) {
  const double roughness = cursor.number("the roughness");
  if (roughness != 0 && !(roughness >= kMinRoughness && roughness <= 1)) {
    fail_at(cursor.last(), "the roughness is " + format_number(roughness) + "; allowed is 0 or in [" +
                               format_number(kMinRoughness) + ", 1]");
  }
  return roughness;
}

void read_clause(MaterialDescription& material, MaterialClause clause, StatementCursor& cursor) {
  switch (clause) {
    case MaterialClause::reflectance:
      material.reflectance = cursor.colour("a channel of the reflectance", {0, 1});
      break;
    case MaterialClause::ior:
      material.ior = cursor.number_in("the index of refraction", {1, kMaxIor});
      break;
    case MaterialClause::eta:
      material.eta = cursor.colour("a channel of eta", {kMinConductorEta, kMaxConductorEta});
      break;
    case MaterialClause::k:
      material.k = cursor.colour("a channel of k", {0, kMaxConductorEta});
      break;
    case MaterialClause::preset:
      read_preset(material, cursor);
      break;
    case MaterialClause::roughness:
      material.roughness = read_roughness(cursor);
      break;
  }
}

std::string parameters_of(MaterialKind kind) {
  std::string text;
  for (std::size_t i = 0; i < std::size(kMaterialClauses); ++i) {
    if (takes(kind, static_cast<MaterialClause>(i))) {
      text += (text.empty() ? "" : ", ") + std::string(kMaterialClauses[i].word);
    }
  }
  return text;
}

void read_parameters(MaterialDescription& material, StatementCursor& cursor) {
  const std::string kind_name = material_kind_names()[static_cast<std::size_t>(material.kind)];
  ClauseSet given = 0;
  while (!cursor.at_end()) {
    const std::size_t index = cursor.keyword(kMaterialClauses, "a parameter of a material");
    const auto clause = static_cast<MaterialClause>(index);
    const std::string word = kMaterialClauses[index].word;
    if (!takes(material.kind, clause)) {
      fail_at(cursor.last(),
              kind_name + " has no parameter '" + word + "'; it takes " + parameters_of(material.kind));
    }
    if ((given & bit(clause)) != 0) fail_at(cursor.last(), word + " is given twice");
    given |= bit(clause);
    read_clause(material, clause, cursor);
  }
  const bool preset = (given & bit(MaterialClause::preset)) != 0;
  if (preset && (given & (bit(MaterialClause::eta) | bit(MaterialClause::k))) != 0) {
    fail_at(cursor.start(), "a conductor has a preset or eta and k, not both");
  }
  const std::string missing = missing_parameter(material.kind, given);
  if (!missing.empty()) fail_at(cursor.here(), "the " + kind_name + " material needs " + missing);
}

}  // namespace

void parse_material(ParserState& state, StatementCursor& cursor) {
  MaterialDescription material;
  material.location = cursor.start();
  material.name = cursor.name("the material's name");
  const auto known = state.material_index.find(material.name);
  if (known != state.material_index.end()) {
    const SourceLocation& first = state.scene.materials[known->second].location;
    fail_at(cursor.last(), "a second material " + printable(material.name) + "; the first stands at " +
                               first.file + ":" + std::to_string(first.line));
  }
  if (state.scene.materials.size() >= kMaxMaterials) {
    throw ResourceError(diagnostic_at(cursor.start(), "more than " + std::to_string(kMaxMaterials) +
                                                          " materials, which is the limit")
                            .to_string());
  }
  // The name is known from here on even if its parameters are faulty, so that its users are not reported too.
  const std::size_t index = state.scene.materials.size();
  state.material_index[material.name] = static_cast<std::uint32_t>(index);
  state.scene.materials.push_back(material);
  material.kind = static_cast<MaterialKind>(cursor.choice(material_kind_names(), "a kind of material"));
  read_parameters(material, cursor);
  state.scene.materials[index] = material;
}

}  // namespace mlt
