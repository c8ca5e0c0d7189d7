// Plans of sweeps: what they span, and what is said of those that are wrong.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <set>

#include "bench/sweep/axes.h"
#include "bench/sweep/estimate.h"
#include "bench/sweep/expression.h"
#include "bench/sweep/plan.h"
#include "bench/sweep/schedulers.h"
#include "bench/sweep/sweep_table.h"
#include "core/error.h"
#include "core/files.h"
#include "scene/gltf/gltf_files.h"
#include "test_paths.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::bench::sweep {
namespace {

Plan plan_of(const std::string& toml, const std::filesystem::path& folder = {}) {
  return parse_plan(toml, "p.toml", folder);
}

// "12=flat" for each point: the agents of its condition, the representation.
std::vector<std::string> points_of(const Plan& plan) {
  std::vector<std::string> out;
  for (const Condition& condition : plan.conditions)
    for (const PlannedPoint& point : condition.points)
      out.push_back(fmt::format("{}={}", condition.scenario.crowd.agents, point.representation));
  return out;
}

std::string fault_of(const std::string& toml) {
  try {
    plan_of(toml);
  } catch (const Error& error) {
    return error.what();
  }
  return "it is taken";
}

using Strings = std::vector<std::string>;

TEST(SweepPlan, AxesSpanAGridAndRepresentationsShareACondition) {
  const Plan plan = plan_of(R"(
[axes]
crowd.agents = [1, 10]
representation = ["flat", "mesh"]
occupancy = [0.15]
)");
  EXPECT_EQ(plan.name, "p");
  EXPECT_EQ(plan.axes, (Strings{"crowd.agents", "representation", "occupancy"}));
  EXPECT_EQ(points_of(plan), (Strings{"1=flat", "1=mesh", "10=flat", "10=mesh"}));
  ASSERT_EQ(plan.conditions.size(), 2U);
  EXPECT_EQ(plan.conditions[1].scenario.occupancy, 0.15);
  EXPECT_EQ(plan.points(), 4U);
  const std::vector<Setting>& settings = plan.conditions[1].points[0].settings;
  ASSERT_EQ(settings.size(), 3U);
  EXPECT_EQ(settings[0].axis, "crowd.agents");
  EXPECT_EQ(settings[0].text, "10");
  EXPECT_EQ(settings[0].number, 10);
  EXPECT_EQ(settings[1].number, std::nullopt);
}

TEST(SweepPlan, RangesStepEvenlyOrByFactors) {
  EXPECT_EQ(points_of(plan_of("[axes]\ncrowd.agents = { from = 1, to = 9, steps = 3 }\n")),
            (Strings{"1=mesh", "5=mesh", "9=mesh"}));
  EXPECT_EQ(points_of(plan_of("[axes]\ncrowd.agents = { from = 1, to = 10000, steps = 5, scale = \"log\" }\n")),
            (Strings{"1=mesh", "10=mesh", "100=mesh", "1000=mesh", "10000=mesh"}));
  // Whole numbers that fall together are one.
  EXPECT_EQ(points_of(plan_of("[axes]\ncrowd.agents = { from = 1, to = 3, steps = 9 }\n")).size(), 3U);
}

TEST(SweepPlan, OptionsConcernTheRepresentationsThatHaveThem) {
  const Plan plan = plan_of(R"toml(
[axes]
representation = ["mesh", "hybrid(mesh,relief)", "relief:rule=any"]
relief.map = [32, 64]
)toml");
  EXPECT_EQ(points_of(plan),
            (Strings{"100=mesh", "100=hybrid(mesh,(relief:map=32))", "100=hybrid(mesh,(relief:map=64))",
                     "100=relief:map=32,rule=any", "100=relief:map=64,rule=any"}));
  EXPECT_EQ(plan.conditions.size(), 1U);
  EXPECT_EQ(plan.conditions[0].points[0].settings.size(), 1U);  // the mesh has no map
  EXPECT_EQ(plan.conditions[0].points[1].settings.size(), 2U);
}

TEST(SweepPlan, ManyPointsOfOneScenarioMakeSeveralConditions) {
  const Plan plan = plan_of(
      "[axes]\nflat.frames = [1, 2, 3, 4, 5]\n[scenario]\nrepresentation = \"flat\"\n[measure]\n"
      "together = 2\n");
  ASSERT_EQ(plan.conditions.size(), 3U);
  EXPECT_EQ(plan.conditions[0].points.size(), 2U);
  EXPECT_EQ(plan.conditions[2].points.size(), 1U);
  EXPECT_EQ(plan.points(), 5U);
}

TEST(SweepPlan, NamedSettingsChangeManyKeysAtOnce) {
  support::ScratchFolder folder;
  std::filesystem::create_directories(folder / "scenes");
  write_file(folder / "scenes" / "two.toml",
             "[[character]]\nsource = \"a.glb\"\n[[character]]\nsource = \"mannequin\"\n");
  const Plan plan = plan_of(R"(
[scenario]
width = 320
[axes]
crowd.agents = [5]
[[axes.types]]
label = "one"
[[axes.types]]
label = "two"
base = "scenes/two.toml"
crowd.outfits = 3
)",
                            folder.path());
  ASSERT_EQ(plan.conditions.size(), 2U);
  EXPECT_EQ(plan.conditions[0].scenario.characters.size(), 1U);
  const scene::Scenario& two = plan.conditions[1].scenario;
  ASSERT_EQ(two.characters.size(), 2U);
  EXPECT_EQ(two.characters[0].source, "scenes/a.glb") << "seen from the plan's folder";
  EXPECT_EQ(two.characters[1].source, "mannequin");
  EXPECT_EQ(two.crowd.outfits, 3U);
  EXPECT_EQ(two.width, 320) << "what the settings do not say stays";
}

