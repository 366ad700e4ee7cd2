// OpenEXR files [Kainz09], by the library of that name; compiled where EXR=yes asks for it.
#if defined(MLT_HAS_OPENEXR)
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>

#include <cmath>
#include <cstring>
#include <exception>
#include <string>
#include <vector>

#include "base/assert.hpp"
#include "base/atomic_file.hpp"
#include "image/image_io.hpp"
#include "image/input_file.hpp"
#include "scene/limits.hpp"

namespace mlt {
namespace {

constexpr const char* kChannels[3] = {"R", "G", "B"};

/// The library goes back to fill in a table, so the whole file is gathered before it is written.
class MemoryStream : public Imf::OStream {
 public:
  MemoryStream() : OStream("") {}
  void write(const char bytes[], int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (bytes_.size() < position_ + size) bytes_.resize(position_ + size);
    std::memcpy(bytes_.data() + position_, bytes, size);
    position_ += size;
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = position; }
  const std::vector<char>& bytes() const { return bytes_; }

 private:
  std::vector<char> bytes_;
  std::size_t position_ = 0;
};

class FileStream : public Imf::IStream {
 public:
  explicit FileStream(const InputFile& file) : IStream(file.path().c_str()), file_(file) {}
  bool read(char bytes[], int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (file_.read(bytes, size, position_) != size) throw std::runtime_error("it ends too early");
    position_ += size;
    return position_ < file_.size();
  }
  std::uint64_t tellg() override { return position_; }
  void seekg(std::uint64_t position) override { position_ = position; }

 private:
  const InputFile& file_;
  std::uint64_t position_ = 0;
};

/// A view of `pixels` as channel `channel`, for a data window that begins at (x, y).
template <class Pixel>
Imf::Slice slice_of(Pixel* pixels, int channel, std::uint32_t width, int x, int y) {
  constexpr std::size_t kPixel = sizeof(Vec3);
  // The library's address of pixel (0, 0), which may lie outside of the memory.
  const auto first =
      reinterpret_cast<std::uintptr_t>(pixels) + sizeof(float) * static_cast<std::size_t>(channel);
  const std::uintptr_t origin = first - static_cast<std::uintptr_t>(static_cast<std::intptr_t>(x)) * kPixel -
                                static_cast<std::uintptr_t>(static_cast<std::intptr_t>(y)) * kPixel * width;
  return Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(origin), kPixel, kPixel * width);
}

std::uint32_t side_of(const InputFile& file, const char* name, int least, int most) {
  const std::int64_t side = std::int64_t{most} - least + 1;
  if (side < 1 || side > kMaxFilmSidePixels) {
    file.fail(std::string("the data window's ") + name + " is " + std::to_string(side) + "; expected 1 to " +
              std::to_string(kMaxFilmSidePixels));
  }
  return static_cast<std::uint32_t>(side);
}

/// R, G and B, or Y in their stead.
void choose_channels(const InputFile& file, const Imf::ChannelList& channels, const char* (&chosen)[3]) {
  const bool is_grey = channels.findChannel("Y") != nullptr && channels.findChannel("R") == nullptr;
  for (int i = 0; i < 3; ++i) {
    chosen[i] = is_grey ? "Y" : kChannels[i];
    const Imf::Channel* channel = channels.findChannel(chosen[i]);
    if (channel == nullptr)
      file.fail(std::string("has no channel ") + chosen[i] + "; expected R, G and B, or Y");
    if (channel->xSampling != 1 || channel->ySampling != 1) {
      file.fail(std::string("channel ") + chosen[i] + " has fewer samples than pixels; expected one a pixel");
    }
  }
}

LoadedImage decode(const InputFile& file) {
  FileStream stream(file);
  Imf::InputFile input(stream, 0);
  const Imath::Box2i window = input.header().dataWindow();
  LoadedImage loaded;
  ImageBuffer& image = loaded.image;
  image.width = side_of(file, "width", window.min.x, window.max.x);
  image.height = side_of(file, "height", window.min.y, window.max.y);
  const char* chosen[3];
  choose_channels(file, input.header().channels(), chosen);
  image.pixels.resize(std::size_t{image.width} * image.height);
  const bool is_grey = chosen[0] == chosen[1];
  Imf::FrameBuffer frame;
  for (int i = 0; i < (is_grey ? 1 : 3); ++i) {
    frame.insert(chosen[i], slice_of(image.pixels.data(), i, image.width, window.min.x, window.min.y));
  }
  input.setFrameBuffer(frame);
  input.readPixels(window.min.y, window.max.y);
  for (Vec3& pixel : image.pixels) {
    if (is_grey) pixel = Vec3{pixel.x};
    if (!std::isfinite(pixel.x) || !std::isfinite(pixel.y) || !std::isfinite(pixel.z)) loaded.non_finite += 1;
  }
  return loaded;
}

}  // namespace

void write_exr(const std::string& path, const ImageView& image, const ImageOptions& options) {
  MLT_CHECK_OP(image.pixels.size(), ==, std::size_t{image.width} * image.height);
  AtomicFile file(path);
  MemoryStream stream;
  try {
    Imf::Header header(static_cast<int>(image.width), static_cast<int>(image.height));
    header.compression() = Imf::ZIP_COMPRESSION;
    for (const TextEntry& entry : options.metadata) {
      header.insert(entry.keyword, Imf::StringAttribute(entry.text));
    }
    Imf::FrameBuffer frame;
    for (int i = 0; i < 3; ++i) {
      header.channels().insert(kChannels[i], Imf::Channel(Imf::FLOAT));
      // The library reads through the address that it declares as writable.
      frame.insert(kChannels[i], slice_of(image.pixels.data(), i, image.width, 0, 0));
    }
    Imf::OutputFile output(stream, header, 0);
    output.setFrameBuffer(frame);
    output.writePixels(static_cast<int>(image.height));
  } catch (const std::exception& error) {
    throw ResourceError(path + ": cannot be made: " + error.what());
  }
  file.write(stream.bytes().data(), stream.bytes().size());
  file.commit();
}

LoadedImage read_exr(const std::string& path) {
  const InputFile file(path, "an OpenEXR image");
  try {
    return decode(file);
  } catch (const InputError&) {
    throw;
  } catch (const std::exception& error) {
    file.fail(std::string("is not an OpenEXR image that can be read: ") + error.what());
  }
}

}  // namespace mlt
#endif
