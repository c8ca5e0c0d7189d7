#include "core/image_io.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/files.h"
#include "core/random.h"

namespace crowdbench {
namespace {

namespace fs = std::filesystem;

Image8 pattern(int width, int height, int channels) {
  Image8 image(width, height, channels);
  for (size_t i = 0; i < image.data.size(); ++i) image.data[i] = static_cast<uint8_t>(random_below(1, i, 1, 256));
  return image;
}

std::string error_of(const std::vector<uint8_t>& bytes) {
  try {
    decode_png(bytes, "x.png");
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

TEST(Png, RoundTripKeepsEveryByteOfEveryChannelCount) {
  for (const int channels : {1, 3, 4}) {
    const Image8 image = pattern(37, 19, channels);
    EXPECT_EQ(decode_png(encode_png(image), "memory"), image) << channels;
  }
}

TEST(Png, SamePixelsAndMetadataGiveTheSameBytes) {
  const Image8 image = pattern(64, 48, 3);
  const ImageMetadata metadata{{"seed", "7"}, {"scenario", "a\nb"}, {"name", "caf\xc3\xa9"}};
  const auto bytes = encode_png(image, metadata);
  EXPECT_EQ(bytes, encode_png(image, metadata));
  EXPECT_NE(bytes, encode_png(image));
  EXPECT_EQ(decode_png(bytes, "memory"), image);
  const std::string text(bytes.begin(), bytes.end());
  EXPECT_NE(text.find(std::string("tEXtseed\0"
                                  "7",
                                  10)),
            std::string::npos);
  EXPECT_NE(text.find("iTXtname"), std::string::npos);
  EXPECT_NE(text.find("caf\xc3\xa9"), std::string::npos);
  EXPECT_EQ(text.find("tIME"), std::string::npos);
}

TEST(Png, WritesAFileAndLeavesNoOther) {
  const fs::path folder = fs::path(::testing::TempDir()) / "crowdbench_png";
  fs::remove_all(folder);
  const Image8 image = pattern(5, 4, 4);
  write_png(folder / "deep" / "x.png", image);
  EXPECT_EQ(decode_png(read_file(folder / "deep" / "x.png"), "x"), image);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "deep"), fs::directory_iterator()), 1);
  fs::remove_all(folder);
}

TEST(Png, RefusesWhatIsNotAPictureInOneLine) {
  EXPECT_EQ(error_of({}), "x.png: is not a PNG picture; name a PNG file");
  auto bytes = encode_png(pattern(40, 40, 3));
  bytes.resize(bytes.size() / 2);
  EXPECT_EQ(error_of(bytes), "x.png: damaged PNG (the file ends too early); write the file again");
}

void put_big_endian(std::vector<uint8_t>& bytes, size_t at, uint32_t value) {
  for (size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<uint8_t>(value >> (24 - 8 * i));
}

// Makes the checksum of every chunk right again, as far as the chunks are whole.
void repair_checksums(std::vector<uint8_t>& png) {
  for (size_t at = 8; at + 12 <= png.size();) {
    size_t length = 0;
    for (size_t i = 0; i < 4; ++i) length = length << 8 | png[at + i];
    if (length > png.size() - at - 12) return;
    uint32_t crc = 0xffffffffU;
    for (size_t i = at + 4; i < at + 8 + length; ++i) {
      crc ^= png[i];
      for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1U) != 0 ? 0xedb88320U : 0U);
    }
    put_big_endian(png, at + 8 + length, ~crc);
    at += 12 + length;
  }
}

void patch_size(std::vector<uint8_t>& png, uint32_t width, uint32_t height) {
  put_big_endian(png, 16, width);
  put_big_endian(png, 20, height);
  repair_checksums(png);
}

TEST(Png, RefusesHugeClaimsBeforeAllocating) {
  auto bytes = encode_png(pattern(8, 8, 4));
  patch_size(bytes, 16384, 8192);
  EXPECT_NE(error_of(bytes).find("cannot hold 16384 x 8192 pixels"), std::string::npos) << error_of(bytes);
  patch_size(bytes, 16385, 1);
  EXPECT_NE(error_of(bytes).find("more than the limit of 16384 a side"), std::string::npos) << error_of(bytes);
  patch_size(bytes, 16384, 16384);
  EXPECT_NE(error_of(bytes).find("134217728 in all"), std::string::npos) << error_of(bytes);
  patch_size(bytes, 0, 4);
  EXPECT_NE(error_of(bytes).find("damaged PNG"), std::string::npos) << error_of(bytes);
}

// Mutants of several kinds of PNG, most with right checksums so that they come past the first gate: each decodes to a
// picture of a legal shape or is refused by an Error. Sanitizer builds make this a finer net.
TEST(Png, MutatedBytesEitherDecodeOrAreRefused) {
  const std::vector<std::vector<uint8_t>> seeds = {encode_png(pattern(9, 7, 1), {{"k", "v"}, {"long", "text here"}}),
                                                   encode_png(pattern(6, 11, 3)), encode_png(pattern(13, 3, 4))};
  constexpr uint64_t kRounds = 6000;
  uint64_t decoded = 0;
  uint64_t refused = 0;
  for (uint64_t round = 0; round < kRounds; ++round) {
    std::vector<uint8_t> bytes = seeds[round % seeds.size()];
    const uint64_t edits = 1 + random_below(11, round, 1, 3);
    for (uint64_t e = 0; e < edits; ++e) {
      const uint64_t key = round * 8 + e;
      const size_t at = 8 + random_below(11, key, 2, bytes.size() - 8);
      switch (random_below(11, key, 3, 6)) {
        case 0: bytes[at] = static_cast<uint8_t>(random_below(11, key, 4, 256)); break;
        case 1: bytes.insert(bytes.begin() + static_cast<ptrdiff_t>(at), 0xff); break;
        case 2: bytes.resize(std::max<size_t>(at, 9)); break;
        case 3: bytes[24 + random_below(11, key, 6, 5)] = static_cast<uint8_t>(random_below(11, key, 7, 20)); break;
        default: bytes[at] ^= static_cast<uint8_t>(1U << random_below(11, key, 5, 8)); break;
      }
      if (bytes.size() < 40) break;
    }
    if (round % 4 != 0) repair_checksums(bytes);
    try {
      const Image8 image = decode_png(bytes, "mutant");
      EXPECT_EQ(image.data.size(), image.pixels() * static_cast<size_t>(image.channels));
      EXPECT_TRUE(image.channels == 1 || image.channels == 3 || image.channels == 4);
      ++decoded;
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(decoded, kRounds / 100);
  EXPECT_GT(refused, kRounds / 4);
  RecordProperty("decoded", static_cast<int>(decoded));
}

}  // namespace
}  // namespace crowdbench
