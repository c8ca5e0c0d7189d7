#include "core/image_io.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/files.h"
#include "core/module.h"
#include "core/png.h"
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
  fs::create_directories(folder);
  const Image8 image = pattern(5, 4, 4);
  write_png(folder / "x.png", image);
  EXPECT_EQ(decode_png(read_file(folder / "x.png"), "x"), image);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1);
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

fs::path scratch() {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  const fs::path folder = fs::path(::testing::TempDir()) / fmt::format("crowdbench_{}", test->name());
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

TEST(Exr, FloatRoundTripIsExactAndItsBytesAreThoseOfThePixels) {
  const fs::path folder = scratch();
  for (const int channels : {1, 3, 4}) {
    ImageF image(33, 17, channels);
    for (size_t i = 0; i < image.data.size(); ++i) image.data[i] = static_cast<float>(random_unit(3, i, 1)) * 1000 - 1;
    image.data[2] = std::numeric_limits<float>::infinity();
    write_exr(folder / "a.exr", image, {{"seed", "7"}, {"scenario", "agents = 5"}});
    const auto back = read_image(folder / "a.exr");
    ASSERT_TRUE(std::holds_alternative<ImageF>(back)) << channels;
    EXPECT_EQ(std::get<ImageF>(back), image) << channels;
    const auto bytes = read_file(folder / "a.exr");
    const std::string text(bytes.begin(), bytes.end());
    EXPECT_NE(text.find("agents = 5"), std::string::npos);
    EXPECT_EQ(text.find(std::string(folder)), std::string::npos) << "a path of this machine is in the file";
    EXPECT_EQ(text.find("capDate"), std::string::npos);
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1);
}

std::string read_error(const fs::path& path) {
  try {
    read_image(path);
  } catch (const Error& error) {
    return error.wrong;
  }
  return {};
}

// An uncompressed EXR of floats in which every sample is the channel's own value; names in the file's order, by their
// bytes.
std::string exr_of(int width, int height, const std::vector<std::pair<std::string, float>>& channels) {
  std::string out;
  const auto put = [&](const void* data, size_t bytes) { out.append(static_cast<const char*>(data), bytes); };
  const auto number = [&](auto value) { put(&value, sizeof(value)); };
  const auto text = [&](const std::string& words) { put(words.c_str(), words.size() + 1); };
  const auto head = [&](const char* name, const char* type, size_t bytes) {
    text(name);
    text(type);
    number(static_cast<int32_t>(bytes));
  };
  number(int32_t{20000630});
  number(int32_t{2});
  size_t list = 1;
  for (const auto& [name, value] : channels) list += name.size() + 17;
  head("channels", "chlist", list);
  for (const auto& [name, value] : channels) {
    text(name);
    for (const int32_t field : {2, 0, 1, 1}) number(field);  // float, not linear, every pixel
  }
  number(uint8_t{0});
  head("compression", "compression", 1);
  number(uint8_t{0});
  for (const char* window : {"dataWindow", "displayWindow"}) {
    head(window, "box2i", 16);
    for (const int32_t edge : {0, 0, width - 1, height - 1}) number(edge);
  }
  head("lineOrder", "lineOrder", 1);
  number(uint8_t{0});
  head("pixelAspectRatio", "float", 4);
  number(1.0F);
  head("screenWindowCenter", "v2f", 8);
  number(0.0F);
  number(0.0F);
  head("screenWindowWidth", "float", 4);
  number(1.0F);
  number(uint8_t{0});
  const size_t row = 4 * channels.size() * static_cast<size_t>(width);
  const size_t first = out.size() + 8 * static_cast<size_t>(height);
  for (int y = 0; y < height; ++y) number(static_cast<uint64_t>(first + static_cast<size_t>(y) * (8 + row)));
  for (int y = 0; y < height; ++y) {
    number(int32_t{y});
    number(static_cast<int32_t>(row));
    for (const auto& [name, value] : channels)
      for (int x = 0; x < width; ++x) number(value);
  }
  return out;
}

// What renderers write beside the picture is left out, and a depth is no alpha.
TEST(Exr, LayersBesideThePictureAreLeftOut) {
  const fs::path folder = scratch();
  using Channels = std::vector<std::pair<std::string, float>>;
  const auto colours = [&](const Channels& channels) {
    write_file(folder / "layers.exr", std::string_view(exr_of(3, 2, channels)));
    const auto image = std::get<ImageF>(read_image(folder / "layers.exr"));
    EXPECT_EQ(image.width, 3);
    EXPECT_EQ(image.height, 2);
    std::vector<float> pixel(image.at(2, 1), image.at(2, 1) + image.channels);
    return pixel;
  };
  const Channels rgb = {{"B", 3}, {"G", 2}, {"R", 1}};
  EXPECT_EQ(colours(rgb), (std::vector<float>{1, 2, 3}));
  EXPECT_EQ(colours({{"A", 0.5F}, {"B", 3}, {"G", 2}, {"R", 1}, {"depth.Z", 9}, {"normal.X", 8}, {"normal.Y", 7}}),
            (std::vector<float>{1, 2, 3, 0.5F}));
  EXPECT_EQ(colours({{"B", 3}, {"G", 2}, {"R", 1}, {"Z", 9}}), (std::vector<float>{1, 2, 3}));
  write_file(folder / "layers.exr", std::string_view(exr_of(3, 2, {{"Y", 1}, {"Z", 2}})));
  EXPECT_NE(read_error(folder / "layers.exr").find("has 2 channels: Y, Z"), std::string::npos)
      << read_error(folder / "layers.exr");
  write_file(folder / "layers.exr", std::string_view(exr_of(3, 2, {{"p", 1}, {"q", 2}, {"s", 2}, {"t", 2}, {"u", 2}})));
  EXPECT_NE(read_error(folder / "layers.exr").find("has 5 channels: p, q, s, t, u"), std::string::npos);
}

TEST(Exr, IdsKeepAll32Bits) {
  const fs::path folder = scratch();
  ImageU32 ids(5, 3, 1);
  ids.data = {0, 1, 2, 255, 256, 65535, 65536, 16777216, 16777217, 100000, 4294967295U, 4294967294U, 7, 8, 9};
  write_exr(folder / "ids.exr", ids);
  write_exr(folder / "again.exr", ids);
  EXPECT_EQ(read_file(folder / "ids.exr"), read_file(folder / "again.exr"));
  const auto back = read_image(folder / "ids.exr");
  ASSERT_TRUE(std::holds_alternative<ImageU32>(back));
  EXPECT_EQ(std::get<ImageU32>(back), ids);
}

TEST(Exr, UnwritableTargetIsAnErrorThatLeavesNothing) {
  const fs::path folder = scratch();
  fs::create_directories(folder / "taken.exr");
  EXPECT_THROW(write_exr(folder / "taken.exr", ImageF(4, 4, 1)), Error);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1);
}