TEST(SweepPlan, ConditionsLeavePointsOutAndListsAddSome) {
  const Plan plan = plan_of(R"(
[axes]
crowd.agents = [1, 10, 100]
representation = ["mesh", "relief"]
relief.map = [32, 256]
[points]
where = ["crowd.agents < 100 or representation == 'mesh'", "relief.map * crowd.agents <= 320"]
[[points.also]]
crowd.agents = 7
representation = "flat"
seed = 3
)");
  EXPECT_EQ(points_of(plan), (Strings{"1=mesh", "1=relief:map=32", "1=relief:map=256", "10=mesh", "10=relief:map=32",
                                      "100=mesh", "7=flat"}));
  EXPECT_EQ(plan.conditions.back().scenario.seed, 3U);
  EXPECT_EQ(plan.axes.back(), "seed");
}

TEST(SweepPlan, SampledAxesAreDrawnTogetherAndFillTheirRanges) {
  const std::string axes =
      "[axes]\ncrowd.agents = { from = 10, to = 1000, scale = \"log\" }\noccupancy = { from = 0.1, to = 0.9 }\n";
  const Plan halton_plan = plan_of(axes + "[points]\nsample = { method = \"halton\", count = 64, seed = 5 }\n");
  ASSERT_EQ(halton_plan.conditions.size(), 64U);
  // Each eighth of either range holds eight of 64, give or take one or two: that is what low discrepancy means.
  std::array<int, 8> by_occupancy{};
  std::array<int, 8> by_agents{};
  for (const Condition& c : halton_plan.conditions) {
    ++by_occupancy.at(static_cast<size_t>((*c.scenario.occupancy - 0.1) / 0.8 * 8));
    ++by_agents.at(std::min<size_t>(7, static_cast<size_t>(std::log10(c.scenario.crowd.agents / 10.0) / 2 * 8)));
  }
  for (const int count : by_occupancy) EXPECT_NEAR(count, 8, 2);
  for (const int count : by_agents) EXPECT_NEAR(count, 8, 2);
  const Plan again = plan_of(axes + "[points]\nsample = { count = 64, seed = 5 }\n");
  EXPECT_EQ(again.hash, halton_plan.hash);
  EXPECT_NE(plan_of(axes + "[points]\nsample = { count = 64, seed = 6 }\n").hash, halton_plan.hash);
  EXPECT_NE(plan_of(axes + "[points]\nsample = { method = \"random\", count = 64, seed = 5 }\n").hash,
            halton_plan.hash);
}

// van der Corput in bases 2 and 3, before the shift: 1/2, 1/4, 3/4 and 1/3, 2/3, 1/9.
TEST(SweepPlan, HaltonIsShiftedByItsSeedAlone) {
  for (const auto& [dimension, values] : {std::pair<size_t, std::array<double, 3>>{0, {0.5, 0.25, 0.75}},
                                          std::pair<size_t, std::array<double, 3>>{1, {1. / 3, 2. / 3, 1. / 9}}})
    for (const uint64_t seed : {1U, 2U})
      for (size_t i = 1; i < 3; ++i) {
        const double moved = halton(seed, i, dimension) - halton(seed, 0, dimension);
        const double wanted = values.at(i) - values[0];
        EXPECT_NEAR(moved - std::round(moved - wanted), wanted, 1e-12);
      }
}

TEST(SweepPlan, KeysSayWhatIsShownAndNothingElse) {
  const auto keys = [](const std::string& toml) {
    const Plan plan = plan_of(toml);
    std::set<std::string> out;
    for (const Condition& condition : plan.conditions)
      for (const PlannedPoint& point : condition.points) out.insert(plan.key(condition, point, 0));
    return out;
  };
  const std::string axes = "crowd.agents = [1, 2]\nrepresentation = [\"mesh\", \"flat\"]\n";
  const std::set<std::string> wanted = keys("[axes]\n" + axes);
  EXPECT_EQ(wanted.size(), 4U);
  EXPECT_EQ(keys("# a comment\nname = \"other\"\nlook_for = \"it\"\n[axes]\nrepresentation = [\"flat\", \"mesh\"]\n"
                 "crowd.agents = [2, 1]\n"),
            wanted);
  EXPECT_EQ(keys("[axes]\n" + axes + "[measure]\nscores = []\n").count(*wanted.begin()), 0U);
  EXPECT_EQ(keys("[axes]\n" + axes + "[scenario]\nseed = 2\n").count(*wanted.begin()), 0U);
  EXPECT_EQ(plan_of("[axes]\n" + axes).hash, plan_of("#\n[axes]\n" + axes).hash);
  EXPECT_NE(plan_of("[axes]\n" + axes).hash, plan_of("[axes]\n" + axes + "[points]\nrepetitions = 2\n").hash);
}

