// libFuzzer harness of the PLY reader.
#include "fuzz/mesh_fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz_mesh(data, size, "fuzz.ply", mlt::read_ply);
  return 0;
}
