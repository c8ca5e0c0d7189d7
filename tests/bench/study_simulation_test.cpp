// Simulated observers who answer an exported study: what each task and kind of trial gets, and that the analysis finds
// the parameters again that they were made with.
#include "bench/experiments/study_simulation.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/files.h"
#include "core/probability.h"
#include "store/store.h"
#include "studies/analysis/analysis.h"
#include "studies/analysis/analysis_output.h"
#include "studies/analysis/exports.h"
#include "studies/plan/adaptive.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/study_page.h"

namespace crowdbench::bench {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;
using studies::StudyAnswers;

// The folder of a study without clips: two lists over the same stimuli, the second backwards, each stimulus `repeats`
// times, and one of them before the first block.
class SimulatedStudyTest : public testing::Test {
 protected:
  void write(const std::string& task, const json& stimuli, int repeats = 1) {
    json trials = {{"format", 1}, {"study", support::kStudyHash}, {"task", task}, {"frames", 150}};
    trials["answers"] = json::array();
    const std::map<std::string, std::vector<const char*>> words = {{"forced-choice", {"upper", "lower"}},
                                                                   {"preference", {"upper", "lower", "cannot-tell"}},
                                                                   {"same-different", {"same", "different"}}};
    for (const char* word : words.at(task)) trials["answers"].push_back({{"value", word}});
    std::vector<std::string> order;
    for (int r = 0; r < repeats; ++r)
      for (const auto& [id, each] : stimuli.items()) order.push_back(id);
    trials["stimuli"] = json::object();
    for (const std::string& id : order) trials["stimuli"][id] = json::object();
    trials["lists"] = json::array();
    for (const char* name : {"1", "2"}) {
      json list = json::array({{{"trial", "t0"}, {"stimulus", order[0]}, {"block", 0}, {"kind", "training"}}});
      for (const std::string& id : order) {
        const std::string kind = stimuli[id].at("kind");
        list.push_back({{"trial", fmt::format("t{}", list.size())},
                        {"stimulus", id},
                        {"block", 1},
                        {"kind", kind == "broken" || kind == "identical" ? "catch" : "main"}});
      }
      trials["lists"].push_back({{"id", name}, {"trials", list}});
      std::reverse(order.begin(), order.end());
    }
    write_file(out / "page" / "index.html", std::string_view("<p>"));
    write_file(out / "page" / "trials.json", std::string_view(trials.dump()));
    write_file(out / "sides.json", std::string_view(json{{"stimuli", stimuli}}.dump()));
  }
  static json test_of(double level, bool on_top, int crowd = 0) {
    return {{"kind", "test"},
            {"condition_name", fmt::format("d={:g}", level)},
            {"series", ""},
            {"level", std::isfinite(level) ? json(level) : json()},
            {"crowd", crowd},
            {"upper", on_top ? "flat" : "mesh"},
            {"lower", on_top ? "mesh" : "flat"},
            {"expected", on_top ? "upper" : "lower"}};
  }
  static json of_kind(json stimulus, const char* kind, const char* expected) {
    stimulus["kind"] = kind;
    stimulus["expected"] = expected;
    return stimulus;
  }
  // How often each stimulus got each answer.
  static std::map<std::string, std::map<std::string, int>> counts(const StudyAnswers& answers) {
    std::map<std::string, std::map<std::string, int>> out;
    for (const StudyAnswerRow& row : answers.answers)
      if (row.kind != "training") ++out[*row.stimulus][*row.answer];
    return out;
  }
  // 4.4 standard deviations of a count: one in 100,000.
  static void expect_share(int count, int of, double share) {
    EXPECT_NEAR(count, of * share, 4.4 * std::sqrt(of * share * (1 - share)) + 0.5) << "of " << of;
  }
  studies::Analysis analysed(const StudyAnswers& answers, studies::AnalysisSettings settings) const {
    studies::Answers rows;
    const studies::Table table = studies::parse_table(studies::answers_csv(answers, out), "answers");
    studies::add_answers(rows, table, studies::columns_by_name(table));
    settings.resamples = 0;
    return studies::analyse(std::move(rows), settings);
  }

