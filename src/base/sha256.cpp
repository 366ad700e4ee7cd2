#include "base/sha256.hpp"

#include <cstring>

#include "base/assert.hpp"
#include "base/sha256_compress.hpp"

namespace mlt {
namespace {

Sha256Compress fastest() {
  const Sha256Compress by_instructions = sha256_by_instructions();
  return by_instructions != nullptr ? by_instructions : &compress_sha256_portably;
}

}  // namespace

void Sha256::compress(const std::uint8_t* block) {
  static const Sha256Compress compress_block = fastest();
  compress_block(state_, block);
}

void Sha256::update(const void* bytes, std::size_t size) {
  MLT_CHECK(!finished_);
  if (size == 0) return;
  const auto* next = static_cast<const std::uint8_t*>(bytes);
  total_bytes_ += size;
  if (pending_size_ > 0) {
    const std::size_t taken = size < kBlockBytes - pending_size_ ? size : kBlockBytes - pending_size_;
    std::memcpy(pending_.data() + pending_size_, next, taken);
    pending_size_ += taken;
    next += taken;
    size -= taken;
    if (pending_size_ < kBlockBytes) return;
    compress(pending_.data());
    pending_size_ = 0;
  }
  for (; size >= kBlockBytes; next += kBlockBytes, size -= kBlockBytes) compress(next);
  if (size > 0) std::memcpy(pending_.data(), next, size);
  pending_size_ = size;
}

std::array<std::uint8_t, Sha256::kDigestBytes> Sha256::finish() {
  MLT_CHECK(!finished_);
  const std::uint64_t total_bits = total_bytes_ * 8;
  constexpr std::size_t kLengthStart = kBlockBytes - 8;
  // A one bit, zeros up to the last 8 bytes of a block, and the length in bits [FIPS180-4 section 5.1.1].
  const std::size_t used = pending_size_ + 1;
  const std::size_t zeros = (used <= kLengthStart ? kLengthStart : kLengthStart + kBlockBytes) - used;
  std::array<std::uint8_t, 2 * kBlockBytes> padding{0x80};
  for (std::size_t i = 0; i < 8; ++i) {
    padding[1 + zeros + i] = static_cast<std::uint8_t>(total_bits >> (56 - 8 * i));
  }
  update(padding.data(), 1 + zeros + 8);
  MLT_CHECK_OP(pending_size_, ==, 0u);
  finished_ = true;
  std::array<std::uint8_t, kDigestBytes> digest;
  for (std::size_t i = 0; i < kDigestBytes; ++i) {
    digest[i] = static_cast<std::uint8_t>(state_[i / 4] >> (24 - 8 * (i % 4)));
  }
  return digest;
}

std::string to_hex(std::span<const std::uint8_t> bytes) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  text.reserve(2 * bytes.size());
  for (const std::uint8_t byte : bytes) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

}  // namespace mlt
