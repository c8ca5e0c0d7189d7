#include "core/colour_tags.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

namespace crowdbench {
namespace {

std::string number(uint32_t value) {
  std::string out;
  for (const int shift : {24, 16, 8, 0}) out += static_cast<char>(value >> shift & 0xff);
  return out;
}
std::string chunk(const std::string& type, const std::string& data) {
  return number(static_cast<uint32_t>(data.size())) + type + data + number(0);
}
std::string tags_of(const std::string& chunks) {
  const std::string file = "\x89PNG\r\n\x1a\n" + chunks;
  return colour_tags(std::vector<uint8_t>(file.begin(), file.end()));
}

const std::string kHeader = chunk("IHDR", std::string(13, '\0'));
const std::string kSrgb = chunk("sRGB", std::string(1, '\0'));
const std::string kLinear = chunk("gAMA", number(100000));
const std::string kPq = chunk("cICP", std::string("\x09\x10\x00\x01", 4));
const std::string kProfile = chunk("iCCP", std::string("Display P3\0\0abc", 15));

TEST(ColourTags, SrgbIsAsGoodAsNothing) {
  EXPECT_EQ(tags_of(kHeader), "");
  EXPECT_EQ(tags_of(kHeader + kSrgb), "");
  EXPECT_EQ(tags_of(kHeader + chunk("gAMA", number(45455))), "");
  EXPECT_EQ(tags_of(kHeader + chunk("cICP", std::string("\x01\x0d\x00\x01", 4))), "");
  EXPECT_EQ(colour_tags(std::vector<uint8_t>{'n', 'o'}), "");
}

TEST(ColourTags, TheStrongestSpeaks) {
  EXPECT_EQ(tags_of(kHeader + kLinear), "gAMA 1");
  EXPECT_EQ(tags_of(kHeader + kLinear + kSrgb), "") << "sRGB overrides gAMA";
  const std::string profile = tags_of(kHeader + kSrgb + kProfile);
  EXPECT_EQ(profile.find("iCCP profile 'Display P3' "), 0U) << profile;
  EXPECT_NE(profile, tags_of(kHeader + chunk("iCCP", std::string("Display P3\0\0abd", 15)))) << "other content";
  EXPECT_EQ(tags_of(kHeader + kSrgb + kProfile + kPq), "cICP 9/16/0/1");
  const std::string primaries = number(31270) + number(32900) + number(68000) + number(32000) + number(26500) +
                                number(69000) + number(15000) + number(6000);
  EXPECT_EQ(tags_of(kHeader + chunk("cHRM", primaries)), "cHRM 0.3127 0.329 0.68 0.32 0.265 0.69 0.15 0.06");
}

TEST(ColourTags, NothingBehindThePixelsOrBeyondTheFile) {
  EXPECT_EQ(tags_of(kHeader + chunk("IDAT", "x") + kPq), "");
  EXPECT_EQ(tags_of(kHeader + kPq.substr(0, kPq.size() - 1)), "");
  EXPECT_EQ(tags_of(number(0xffffffffU) + "gAMA"), "");
  EXPECT_EQ(tags_of(kHeader + chunk("gAMA", "xy")), "");
}

}  // namespace
}  // namespace crowdbench
