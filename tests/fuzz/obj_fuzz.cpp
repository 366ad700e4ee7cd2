// libFuzzer harness of the OBJ reader: any bytes give a mesh with finite vertices and indices in range, or an
// error. The budget is small so that both of its limits are met.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "base/error.hpp"
#include "scene/limits.hpp"
#include "scene/mesh_file.hpp"

namespace {

constexpr mlt::MeshBudget kBudget{4096, 4096};

void require(bool condition) {
  if (!condition) std::abort();
}

void check(const mlt::MeshData& mesh) {
  require(mesh.vertices.size() <= kBudget.vertices && mesh.indices.size() <= kBudget.triangles * 3);
  require(!mesh.indices.empty() && mesh.indices.size() % 3 == 0);
  for (const std::uint32_t index : mesh.indices) require(index < mesh.vertices.size());
  for (const mlt::DVec3& vertex : mesh.vertices) {
    require(std::isfinite(vertex.x) && std::isfinite(vertex.y) && std::isfinite(vertex.z));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    check(mlt::read_obj({reinterpret_cast<const char*>(data), size}, "fuzz.obj", kBudget));
  } catch (const mlt::InputError& error) {
    require(!error.diagnostics().empty() && error.diagnostics().size() <= mlt::kMaxDiagnostics);
  } catch (const mlt::ResourceError&) {
  }
  return 0;
}
