#include "core/files.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "core/error.h"

namespace crowdbench {
namespace {
namespace fs = std::filesystem;

class Files : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              (std::string("crowdbench-files-") + testing::UnitTest::GetInstance()->current_test_info()->name() + "-" +
               std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  size_t entries() const { return static_cast<size_t>(std::distance(fs::directory_iterator(folder_), {})); }
  fs::path folder_;
};

TEST_F(Files, WhatIsWrittenIsRead) {
  const std::string text("a\0b\n", 4);
  write_file(folder_ / "x.txt", text);
  EXPECT_EQ(read_text(folder_ / "x.txt"), text);
  write_file(folder_ / "x.txt", "");
  EXPECT_EQ(read_text(folder_ / "x.txt"), "");
}

TEST_F(Files, NoFolderIsMadeForAFile) {
  const auto wrong = [](const auto& does) -> std::string {
    try {
      does();
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  };
  const fs::path deep = folder_ / "a" / "b";
  for (const std::string& text :
       {wrong([&] { write_file(deep / "x.txt", "x"); }), wrong([&] { require_writable_file(deep / "x.txt"); }),
        wrong([&] { require_writable_folder(deep / "maps"); })}) {
    EXPECT_NE(text.find("there is no folder '" + deep.string() + "'"), std::string::npos) << text;
    EXPECT_NE(text.find("mkdir -p"), std::string::npos) << text;
  }
  EXPECT_EQ(entries(), 0U);
  EXPECT_NE(wrong([] { write_file("", "x"); }).find("empty"), std::string::npos);
  // A folder is made within one that exists, and one that exists is fine.
  make_folder(folder_ / "maps/");
  make_folder(folder_ / "maps");
  EXPECT_TRUE(fs::is_directory(folder_ / "maps"));
  write_file(folder_ / "taken", "x");
  EXPECT_NE(wrong([&] { make_folder(folder_ / "taken"); }).find("not a folder"), std::string::npos);
}

// As root, a rename would put a file in the device's place.
TEST_F(Files, ADeviceIsNotReplaced) {
  EXPECT_THROW(write_file("/dev/null", "x"), Error);
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(Files, ReadsNoMoreThanTheLimit) {
  write_file(folder_ / "x", "12345");
  EXPECT_EQ(read_file(folder_ / "x", 5).size(), 5U);
  EXPECT_THROW(read_file(folder_ / "x", 4), Error);
}

TEST_F(Files, RefusesWhatIsNotAFile) {
  EXPECT_THROW(read_file(folder_), Error);
  EXPECT_THROW(read_file(folder_ / "absent"), Error);
  EXPECT_THROW(read_file("/dev/zero"), Error);
  EXPECT_THROW(write_file(folder_, "x"), Error);
}

TEST_F(Files, APendingFileAppearsOnlyWhenCommitted) {
  {
    PendingFile pending(folder_ / "x.db");
    EXPECT_EQ(pending.path().extension(), ".db");
    write_file(pending.path(), "part");
    EXPECT_FALSE(fs::exists(folder_ / "x.db"));
  }
  EXPECT_EQ(entries(), 0U);
  {
    PendingFile pending(folder_ / "x.db");
    write_file(pending.path(), "whole");
    pending.commit();
  }
  EXPECT_EQ(read_text(folder_ / "x.db"), "whole");
  EXPECT_EQ(entries(), 1U);
}

TEST_F(Files, AFailedWriteKeepsTheOldFileAndLeavesNothingBehind) {
  write_file(folder_ / "x", "old");
  const fs::path below_a_file = folder_ / "x" / "y";
  EXPECT_THROW(write_file(below_a_file, "new"), Error);
  EXPECT_EQ(read_text(folder_ / "x"), "old");
  EXPECT_EQ(entries(), 1U);
}

}  // namespace
}  // namespace crowdbench