  support::ScratchFolder folder;
  fs::path out = folder / "out";
  void SetUp() override { fs::create_directories(out / "page"); }
};

TEST_F(SimulatedStudyTest, AnswersEachKindOfTrialByItsRule) {
  const double far = std::numeric_limits<double>::infinity();
  write("forced-choice",
        {{"s1", test_of(10, true)},
         {"s2", test_of(20, false)},
         {"s3", test_of(far, true)},
         {"s4", of_kind(test_of(10, false), "broken", "lower")},
         {"s5", of_kind(test_of(10, false), "identical", "")}},
        50);
  SimulatedStudy simulated;
  simulated.observers = 40;
  simulated.who = {.threshold = 10, .slope = -0.2, .lapse = 0.1};
  const StudyAnswers answers = simulate_study(out, simulated);
  ASSERT_EQ(answers.participants.size(), 40U);
  EXPECT_EQ(answers.participants[3].list, "2");
  EXPECT_EQ(answers.answers.size(), 40U * (1 + 5 * 50));
  auto given = counts(answers);
  // Seen by half, of whom one in ten slips; the others guess: 0.5 * 0.9 + 0.5 * 0.5.
  expect_share(given["s1"]["upper"], 2000, 0.7);
  const double seen = 1 / (1 + std::exp(2));
  expect_share(given["s2"]["lower"], 2000, 0.9 * seen + 0.5 * (1 - seen));
  expect_share(given["s3"]["upper"], 2000, 0.5);  // infinitely far away: seen by nobody
  expect_share(given["s4"]["lower"], 2000, 0.9);
  expect_share(given["s5"]["upper"], 2000, 0.5);
  // The same seed, the same answers, and the first observers are the same however many there are; another seed, others.
  simulated.observers = 3;
  const StudyAnswers fewer = simulate_study(out, simulated);
  EXPECT_TRUE(std::equal(fewer.answers.begin(), fewer.answers.end(), answers.answers.begin()));
  simulated.seed = 2;
  EXPECT_NE(simulate_study(out, simulated).answers, fewer.answers);
}

TEST_F(SimulatedStudyTest, SaysWhatItCannotTell) {
  write("preference", {{"s1", test_of(10, true)}, {"s2", test_of(10, false)}}, 50);
  SimulatedStudy simulated;
  simulated.observers = 40;
  simulated.who = {.threshold = 10, .slope = 1, .side_bias = std::log(3)};
  simulated.cannot_tell = 0.4;
  auto given = counts(simulate_study(out, simulated));
  // Seen in three of four cases where it stands above, in one of four below; guessed to stand above likewise.
  expect_share(given["s1"]["upper"], 2000, 0.75 + 0.25 * 0.6 * 0.75);
  expect_share(given["s1"]["cannot-tell"], 2000, 0.25 * 0.4);
  expect_share(given["s2"]["lower"], 2000, 0.25 + 0.75 * 0.6 * 0.25);
}

TEST_F(SimulatedStudyTest, SameOrDifferentHasFalseAlarms) {
  write("same-different",
        {{"s1", of_kind(test_of(10, true), "test", "different")}, {"s2", of_kind(test_of(10, true), "alike", "same")}},
        50);
  SimulatedStudy simulated;
  simulated.observers = 40;
  simulated.who = {.threshold = 10, .slope = 1};
  simulated.guess = 0.2;
  auto given = counts(simulate_study(out, simulated));
  expect_share(given["s1"]["different"], 2000, 0.5 + 0.5 * 0.2);
  expect_share(given["s2"]["different"], 2000, 0.2);
}

TEST_F(SimulatedStudyTest, PairsGoByTheirWorths) {
  json pair = test_of(10, true);
  pair["kind"] = "pair";
  pair["expected"] = nullptr;
  pair["level"] = nullptr;
  write("preference", {{"s1", pair}}, 100);
  SimulatedStudy simulated;
  simulated.observers = 40;
  simulated.log_worth = {{"flat", std::log(2)}, {"mesh", std::log(6)}};
  simulated.log_nu = std::log(0.5);
  auto given = counts(simulate_study(out, simulated));
  const double tie = 0.5 * std::sqrt(12);
  expect_share(given["s1"]["upper"], 4000, 2 / (8 + tie));
  expect_share(given["s1"]["lower"], 4000, 6 / (8 + tie));
  simulated.log_worth = {{"flot", 1}};
  try {
    simulate_study(out, simulated);
    FAIL() << "there is no such item";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean 'flat'?"), std::string::npos) << error.what();
  }
}

// ---- from the folder to the numbers that the observers were made with
//
// A few seeds here; as many as one likes, and the rows of docs/study-evidence.md, by tools/study_evidence.sh.

size_t seeds(size_t normally) {
  const char* given = std::getenv("CROWDBENCH_SEEDS");
  return given != nullptr ? std::strtoul(given, nullptr, 10) : normally;
}

// That 95 % intervals held the truth so often: within what 99.9 of 100 honest runs give, and 93 to 97 % of 500 or more.
void expect_held(size_t held, size_t n, const char* what) {
  const double share = static_cast<double>(held) / static_cast<double>(n);
  const CountLimits limits = binomial_limits(n, 0.95);
  std::cout << fmt::format("| {} | {} of {} | {:.1f} % | 95 % | {} to {} |\n", what, held, n, 100 * share, limits.low,
                           limits.high);
  const double noise = 3.3 * std::sqrt(0.95 * 0.05 / static_cast<double>(n)) + 1.0 / static_cast<double>(n);
  EXPECT_GE(share, n >= 500 ? 0.93 : 0.95 - noise) << what;
  EXPECT_LE(share, n >= 500 ? 0.97 : 1) << what;
}

class RecoveredStudyTest : public SimulatedStudyTest {
 protected:
  static constexpr double kThreshold = 14;
  static constexpr double kSlope = -0.5;
  // Six levels, both ways up; more(id, level, on_top): beside each.
  static json levels(const std::function<void(json& all, double level, bool on_top)>& more = {}) {
    json out;
    for (const double level : kLevels)
      for (const bool on_top : {true, false}) {
        out[id_of(level, on_top)] = test_of(level, on_top);
        if (more) more(out, level, on_top);
      }
    out["b"] = of_kind(test_of(4, true), "broken", "upper");
    return out;
  }
  static std::string id_of(double level, bool on_top) { return fmt::format("s{}{}", level, on_top ? 'a' : 'b'); }
  static constexpr std::array<double, 6> kLevels = {4, 8, 12, 16, 20, 24};

