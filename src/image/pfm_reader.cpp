#include <bit>
#include <charconv>
#include <string_view>

#include "image/image_io.hpp"
#include "image/input_file.hpp"
#include "scene/limits.hpp"

namespace mlt {
namespace {

constexpr std::size_t kMaxHeaderBytes = 256;  // four tokens; the longest sensible header has about 40 bytes

struct PfmHeader {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t channels = 0;
  float scale = 1;  ///< magnitude
  bool little_endian = true;
  std::size_t bytes = 0;  ///< offset of the first value
};

bool is_space(char letter) {
  return letter == ' ' || letter == '\n' || letter == '\t' || letter == '\r';
}

/// Takes the next token and the one white-space character behind it off `rest`.
std::string_view take_token(const InputFile& file, std::string_view& rest) {
  while (!rest.empty() && is_space(rest.front())) rest.remove_prefix(1);
  std::size_t length = 0;
  while (length < rest.size() && !is_space(rest[length])) ++length;
  if (length == rest.size()) file.fail("the header does not end; expected 'PF', width, height and scale");
  const std::string_view token = rest.substr(0, length);
  rest.remove_prefix(length + 1);
  return token;
}

/// Values in messages come from the file, so what a terminal would interpret is replaced.
std::string printable(std::string_view token) {
  std::string text;
  for (const char letter : token.substr(0, 40)) text += letter >= ' ' && letter <= '~' ? letter : '?';
  return text;
}

std::uint32_t parse_side(const InputFile& file, const char* name, std::string_view token) {
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
  if (error != std::errc{} || end != token.data() + token.size() || value < 1 || value > kMaxFilmSidePixels) {
    file.fail(std::string("the ") + name + " is '" + printable(token) + "'; expected an integer from 1 to " +
              std::to_string(kMaxFilmSidePixels));
  }
  return value;
}

PfmHeader parse_header(const InputFile& file) {
  char bytes[kMaxHeaderBytes];
  const std::string_view all(bytes, file.read(bytes, sizeof bytes, 0));
  std::string_view rest = all;
  PfmHeader header;
  if (all.substr(0, 2) != "PF" && all.substr(0, 2) != "Pf") {
    file.fail("starts with '" + printable(all.substr(0, 2)) +
              "'; expected a PFM image, which starts with 'PF'");
  }
  const std::string_view magic = take_token(file, rest);
  if (magic.size() != 2) file.fail("starts with '" + printable(magic) + "'; expected 'PF' or 'Pf'");
  header.channels = magic == "PF" ? 3 : 1;
  header.width = parse_side(file, "width", take_token(file, rest));
  header.height = parse_side(file, "height", take_token(file, rest));
  const std::string_view scale = take_token(file, rest);
  const auto [end, error] = std::from_chars(scale.data(), scale.data() + scale.size(), header.scale);
  if (error != std::errc{} || end != scale.data() + scale.size() || !std::isfinite(header.scale) ||
      header.scale == 0.0f) {
    file.fail("the scale is '" + printable(scale) +
              "'; expected a number other than 0, negative for little-endian");
  }
  header.little_endian = header.scale < 0;
  header.scale = std::fabs(header.scale);
  header.bytes = all.size() - rest.size();
  return header;
}

float decode(const std::uint8_t* bytes, bool little_endian) {
  std::uint32_t bits = 0;
  for (int i = 0; i < 4; ++i) bits |= std::uint32_t{bytes[i]} << (little_endian ? 8 * i : 24 - 8 * i);
  return std::bit_cast<float>(bits);
}

}  // namespace

LoadedImage read_pfm(const std::string& path) {
  const InputFile file(path, "a PFM image");
  const PfmHeader header = parse_header(file);
  // At most 2^16 * 2^16 * 12, far below 2^64.
  const std::uint64_t row_bytes = std::uint64_t{4} * header.channels * header.width;
  const std::uint64_t expected = header.bytes + row_bytes * header.height;
  if (file.size() != expected) {
    file.fail("has " + std::to_string(file.size()) + " bytes; expected " + std::to_string(expected) +
              " for " + std::to_string(header.width) + " x " + std::to_string(header.height) + " pixels of " +
              std::to_string(header.channels) + " channels");
  }
  LoadedImage result;
  result.image.width = header.width;
  result.image.height = header.height;
  result.image.pixels.resize(std::size_t{header.width} * header.height, Vec3{0, 0, 0});
  std::vector<std::uint8_t> row(row_bytes);
  for (std::uint32_t i = 0; i < header.height; ++i) {
    if (file.read(row.data(), row.size(), header.bytes + row_bytes * i) != row.size()) {
      file.fail("became shorter while it was read");
    }
    Vec3* pixels = result.image.pixels.data() + std::size_t{header.height - 1 - i} * header.width;
    for (std::uint32_t x = 0; x < header.width; ++x) {
      for (std::uint32_t channel = 0; channel < 3; ++channel) {
        const std::size_t index = std::size_t{x} * header.channels + (header.channels == 3 ? channel : 0);
        pixels[x][static_cast<int>(channel)] =
            decode(row.data() + 4 * index, header.little_endian) * header.scale;
      }
      if (!is_finite(pixels[x])) ++result.non_finite;
    }
  }
  return result;
}

}  // namespace mlt