TEST(ReadImage, RefusesWhatIsNotAPicture) {
  const fs::path folder = scratch();
  EXPECT_EQ(read_error(folder / "absent.png"), "no such file");
  EXPECT_EQ(read_error(folder), "is not a regular file");
  write_file(folder / "text.exr", "not a picture at all");
  EXPECT_NE(read_error(folder / "text.exr").find("cannot be read as a picture"), std::string::npos);
  write_file(folder / "empty.png", "");
  EXPECT_NE(read_error(folder / "empty.png").find("cannot be read as a picture"), std::string::npos);
  write_exr(folder / "half.exr", ImageF(64, 64, 3));
  auto bytes = read_file(folder / "half.exr");
  write_file(folder / "half.exr", bytes.data(), bytes.size() / 2);
  EXPECT_NE(read_error(folder / "half.exr"), "");
}

// Sixteen-bit and grey-with-alpha PNG, by hand: 2 x 1 pixels, stored (uncompressed) DEFLATE.
std::vector<uint8_t> raw_png(uint8_t depth, uint8_t type, const std::vector<uint8_t>& row) {
  std::vector<uint8_t> png = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  const auto chunk = [&](const char* name, const std::vector<uint8_t>& body) {
    png.resize(png.size() + 4);
    put_big_endian(png, png.size() - 4, static_cast<uint32_t>(body.size()));
    png.insert(png.end(), name, name + 4);
    png.insert(png.end(), body.begin(), body.end());
    png.resize(png.size() + 4);
  };
  chunk("IHDR", {0, 0, 0, 2, 0, 0, 0, 1, depth, type, 0, 0, 0});
  const auto length = static_cast<uint8_t>(row.size() + 1);
  std::vector<uint8_t> zlib = {0x78, 0x01, 0x01, length, 0, static_cast<uint8_t>(~length), 0xff, 0};
  zlib.insert(zlib.end(), row.begin(), row.end());
  uint32_t a = 1;
  uint32_t b = a;  // the filter byte, 0, leaves a at 1 and adds it to b, which starts at 0
  for (const uint8_t byte : row) {
    a = (a + byte) % 65521;
    b = (b + a) % 65521;
  }
  zlib.resize(zlib.size() + 4);
  put_big_endian(zlib, zlib.size() - 4, b << 16 | a);
  chunk("IDAT", zlib);
  chunk("IEND", {});
  repair_checksums(png);
  return png;
}