// What is wrong, where, and what would be right.
// A character's file that has changed, or a buffer that it names, is another character.
TEST(SweepPlan, KeysHoldWhatTheCharactersFilesHold) {
  const support::ScratchFolder scratch;
  const std::filesystem::path& folder = scratch.path();
  const auto key = [&](const std::string& source) {
    const Plan plan = plan_of("[axes]\nseed = [1]\n[[scenario.character]]\nsource = \"" + source + "\"\n", folder);
    return plan.key(plan.conditions[0], plan.conditions[0].points[0], 0);
  };
  write_file(folder / "a.gltf", std::string_view(R"({"buffers": [{"uri": "a.bin"}]})"));
  write_file(folder / "a.bin", std::string_view("one"));
  const std::string first = key("a.gltf");
  EXPECT_EQ(key("a.gltf"), first);
  write_file(folder / "a.bin", std::string_view("two"));
  const std::string second = key("a.gltf");
  EXPECT_NE(second, first);
  write_file(folder / "a.gltf", std::string_view(R"({"buffers": [{"uri": "a.bin"}] })"));
  EXPECT_NE(key("a.gltf"), second);
  // By the loader's rules: names are decoded, and nothing outside of the asset's folder is looked at.
  std::filesystem::create_directory(folder / "in");
  write_file(folder / "in/b.gltf", std::string_view(R"({"images": [{"uri": "a%20b.png"}, {"uri": "../a.bin"}]})"));
  write_file(folder / "in/a b.png", std::string_view("one"));
  const std::string third = key("in/b.gltf");
  std::vector<std::pair<std::string, bool>> named_files;
  scene::each_gltf_file(read_file(folder / "in/b.gltf"), folder / "in",
                        [&](const std::string& uri, const auto& bytes) { named_files.emplace_back(uri, !!bytes); });
  EXPECT_EQ(named_files, (std::vector<std::pair<std::string, bool>>{{"a%20b.png", true}, {"../a.bin", false}}));
  write_file(folder / "a.bin", std::string_view("three"));
  EXPECT_EQ(key("in/b.gltf"), third);
  write_file(folder / "in/a b.png", std::string_view("two"));
  EXPECT_NE(key("in/b.gltf"), third);
  // A container's names count too, and what is long is no trouble.
  const std::string named = R"({"images": [{"uri":)" + std::string(100'000, ' ') + R"("in/a b.png"}]})";
  const auto little_endian = [](size_t value) {
    std::string out;
    for (int shift = 0; shift < 32; shift += 8) out += static_cast<char>(value >> shift & 0xFF);
    return out;
  };
  const std::string padded = named + std::string((4 - named.size() % 4) % 4, ' ');
  write_file(folder / "c.glb", std::string_view("glTF" + little_endian(2) + little_endian(20 + padded.size()) +
                                                little_endian(padded.size()) + "JSON" + padded));
  const std::string fourth = key("c.glb");
  write_file(folder / "in/a b.png", std::string_view("three"));
  EXPECT_NE(key("c.glb"), fourth);
  std::filesystem::remove(folder / "a.gltf");
  EXPECT_EQ(key("a.gltf"), key("a.gltf")) << "what is missing is said when it is loaded";
}

TEST(SweepPlan, ValuesOfOptionsAreCheckedWhenThePlanIsRead) {
  const auto with = [](const std::string& representation) {
    return fault_of("[axes]\nrepresentation = [\"" + representation + "\"]\n");
  };
  EXPECT_NE(with("relief:depth=12").find("option depth=12 is not one of 8, 16"), std::string::npos)
      << with("relief:depth=12");
  EXPECT_NE(with("hybrid(mesh,(flat:texels=4),distance=5)").find("option texels=4 is not a number from 16 to 1024"),
            std::string::npos)
      << with("hybrid(mesh,(flat:texels=4),distance=5)");
  EXPECT_NE(with("relief:merge=17").find("is not one of auto|0..16"), std::string::npos);
  for (const char* fine : {"relief:merge=auto", "relief:merge=3", "relief:steps=64+5", "flat:texels=64"})
    EXPECT_EQ(with(fine), "it is taken");
  EXPECT_EQ(fault_of("[axes]\nrepresentation = [\"relief:depth=12\", \"flat\"]\n[points]\n"
                     "where = [\"representation == 'flat'\"]\n"),
            fault_of("[axes]\nrepresentation = [\"relief:depth=12\"]\n"))
      << "what is left out is checked too";
}

// Rows and labels of one hybrid at several distances tell them apart, the default one too.
TEST(SweepPlan, AHybridKeepsTheDistanceThatItWasGiven) {
  const Plan plan = plan_of("[axes]\nrepresentation = [\"hybrid(mesh,flat)\"]\nhybrid.distance = [10, 20]\n");
  EXPECT_EQ(points_of(plan), (Strings{"100=hybrid(mesh,flat,distance=10)", "100=hybrid(mesh,flat,distance=20)"}));
}

TEST(SweepPlan, FaultsNameTheirLineAndTheNearestName) {
  const std::vector<std::pair<std::string, std::string>> faults = {
      {"", "p.toml: nothing varies"},
      {"[axis]\n", "p.toml:1: unknown key `axis`; did you mean `axes`?"},
      {"[axes]\n\ncrowd.agent = [1]\n", "p.toml:3: the axis `crowd.agent` is neither"},
      {"[axes]\ncrowd.agent = [1]\n", "did you mean `crowd.agents`?"},
      {"[axes]\nagents = [1]\n", "did you mean `crowd.agents`?"},
      {"[axes]\nflat.texel = [64]\n", "p.toml:2: flat has no option 'texel'; did you mean `texels`?"},
      {"[axes]\nseed = [1]\nflat.texels = [64, 32]\n",
       "p.toml:3: `flat.texels` changes nothing: no point draws `flat`"},
      {"[axes]\nflat.texels = [\"64,views=9\"]\n", "which is not a value that an option takes"},
      {"[axes]\ncrowd.agents = 5\n", "p.toml:2: the axis `crowd.agents` is an integer; give a list"},
      {"[axes]\ncrowd.agents = []\n", "has 0 values"},
      {"[axes]\ncrowd.agents = [1,\n 1]\n", "p.toml:3: the axis `crowd.agents` has 1 twice"},
      {"[axes]\ncrowd.agents = [1,\n 1.5]\n", "p.toml:3: `crowd.agents` is a number; give an integer"},
      {"[axes]\ncrowd.agents = [-1]\n", "it must lie between 0 and 1000000"},
      {"[axes]\ncrowd.agents = { from = 1, to = 5 }\n", "p.toml:2: the range of `crowd.agents` has no `steps`"},
      {"[axes]\ncrowd.agents = { from = 1, stop = 5, steps = 2 }\n", "unknown key `stop` of a range"},
      {"[axes]\ncrowd.agents = { from = 9, to = 5, steps = 2 }\n", "goes from 9 to 5"},
      {"[axes]\nocc = { from = 0, to = 1, steps = 2, scale = \"log\" }\n", "the axis `occ` is neither"},
      {"[axes]\noccupancy = { from = 0.1, to = inf, steps = 2 }\n", "has no number as `to`"},
      {"[axes]\nrepresentation = [\"mesh\",\n \"flta\"]\n",
       "p.toml:3: `representation`: there is no representation 'flta'"},
      {"[axes]\ncamera.key.time = [1]\n", "`camera.key` is a table of keys"},
      {"[axes]\n\"camera.key.time\" = [1]\n", "is of a camera's path"},
      {"[axes]\ncamera = [1]\n", "`camera` is a table of keys"},
      {"[[axes.types]]\ncrowd.agents = 1\n", "p.toml:1: an entry of `types` has no label"},
      {"[[axes.types]]\nlabel = \"a\"\ncrowd.agnts = 1\n",
       "p.toml:3: unknown key `crowd.agnts`; did you mean `agents`?"},
      {"[[axes.types]]\nlabel = \"a\"\n[[axes.types]]\nlabel = \"a\"\n", "the label 'a' is given twice"},
      {"[scenario]\nbase = \"nowhere.toml\"\n", "p.toml:2: `base`: there is no file 'nowhere.toml'"},
      {"[scenario]\nwidht = 3\n[axes]\nseed = [1]\n", "p.toml:2: unknown key `widht`; did you mean `width`?"},
      {"[axes]\nsamples = [1,3]\n", "the point samples = 3: `samples` is 3"},
      {"[axes]\nseed = [1]\n[points]\nwhere = [\"sed > 1\"]\n",
       "p.toml:4: `sed > 1` names `sed`, which is not an axis; did"},
      {"[axes]\nseed = [1]\n[points]\nwhere = [\"seed >\"]\n", "it ends too early"},
      {"[axes]\nseed = [1]\n[points]\nwhere = [\"seed = 1\"]\n", "equality is written =="},
      {"[axes]\nseed = [1]\n[points]\nwhere = [\"seed\"]\n", "a number or a text stands where a comparison is wanted"},
      {"[axes]\nseed = [1]\n[points]\nwhere = [\"seed > 1\"]\n", "p.toml:3: the conditions leave no point"},
      {"[axes]\nseed = [1]\n[points]\nsample = { count = 3 }\n", "no axis is left for `sample`"},
      {"[axes]\nseed = [1]\n[points]\nrepetitions = 0\n", "`repetitions` is not a whole number from 1 to 1000"},
      {"[axes]\nseed = [1]\n[measure]\nscores = [\"flipp\"]\n",
       "p.toml:4: there is no score 'flipp'; did you mean `flip`?"},
      {"[axes]\nseed = [1]\n[measure]\nrounds = 3\n", "`rounds` is not a whole number from 10"},
      {"[axes]\nseed = [1]\n[measure]\ntimes = false\nscores = []\n", "neither times nor scores are wanted"},
      {"[axes]\nseed = [1]\n[measure]\nreference = \"msh\"\n",
       "p.toml:4: `reference`: there is no representation 'msh'"},
      {"[axes]\nseed = [1]\n[[table]]\nrows = \"sede\"\nvalue = \"speed\"\n", "`rows`: there is no axis 'sede'"},
      {"[axes]\nseed = [1]\n[[table]]\nrows = \"seed\"\nvalue = \"sped\"\n", "did you mean `speed`?"},
      {"[axes]\nseed = [1]\n[measure]\nscores = [\"flip\"]\n[[table]]\nrows = \"seed\"\nvalue = \"mae\"\n",
       "is not measured"},
      {"[axes]\nseed = [1]\n[[table]]\nrows = \"seed\"\nvalue = \"agents_at_ms\"\n", "belong together"},
      {"name = 3\n[axes]\nseed = [1]\n", "p.toml:1: `name` is not a text"},
      {"[axes]\nseed = [1]\nlook_for = \"x\"\n", "the axis `look_for` is neither"},
      {"[axes\n", "p.toml:1: "},
      {"axes = 3\n", "`axes` is an integer"},
      {"[[axes.types]]\nlabel = \"a\"\n[axes]\nseed = [1]\n", "[axes] above the [[axes.name]]"},
      {"[axes]\nrepresentation = [\"relief\"]\nrelief.map = [64,\n 1000000]\n",
       "p.toml:4: `relief.map`: option map=1000000 is not one of 32, 64, 128, 256"},
  };
  for (const auto& [toml, wanted] : faults)
    EXPECT_NE(fault_of(toml).find(wanted), std::string::npos) << toml << fault_of(toml) << "\n  wanted: " << wanted;
}

TEST(SweepPlan, HostileTextIsRefusedAtOnce) {
  std::string axes = "[axes]\n";
  for (const char* key : {"seed", "width", "height", "crowd.agents", "crowd.outfits", "tick_rate"})
    axes += fmt::format("{} = [{}]\n", key, "1, 2, 3, 4, 5, 6, 7, 8, 9, 10");
  EXPECT_NE(fault_of(axes).find("the axes span more than 100000 points"), std::string::npos) << fault_of(axes);
  EXPECT_NE(fault_of("[axes]\nseed = " + std::string(100, '[')).find("brackets nest deeper"), std::string::npos);
  EXPECT_NE(fault_of("[axes]\nseed = { from = 0, to = 9e18, steps = 1000000000 }\n").find("`steps`"),
            std::string::npos);
  const auto condition = [](const std::string& text) {
    return fault_of("[axes]\nseed = [1]\n[points]\nwhere = [\"" + text + "\"]\n");
  };
  EXPECT_NE(condition(std::string(500, '(')).find("it nests too deeply"), std::string::npos);
  EXPECT_NE(condition(std::string(500, '-') + "1 < 2").find("it nests too deeply"), std::string::npos);
  EXPECT_NE(condition(std::string(2000, '1')).find("make several of it"), std::string::npos);
  EXPECT_NE(condition("seed == 'a").find("a text has no end"), std::string::npos);
  EXPECT_NE(condition("seed $ 1").find("`$` is not expected"), std::string::npos);
  EXPECT_NE(condition("1e999 < seed").find("is not a number"), std::string::npos);
  EXPECT_EQ(condition("seed / 0 > 5"), "it is taken");  // infinity is more
}

TEST(SweepExpression, FollowsTheUsualPrecedence) {
  const std::map<std::string, AxisNumberOrText> values = {{"a", 6.0}, {"b.c", 3.0}, {"t", std::string("x y")}};
  const auto holds = [&](const std::string& text) { return Expression(text, "w", {"a", "b.c", "t"}).holds(values); };
  EXPECT_TRUE(holds("a + b.c * 2 == 12"));
  EXPECT_TRUE(holds("(a + b.c) * 2 == 18"));
  EXPECT_TRUE(holds("a - b.c - 1 == 2 and a / b.c / 2 == 1"));
  EXPECT_TRUE(holds("-a < 1e-3 and t == 'x y'"));
  EXPECT_TRUE(holds("a < 1 and a < 2 or b.c >= 3"));
  EXPECT_FALSE(holds("not a > 5 or t != \"x y\""));
  EXPECT_TRUE(holds("not (a > 5 and b.c > 5)"));
  EXPECT_FALSE(holds("t == a"));
  EXPECT_THROW(holds("t < 3"), Error);
  EXPECT_THROW(holds("a + (b.c > 1) > 0"), Error);
  EXPECT_THROW(holds("a < 1 < 2"), Error);
}

// Every plan that ships is one, and says what to look for.
TEST(SweepPlan, ThoseThatShipAreRead) {
  size_t plans = 0;
  std::ifstream file(CROWDBENCH_SOURCE_DIR "/bench/plans/README.md");
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  for (const auto& entry : std::filesystem::directory_iterator(CROWDBENCH_SOURCE_DIR "/bench/plans")) {
    if (entry.path().extension() != ".toml") continue;
    SCOPED_TRACE(entry.path().filename().string());
    const Plan plan = read_plan(entry.path());
    EXPECT_FALSE(plan.look_for.empty());
    EXPECT_FALSE(plan.tables.empty());
    EXPECT_EQ(plan.name, entry.path().stem());
    EXPECT_GT(plan.points(), 1U);
    EXPECT_NE(page.find("| `" + plan.name + ".toml` | " + plan.look_for + " |"), std::string::npos) << "in README.md";
    ++plans;
  }
  EXPECT_GE(plans, 11U);
}

// The plan that the README explains every key by.
TEST(SweepPlan, TheOneInTheReadmeIsRead) {
  std::ifstream file(CROWDBENCH_SOURCE_DIR "/bench/sweep/README.md");
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  const size_t begin = page.find("```toml\n");
  ASSERT_NE(begin, std::string::npos);
  const Plan plan = plan_of(page.substr(begin + 8, page.find("```", begin + 8) - begin - 8));
  EXPECT_EQ(plan.name, "textures");
  EXPECT_EQ(plan.tables.size(), 1U);
  // Two occupancies, nine crowds, twenty lenses; three representations, one of them with two maps; some are left out.
  EXPECT_GT(plan.points(), 2 * 9 * 20U);
  EXPECT_LT(plan.points(), 2 * 9 * 20 * 4U);
}

// ---- what a sweep will take

constexpr const char* kTwoByTwo =
    "[axes]\ncrowd.agents = [1, 10]\nrepresentation = [\"flat\", \"mesh\"]\n[points]\nrepetitions = 3\n"
    "[measure]\ntime_limit_s = 7\n";

TEST(SweepEstimate, IsAGuessOfTheRestOfTheShard) {
  const support::ScratchFolder folder;
  const Plan plan = plan_of(kTwoByTwo);
  const Estimate all = estimate(plan, {1, 1}, folder / "none.sqlite");
  EXPECT_EQ(all.conditions, 2U);
  EXPECT_EQ(all.repetitions, 3U);
  EXPECT_EQ(all.points, 12U);
  EXPECT_EQ(all.held, 0U);
  EXPECT_FALSE(all.measured);
  // Two conditions three times: two points, the reference and its twin in 8 rounds to warm up and 24 more, by what a
  // frame of so many agents took where it was tried, 1.5 s more each; two bakes of 5 s.
  const double pixels = 640 * 480 * 5e-8;
  EXPECT_NEAR(all.seconds, 3 * (32 * 4 * (2 * (0.003 + pixels) + 11 * 0.0004) + 2 * 1.5) + 2 * 5, 1e-6);
  // A long frame's rounds end at the time limit.
  EXPECT_NEAR(
      estimate(plan_of("[axes]\ncrowd.agents = [100000]\n[measure]\ntime_limit_s = 7\n"), {1, 1}, "none").seconds,
      2 * 7 + 1.5 + 5, 1e-6);
  const Estimate half = estimate(plan, {2, 2}, folder / "none.sqlite");
  EXPECT_EQ(half.conditions, 1U);
  EXPECT_EQ(half.points, 6U);
  EXPECT_LT(half.bytes, all.bytes);
  const Estimate none = estimate(plan, {3, 3}, folder / "none.sqlite");
  EXPECT_EQ(none.points, 0U) << "more shards than conditions";
  EXPECT_EQ(none.seconds, 0);
}

TEST(SweepEstimate, ADryRunHasALineAPoint) {
  Estimate all = estimate(plan_of(kTwoByTwo), {1, 1}, "none.sqlite");
  all.bytes = 1'500'000;
  EXPECT_EQ(dry_run_text(plan_of(kTwoByTwo), {1, 1}, all),
            "condition 1: crowd.agents = 1, representation = flat\n"
            "condition 1: crowd.agents = 1, representation = mesh\n"
            "condition 2: crowd.agents = 10, representation = flat\n"
            "condition 2: crowd.agents = 10, representation = mesh\n"
            "p: 12 points in 2 conditions, 3 times each; about 35 s by a rough guess; a file of about 1.5 MB\n");
  all.held = 6;
  all.bytes = 999'400;
  const std::string done = dry_run_text(plan_of(kTwoByTwo), {1, 1}, all);
  EXPECT_TRUE(done.ends_with("3 times each; 6 done already; a file of about 999 kB\n")) << done;
}

// ---- jobs of schedulers

TEST(SweepJobs, ShardsAreNamedBesideTheMergedFile) {
  EXPECT_EQ(shard_file("a/textures.sqlite", 2, 8), "a/textures-2-of-8.sqlite");
  EXPECT_EQ(shard_file("textures", 1, 1), "textures-1-of-1");
  EXPECT_EQ(shard_file("v1.2/all.tar.sqlite", 3, 10), "v1.2/all.tar-3-of-10.sqlite");
}

TEST(SweepJobs, NamesAndPathsCannotLeaveTheirLine) {
  ShardJobs jobs{"a\nb; c", "/bin/crowd bench", "/p.toml", "/out.sqlite", 2, {"--device", "it's 0"}};
  const std::string array = slurm_array(jobs);
  EXPECT_NE(array.find("#SBATCH --job-name=a_b__c\n#SBATCH --array=1-2\n"), std::string::npos) << array;
  EXPECT_NE(array.find("'/bin/crowd bench' sweep /p.toml --shard \"$SLURM_ARRAY_TASK_ID/2\" --device 'it'\\''s 0' \\\n"
                       "  --out /out-\"$SLURM_ARRAY_TASK_ID\"-of-2.sqlite &\n"),
            std::string::npos)
      << array;
  EXPECT_NE(slurm_merge(jobs).find("exec '/bin/crowd bench' merge /out.sqlite \\\n  /out-1-of-2.sqlite \\\n"
                                   "  /out-2-of-2.sqlite\n"),
            std::string::npos);
  jobs.name = "";
  EXPECT_NE(slurm_array(jobs).find("--job-name=sweep\n"), std::string::npos);
  EXPECT_NE(openjd_template(jobs).find("\"{{Task.Param.Shard}}/2\""), std::string::npos);
}

// ---- tables

// Two crowds drawn by two representations, twice each; a mesh of 1000 agents at 8 ms.
StoreContents measured(const std::vector<std::pair<double, std::string>>& cells) {
  StoreContents out;
  RunRow run;
  run.id = 1;
  run.headline = "cpu";
  out.runs = {run};
  for (const auto& [agents, representation] : cells) {
    MeasurementRow row;
    row.id = static_cast<int64_t>(out.measurements.size() + 1);
    row.key.agents = static_cast<uint32_t>(agents);
    row.cpu_ns.emplace();
    row.cpu_ns->median = 1e4 * agents;
    row.cpu_ns->low = 0.5e4 * agents;
    row.cpu_ns->high = 2e4 * agents;
    row.frame_ns = row.cpu_ns;
    out.measurements.push_back(row);
    SweepPointRow point;
    point.run = 1;
    point.role = "point";
    point.state = "done";
    point.representation = representation;
    point.settings = fmt::format(R"({{"crowd.agents": "{:g}"}})", agents);
    point.measurement = row.id;
    out.sweep_points.push_back(point);
  }
  return out;
}

TEST(SweepTable, ACellIsAValueWithItsIntervalOrTheMedianOfSeveral) {
  const Plan plan = plan_of(kTwoByTwo);
  StoreContents contents = measured({{100, "mesh"}, {400, "mesh"}, {100, "a|b"}});
  TableRequest request{"", "crowd.agents", "representation", "time_ms", {}, ""};
  EXPECT_EQ(table_text(request, plan, contents),
            "**p**: time, ms, by representation\n\n"
            "| crowd.agents | mesh | a\\|b |\n|---|--:|--:|\n"
            "| 100 | 1.000 [0.500, 2.000] | 1.000 [0.500, 2.000] |\n"
            "| 400 | 4.000 [2.000, 8.000] | - |\n");
  // Several points of one cell: their median, and how many they are where they differ.
  request = {"All", "representation", "", "time_ms", {}, ""};
  EXPECT_EQ(table_text(request, plan, contents),
            "**All**\n\n| representation | time, ms |\n|---|--:|\n| mesh | 2.500 (of 2) |\n| a\\|b | 1.000 [0.500, "
            "2.000] |\n");
}

TEST(SweepTable, SampledRowsAscendAndTheReferenceHasNoScoreOfItself) {
  const Plan plan = plan_of(kTwoByTwo);
  StoreContents contents = measured({{7, "flat"}, {46, "flat"}, {13, "flat"}, {7, "mesh"}});
  contents.sweep_points.back().role = "reference";
  EXPECT_EQ(
      table_text({"", "crowd.agents", "representation", "ssim", {}, ""}, plan, contents),
      "**p**: SSIM, by representation\n\n| crowd.agents | flat |\n|---|--:|\n| 7 | - |\n| 13 | - |\n| 46 | - |\n");
  EXPECT_NE(
      table_text({"", "crowd.agents", "representation", "time_ms", {}, ""}, plan, contents).find("| flat | mesh |"),
      std::string::npos);
  // Falling lists stay as they are.
  EXPECT_NE(table_text({"", "crowd.agents", "", "time_ms", {}, ""}, plan, measured({{400, "flat"}, {100, "flat"}}))
                .find("| 400 | 4.000 [2.000, 8.000] |\n| 100"),
            std::string::npos);
}

TEST(SweepTable, AgentsInSoManyMillisecondsFollowAPowerLaw) {
  const Plan plan = plan_of(kTwoByTwo);
  // 1 ms at 100 and 4 ms at 400: 200 in 2 ms.
  const StoreContents contents = measured({{100, "mesh"}, {400, "mesh"}});
  const auto agents_at = [&](double ms) {
    const std::string text = table_text({"", "representation", "", "agents_at_ms", ms, ""}, plan, contents);
    return text.substr(text.find("| mesh |"));
  };
  EXPECT_EQ(agents_at(2), "| mesh | 200 |\n");
  EXPECT_EQ(agents_at(1), "| mesh | 100 |\n");
  EXPECT_EQ(agents_at(0.5), "| mesh | < 100 |\n");
  EXPECT_EQ(agents_at(9), "| mesh | > 400 |\n");
}

TEST(SweepTable, WhatIsNotThereIsRefusedWithTheNearest) {
  const auto fault = [](const TableRequest& request, const Measures& measures) {
    try {
      check_table(request, {"crowd.agents"}, measures);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("it is taken");
  };
  Measures measures;
  EXPECT_EQ(fault({"", "crowd.agents", "representation", "time_ms", {}, "p:1"}, measures), "it is taken");
  EXPECT_EQ(fault({"", "crowd.agent", "", "time_ms", {}, "p:1"}, measures),
            "p:1: `rows`: there is no axis 'crowd.agent'; did you mean `crowd.agents`?");
  EXPECT_EQ(fault({"", "crowd.agents", "", "time_m", {}, "p:1"}, measures),
            "p:1: `value`: there is no measure 'time_m'; did you mean `time_ms`?");
  EXPECT_TRUE(fault({"", "crowd.agents", "", "agents_at_ms", {}, "p:1"}, measures).starts_with("p:1: `at` and "));
  EXPECT_TRUE(fault({"", "crowd.agents", "", "time_ms", 3, "p:1"}, measures).starts_with("p:1: `at` and "));
  const std::string score(metrics::scores()[0]->name);
  EXPECT_EQ(fault({"", "crowd.agents", "", score, {}, "p:1"}, measures),
            "p:1: the score '" + score + "' is not measured; name it in [measure] `scores`");
  measures.scores = {metrics::scores()[0]};
  EXPECT_EQ(fault({"", "crowd.agents", "", score, {}, "p:1"}, measures), "it is taken");
  measures.times = false;
  EXPECT_TRUE(fault({"", "crowd.agents", "", "cpu_ms", {}, "p:1"}, measures).starts_with("p:1: 'cpu_ms' needs times"));
}

TEST(SweepTable, TheEndSaysWhereSpeedsHaveNoLevelBesideThem) {
  const auto said = [](std::vector<std::string> names) {
    StoreContents contents = measured({{100, "mesh"}, {100, "mesh"}, {100, "mesh"}});
    for (size_t i = 0; i < 3; ++i) {
      contents.sweep_points[i].representation = names[i];
      contents.sweep_points[i].ratio = 2;
    }
    return sweep_text(plan_of(kTwoByTwo), contents).find("No level of detail of mesh") != std::string::npos;
  };
  EXPECT_TRUE(said({"mesh", "flat", "relief"}));
  EXPECT_FALSE(said({"mesh", "flat", "mesh:triangles=500"}));
  EXPECT_FALSE(said({"mesh", "mesh", "mesh"})) << "no speed of another";
}

TEST(SweepTable, TheEndSaysTheControlsAndWhatWasNotDone) {
  StoreContents contents = measured({{100, "mesh"}, {100, "mesh"}, {100, "flat"}});
  contents.sweep_points[0].role = contents.sweep_points[1].role = "aa";
  contents.sweep_points[0].ratio = 1.02;
  contents.sweep_points[0].ratio_low = 0.99;
  contents.sweep_points[0].ratio_high = 1.05;
  contents.sweep_points[1].ratio = 0.95;
  contents.sweep_points[1].ratio_low = 0.93;
  contents.sweep_points[1].ratio_high = 0.97;
  contents.sweep_points[2].state = "failed";
  contents.sweep_points[2].reason = "no budget";
  Plan plan = plan_of(kTwoByTwo);
  plan.look_for = "Whether it holds.";
  const std::string text = sweep_text(plan, contents);
  EXPECT_TRUE(text.starts_with("Whether it holds.\n\n| crowd.agents | representation |")) << text;
  EXPECT_NE(
      text.find("A/A: of 2 pairs of the reference with itself the 95 % interval of 1 leaves 1 out; the farthest is "
                "5.3 % off.\n1 point (failed: no budget)\n"),
      std::string::npos)
      << text;
}

}  // namespace
}  // namespace crowdbench::bench::sweep