  // Studies of 24 simulated observers each, by the mixed model of the analysis. truth: where it says that the threshold
  // is.
  void expect_threshold(size_t n, double truth, const studies::AnalysisSettings& settings, const char* what) {
    size_t held = 0;
    for (uint64_t seed = 1; seed <= n; ++seed) {
      SimulatedStudy simulated;
      simulated.seed = seed;
      simulated.who = {.threshold = kThreshold, .slope = kSlope, .threshold_sd = 1.5};
      const studies::Analysis found = analysed(simulate_study(out, simulated), settings);
      ASSERT_EQ(found.tasks.size(), 1U);
      ASSERT_EQ(found.tasks[0].curves.size(), 1U) << "the level is the axis and no condition";
      ASSERT_EQ(found.tasks[0].mixed.size(), 1U);
      const auto& threshold = found.tasks[0].mixed[0].threshold;
      ASSERT_TRUE(threshold && threshold->interval) << "seed " << seed;
      EXPECT_NEAR(threshold->at, truth, 3) << "seed " << seed;
      held += threshold->interval->low <= truth && threshold->interval->high >= truth ? 1 : 0;
    }
    expect_held(held, n, what);
  }
  static studies::AnalysisSettings falling() {
    studies::AnalysisSettings settings;
    settings.curve.falling = true;
    return settings;
  }
};

TEST_F(RecoveredStudyTest, ThresholdOfForcedChoice) {
  write("forced-choice", levels(), 3);
  expect_threshold(seeds(12), kThreshold, falling(), "threshold of forced choice, export to interval");
}

TEST_F(RecoveredStudyTest, ThresholdOfSameDifferent) {
  write("same-different", levels([](json& all, double level, bool on_top) {
          all[id_of(level, on_top)]["expected"] = "different";
          all[id_of(level, on_top) + "same"] = of_kind(test_of(level, on_top), "alike", "same");
        }),
        3);
  studies::AnalysisSettings settings = falling();
  settings.curve.guess_rate = studies::Rate::free;
  // One in ten says "different" of what is not seen: 0.75 where 0.65 / 0.9 is seen.
  const double seen = 0.65 / 0.9;
  expect_threshold(seeds(4), kThreshold + std::log(seen / (1 - seen)) / kSlope, settings,
                   "threshold of same-different, export to interval");
}

TEST_F(RecoveredStudyTest, ThresholdOfQuestPlus) {
  write("forced-choice", levels(), 3);
  json rule = support::two_level_rule();
  rule["falling"] = true;
  rule["threshold"] = json::array();
  for (int i = 0; i <= 20; ++i) rule["threshold"].push_back(4 + i);
  rule["slope"] = {0.4, 0.8, 1.6, 3.2, 6.4};
  rule["choices"] = rule["yes"] = json();
  for (const double level : kLevels) {
    rule["choices"].push_back({{"level", level}, {"stimuli", {id_of(level, true), id_of(level, false)}}});
    for (const bool on_top : {true, false}) rule["yes"][id_of(level, on_top)] = on_top ? "upper" : "lower";
  }
  support::let_the_page_choose(out, rule);
  expect_threshold(seeds(4), kThreshold, falling(), "threshold of quest-plus (a pilot), export to interval");
}

TEST_F(RecoveredStudyTest, RankingOfActivePairs) {
  const std::map<std::string, double> worths = {{"fine", 1.2}, {"good", 0.4}, {"poor", -1}, {"some", -0.3}};
  std::vector<std::string> items;
  for (const auto& [name, worth] : worths) items.push_back(name);
  json stimuli;
  json rule = {{"method", "active-pairs"},
               {"items", items.size()},
               {"choices", json::array()},
               {"alike", json::array()},
               {"yes", json::object()}};
  for (size_t a = 0; a < items.size(); ++a)
    for (size_t b = a + 1; b < items.size(); ++b) {
      json ids = json::array();
      for (const bool a_on_top : {true, false}) {
        const std::string id = fmt::format("p{}{}{}", a, b, a_on_top ? 'a' : 'b');
        stimuli[id] = of_kind(test_of(4, true), "pair", "");
        stimuli[id]["level"] = nullptr;
        stimuli[id]["expected"] = nullptr;
        stimuli[id]["upper"] = items[a_on_top ? a : b];
        stimuli[id]["lower"] = items[a_on_top ? b : a];
        rule["yes"][id] = a_on_top ? "upper" : "lower";
        ids.push_back(id);
      }
      rule["choices"].push_back({{"a", a}, {"b", b}, {"stimuli", ids}});
    }
  write("preference", stimuli, 1);
  support::let_the_page_choose(out, rule);
  const size_t n = seeds(4);
  size_t ordered = 0;
  for (uint64_t seed = 1; seed <= n; ++seed) {
    SimulatedStudy simulated;
    simulated.seed = seed;
    simulated.log_worth = worths;
    const studies::Analysis found = analysed(simulate_study(out, simulated), {});
    ASSERT_TRUE(found.tasks.at(0).ranking);
    const studies::RankingResult& r = *found.tasks[0].ranking;
    std::map<std::string, double> q;
    for (size_t i = 0; i < r.items.size(); ++i) q[r.items[i]] = r.jod_with_prior.q.at(i);
    ordered += q["fine"] > q["good"] && q["good"] > q["some"] && q["some"] > q["poor"] ? 1 : 0;
    EXPECT_EQ(found.tasks[0].conditions.at(0).condition, "") << "of pairs no condition is said";
  }
  std::cout << fmt::format(
      "| ranking of active pairs as it was made, export to ranking | {} of {} | {:.1f} % | - | - |\n", ordered, n,
      100 * static_cast<double>(ordered) / static_cast<double>(n));
  EXPECT_GE(ordered, n * 3 / 4);
}

TEST_F(SimulatedStudyTest, AdaptiveTrialsAreChosenByTheStudysRule) {
  support::write_study_folder(out, {{"s001", json::object()}, {"s002", json::object()}});
  write_file(out / "page" / "index.html", std::string_view("<p>"));
  support::let_the_page_choose(out);
  const std::string rule = support::two_level_rule().dump();
  const studies::AdaptiveRule read = studies::parse_adaptive(rule, "trials.json");
  EXPECT_EQ(json::parse(studies::adaptive_json(read).dump()), support::two_level_rule()) << "read and written";
  SimulatedStudy simulated;
  simulated.observers = 6;
  simulated.who = {.threshold = 15, .slope = 0.3};
  const StudyAnswers answers = simulate_study(out, simulated);
  for (const StudyParticipantRow& who : answers.participants) {
    std::vector<studies::GivenAnswer> before;
    for (const StudyAnswerRow& row : answers.answers) {
      if (row.participant != who.id || row.kind != "main") continue;
      EXPECT_EQ(*row.stimulus, studies::chosen_stimulus(read, support::kStudyHash, who.list, row.item, before));
      before.push_back({*row.stimulus, *row.answer});
    }
    EXPECT_EQ(before.size(), 3U);
  }
  for (const auto& [member, value] : std::map<std::string, json>{{"method", "constant"},
                                                                 {"threshold", json::array()},
                                                                 {"guess", {0.9}},
                                                                 {"slope", "steep"},
                                                                 {"yes", {{"s001", "upper"}}}}) {
    json broken = support::two_level_rule();
    broken[member] = value;
    EXPECT_THROW(studies::parse_adaptive(broken.dump(), "trials.json"), Error) << member;
  }
}

TEST_F(SimulatedStudyTest, IsAResultFileLikeAServers) {
  write("forced-choice", {{"s1", test_of(10, true)}});
  const StudyAnswers answers = simulate_study(out, {});
  const fs::path file = folder / "answers.sqlite";
  write_simulated(answers, file);
  const StudyAnswers kept = studies::read_study_answers({file}, support::kStudyHash);
  EXPECT_EQ(studies::answers_csv(kept, out), studies::answers_csv(answers, out));
  // Whatever is made of them says that nobody answered.
  const studies::Analysis found = analysed(kept, {});
  EXPECT_EQ(found.simulated_rows, found.rows);
  const std::string told = studies::analysis_markdown(found);
  EXPECT_TRUE(told.starts_with("# What simulated observers answered\n\nSIMULATED: ")) << told.substr(0, 200);
  for (const studies::ExportedFile& exported : studies::export_files(found))
    if (exported.name.ends_with("_data.csv")) {
      EXPECT_NE(exported.text.find("\nsimulated,"), std::string::npos);
    }
  EXPECT_THROW(write_simulated(answers, file), Error) << "nothing is added to answers that are there";
}

}  // namespace
}  // namespace crowdbench::bench
