// TOML as plans read it: the tree, a table key by key, and a scenario's keys within another document.
#include <gtest/gtest.h>

#include "core/error.h"
#include "core/files.h"
#include "scene/cast/scenario_table.h"
#include "scene/scenario/scenario.h"
#include "scene/scenario/toml_document.h"
#include "scene/scenario/toml_table.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::scene {
namespace {

std::string error_of(const auto& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

TEST(TomlDocument, IsATreeThatKnowsItsLines) {
  const TomlNode document = parse_toml("a = 1\nb = [2.5, \"x\"]\n[c]\nd = true\n", "p.toml");
  ASSERT_TRUE(document.is_table());
  EXPECT_EQ(document.find("a")->integer, 1);
  EXPECT_EQ(document.find("a")->as_number(), 1.0);
  ASSERT_TRUE(document.find("b")->is_list());
  EXPECT_EQ(document.find("b")->list.at(0).number, 2.5);
  EXPECT_EQ(document.find("b")->list.at(1).text, "x");
  EXPECT_TRUE(document.find("c")->find("d")->boolean);
  EXPECT_EQ(document.find("c")->find("d")->place("p.toml"), "p.toml:4");
  EXPECT_EQ(document.find("e"), nullptr);
  EXPECT_TRUE(error_of([] { parse_toml("a = 1\nb = [", "p.toml"); }).starts_with("p.toml:"));
}

TEST(TomlTable, ReadsWhatIsMeantAndRefusesTheRestByLine) {
  enum class Kind : uint8_t { flat, round };
  const TomlNode document = parse_toml(
      "count = 3\nshare = 0.5\nname = \"x\"\nwords = [\"a\", \"b\"]\nkind = \"round\"\non = true\n", "p.toml");
  const std::vector<std::string> known = {"count", "share", "name", "words", "kind", "on", "absent"};
  const TomlTable table(document, "", "p.toml", known);
  uint32_t count = 0;
  table.whole("count", 1, 3, count);
  EXPECT_EQ(count, 3U);
  double share = 0;
  table.number("share", 0, 1, share);
  EXPECT_EQ(share, 0.5);
  std::optional<double> absent;
  table.number("absent", 0, 1, absent);
  EXPECT_FALSE(absent);
  std::vector<std::string> words = {"before"};
  table.texts("words", words);
  EXPECT_EQ(words, (std::vector<std::string>{"a", "b"}));
  Kind kind = Kind::flat;
  table.choice("kind", {"flat", "round"}, kind);
  EXPECT_EQ(kind, Kind::round);
  bool on = false;
  table.flag("on", on);
  EXPECT_TRUE(on);
  EXPECT_TRUE(table.tables("absent").empty());
  EXPECT_TRUE(error_of([&] {
                table.whole("count", 4, 5, count);
              }).starts_with("p.toml:1: `count` is not a whole number from 4 to 5"));
  EXPECT_TRUE(error_of([&] { table.number("name", 0, 1, share); }).starts_with("p.toml:3: "));
  EXPECT_TRUE(error_of([&] { table.choice("kind", {"flat", "oval"}, kind); }).starts_with("p.toml:5: "));
  EXPECT_NE(error_of([&] {
              TomlTable(document, "t", "p.toml", {"counts", "share", "name", "words", "kind", "on"});
            }).find("p.toml:1: unknown key `count` of t; did you mean `counts`?"),
            std::string::npos);
}

TEST(ScenarioTable, PutsKeysOnTopOfABaseAndSeesItsPathsFromThere) {
  const support::ScratchFolder folder;
  make_folder(folder / "scenes");
  write_file(folder / "scenes/base.toml", "width = 100\nheight = 50\n[[character]]\nsource = \"hero.glb\"\n");
  const TomlNode plan = parse_toml("base = \"scenes/base.toml\"\nheight = 60\n", "plan.toml");
  Scenario scenario;
  change_by_table(scenario, plan, "plan.toml", folder.path());
  EXPECT_EQ(scenario.width, 100);
  EXPECT_EQ(scenario.height, 60);
  ASSERT_EQ(scenario.characters.size(), 1U);
  EXPECT_EQ(scenario.characters[0].source, "scenes/hero.glb");
  const TomlNode wrong = parse_toml("\nbase = \"nowhere.toml\"\n", "plan.toml");
  EXPECT_TRUE(error_of([&] {
                change_by_table(scenario, wrong, "plan.toml", folder.path());
              }).starts_with("plan.toml:2: `base`: there is no file"));
}

}  // namespace
}  // namespace crowdbench::scene
