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
  EXPECT_EQ(printable("a\u202eb\u2066c\u200fd\u061ce\u0085f\u2028"), "a?b?c?d?e?f?") << "what turns or breaks lines";
  EXPECT_EQ(printable("\u2013\u2026\u00e9\u0628\u05d0"), "\u2013\u2026\u00e9\u0628\u05d0") << "letters and dashes stay";
  EXPECT_EQ(printable("gr\u00fc\u00dfe", 5), "gr\u00fc...") << "whole characters";
}

TEST(Error, WhatTheProgramSaysIsNeverCut) {
  const std::string long_advice(5000, 'x');
  EXPECT_EQ(std::string(Error("a", "b", long_advice).what()), "a: b; " + long_advice);
}

TEST(NearestFirst, ShowsWholeNamesTheLikeliestFirst) {
  std::vector<std::string> names;
  for (int i = 0; i < 40; ++i) names.push_back("Clip_with_a_long_name_" + std::to_string(100 + i));
  names.push_back("Walking_A");
  const std::string text = nearest_first("Walking", names);
  EXPECT_EQ(text.find("Walking_A, "), 0U) << text;
  EXPECT_TRUE(text.ends_with(" and 29 more")) << text;
  EXPECT_EQ(nearest_first("x", {"walk", "run"}), "walk, run") << "all of them, in their own order";
  EXPECT_EQ(nearest_first("x", {}), "");
}

TEST(NearestName, FindsSlipsAndNothingElse) {
  const std::vector<std::string> names = {"agents", "placement", "motion"};
  EXPECT_EQ(nearest_name("agnets", names), "agents");
  EXPECT_EQ(nearest_name("placment", names), "placement");
  EXPECT_EQ(nearest_name("colour", names), "");
  const std::vector<std::string> clips = {"talk", "walk", "idle"};
  EXPECT_EQ(nearest_name("wlak", clips), "walk") << "a swap is one slip: talk is two away";
  EXPECT_EQ(nearest_name("Wlak", clips), "walk");
  EXPECT_EQ(nearest_name("IDLE", clips), "idle");
  EXPECT_EQ(nearest_name("ilde", {"side", "idle"}), "idle");
  EXPECT_EQ(nearest_name("adcb", {"xxxx", "abcd"}), "abcd") << "not neighbours: two letters exchanged";
  EXPECT_EQ(nearest_name(std::string(10'000, 'a'), names), "");
  EXPECT_EQ(nearest_name("x", {}), "");
}

}  // namespace
}  // namespace crowdbench
