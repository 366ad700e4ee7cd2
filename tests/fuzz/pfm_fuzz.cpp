// libFuzzer harness of the PFM reader: any bytes give a picture of the size that its header states, or an
// error. The reader takes a path, so the bytes go through a file in memory.
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "base/error.hpp"
#include "image/image_io.hpp"

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

class MemoryFile {
 public:
  MemoryFile(const std::uint8_t* data, std::size_t size) : descriptor_(::memfd_create("fuzz.pfm", 0)) {
    require(descriptor_ >= 0);
    while (size > 0) {
      const ssize_t written = ::write(descriptor_, data, size);
      require(written > 0);
      data += written;
      size -= static_cast<std::size_t>(written);
    }
  }
  ~MemoryFile() { ::close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

}  // namespace

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
