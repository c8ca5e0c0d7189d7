// The rule by which trials are chosen while a participant answers, and that the page follows the same one.
#include "studies/plan/adaptive.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/command_line.h"
#include "core/files.h"
#include "core/random.h"
#include "studies/analysis/active_pairs.h"
#include "studies/plan/frozen.h"
#include "studies/plan/page_files.h"
#include "studies/server/study_folder.h"
#include "test_paths.h"
#include "tests/support/driver.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::studies {
namespace {
namespace fs = std::filesystem;

const std::string kStudy(64, 'b');

StudyPlan quest_plan(const std::string& task, const std::string& levels, const std::string& analysis) {
  return parse_study_plan("[question]\nask = \"differs\"\ntask = \"" + task +
                              "\"\n[conditions]\ntest = \"hybrid(mesh,flat)\"\n[factors]\nswitch_m = " + levels +
                              "\n[method]\nkind = \"quest-plus\"\ntrials = 30\n" + analysis,
                          "study.toml", {});
}
StudyPlan pairs_plan(const std::string& task) {
  return parse_study_plan("[question]\ntask = \"" + task +
                              "\"\n[conditions]\ntest = \"hybrid(mesh,flat)\"\n[factors]\nswitch_m = [0, 5, 10, 20]\n"
                              "[method]\nkind = \"active-pairs\"\ntrials = 30\n",
                          "study.toml", {});
}

// One simulated participant's trials of a list, chosen and fixed ones, each with what stood before it.
struct Sitting {
  struct Turn {
    std::string trial;
    std::vector<GivenAnswer> before;
    std::string chosen;
  };
  AdaptiveRule rule;
  std::vector<Turn> turns;  // the chosen ones
  std::vector<GivenAnswer> given;
};
// right: how often the answer that counts as yes is given, by level; of pairs, that the earlier item is chosen.
template <typename Right>
Sitting sit(const StudyPlan& plan, uint64_t seed, const Right& right) {
  const StudyDesign design = make_design(plan);
  Sitting out;
  out.rule = adaptive_rule(plan, design);
  const std::vector<AnswerChoice> answers = answer_choices(plan.task);
  size_t number = 0;
  for (const Trial& trial : design.lists[0]) {
    const std::string name = "t" + std::to_string(++number);
    std::string stimulus = design.stimuli[trial.stimulus].id;
    if (trial.kind != TrialKind::main) continue;
    if (is_chosen(plan, design, trial)) {
      stimulus = chosen_stimulus(out.rule, kStudy, "1", name, out.given);
      out.turns.push_back({name, out.given, stimulus});
    }
    const auto choice = std::find_if(out.rule.choices.begin(), out.rule.choices.end(), [&](const AdaptiveChoice& c) {
      return std::find(c.stimuli.begin(), c.stimuli.end(), stimulus) != c.stimuli.end();
    });
    const double p = choice == out.rule.choices.end() ? 0.2 : right(*choice);
    const std::string& yes = out.rule.yes.at(stimulus);
    const auto no = std::find_if(answers.begin(), answers.end(), [&](const AnswerChoice& a) { return a.value != yes; });
    std::string answer = random_unit(seed, number, 1) < p ? yes : no->value;
    if (answers.size() > 2 && number % 7 == 0) answer = "cannot-tell";
    out.given.push_back({stimulus, answer});
  }
  return out;
}

double logistic(double x) { return 1 / (1 + std::exp(-x)); }

TEST(Adaptive, AllLevelsMayBeChosenEitherWayUp) {
  const StudyPlan plan = quest_plan("same-different", "[20, 0, 5]", "");
  const StudyDesign design = make_design(plan);
  const AdaptiveRule rule = adaptive_rule(plan, design);
  ASSERT_EQ(rule.choices.size(), 3U);
  std::vector<double> levels;
  for (const AdaptiveChoice& choice : rule.choices) {
    levels.push_back(choice.level);
    EXPECT_EQ(choice.stimuli.size(), 2U * plan.stimulus.crowds);
    for (const std::string& stimulus : choice.stimuli) EXPECT_EQ(rule.yes.at(stimulus), "different");
  }
  EXPECT_EQ(levels, (std::vector<double>{0, 5, 20}));
  EXPECT_EQ(rule.threshold.front(), 0);
  EXPECT_EQ(rule.threshold.back(), 20);
  EXPECT_EQ(rule.guess.size(), 6U) << "what a participant likes to say is not known";
  EXPECT_FALSE(rule.alike.empty());
  for (const Trial& trial : design.lists[0])
    EXPECT_EQ(is_chosen(plan, design, trial),
              trial.kind == TrialKind::main && design.stimuli[trial.stimulus].kind == StimulusKind::test);
}

TEST(Adaptive, OfAPairYesIsTheFirstItemWhereverItStands) {
  const StudyPlan plan = pairs_plan("forced-choice");
  const StudyDesign design = make_design(plan);
  const AdaptiveRule rule = adaptive_rule(plan, design);
  ASSERT_EQ(rule.items.size(), 5U);
  ASSERT_EQ(rule.choices.size(), 10U);
  for (const AdaptiveChoice& choice : rule.choices)
    for (const std::string& id : choice.stimuli) {
      const auto stimulus = std::find_if(design.stimuli.begin(), design.stimuli.end(),
                                         [&](const Stimulus& each) { return each.id == id; });
      const bool upper = rule.yes.at(id) == "upper";
      EXPECT_EQ(upper ? stimulus->item_upper : stimulus->item_lower, rule.items[choice.a]);
      EXPECT_EQ(upper ? stimulus->item_lower : stimulus->item_upper, rule.items[choice.b]);
    }
}

TEST(Adaptive, LevelsAreChosenAboutTheThreshold) {
  const StudyPlan plan = quest_plan("forced-choice", "[0, 4, 8, 12, 16, 20, 24, 28, 32]", "");
  for (const double threshold : {8.0, 24.0}) {
    const auto right = [&](const AdaptiveChoice& c) { return 0.5 + 0.5 * logistic((c.level - threshold) / 1.5); };
    double mean = 0;
    constexpr int kSittings = 4;
    for (uint64_t seed = 0; seed < kSittings; ++seed) {
      const Sitting sitting = sit(plan, seed, right);
      for (size_t k = 10; k < 30; ++k)
        for (const AdaptiveChoice& choice : sitting.rule.choices)
          if (std::count(choice.stimuli.begin(), choice.stimuli.end(), sitting.turns[k].chosen) > 0)
            mean += choice.level / (20.0 * kSittings);
    }
    EXPECT_NEAR(mean, threshold, 5);
  }
}

TEST(Adaptive, WhatTheGridDoesNotAllowTellsNothing) {
  const StudyPlan plan =
      quest_plan("forced-choice", "[0, 5, 20]", "[analysis]\ncurve = \"weibull\"\nguess = 0\nlapse = 0\n");
  const AdaptiveRule rule = adaptive_rule(plan, make_design(plan));
  const std::string& nothing = rule.choices[0].stimuli[0];
  const std::vector<GivenAnswer> before = {{nothing, rule.yes.at(nothing)}};
  EXPECT_EQ(choice_worths(rule, before), choice_worths(rule, {}));
}

TEST(ActivePairs, BeliefIsTheModeAndItsCurvature) {
  const PairBelief none = pair_belief({}, 3);
  EXPECT_EQ(none.mean, (std::vector<double>{0, 0, 0}));
  EXPECT_NEAR(none.covariance[1][1], kWorthSd * kWorthSd, 1e-12);
  // One answer: the mode is at t and -t with t / sd^2 = 1 - logistic(2 t).
  const PairBelief one = pair_belief(std::vector<PairAnswer>{{0, 1, 1}}, 3);
  const double t = one.mean[0];
  EXPECT_GT(t, 0);
  EXPECT_NEAR(one.mean[1], -t, 1e-10);
  EXPECT_EQ(one.mean[2], 0);
  EXPECT_NEAR(t / (kWorthSd * kWorthSd), 1 - logistic(2 * t), 1e-10);
  // Along the difference the curvature is 1 / sd^2 + 2 p (1 - p), by hand.
  const double p = logistic(2 * t);
  const double across = one.covariance[0][0] + one.covariance[1][1] - 2 * one.covariance[0][1];
  EXPECT_NEAR(across, 2 / (1 / (kWorthSd * kWorthSd) + 2 * p * (1 - p)), 1e-10);
}

TEST(ActivePairs, AKnownPairTellsLeast) {
  std::vector<PairAnswer> answers;
  for (int k = 0; k < 12; ++k) answers.push_back({0, 1, 1});
  const PairBelief belief = pair_belief(answers, 4);
  const double known = expected_information(belief, 0, 1);
  const double open = expected_information(belief, 2, 3);
  EXPECT_GT(known, 0);
  EXPECT_LT(known, 0.5 * open);
  EXPECT_LT(open, std::log(2));
  EXPECT_NEAR(open, expected_information(belief, 3, 2), 1e-12);
  const PairBelief certain{{1, 0}, {{0, 0}, {0, 0}}};
  EXPECT_NEAR(expected_information(certain, 0, 1), 0, 1e-12);
}

TEST(Adaptive, PairsNearEachOtherAreShownMore) {
  const StudyPlan plan = pairs_plan("forced-choice");
  // The last item is far worse than all others, which are alike.
  const auto right = [](const AdaptiveChoice& c) { return c.b == 4 ? 0.99 : 0.5; };
  int last = 0;
  int all = 0;
  for (uint64_t seed = 0; seed < 4; ++seed) {
    const Sitting sitting = sit(plan, seed, right);
    for (size_t k = 10; k < sitting.turns.size(); ++k)
      for (const AdaptiveChoice& choice : sitting.rule.choices)
        if (std::count(choice.stimuli.begin(), choice.stimuli.end(), sitting.turns[k].chosen) > 0) {
          ++all;
          last += choice.b == 4 ? 1 : 0;
        }
  }
  EXPECT_EQ(all, 80);
  EXPECT_LT(last, 27) << "a fixed order shows it in four of ten, 32; the rule in 22";
}

TEST(Adaptive, PageChoosesTheSame) {
  if (support::run_shell("command -v node >/dev/null").status != 0) GTEST_SKIP() << "node is not installed (nodejs)";
  const std::string more = "[0, 2, 4, 8, 16]";
  const auto rising = [](const AdaptiveChoice& c) { return 0.5 + 0.47 * logistic((c.level - 5) / 1.2); };
  const auto falling = [](const AdaptiveChoice& c) { return 0.5 + 0.47 * logistic((6 - c.level) / 2); };
  const auto worse = [](const AdaptiveChoice& c) {
    return logistic(0.8 * (static_cast<double>(c.b) - static_cast<double>(c.a)));
  };
  const std::vector<std::pair<std::string, Sitting>> sittings = {
      {"logistic", sit(quest_plan("forced-choice", more, ""), 1, rising)},
      {"weibull", sit(quest_plan("forced-choice", more, "[analysis]\ncurve = \"weibull\"\n"), 2, rising)},
      {"cumgauss",
       sit(quest_plan("forced-choice", more, "[analysis]\ncurve = \"cumgauss\"\nfalling = true\n"), 3, falling)},
      {"fixed lapse", sit(quest_plan("forced-choice", more, "[analysis]\nlapse = 0\nguess = 0\n"), 4, rising)},
      {"same-different", sit(quest_plan("same-different", more, ""), 5, rising)},
      {"pairs", sit(pairs_plan("forced-choice"), 6, worse)},
      {"preference", sit(pairs_plan("preference"), 7, worse)}};
  nlohmann::json cases = nlohmann::json::array();
  size_t turns = 0;
  for (const auto& [name, sitting] : sittings) {
    nlohmann::json trials = nlohmann::json::array();
    std::set<std::string> different;
    for (const Sitting::Turn& turn : sitting.turns) {
      nlohmann::json before = nlohmann::json::array();
      for (const GivenAnswer& given : turn.before)
        before.push_back({{"stimulus", given.stimulus}, {"answer", given.answer}});
      trials.push_back({{"trial", turn.trial},
                        {"before", before},
                        {"chosen", turn.chosen},
                        {"worths", choice_worths(sitting.rule, turn.before)}});
      different.insert(turn.chosen);
    }
    EXPECT_GE(different.size(), 5U) << name;
    turns += trials.size();
    cases.push_back({{"name", name},
                     {"rule", nlohmann::json::parse(adaptive_json(sitting.rule).dump())},
                     {"study", kStudy},
                     {"list", "1"},
                     {"trials", trials}});
  }
  const support::ScratchFolder folder;
  write_file(folder / "cases.json", std::string_view(cases.dump()));
  const fs::path sources = CROWDBENCH_SOURCE_DIR;
  const support::Outcome outcome =
      support::run_shell("node " + shell_quoted((sources / "tests/studies/adaptive_check.mjs").string()) + " " +
                         shell_quoted((sources / "studies/page").string()) + " " +
                         shell_quoted((folder / "cases.json").string()) + " 2>&1");
  EXPECT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_EQ(outcome.text, std::to_string(turns) + "\n");
}

TEST(Adaptive, FrozenPlansSayThatTheOrderAdapts) {
  const auto method = [](const StudyPlan& plan) { return nlohmann::json::parse(plan.meaning().dump()).at("method"); };
  const nlohmann::json quest = method(quest_plan("forced-choice", "[0, 5, 20]", ""));
  EXPECT_EQ(quest.at("order").get<std::string>().substr(0, 8), "adaptive");
  EXPECT_EQ(quest.at("threshold").size(), 31U);
  const nlohmann::json pairs = method(pairs_plan("preference"));
  EXPECT_EQ(pairs.at("worth_sd"), kWorthSd);
  const StudyPlan constant =
      parse_study_plan("[conditions]\ntest = \"hybrid(mesh,flat)\"\n[factors]\nswitch_m = [0, 5]\n", "study.toml", {});
  EXPECT_FALSE(method(constant).contains("order"));
}

// What an export writes, with no clip drawn, is what page and server read.
TEST(Adaptive, ExportedListsLeaveTheChoiceToThePage) {
  const StudyPlan plan = quest_plan("forced-choice", "[0, 5, 20]", "");
  const StudyDesign design = make_design(plan);
  FrozenPlan frozen;
  frozen.hash = plan.hash();
  Json stimuli = Json::array();
  for (const Stimulus& stimulus : design.stimuli) {
    Json entry = stimulus_json(plan, design, stimulus);
    entry["files"] = Json::array();
    entry["check_frame"] = Json::object();
    stimuli.push_back(entry);
  }
  const Json halves = Json::array();
  const ExportSettings settings;
  const nlohmann::json trials =
      nlohmann::json::parse(trials_json({plan, frozen, design, halves, stimuli, settings, "", ""}).dump());
  EXPECT_EQ(trials.at("adaptive").at("choices").size(), 3U);
  size_t chosen = 0;
  for (const nlohmann::json& trial : trials.at("lists")[0].at("trials")) {
    EXPECT_EQ(trial.at("stimulus").is_null(), trial.at("kind") == "main");
    chosen += trial.at("stimulus").is_null() ? 1 : 0;
  }
  EXPECT_EQ(chosen, 30U);
  const support::ScratchFolder out;
  fs::create_directories(out / "page");
  write_file(out / "page" / "trials.json", std::string_view(trials.dump()));
  write_file(out / "page" / "index.html", std::string_view("page"));
  const StudyFolder folder = read_study_folder(out.path());
  EXPECT_EQ(folder.choices.size(), 3U * 2 * plan.stimulus.crowds);
  EXPECT_EQ(std::count_if(folder.trials.at("1").begin(), folder.trials.at("1").end(),
                          [](const auto& each) { return each.second.stimulus.empty(); }),
            30);
}

}  // namespace
}  // namespace crowdbench::studies
