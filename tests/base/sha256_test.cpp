#include "base/sha256.hpp"

#include <catch2/catch.hpp>
#include <string>

#include "base/sha256_compress.hpp"

namespace mlt {
namespace {

std::string hash_of(const std::string& text) {
  Sha256 hash;
  hash.update(text.data(), text.size());
  return to_hex(hash.finish());
}

TEST_CASE("SHA-256 gives the digests that FIPS 180-4 publishes") {
  // The examples of the standard, and the empty message of NIST's validation suite.
  CHECK(hash_of("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(hash_of("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(hash_of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq") ==
        "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  CHECK(hash_of(std::string(1000000, 'a')) ==
        "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST_CASE("SHA-256 pads messages of every length around the block size") {
  // Digests of n bytes 'a', made with sha256sum: the length field just fits, just misses, fills a block.
  CHECK(hash_of(std::string(55, 'a')) == "9f4390f8d30c2dd92ec9f095b65e2b9ae9b0a925a5258e241c9f1e910f734318");
  CHECK(hash_of(std::string(56, 'a')) == "b35439a4ac6f0948b6d6f9e3c6af0f5f590ce20f1bde7090ef7970686ec6738a");
  CHECK(hash_of(std::string(63, 'a')) == "7d3e74a05d7db15bce4ad9ec0658ea98e3f06eeecf16b4c6fff2da457ddc2f34");
  CHECK(hash_of(std::string(64, 'a')) == "ffe054fe7ae0cb6dc65c3af9b61d5209f439851db43d0ba5997337df154668eb");
  CHECK(hash_of(std::string(65, 'a')) == "635361c48bb9eab14198e76ea8ab7f1a41685d6ad62aa9146d301d4f17eb0ae0");
  CHECK(hash_of(std::string(119, 'a')) == "31eba51c313a5c08226adf18d4a359cfdfd8d2e816b13f4af952f7ea6584dcfb");
  CHECK(hash_of(std::string(120, 'a')) == "2f3d335432c70b580af0e8e1b3674a7c020d683aa5f73aaaedfdc55af904c21c");
}

TEST_CASE("SHA-256 does not depend on how the bytes are cut into updates") {
  std::string text;
  for (int i = 0; i < 300; ++i) text += static_cast<char>(i * 7 + 3);
  const std::string whole = hash_of(text);
  for (std::size_t first = 0; first <= 130; ++first) {
    for (const std::size_t second : {std::size_t{0}, std::size_t{1}, std::size_t{63}, std::size_t{64}}) {
      Sha256 hash;
      hash.update(text.data(), first);
      hash.update(text.data() + first, second);
      hash.update(nullptr, 0);
      hash.update(text.data() + first + second, text.size() - first - second);
      REQUIRE(to_hex(hash.finish()) == whole);
    }
  }
}

TEST_CASE("the processor's instructions for SHA-256 do what the portable code does") {
  const Sha256Compress by_instructions = sha256_by_instructions();
  if (by_instructions == nullptr) {
    WARN("this processor has none");
    return;
  }
  // Random blocks, and states that follow from them.
  Sha256State portable{1, 2, 3, 4, 5, 6, 7, 8};
  Sha256State instructed = portable;
  std::uint8_t block[Sha256::kBlockBytes];
  std::uint32_t number = 1;
  for (int i = 0; i < 1000; ++i) {
    for (std::uint8_t& byte : block) {
      number = number * 1664525U + 1013904223U;
      byte = static_cast<std::uint8_t>(number >> 24);
    }
    compress_sha256_portably(portable, block);
    by_instructions(instructed, block);
    REQUIRE(instructed == portable);
  }
}

TEST_CASE("to_hex writes two digits a byte") {
  const std::uint8_t bytes[] = {0x00, 0x0f, 0xa5, 0xff};
  CHECK(to_hex(bytes) == "000fa5ff");
  CHECK(to_hex({}) == "");
}

}  // namespace
}  // namespace mlt
