#include "studies/plan/plan.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "core/error.h"
#include "core/files.h"
#include "scene/cast/load_cast.h"
#include "scene/crowd/crowd.h"
#include "studies/plan/default_texts.h"
#include "studies/plan/design.h"
#include "studies/plan/export.h"
#include "studies/plan/frozen.h"
#include "studies/plan/page_files.h"
#include "studies/plan/plan_cast.h"
#include "studies/plan/time_left.h"
#include "studies/stimuli/bodies.h"
#include "test_paths.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::studies {
namespace {
namespace fs = std::filesystem;

// A plan of this text, and more lines at its end.
StudyPlan parsed(const std::string& more) {
  return parse_study_plan("[conditions]\ntest = \"hybrid(mesh,flat)\"\n" + more, "study.toml", {});
}
std::string fault_of(const std::string& toml) {
  try {
    parse_study_plan(toml, "study.toml", {});
  } catch (const Error& error) {
    return error.what();
  }
  return "no fault";
}

TEST(StudyPlan, FactorsMakeConditions) {
  const StudyPlan plan = parsed(
      "[factors]\nswitch_m = [0, 10.5, \"inf\"]\nheight_px = [30, 60]\n"
      "[analysis]\nlevel = \"switch_m\"\n");
  ASSERT_EQ(plan.conditions.size(), 6U);
  EXPECT_EQ(plan.conditions[0].test.text(), "flat");
  EXPECT_EQ(plan.conditions[2].test.text(), "hybrid(mesh,flat,distance=10.5)");
  EXPECT_EQ(plan.conditions[5].test.text(), "mesh");
  EXPECT_EQ(plan.conditions[2].name, "switch_m=10.5 height_px=30");
  EXPECT_EQ(plan.conditions[3].height_px, 60);
  EXPECT_EQ(plan.conditions[2].level, 10.5);
  EXPECT_FALSE(plan.conditions[5].level.has_value());  // an infinite one has no place on an axis
  EXPECT_TRUE(plan.conditions[0].scenario.ground);
  EXPECT_EQ(plan.conditions[0].scenario.crowd.motion, scene::MotionKind::lanes);
  EXPECT_TRUE(plan.conditions[0].spacing_by_bodies);

  const StudyPlan other =
      parsed("[factors]\nflat.views = [\"sphere-17x8\", \"sphere-32x9\"]\ncrowd.spacing = [2, 3]\n");
  EXPECT_EQ(other.conditions[3].test.text(), "hybrid(mesh,(flat:views=sphere-32x9))");
  EXPECT_EQ(other.conditions[3].scenario.crowd.spacing, 3);
  EXPECT_FALSE(other.conditions[3].spacing_by_bodies);
}

TEST(StudyPlan, InstructionsSayWhatThePlanHas) {
  const std::string once = parsed("").instructions;
  EXPECT_NE(once.find("\n**Which crowd looks better?**\n"), std::string::npos) << once;
  EXPECT_NE(once.find("Each clip is shown once. The first clips are for practice: their answers do not count."),
            std::string::npos)
      << once;
  EXPECT_EQ(
      parse_study_plan("training = 0\n[conditions]\ntest = \"flat\"\n", "study.toml", {}).instructions.find("practice"),
      std::string::npos);
  EXPECT_NE(parsed("[stimulus]\nreplays = 1\n").instructions.find("Each clip may be watched once more."),
            std::string::npos);
}

TEST(StudyPlan, FaultsAreSaidPrecisely) {
  const std::string test = "[conditions]\ntest = \"hybrid(mesh,flat)\"\n";
  const std::vector<std::array<std::string, 2>> faults = {
      {"tilte = \"x\"\n", "study.toml:1: unknown key `tilte`; did you mean `title`?"},
      {"[question]\ntask = \"preferense\"\n", "study.toml:2: `task` is 'preferense'; did you mean \"preference\"?"},
      {"[question]\ntask = \"same-different\"\n", "study.toml:2: `same-different` does not ask \"better\""},
      {"[question]\ntask = \"preference\"\nask = \"pop\"\n",
       "study.toml:2: whether something popped is seen or not, and nothing that one prefers"},
      {"[conditions]\ntest = \"mesh\"\n", "study.toml:2: the reference, mesh, is held against itself"},
      {"[stimulus]\nfps = 500\n", "study.toml:2: `fps` is not a whole number from 1 to 240"},
      {"[stimulus]\nseconds = 0.51\n", "study.toml:2: 0.51 s are not a whole number of frames at 30 fps"},
      {"[stimulus]\nbar_px = 7\n", "study.toml:2: `bar_px` is odd"},
      {"[factors]\nswitch_m = [5]\n", "nothing is held against the reference"},
      {test + "[factors]\nswitch_mm = [5]\n", "study.toml:4: unknown factor `switch_mm`; did you mean `switch_m`?"},
      {test + "[factors]\nswitch_m = [5, -1]\n", "study.toml:4: `switch_m` holds what is not a number from 0"},
      {test + "[factors]\nswitch_m = [5, 5]\n", "study.toml:4: the factor `switch_m` has 5 twice"},
      {"[conditions]\ntest = \"flat\"\n[factors]\nswitch_m = [5]\n",
       "study.toml:4: `switch_m` switches between two representations, and 'flat' is one"},
      {"[conditions]\ntest = \"flta\"\n", "study.toml:2: `test`"},
      {test + "[factors]\nflat.viws = [5]\n", "study.toml:4: flat has no option 'viws'; did you mean `views`?"},
      {test + "[factors]\nrelief.steps = [\"8+4\"]\n", "is not drawn by it"},
      {"[conditions]\ntest = \"mesh\"\n[factors]\nmesh.triangles = [\"a\", 80]\n",
       "study.toml:4: `mesh.triangles`: option triangles=a is not a"},
      {"[conditions]\ntest = \"mesh\"\n[factors]\nmesh.triangles = [\n80,\n-3]\n",
       "study.toml:6: `mesh.triangles`: option triangles=-3 is not a"},
      {"[conditions]\ntest = \"mesh\"\n[factors]\nmesh.triangles = [40, \"inf\"]\n",
       "study.toml:4: `mesh.triangles`: option triangles=inf is not a"},
      {test + "[factors]\nhybrid.fade = [2, 900]\n", "study.toml:4: `hybrid.fade`: option fade=900 is not a"},
      {test + "[factors]\nflat.blend = [2]\n", "study.toml:4: `flat.blend`: "},
      {"[conditions]\ntest = \"mesh\"\n[factors]\npixels_per_texel = [1, 2]\n",
       "study.toml:4: 'mesh' has no texels that pixels could be counted by; use `height_px`"},
      {test + "[factors]\npixels_per_texel = [1]\nswitch_m = [5, \"inf\"]\n", "'mesh' has no texels"},
      {test + "[factors]\nheight_px = [40]\npixels_per_texel = [1]\n", "study.toml:5: `height_px` and"},
      {test + "[factors]\nheight_px = [300]\n", "are taller than `largest_px` = 120"},
      {test + "[factors]\nseed = [1, 2]\n", "study.toml:4: the factor `seed` has no meaning in a study"},
      {test + "[factors]\nwidth = [320, 640]\n", "the picture's size varies (width=640)"},
      {test + "[scenario]\ncrowd.motion = \"treadmill\"\n", "study.toml:4: a crowd that walks on the spot"},
      {test + "[scenario]\noccupancy = 0.2\n", "study.toml:4: `occupancy` moves camera and crowd"},
      {test + "[scenario]\nwidth = 641\n", "study.toml:4: a picture of 641x480 has an odd side"},
      {test + "[scenario]\ntick_rate = 50\n", "study.toml:4: 50 ticks a second do not divide into 30 frames"},
      {test + "[method]\nkind = \"quest-plus\"\n", "study.toml:4: the method chooses trials"},
      {test + "[method]\nkind = \"quest-plus\"\ntrials = 40\n", "QUEST+ needs a right answer"},
      {test + "[question]\ntask = \"forced-choice\"\n[method]\nkind = \"quest-plus\"\ntrials = 40\n",
       "QUEST+ needs one factor of three or more finite numbers"},
      {test + "[method]\ntrials = 40\n", "study.toml:4: `trials` follows from conditions"},
      {test + "[method]\nkind = \"active-pairs\"\ntrials = 9\n[factors]\nheight_px = [20, 40]\n",
       "active pairs compare representations within one scene"},
      {test + "[question]\nask = \"differs\"\ntask = \"same-different\"\n[catch]\nidentical = 1\n",
       "half of all same-different trials are identical already"},
      {test + "[catch]\nbroken_by = \"mesh\"\n", "`broken_by` is the reference"},
      {test + "[catch]\nbroken = 0\n[exclude]\ncatch_least = 0.5\n", "there are no broken catch trials"},
      {test + "[participants]\nlists = 3\n", "study.toml:4: 3 lists do not balance orders and sides of 1 conditions"},
      {test + "[participants]\nplanned = 9\n", "9 participants do not fill 2 lists evenly; plan 10"},
      {test + "[question]\ntask = \"forced-choice\"\n[analysis]\nties = \"drop\"\n",
       "`ties` is a rule for \"cannot tell\""},
      {test + "[analysis]\ncurve = \"weibull\"\n", "study.toml:4: `curve` is of the psychometric function"},
      {test + "[factors]\nswitch_m = [1, 2]\n[analysis]\nlevel = \"swich_m\"\n", "did you mean `switch_m`?"},
      {test + "[factors]\nswitch_m = [1, \"inf\"]\n[analysis]\nlevel = \"switch_m\"\n", "fewer than two finite levels"},
      {test + "[analysis]\nmargin = 0.7\n", "study.toml:4: `margin` is not a number from 0.001 to 0.5"},
      {test + "[question]\nconsent = \"nowhere.md\"\n", "study.toml:4: `consent`: nowhere.md"},
  };
  for (const auto& [toml, expected] : faults)
    EXPECT_NE(fault_of(toml).find(expected), std::string::npos) << toml << "\n" << fault_of(toml);
}

// What only loading finds is found before a plan is frozen, with its line.
TEST(StudyPlan, CharactersAndClipsAreThere) {
  const support::ScratchFolder folder;
  const fs::path file = folder / "p.toml";
  const auto fault = [&](const std::string& more) -> std::string {
    write_file(file, "[conditions]\ntest = \"flat\"\n" + more);
    try {
      require_cast(file, read_study_plan(file));
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(fault(""), "");
  EXPECT_EQ(fault("[factors]\ncharacter = [\"mannequin\", \"mannequin:triangles=500\"]\n"), "");
  const std::vector<std::array<std::string, 3>> faults = {
      {"[factors]\ncharacter = [\n\"mannequin\",\n\"nobody.glb\"]\n", ":6: ", "nobody.glb"},
      {"[factors]\ncharacter = [\"mannequin:triangles=x\"]\n", ":4: ", "triangles=x is not a whole number"},
      {"[factors]\nclip = [\"walk\", \"fly\"]\n", ":4: ", "fly"},
      {"[scenario]\n[[scenario.character]]\nsource = \"mannequin\"\nclips = [\"fly\"]\n", ":6: ", "fly"},
      {"[scenario]\n[[scenario.character]]\nsource = \"nobody.glb\"\n", ":5: ", "nobody.glb"}};
  for (const auto& [more, line, wrong] : faults) {
    const std::string said = fault(more);
    EXPECT_TRUE(said.starts_with(file.string() + line)) << more << said;
    EXPECT_NE(said.find(wrong), std::string::npos) << more << said;
  }
}

TEST(StudyPlan, HashIsOfTheMeaning) {
  const StudyPlan plan = parsed("[factors]\nswitch_m = [0, 10]\n[stimulus]\ncrowds = 2\n");
  const StudyPlan spelt = parsed(
      "# a comment\n[stimulus]\nseconds = 10\n[factors]\nswitch_m = [0.0, 10]\n"
      "[method]\nrepeats = 2\n");
  EXPECT_EQ(plan.hash(), spelt.hash());
  for (const char* const change : {"[stimulus]\ncrowds = 3\n", "[analysis]\nmargin = 0.1\n", "[scenario]\nseed = 2\n",
                                   "[exclude]\nhidden = false\n", "[participants]\nplanned = 400\n"})
    EXPECT_NE(parsed("[factors]\nswitch_m = [0, 10]\n" + std::string(change)).hash(), plan.hash()) << change;
}

// Every condition stands at each place of a round, directly after each other one, and on each side equally often, for
// even and odd numbers of conditions; a list shows every condition with every crowd so often as the plan says.
TEST(StudyDesign, OrdersAndSidesAreBalanced) {
  for (const int conditions : {2, 3, 4, 5}) {
    std::string levels = "1";
    for (int i = 2; i <= conditions; ++i) levels += fmt::format(", {}", i);
    const StudyPlan plan = parsed(
        fmt::format("[factors]\nswitch_m = [{}]\n[stimulus]\ncrowds = 2\n[method]\nrepeats = 2\nblocks = 2\n", levels));
    const StudyDesign design = make_design(plan);
    const auto n = static_cast<size_t>(conditions);
    ASSERT_EQ(design.lists.size(), 2 * n * (n % 2 == 0 ? 1 : 2));
    std::map<std::array<size_t, 3>, size_t> places;   // round, place, condition
    std::map<std::array<size_t, 3>, size_t> follows;  // round, condition, the one before
    std::map<std::array<size_t, 3>, int> sides;       // round, place, condition: tests on top less those below
    for (const auto& list : design.lists) {
      std::vector<size_t> shown;
      std::map<std::pair<size_t, uint32_t>, int> within;
      std::map<std::pair<size_t, uint32_t>, int> side;
      size_t catches = 0;
      for (const Trial& trial : list) {
        const Stimulus& stimulus = design.stimuli[trial.stimulus];
        catches += trial.kind == TrialKind::catch_trial ? 1 : 0;
        if (trial.kind != TrialKind::main) continue;
        shown.push_back(stimulus.condition);
        const size_t place = (shown.size() - 1) % n;
        const size_t round = (shown.size() - 1) / n;
        ++places[{round, place, stimulus.condition}];
        sides[{round, place, stimulus.condition}] += *stimulus.test_on_top ? 1 : -1;
        if (place > 0) ++follows[{round, stimulus.condition, shown[shown.size() - 2]}];
        ++within[{stimulus.condition, stimulus.crowd}];
        side[{stimulus.condition, stimulus.crowd}] += *stimulus.test_on_top ? 1 : -1;
      }
      EXPECT_EQ(catches, 4U);
      EXPECT_EQ(list.size(), trials_of_participant(plan));
      EXPECT_EQ(list.back().block, 2U);
      EXPECT_EQ(within.size(), 2 * n);
      for (const auto& [key, count] : within) EXPECT_EQ(count, 2);
      for (const auto& [key, balance] : side) EXPECT_EQ(balance, 0);
    }
    for (size_t round = 0; round < 4; ++round)
      for (size_t a = 0; a < n; ++a)
        for (size_t b = 0; b < n; ++b) {
          EXPECT_EQ((places[{round, a, b}]), design.lists.size() / n);
          EXPECT_EQ((sides[{round, a, b}]), 0);
          if (a != b) {
            EXPECT_EQ((follows[{round, a, b}]), design.lists.size() / n);
          }
        }
  }
}

TEST(StudyDesign, StimuliSayWhatIsRight) {
  const StudyPlan plan = parsed(
      "[question]\nask = \"differs\"\ntask = \"same-different\"\n[factors]\n"
      "switch_m = [0, 10]\n[stimulus]\nseeds = \"same\"\n");
  const StudyDesign design = make_design(plan);
  std::map<std::string, int> expected;
  for (const Trial& trial : design.lists[0])
    if (trial.kind == TrialKind::main) ++expected[design.stimuli[trial.stimulus].expected];
  EXPECT_EQ(expected["same"], expected["different"]);  // as many without a difference as with one
  EXPECT_EQ(expected["same"], 8);
  for (const Stimulus& stimulus : design.stimuli)
    if (stimulus.kind == StimulusKind::alike) {
      EXPECT_EQ(stimulus.upper, stimulus.lower);
    }

  // Two crowds: nobody compares pixels, and the twin of the half under test is its own crowd by the reference.
  const StudyPlan two = parsed("[factors]\nswitch_m = [0, 10]\n");
  const StudyDesign independent = make_design(two);
  size_t tests = 0;
  for (const Stimulus& stimulus : independent.stimuli) {
    if (stimulus.kind != StimulusKind::test) continue;
    ++tests;
    const PlannedHalf& test = independent.halves[*stimulus.test_on_top ? stimulus.upper : stimulus.lower];
    const PlannedHalf& other = independent.halves[*stimulus.test_on_top ? stimulus.lower : stimulus.upper];
    const PlannedHalf& twin = independent.halves[*stimulus.twin];
    EXPECT_NE(test.scenario.seed, other.scenario.seed);
    EXPECT_EQ(test.scenario.seed, twin.scenario.seed);
    EXPECT_EQ(twin.spec.text(), "mesh");
    EXPECT_EQ(stimulus.expected, *stimulus.test_on_top ? "lower" : "upper");  // the reference is the better one
  }
  EXPECT_EQ(tests, 2U * 2 * 2);                      // conditions, crowds, sides
  EXPECT_EQ(independent.halves.size(), 3U * 2 + 2);  // each crowd by each of three, and two that are broken
  std::set<std::string> ids;
  for (const Stimulus& stimulus : independent.stimuli) ids.insert(stimulus.id);
  EXPECT_EQ(ids.size(), independent.stimuli.size());
}

TEST(StudyDesign, PilotsHaveEverythingThatMayBeChosen) {
  const StudyPlan pairs = parsed("[factors]\nswitch_m = [0, 10, 20]\n[method]\nkind = \"active-pairs\"\ntrials = 12\n");
  const StudyDesign design = make_design(pairs);
  std::set<std::pair<std::string, std::string>> met;
  for (const Stimulus& stimulus : design.stimuli)
    if (stimulus.kind == StimulusKind::pair) met.insert({stimulus.item_upper, stimulus.item_lower});
  EXPECT_EQ(met.size(), 12U);  // four items, either way up
  // No condition is said of a pair, whose items are of two; of the other stimuli it is.
  for (const Stimulus& stimulus : design.stimuli) {
    const Json said = stimulus_json(pairs, design, stimulus);
    EXPECT_EQ(said.at("condition_name").text().empty(), stimulus.kind == StimulusKind::pair) << stimulus.id;
  }
  std::map<std::pair<std::string, std::string>, int> shown;
  for (const auto& list : design.lists)
    for (const Trial& trial : list)
      if (trial.kind == TrialKind::main)
        ++shown[{design.stimuli[trial.stimulus].item_upper, design.stimuli[trial.stimulus].item_lower}];
  EXPECT_EQ(shown.size(), 12U);
  for (const auto& [pair, count] : shown) EXPECT_EQ(count, shown.begin()->second);

  const StudyPlan quest = parsed(
      "[question]\ntask = \"forced-choice\"\n[factors]\nswitch_m = [0, 10, 20]\n"
      "[method]\nkind = \"quest-plus\"\ntrials = 7\n");
  EXPECT_EQ(quest.analysis.level, "switch_m");
  EXPECT_EQ(make_design(quest).lists[0].size(), 7U + 4 + 2);
}

TEST(StudyPlan, ShippedOnesAreWhole) {
  size_t plans = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(CROWDBENCH_SOURCE_DIR) / "studies" / "plans")) {
    if (entry.path().extension() != ".toml") continue;
    ++plans;
    const StudyPlan plan = read_study_plan(entry.path());
    EXPECT_EQ(plan.name, entry.path().stem().string());
    const StudyDesign design = make_design(plan);
    const ExportEstimate estimate = estimate_export(plan, design, false);
    EXPECT_GT(estimate.halves, 2U) << plan.name;
    EXPECT_GE(plan.participants.planned, 9U) << plan.name;
    EXPECT_LT(estimate.minutes_a_participant, 60) << plan.name;
    EXPECT_LT(estimate.page_bytes, 4e9) << plan.name;
    EXPECT_GE(estimate.seconds, estimate.bake_seconds) << plan.name;
  }
  EXPECT_EQ(plans, 6U);
}

// A bake is counted once for a representation and a character, whichever conditions and seeds ask for it; the reference
// and its levels of detail bake nothing.
TEST(StudyPlan, EstimatesCountEveryBakeOnce) {
  const auto estimated = [](const std::string& factors) {
    const StudyPlan plan = parsed("[question]\ntask = \"forced-choice\"\n[factors]\n" + factors);
    return estimate_export(plan, make_design(plan), false);
  };
  EXPECT_EQ(estimated("switch_m = [0, 10, 20]\n").bakes, 1U) << "the far half of three switches";
  const ExportEstimate two = estimated("switch_m = [0, 10]\nflat.views = [\"sphere-17x8\", \"sphere-32x9\"]\n");
  EXPECT_EQ(two.bakes, 2U);
  EXPECT_GT(two.bake_seconds, 0);
  EXPECT_GT(two.seconds, two.bake_seconds);
  const StudyPlan levels = parse_study_plan(
      "[conditions]\ntest = \"mesh\"\n[question]\ntask = \"forced-choice\"\n[factors]\nmesh.triangles = [40, 80]\n",
      "study.toml", {});
  EXPECT_EQ(estimate_export(levels, make_design(levels), false).bakes, 0U);
}

// The estimate's bakes do not make drawing look slow, and what they took here tells of those to come.
TEST(TimeLeft, CountsBakesApart) {
  TimeLeft left(100, 30);
  left.set_bakes(2);
  EXPECT_EQ(left.seconds(), 160) << "before anything was made";
  left.baked(1, 90);
  left.step(10, true, 20);
  left.set_bakes(1);
  EXPECT_EQ(left.seconds(), 90 * 2 + 90) << "twice as slow at drawing, and a bake as long as the first";
  left.baked(1, 0.5);  // from the cache
  left.step(10, true, 20);
  left.set_bakes(0);
  EXPECT_EQ(left.seconds(), 80 * 2);
  left.step(50, false, 0.01);  // kept from before
  EXPECT_EQ(left.seconds(), 30 * 2);
}

// Between every two switch distances that a shipped plan compares stand a twentieth of those in view, or more: else its
// conditions show the same.
TEST(StudyPlan, ShippedDistancesPartTheCrowd) {
  const StudyPlan plan =
      read_study_plan(fs::path(CROWDBENCH_SOURCE_DIR) / "studies" / "plans" / "switch_distance.toml");
  const std::vector<double> limits = {0, 10, 15, 1e9};
  ASSERT_EQ(plan.conditions.size(), limits.size());
  for (const char* const name : {"switch_m=0", "switch_m=10", "switch_m=15", "switch_m=inf"})
    EXPECT_TRUE(std::any_of(plan.conditions.begin(), plan.conditions.end(), [name](const StudyCondition& condition) {
      return condition.name == name;
    })) << name;
  scene::Scenario scenario = plan.conditions[0].scenario;
  const scene::Cast cast = scene::load_cast(scenario, plan.folder);
  scenario.crowd.spacing = spacing_of_bodies(scenario, cast);
  const scene::Crowd crowd = scene::make_crowd(scenario, cast, scene::stage_view(scenario));
  const scene::Camera camera = scenario.camera.at(0);
  std::vector<size_t> between(limits.size() - 1);
  size_t all = 0;
  for (uint64_t tick = 0; tick < 1500; tick += 300)
    for (const auto& agents : scene::make_frame(scenario, cast, crowd, camera, tick).agents)
      for (const scene::FrameAgent& agent : agents) {
        const double distance = glm::length(glm::dvec3(agent.position));  // of the eye
        ++all;
        for (size_t i = 0; i + 1 < limits.size(); ++i)
          between[i] += distance >= limits[i] && distance < limits[i + 1] ? 1 : 0;
      }
  for (const size_t each : between) EXPECT_GT(static_cast<double>(each), 0.05 * static_cast<double>(all));
}

class FrozenPlans : public testing::Test {
 protected:
  fs::path folder = fs::temp_directory_path() / ("crowdbench-frozen-" + std::to_string(::getpid()));
  fs::path file = folder / "study.toml";
  void SetUp() override { fs::create_directories(folder); }
  void TearDown() override { fs::remove_all(folder); }
  StudyPlan write(const std::string& more) const {
    write_file(file, "[conditions]\ntest = \"flat\"\n" + more);
    return read_study_plan(file);
  }
  static std::string fault(const std::function<void()>& run) {
    try {
      run();
    } catch (const Error& error) {
      return error.what();
    }
    return "no fault";
  }
};

TEST_F(FrozenPlans, ChangesAreSaidOrRefused) {
  const StudyPlan plan = write("");
  EXPECT_NE(fault([&] { require_frozen(file, plan); }).find("is not frozen"), std::string::npos);
  const FrozenPlan frozen = freeze(file, plan);
  EXPECT_EQ(frozen.file, folder / "study.frozen.json");
  EXPECT_EQ(require_frozen(file, plan).hash, plan.hash());
  const std::string before = read_text(frozen.file);
  freeze(file, plan);  // once more: nothing changes
  EXPECT_EQ(read_text(frozen.file), before);
  EXPECT_NE(before.find("\"deviations\": []"), std::string::npos);

  const StudyPlan changed = write("[analysis]\nmargin = 0.2\n");
  EXPECT_NE(fault([&] { require_frozen(file, changed); }).find("was changed since it was frozen"), std::string::npos);
  EXPECT_NE(fault([&] { freeze(file, changed); }).find("--deviation"), std::string::npos);
  freeze(file, changed, "the margin was too small");
  const FrozenPlan deviated = require_frozen(file, changed);
  EXPECT_EQ(deviated.hash, plan.hash());
  ASSERT_EQ(deviated.deviations.size(), 1U);
  EXPECT_EQ(deviated.deviations[0].reason, "the margin was too small");
  EXPECT_EQ(deviated.current_hash(), changed.hash());
  freeze(file, changed, {}, true);
  EXPECT_EQ(require_frozen(file, changed).hash, changed.hash());
}

TEST_F(FrozenPlans, EditedFilesAreRefused) {
  const StudyPlan plan = write("");
  const fs::path frozen = freeze(file, plan).file;
  const std::string text = read_text(frozen);
  const auto edited = [&](const std::string& from, const std::string& to) {
    std::string other = text;
    const size_t at = other.find(from);
    EXPECT_NE(at, std::string::npos);
    write_file(frozen, other.replace(at, from.size(), to));
    return fault([&] { read_frozen(file); });
  };
  EXPECT_NE(edited("\"alpha\": 0.05", "\"alpha\": 0.1").find("its analysis is not the one"), std::string::npos);
  EXPECT_NE(edited("\"crowds\": 2", "\"crowds\": 3").find("its hash is not that of its meaning"), std::string::npos);
  EXPECT_NE(edited("{", "").find("is not a JSON object"), std::string::npos);
}

}  // namespace
}  // namespace crowdbench::studies
