// The words of the scene format: statements and the clauses that may follow their arguments. Names, usage
// lines in diagnostics, suggestions for misspelt words and the check of docs/SCENES.md all come from here.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "scene/description.hpp"

namespace mlt {

/// word, form. Positional arguments come first, clauses after them in any order.
#define MLT_SCENE_STATEMENTS(X)                                                               \
  X(include, "include FILE")                                                                  \
  X(define, "define NAME VALUE...")                                                           \
  X(film, "film WIDTH HEIGHT")                                                                \
  X(depth, "depth EDGES")                                                                     \
  X(camera, "camera eye X Y Z target X Y Z [up X Y Z] [fov DEGREES]")                         \
  X(material, "material NAME KIND [PARAMETER VALUE...]...")                                   \
  X(triangle, "triangle X1 Y1 Z1 X2 Y2 Z2 X3 Y3 Z3 material NAME [clauses]")                  \
  X(quad, "quad X1 Y1 Z1 X2 Y2 Z2 X3 Y3 Z3 X4 Y4 Z4 material NAME [clauses]")                 \
  X(box, "box XMIN YMIN ZMIN XMAX YMAX ZMAX material NAME [inward] [clauses]")                \
  X(sphere, "sphere X Y Z RADIUS material NAME [clauses]")                                    \
  X(mesh, "mesh FILE material NAME [clauses]")                                                \
  X(inline_mesh, "inline_mesh material NAME [clauses], then vertex and face lines up to end") \
  X(vertex, "vertex X Y Z, between inline_mesh and end")                                      \
  X(face, "face I J K..., indices of vertices from 0, between inline_mesh and end")           \
  X(end, "end, after inline_mesh")

/// word, form.
#define MLT_CAMERA_CLAUSES(X) \
  X(eye, "eye X Y Z")         \
  X(target, "target X Y Z")   \
  X(up, "up X Y Z")           \
  X(fov, "fov DEGREES")

/// word, form.
#define MLT_MATERIAL_CLAUSES(X)       \
  X(reflectance, "reflectance R G B") \
  X(ior, "ior VALUE")                 \
  X(eta, "eta R G B")                 \
  X(k, "k R G B")                     \
  X(preset, "preset NAME")            \
  X(roughness, "roughness ALPHA")

/// word, form.
#define MLT_SHAPE_CLAUSES(X)          \
  X(material, "material NAME")        \
  X(emit, "emit R G B")               \
  X(translate, "translate X Y Z")     \
  X(rotate, "rotate DEGREES X Y Z")   \
  X(scale, "scale S, or scale X Y Z") \
  X(inward, "inward, of a box")

#define MLT_ENUMERATE_WORD(word, form) word,
enum class StatementKind : std::uint8_t { MLT_SCENE_STATEMENTS(MLT_ENUMERATE_WORD) };
enum class CameraClause : std::uint8_t { MLT_CAMERA_CLAUSES(MLT_ENUMERATE_WORD) };
enum class MaterialClause : std::uint8_t { MLT_MATERIAL_CLAUSES(MLT_ENUMERATE_WORD) };
enum class ShapeClause : std::uint8_t { MLT_SHAPE_CLAUSES(MLT_ENUMERATE_WORD) };
#undef MLT_ENUMERATE_WORD

struct Keyword {
  const char* word;
  const char* form;
};

#define MLT_KEYWORD_ROW(word, form) Keyword{#word, form},
inline constexpr Keyword kStatements[] = {MLT_SCENE_STATEMENTS(MLT_KEYWORD_ROW)};
inline constexpr Keyword kCameraClauses[] = {MLT_CAMERA_CLAUSES(MLT_KEYWORD_ROW)};
inline constexpr Keyword kMaterialClauses[] = {MLT_MATERIAL_CLAUSES(MLT_KEYWORD_ROW)};
inline constexpr Keyword kShapeClauses[] = {MLT_SHAPE_CLAUSES(MLT_KEYWORD_ROW)};
#undef MLT_KEYWORD_ROW

/// The material kinds' words, from MLT_MATERIAL_KINDS.
std::vector<std::string> material_kind_names();

/// Named conductors: index of refraction and extinction for red, green and blue.
struct ConductorPreset {
  const char* name;
  double eta[3];
  double k[3];
};

/// RGB projections of measured spectra as RGB renderers commonly use them; the measurements are those of
/// [Johnson72] (gold, silver, copper) and [Rakic98] (aluminium).
inline constexpr ConductorPreset kConductorPresets[] = {
    {"aluminium", {1.657, 0.880, 0.521}, {9.224, 6.270, 4.837}},
    {"copper", {0.200, 0.924, 1.102}, {3.912, 2.452, 2.142}},
    {"gold", {0.143, 0.375, 1.442}, {3.983, 2.386, 1.603}},
    {"silver", {0.155, 0.117, 0.138}, {4.828, 3.122, 2.147}},
};

/// "; allowed are a, b and c", or the nearest of them when `word` is close to one.
std::string allowed_words(std::string_view word, const std::vector<std::string>& allowed);

}  // namespace mlt
