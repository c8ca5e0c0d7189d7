#include "core/hash.h"

#include <gtest/gtest.h>

#include <set>

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
