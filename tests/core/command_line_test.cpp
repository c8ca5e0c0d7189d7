#include "core/command_line.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>

namespace crowdbench {
namespace {

TEST(CommandLine, QuotesOnlyWhatAShellWouldChange) {
  EXPECT_EQ(shell_quoted("flat:views=sphere-17x8,frames=8"), "flat:views=sphere-17x8,frames=8");
  EXPECT_EQ(shell_quoted("--out"), "--out");
  EXPECT_EQ(shell_quoted(""), "''");
  EXPECT_EQ(shell_quoted("my results.sqlite"), "'my results.sqlite'");
  EXPECT_EQ(shell_quoted("hybrid(mesh,flat)"), "'hybrid(mesh,flat)'");
  EXPECT_EQ(shell_quoted("it's"), "'it'\\''s'");
  EXPECT_EQ(shell_quoted("~/a"), "'~/a'");
  EXPECT_EQ(shell_quoted({"crowdbench", "bench", "a b"}), "crowdbench bench 'a b'");
}

// The shell itself is the oracle: it prints each word in brackets.
TEST(CommandLine, AShellReadsTheSameWords) {
  const std::vector<std::string> words = {
      "plain", "",    "a b", "$HOME", "`id`", "it's \"it\"", "*",     "a\\nb\\", "#x",    "a\nb", "{1,2}",
      "!1",    "x;y", "(z)", "\t",    "é",    "a=b",         "~root", "%s^@+",   "[a-z]", "<",    "?"};
  std::string wanted;
  for (const std::string& word : words) wanted += "[" + word + "]";
  FILE* pipe = popen(("printf '[%s]' " + shell_quoted(words)).c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::array<char, 4096> buffer{};
  const size_t size = fread(buffer.data(), 1, buffer.size(), pipe);
  EXPECT_EQ(pclose(pipe), 0);
  EXPECT_EQ(std::string(buffer.data(), size), wanted);
}

TEST(CommandLine, IsAllOfItWithoutTheProgramsFolder) {
  const std::string before = command_line();
  EXPECT_EQ(before, "");
  const char* const argv[] = {
      "./build/release/bin/crowdbench", "bench", "--agents", "1,10", "--out", "my results.sqlite"};
  set_command_line(6, argv);
  EXPECT_EQ(command_line(), "crowdbench bench --agents 1,10 --out 'my results.sqlite'");
  set_command_line(0, argv);
  EXPECT_EQ(command_line(), before);
}

}  // namespace
}  // namespace crowdbench
