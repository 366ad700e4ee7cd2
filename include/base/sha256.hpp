// SHA-256 [FIPS180-4] as a stream: the film's hash, by which two renders are known to be the same bit for
// bit. No allocation; results do not depend on how the bytes are cut into calls of update().
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace mlt {

class Sha256 {
 public:
  static constexpr std::size_t kDigestBytes = 32;
  static constexpr std::size_t kBlockBytes = 64;

  /// Appends `size` bytes, less than 2^61 over the whole stream. `bytes` may be null when `size` is 0.
  void update(const void* bytes, std::size_t size);
  /// Pads and returns the digest. May be called once; nothing may be appended after it.
  std::array<std::uint8_t, kDigestBytes> finish();

 private:
  void compress(const std::uint8_t* block);

  std::array<std::uint32_t, 8> state_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                      0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<std::uint8_t, kBlockBytes> pending_{};  ///< the first pending_size_ bytes of an unfinished block
  std::size_t pending_size_ = 0;
  std::uint64_t total_bytes_ = 0;
  bool finished_ = false;
};

/// Lower-case hexadecimal, two digits a byte.
std::string to_hex(std::span<const std::uint8_t> bytes);

}  // namespace mlt
