#include "renderers/bake/bake_cache.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>

#include "core/error.h"
#include "core/files.h"
#include "renderers/bake/bake_loader.h"
#include "renderers/bake/cache_entries.h"
#include "tests/renderers/gl_test_support.h"
#include "tests/support/cache_folder.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::renderers {
namespace {

namespace fs = std::filesystem;

class BakeCacheTest : public ::testing::Test {
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
  const uint64_t bytes = cache.store("flat", "00ff", payload_, 2.5);
  EXPECT_EQ(bytes, fs::file_size(cache.path("flat", "00ff")));
  EXPECT_EQ(cache.disk_bytes("flat", "00ff"), bytes);
  EXPECT_EQ(cache.load("flat", "00ff")->payload, payload_);
  EXPECT_EQ(cache.load("flat", "00ff")->made_seconds, 2.5);
  EXPECT_FALSE(cache.load("flat", "00fe"));
  EXPECT_FALSE(cache.load("relief", "00ff"));
}

TEST_F(BakeCacheTest, EveryFlippedBitIsSeenAndTheEntryRemoved) {
  const BakeCache cache(folder_);
  cache.store("flat", "00ff", payload_, 2.5);
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
  cache.store("flat", "00ff", payload_, 2.5);
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
  cache.store("flat", "00ff", payload_, 2.5);
  fs::copy_file(cache.path("flat", "00ff"), cache.path("flat", "00aa"));
  EXPECT_FALSE(cache.load("flat", "00aa"));
}

TEST_F(BakeCacheTest, AnotherVersionsEntryIsAbsentAndNotCalledDamaged) {
  const BakeCache cache(folder_);
  cache.store("flat", "00ff", payload_, 2.5);
  const fs::path file = cache.path("flat", "00ff");
  std::vector<uint8_t> older = read_file(file);
  ASSERT_EQ(std::string(older.begin(), older.begin() + 8), "CBBAKE3\n");
  older[6] = '1';
  overwrite(file, older);
  ::testing::internal::CaptureStderr();
  EXPECT_FALSE(cache.load("flat", "00ff"));
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_GT(cache.store("flat", "00ff", payload_, 2.5), 0U);
  EXPECT_EQ(cache.load("flat", "00ff")->payload, payload_);
}

TEST_F(BakeCacheTest, AFolderThatCannotBeWrittenIsAWarning) {
  overwrite(folder_ / "file", {1});
  const BakeCache cache(folder_ / "file" / "below");  // a file where a folder should be: fails for root too
  EXPECT_EQ(cache.store("flat", "00ff", payload_, 2.5), 0U);
  EXPECT_FALSE(cache.load("flat", "00ff"));
}

TEST_F(BakeCacheTest, SwitchedOffItNeitherReadsNorWrites) {
  BakeCache(folder_).store("flat", "00ff", payload_, 2.5);
  const BakeCache off(folder_, false);
  EXPECT_FALSE(off.load("flat", "00ff"));
  EXPECT_EQ(off.store("flat", "00aa", payload_, 2.5), 0U);
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

class BakeCacheLimit : public BakeCacheTest {
 protected:
  void SetUp() override { ::unsetenv(kVariable); }
  void TearDown() override {
    ::unsetenv(kVariable);
    BakeCacheTest::TearDown();
  }
  // Stores an entry of about `mib` MiB that was last used so many hours ago.
  void store(const std::string& key, size_t mib, int hours_ago) const {
    const BakeCache cache(folder_);
    ASSERT_GT(cache.store("flat", key, std::vector<uint8_t>(mib << 20), 2.5), 0U);
    fs::last_write_time(cache.path("flat", key), fs::file_time_type::clock::now() - std::chrono::hours(hours_ago));
  }
  std::vector<std::string> keys() const {
    std::vector<std::string> keys;
    for (const CacheEntry& entry : cache_entries(folder_)) keys.push_back(entry.key);
    return keys;
  }
  static constexpr const char* kVariable = "CROWDBENCH_CACHE_LIMIT_MIB";
};

TEST_F(BakeCacheLimit, WhatWasUnusedForLongestGoesFirst) {
  store("aa", 1, 3);
  store("bb", 1, 9);
  store("cc", 1, 6);
  EXPECT_EQ(keys(), (std::vector<std::string>{"bb", "cc", "aa"}));
  EXPECT_TRUE(BakeCache(folder_).load("flat", "bb")) << "used now";
  EXPECT_EQ(keys(), (std::vector<std::string>{"cc", "aa", "bb"}));
  ::setenv(kVariable, "3", 1);
  store("dd", 1, 0);  // and the headers: four entries of a little over 1 MiB, of which two fit
  EXPECT_EQ(keys(), (std::vector<std::string>{"bb", "dd"}));
}

TEST_F(BakeCacheLimit, TheNewestStaysWhateverItTakes) {
  store("aa", 1, 1);
  ::setenv(kVariable, "1", 1);
  ::testing::internal::CaptureStderr();
  store("bb", 2, 0);
  EXPECT_NE(::testing::internal::GetCapturedStderr().find("this bake alone takes 2 MiB of the 1"), std::string::npos);
  EXPECT_EQ(keys(), (std::vector<std::string>{"bb"}));
  store("cc", 1, 0);
  EXPECT_EQ(keys(), (std::vector<std::string>{"cc"}));
}

TEST_F(BakeCacheLimit, OtherFilesAreNotTouched) {
  store("aa", 1, 1);
  for (const char* name : {"notes.txt", "flat-xyz.bake", "bake", ".flat-aa.77.part.bake"})
    overwrite(folder_ / name, {1});
  overwrite(folder_ / ".flat-aa.78.part.bake", {1});
  fs::last_write_time(folder_ / ".flat-aa.78.part.bake", fs::file_time_type::clock::now() - std::chrono::hours(25));
  EXPECT_EQ(clear_cache(folder_).count, 1U);
  size_t left = 0;
  for (const auto& file : fs::directory_iterator(folder_)) left += file.path().filename() != ".flat-aa.78.part.bake";
  EXPECT_EQ(left, 4U);
  EXPECT_FALSE(fs::exists(folder_ / ".flat-aa.78.part.bake")) << "nobody will finish it";
  EXPECT_EQ(clear_cache(folder_ / "absent").count, 0U);
}

TEST_F(BakeCacheLimit, IsReadFromTheEnvironment) {
  EXPECT_EQ(cache_limit_bytes(), 4ULL << 30);
  ::setenv(kVariable, "10", 1);
  EXPECT_EQ(cache_limit_bytes(), 10ULL << 20);
  ::setenv(kVariable, "0", 1);
  EXPECT_EQ(cache_limit_bytes(), UINT64_MAX);
  for (const char* wrong : {"-1", "4GiB", "1e3", "99999999999999999999", " 5", "1073741825"}) {
    ::setenv(kVariable, wrong, 1);
    EXPECT_THROW(cache_limit_bytes(), Error) << wrong;
  }
}

// ---- a cast's bakes

TEST(BakeRecords, AreOneKeyAndCachedOnlyTogether) {
  EXPECT_FALSE(bake_info_of({}).cached);
  const std::vector<BakeRecord> both = {{"a1", true, 10, 3.5}, {"b2", false, 5, 1.25}};
  const std::span<const BakeRecord> one = std::span(both).first(1);
  EXPECT_TRUE(bake_info_of(one).cached);
  EXPECT_EQ(bake_info_of(one).cache_key, "a1");
  EXPECT_FALSE(bake_info_of(both).cached);
  EXPECT_EQ(bake_info_of(both).cache_key.size(), 64U) << "a hash over all of them";
  EXPECT_NE(bake_info_of(both).cache_key, bake_info_of(std::vector{both[1], both[0]}).cache_key);
  EXPECT_EQ(disk_bytes_of(both), 15U);
  EXPECT_EQ(bake_info_of(both).made_seconds, 4.75) << "cold, wherever it came from";
  EXPECT_EQ(disk_bytes_of({}), 0U);
}

TEST(BakeBudget, SaysWhatWouldFit) {
  constexpr uint64_t kMiB = 1 << 20;
  EXPECT_EQ(budget_advice("texels=64", "lower texels", 3 * kMiB, kMiB),
            "texels=64 would fit: lower texels, or raise --bake-budget by 2 MiB");
  EXPECT_EQ(budget_advice("", "lower texels", kMiB + 1, kMiB), "lower texels, or raise --bake-budget by 1 MiB");
  EXPECT_EQ(fitting_size(128, 16, 400, 100), 64) << "a quarter of the bytes, half the side";
  EXPECT_EQ(fitting_size(128, 64, 400, 100), 64);
  EXPECT_EQ(fitting_size(128, 65, 400, 100), 0);
  EXPECT_EQ(fitting_size(128, 16, 400, 0), 0);
}

struct TenBytes {
  std::vector<uint8_t> bytes = std::vector<uint8_t>(10, 7);
  uint64_t texture_bytes() const { return bytes.size(); }
};
std::vector<uint8_t> serialise(const TenBytes& bake) { return bake.bytes; }
std::optional<TenBytes> read_ten(std::span<const uint8_t> bytes) {
  if (bytes.size() != 10) return std::nullopt;
  return TenBytes{{bytes.begin(), bytes.end()}};
}

class BakeLoaderGl : public ::testing::Test {
 protected:
  MakeContext make_{renderers::testing::context(), renderers::testing::walker()};
  int made_ = 0;
  // Of "a" and of "b".
  std::vector<BakeRecord> load_both() {
    BakeLoader loader(make_.policy(), {"ten", "tens", "numbers", "buy memory"});
    for (const char* name : {"a", "b"})
      loader.load<TenBytes>(name, fmt::format("0{}", name), read_ten, [&](uint64_t budget, const BakeProgress&) {
        EXPECT_EQ(budget, make_.bake_budget - 10 * loader.records().size());
        ++made_;
        return TenBytes{};
      });
    return loader.records();
  }
  support::CacheFolder cache_;
};

TEST_F(BakeLoaderGl, MakesOnceAndReadsAfterwards) {
  const std::vector<BakeRecord> first = load_both();
  EXPECT_EQ(made_, 2);
  EXPECT_FALSE(first[0].cached);
  EXPECT_GT(first[0].disk_bytes, 10U);
  const std::vector<BakeRecord> second = load_both();
  EXPECT_EQ(made_, 2);
  EXPECT_TRUE(second[1].cached);
  EXPECT_EQ(second[1].cache_key, "0b");
  EXPECT_GT(first[1].made_seconds, 0);
  EXPECT_EQ(second[1].made_seconds, first[1].made_seconds) << "what making it took, not what reading it did";
  make_.rebake = true;
  load_both();
  EXPECT_EQ(made_, 4);
}

TEST_F(BakeLoaderGl, OneBudgetIsForAllOfThem) {
  make_.use_cache = false;
  make_.bake_budget = 20;
  EXPECT_EQ(load_both()[1].disk_bytes, 0U);
  make_.bake_budget = 19;
  try {
    load_both();
    FAIL() << "twenty bytes are more than nineteen";
  } catch (const Error& error) {
    EXPECT_EQ(error.where, "ten bake of b");
    EXPECT_EQ(error.wrong, "0 MiB of numbers are more than what is left of the budget, 0");
    EXPECT_EQ(error.advice, "buy memory");
  }
}

}  // namespace
}  // namespace crowdbench::renderers