TEST(ReadImage, SixteenBitPngKeepsItsValues) {
  const fs::path folder = scratch();
  const auto bytes = raw_png(16, 0, {0x12, 0x34, 0xff, 0xfe});
  write_file(folder / "x.png", bytes.data(), bytes.size());
  const auto image = read_image(folder / "x.png");
  ASSERT_TRUE(std::holds_alternative<Image16>(image));
  EXPECT_EQ(std::get<Image16>(image).channels, 1);
  EXPECT_EQ(std::get<Image16>(image).data, (std::vector<uint16_t>{0x1234, 0xfffe}));
  EXPECT_NE(error_of(bytes).find("16 bits"), std::string::npos);
}

// A clear texel's colour is what filters mix into its neighbours: (200, 100, 50) at alpha 0 beside (10, 20, 30),
// opaque, in files made by hand.
TEST(ReadImage, ColoursOfClearTexelsAreKeptInEveryFormat) {
  const std::vector<uint8_t> wanted = {200, 100, 50, 0, 10, 20, 30, 255};
  const std::vector<uint8_t> webp = {0x52, 0x49, 0x46, 0x46, 0x1e, 0x00, 0x00, 0x00, 0x57, 0x45, 0x42, 0x50, 0x56,
                                     0x50, 0x38, 0x4c, 0x11, 0x00, 0x00, 0x00, 0x2f, 0x01, 0x00, 0x00, 0x10, 0x38,
                                     0x05, 0xd9, 0x15, 0x90, 0xef, 0x21, 0x73, 0x80, 0xff, 0x38, 0x04, 0x00};
  const std::vector<uint8_t> tga = {0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x02,
                                    0x00, 0x01, 0x00, 0x20, 0x28, 0x32, 0x64, 0xc8, 0x00, 0x1e, 0x14, 0x0a, 0xff};
  // Little-endian, one strip, ExtraSamples 2: alpha that nothing is multiplied by.
  std::vector<uint8_t> tiff = {'I', 'I', 42, 0, 8, 0, 0, 0, 11, 0};
  const auto tag = [&](int name, int type, int count, int value) {
    for (const int v : {name, type})
      tiff.insert(tiff.end(), {static_cast<uint8_t>(v & 255), static_cast<uint8_t>(v >> 8)});
    for (const int v : {count, value})
      tiff.insert(tiff.end(), {static_cast<uint8_t>(v & 255), static_cast<uint8_t>(v >> 8), 0, 0});
  };
  tag(256, 3, 1, 2), tag(257, 3, 1, 1), tag(258, 3, 4, 146), tag(259, 3, 1, 1), tag(262, 3, 1, 2), tag(273, 4, 1, 154);
  tag(277, 3, 1, 4), tag(278, 3, 1, 1), tag(279, 4, 1, 8), tag(284, 3, 1, 1), tag(338, 3, 1, 2);
  tiff.insert(tiff.end(), {0, 0, 0, 0, 8, 0, 8, 0, 8, 0, 8, 0});
  tiff.insert(tiff.end(), wanted.begin(), wanted.end());
  Image8 picture(2, 1, 4);
  picture.data = wanted;
  const std::map<std::string, std::vector<uint8_t>> files = {
      {"webp", webp}, {"tga", tga}, {"tif", tiff}, {"png", encode_png(picture)}};
  const fs::path folder = fs::path(::testing::TempDir()) / "crowdbench_clear";
  fs::create_directories(folder);
  for (const auto& [extension, bytes] : files) {
    EXPECT_EQ(std::get<Image8>(read_image(bytes, extension, "memory", 100)).data, wanted) << extension;
    const fs::path path = folder / ("clear." + extension);
    write_file(path, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
    EXPECT_EQ(std::get<Image8>(read_image(path)).data, wanted) << extension << " from a file";
  }
  fs::remove_all(folder);
  // What is cut short is refused and not half read.
  const std::vector<uint8_t> cut(webp.begin(), webp.end() - 6);
  EXPECT_THROW(read_image(cut, "webp", "memory", 100), Error);
}

TEST(ReadImage, FewerBitsAndGreyWithAlphaAreWidened) {
  // Two samples of 2 bits: 1 and 3 of 3 are 85 and 255 of 255.
  const Image8 two_bits = decode_png(raw_png(2, 0, {0b01'11'00'00}), "x");
  EXPECT_EQ(two_bits.channels, 1);
  EXPECT_EQ(two_bits.data, (std::vector<uint8_t>{85, 255}));
  const Image8 grey_alpha = decode_png(raw_png(8, 4, {10, 20, 30, 40}), "x");
  EXPECT_EQ(grey_alpha.channels, 4);
  EXPECT_EQ(grey_alpha.data, (std::vector<uint8_t>{10, 10, 10, 20, 30, 30, 30, 40}));
}

// ---- what image_io.h is made of

TEST(Png, IsToldByItsSignatureAlone) {
  const std::vector<uint8_t> signature = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  EXPECT_TRUE(is_png(signature));
  EXPECT_FALSE(is_png({}));
  EXPECT_FALSE(is_png(std::span(signature).first(7)));
  std::vector<uint8_t> text_mode = signature;  // as a transfer of text would leave it
  text_mode[4] = '\n';
  EXPECT_FALSE(is_png(text_mode));
  const fs::path file = fs::path(::testing::TempDir()) / "crowdbench_signature";
  write_file(file, std::string_view("\x89PNG\r\n\x1a\n and then what is no picture"));
  EXPECT_TRUE(is_png_file(file));
  fs::remove(file);
  EXPECT_FALSE(is_png_file(file)) << "there is no such file";
}

TEST(Png, WhatIsNoPngIsRefusedAndOneRowMayBeAsLongAsTheSideAllows) {
  EXPECT_THROW((void)decode_any_png({}, "memory"), Error);
  const Image8 row(kMaxImageSide, 1, 1);
  const auto decoded = decode_any_png(encode_png(row), "memory");
  ASSERT_TRUE(std::holds_alternative<Image8>(decoded));
  EXPECT_EQ(std::get<Image8>(decoded), row);
}

TEST(Module, WhatIsMissingIsNamedWithWhatNeedsIt) {
  try {
    (void)module_symbol("no_such_module", "entry", "reading dreams");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.where, "crowdbench_no_such_module.so");
    EXPECT_TRUE(error.wrong.starts_with("reading dreams needs this module, which cannot be loaded (")) << error.wrong;
  }
}

}  // namespace
}  // namespace crowdbench
