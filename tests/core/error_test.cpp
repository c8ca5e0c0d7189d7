#include "core/error.h"

#include <gtest/gtest.h>

namespace crowdbench {
namespace {

TEST(Error, IsOneLineOfWhereWhatAndAdvice) {
  EXPECT_STREQ(Error("a.toml:3", "is wrong", "mend it").what(), "a.toml:3: is wrong; mend it");
  EXPECT_STREQ(Error("", "is wrong").what(), "is wrong");
  EXPECT_STREQ(Error("f", "holds\na\x1b[31m").what(), "f: holds?a?[31m");
}

TEST(Printable, CutsAndReplaces) {
  EXPECT_EQ(printable("abc", 3), "abc");
  EXPECT_EQ(printable("abcd", 3), "abc...");
  EXPECT_EQ(printable("a\tb\x7f"), "a?b?");
}

TEST(NearestName, FindsSlipsAndNothingElse) {
  const std::vector<std::string> names = {"agents", "placement", "motion"};
  EXPECT_EQ(nearest_name("agnets", names), "agents");
  EXPECT_EQ(nearest_name("placment", names), "placement");
  EXPECT_EQ(nearest_name("colour", names), "");
  EXPECT_EQ(nearest_name(std::string(10'000, 'a'), names), "");
  EXPECT_EQ(nearest_name("x", {}), "");
}

}  // namespace
}  // namespace crowdbench
