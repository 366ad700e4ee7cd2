#include "material/material.hpp"

#include "material/bsdf.hpp"

namespace mlt {

Material compile_material(const MaterialDescription& description) {
  Material material;
  material.kind = description.kind;
  switch (description.kind) {
#define MLT_CASE(name)                           \
  case MaterialKind::name:                       \
    name##_bsdf::compile(description, material); \
    break;
    MLT_MATERIAL_KINDS(MLT_CASE)
#undef MLT_CASE
  }
  return material;
}

}  // namespace mlt
