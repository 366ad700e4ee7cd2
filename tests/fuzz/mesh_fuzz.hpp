// What the harnesses of mesh readers share: any bytes give a mesh with finite vertices and indices in range,
// or an error. The budget is small so that both of its limits are met.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "base/error.hpp"
#include "fuzz/fuzz.hpp"
#include "scene/limits.hpp"
#include "scene/mesh_file.hpp"

inline void check(const mlt::MeshData& mesh, const mlt::MeshBudget& budget) {
  require(mesh.vertices.size() <= budget.vertices && mesh.indices.size() <= budget.triangles * 3);
  require(!mesh.indices.empty() && mesh.indices.size() % 3 == 0);
  for (const std::uint32_t index : mesh.indices) require(index < mesh.vertices.size());
  for (const mlt::DVec3& vertex : mesh.vertices) {
    require(std::isfinite(vertex.x) && std::isfinite(vertex.y) && std::isfinite(vertex.z));
  }
}

/// Reader is called with the bytes, a name and the budget.
template <class Reader>
void fuzz_mesh(const std::uint8_t* data, std::size_t size, const char* name, Reader read) {
  constexpr mlt::MeshBudget kBudget{4096, 4096};
  try {
    check(read({reinterpret_cast<const char*>(data), size}, name, kBudget), kBudget);
  } catch (const mlt::InputError& error) {
    require(!error.diagnostics().empty() && error.diagnostics().size() <= mlt::kMaxDiagnostics);
  } catch (const mlt::ResourceError&) {
  }
}
