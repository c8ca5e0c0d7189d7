#include "core/hash.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "core/sha256_blocks.h"

namespace crowdbench {
namespace {

// FIPS 180-2, appendix B.1, and the digest of no bytes.
TEST(Sha256, KnownDigests) {
  EXPECT_EQ(sha256_hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_hex(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(Sha256, TextsAreToldApartByTheirLengths) {
  // The bytes are 02 00.. "ab" 01 00.. "c", hashed by an independent implementation.
  EXPECT_EQ(Sha256().text("ab").text("c").hex(), "43ee655579de01ca739b3f95c1c2d3f46d353b2c0df818064ea594506cdb2617");
  EXPECT_NE(Sha256().text("a").text("bc").hex(), Sha256().text("ab").text("c").hex());
}

TEST(Sha256, NumbersAreTheirBytes) {
  const uint32_t number = 0x64636261;  // "abcd" in memory
  EXPECT_EQ(Sha256().value(number).hex(), sha256_hex("abcd"));
  EXPECT_NE(Sha256().values(std::vector<int>{1, 2}).hex(), Sha256().values(std::vector<int>{1}).value(2).hex());
}

// FIPS 180-2, appendix B.3: a million times the letter a. In pieces of every length, so that whole blocks begin
// anywhere.
TEST(Sha256, OfPiecesIsThatOfTheWhole) {
  const std::string letters(1'000'000, 'a');
  const std::string published = "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0";
  EXPECT_EQ(sha256_hex(letters), published);
  Sha256 pieces;
  for (size_t at = 0, n = 0; at < letters.size(); at += n, n = n % 700 + 1)
    pieces.bytes(letters.data() + at, std::min(n, letters.size() - at));
  EXPECT_EQ(pieces.hex(), published);
}

// Short pieces go through libmd, and long ones through the processor's instructions where it has them.
TEST(Sha256, IsTheSameByWhicheverCode) {
  std::string bytes;
  for (uint32_t i = 0; i < 1000; ++i) bytes.push_back(static_cast<char>(i * 2654435761U >> 24));
  for (size_t length = 0; length <= bytes.size(); ++length) {
    Sha256 apart;
    for (size_t i = 0; i < length; ++i) apart.bytes(&bytes[i], 1);
    ASSERT_EQ(sha256_hex(std::string_view(bytes).substr(0, length)), apart.hex()) << length;
  }
}

// FIPS 180-2, appendix B.1: the one block of "abc", as padded there.
TEST(Sha256, InstructionsCompressTheBlockOfAbc) {
  if (!has_sha256_instructions()) GTEST_SKIP() << "needs a processor with SHA instructions";
  std::vector<uint8_t> block(64, 0);
  std::copy_n("abc\x80", 4, block.begin());
  block[63] = 24;
  std::vector<uint32_t> state = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                 0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  compress_sha256(state.data(), block.data(), 1);
  EXPECT_EQ(state, (std::vector<uint32_t>{0xba7816bf, 0x8f01cfea, 0x414140de, 0x5dae2223, 0xb00361a3, 0x96177a9c,
                                          0xb410ff61, 0xf20015ad}));
}

// The values that xxHash's own self-test has for no bytes, with two seeds, and for one byte of zero.
TEST(Xxh3, PublishedValues) {
  EXPECT_EQ(xxh3_64({}), 0x2D06800538D394C2U);
  EXPECT_EQ(xxh3_64({}, 0x9E3779B185EBCA8DU), 0xA8A6B918B2F0364AU);
  EXPECT_EQ(xxh3_64(std::vector<uint8_t>{0}), 0xC44BDFF4074EECDBU);
}

TEST(Xxh3, DependsOnEveryByteItsPlaceAndTheLength) {
  const std::vector<uint8_t> zeros(300, 0);
  std::set<uint64_t> seen;
  for (size_t n = 0; n <= zeros.size(); ++n) seen.insert(xxh3_64(std::span(zeros).first(n)));
  for (size_t i = 0; i < zeros.size(); ++i) {
    std::vector<uint8_t> one = zeros;
    one[i] = 1;
    seen.insert(xxh3_64(one));
  }
  EXPECT_EQ(seen.size(), 601U);
}

}  // namespace
}  // namespace crowdbench
