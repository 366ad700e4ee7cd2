// libFuzzer harness of the PFM reader: any bytes give a picture of the size that its header states, or an
// error. The reader takes a path, so the bytes go through a file in memory.
#include <cstddef>
#include <cstdint>

#include "base/error.hpp"
#include "fuzz/memory_file.hpp"
#include "image/image_io.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const MemoryFile file(data, size);
  try {
    const mlt::LoadedImage read = mlt::read_pfm(file.path());
    require(read.image.width > 0 && read.image.height > 0);
    require(read.image.pixels.size() == std::size_t{read.image.width} * read.image.height);
    require(read.non_finite <= read.image.pixels.size());
  } catch (const mlt::InputError& error) {
    require(!error.diagnostics().empty());
  }
  return 0;
}
