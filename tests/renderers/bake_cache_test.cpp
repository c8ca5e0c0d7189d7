#include "renderers/bake/bake_cache.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

#include "core/files.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::renderers {
namespace {

namespace fs = std::filesystem;

class BakeCacheTest : public testing::Test {
 protected:
  void TearDown() override {
    std::error_code ignored;
    fs::permissions(folder_, fs::perms::owner_all, ignored);
  }
  void overwrite(const fs::path& file, const std::vector<uint8_t>& bytes) {
    std::ofstream(file, std::ios::binary | std::ios::trunc)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  const support::ScratchFolder scratch_;
  const fs::path folder_ = scratch_.path();
  std::vector<uint8_t> payload_ = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 250, 251, 252, 0, 0,  17,  33,  65, 9,
                                   9, 9, 9, 9, 9, 1, 2, 3, 4, 5,  6,   7,   8,   9, 10, 250, 251, 252};
};

TEST_F(BakeCacheTest, GivesBackWhatWasStored) {
  const BakeCache cache(folder_ / "sub");
  EXPECT_FALSE(cache.load("flat", "00ff"));
  const uint64_t bytes = cache.store("flat", "00ff", payload_);
  EXPECT_EQ(bytes, fs::file_size(cache.path("flat", "00ff")));
  EXPECT_EQ(cache.disk_bytes("flat", "00ff"), bytes);
  EXPECT_EQ(cache.load("flat", "00ff"), payload_);
  EXPECT_FALSE(cache.load("flat", "00fe"));
  EXPECT_FALSE(cache.load("relief", "00ff"));
}

TEST_F(BakeCacheTest, EveryFlippedBitIsSeenAndTheEntryRemoved) {
  const BakeCache cache(folder_);
  cache.store("flat", "00ff", payload_);
  const fs::path file = cache.path("flat", "00ff");
  const std::vector<uint8_t> sound = read_file(file);
  for (size_t i = 0; i < sound.size(); ++i) {
    std::vector<uint8_t> flipped = sound;
    flipped[i] ^= static_cast<uint8_t>(1U << (i % 8));
    overwrite(file, flipped);
    EXPECT_FALSE(cache.load("flat", "00ff")) << "byte " << i;
    EXPECT_FALSE(fs::exists(file)) << "byte " << i;
  }
}

TEST_F(BakeCacheTest, EveryTruncationAndAnyTailIsSeen) {
  const BakeCache cache(folder_);
  cache.store("flat", "00ff", payload_);
  const fs::path file = cache.path("flat", "00ff");
  const std::vector<uint8_t> sound = read_file(file);
  for (size_t n = 0; n < sound.size(); ++n) {
    overwrite(file, {sound.begin(), sound.begin() + static_cast<std::ptrdiff_t>(n)});
    EXPECT_FALSE(cache.load("flat", "00ff")) << n;
  }
  std::vector<uint8_t> longer = sound;
  longer.push_back(0);
  overwrite(file, longer);
  EXPECT_FALSE(cache.load("flat", "00ff"));
}

TEST_F(BakeCacheTest, AnEntryUnderAnothersNameIsRefused) {
  const BakeCache cache(folder_);
  cache.store("flat", "00ff", payload_);
  fs::copy_file(cache.path("flat", "00ff"), cache.path("flat", "00aa"));
  EXPECT_FALSE(cache.load("flat", "00aa"));
}

TEST_F(BakeCacheTest, AnotherVersionsEntryIsAbsentAndNotCalledDamaged) {
  const BakeCache cache(folder_);
  cache.store("flat", "00ff", payload_);
  const fs::path file = cache.path("flat", "00ff");
  std::vector<uint8_t> older = read_file(file);
  ASSERT_EQ(std::string(older.begin(), older.begin() + 8), "CBBAKE2\n");
  older[6] = '1';
  overwrite(file, older);
  testing::internal::CaptureStderr();
  EXPECT_FALSE(cache.load("flat", "00ff"));
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_GT(cache.store("flat", "00ff", payload_), 0U);
  EXPECT_EQ(cache.load("flat", "00ff"), payload_);
}

TEST_F(BakeCacheTest, AFolderThatCannotBeWrittenIsAWarning) {
  overwrite(folder_ / "file", {1});
  const BakeCache cache(folder_ / "file" / "below");  // a file where a folder should be: fails for root too
  EXPECT_EQ(cache.store("flat", "00ff", payload_), 0U);
  EXPECT_FALSE(cache.load("flat", "00ff"));
}

TEST_F(BakeCacheTest, SwitchedOffItNeitherReadsNorWrites) {
  BakeCache(folder_).store("flat", "00ff", payload_);
  const BakeCache off(folder_, false);
  EXPECT_FALSE(off.load("flat", "00ff"));
  EXPECT_EQ(off.store("flat", "00aa", payload_), 0U);
  EXPECT_FALSE(fs::exists(off.path("flat", "00aa")));
}

TEST(ByteReader, ReadingPastTheEndIsSeen) {
  ByteWriter writer;
  writer.value(42);
  writer.values(std::vector<float>{1.5F, 2.5F});
  ByteReader reader(writer.bytes());
  EXPECT_EQ(reader.value<int>(), 42);
  EXPECT_EQ(reader.values<float>(), (std::vector<float>{1.5F, 2.5F}));
  EXPECT_TRUE(reader.ok());
  EXPECT_TRUE(reader.at_end());
  EXPECT_EQ(reader.value<int>(), 0);
  EXPECT_FALSE(reader.ok());
  ByteReader huge(writer.bytes());
  huge.value<int>();
  EXPECT_TRUE(huge.values<double>().empty()) << "2 doubles do not fit where 2 floats lie";
  EXPECT_FALSE(huge.ok());
}

}  // namespace
}  // namespace crowdbench::renderers
