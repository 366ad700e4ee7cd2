// libFuzzer harness of the OBJ reader.
#include "fuzz/mesh_fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz_mesh(data, size, "fuzz.obj", mlt::read_obj);
  return 0;
}
