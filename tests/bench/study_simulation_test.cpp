// Simulated observers who answer an exported study: what each task and kind of trial gets, and that the analysis finds
// the parameters again that they were made with.
#include "bench/experiments/study_simulation.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/files.h"
#include "store/store.h"
#include "studies/analysis/analysis.h"
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
  // Seen in three of four cases where it stands above, in one of four below.
  expect_share(given["s1"]["upper"], 2000, 0.75 + 0.25 * 0.6 * 0.5);
  expect_share(given["s1"]["cannot-tell"], 2000, 0.25 * 0.4);
  expect_share(given["s2"]["lower"], 2000, 0.25 + 0.75 * 0.6 * 0.5);
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

// From the folder to the numbers that the observers were made with: 12 studies of 24 simulated observers. The 95 %
// intervals hold the truth in all but 3 at most: more than that happens in one of 450 such dozens.
TEST_F(SimulatedStudyTest, TheAnalysisFindsTheThreshold) {
  json stimuli;
  for (const double level : {4, 8, 12, 16, 20, 24})
    for (const bool on_top : {true, false})
      stimuli[fmt::format("s{}{}", level, on_top ? 'a' : 'b')] = test_of(level, on_top);
  stimuli["b"] = of_kind(test_of(4, true), "broken", "upper");
  write("forced-choice", stimuli, 3);
  studies::AnalysisSettings settings;
  settings.curve.falling = true;
  int held = 0;
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    SimulatedStudy simulated;
    simulated.seed = seed;
    simulated.who = {.threshold = 14, .slope = -0.5, .threshold_sd = 1.5};
    const studies::Analysis found = analysed(simulate_study(out, simulated), settings);
    ASSERT_EQ(found.tasks.size(), 1U);
    ASSERT_EQ(found.tasks[0].curves.size(), 1U) << "the level is the axis and no condition";
    ASSERT_EQ(found.tasks[0].mixed.size(), 1U);
    const auto& threshold = found.tasks[0].mixed[0].threshold;
    ASSERT_TRUE(threshold);
    EXPECT_NEAR(threshold->at, 14, 2.5) << "seed " << seed;
    ASSERT_TRUE(threshold->interval);
    held += threshold->interval->low <= 14 && threshold->interval->high >= 14 ? 1 : 0;
  }
  EXPECT_GE(held, 9);
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
  EXPECT_NE(kept.answers[0].data.find("\"observers\":\"simulated\""), std::string::npos);
  EXPECT_THROW(write_simulated(answers, file), Error) << "nothing is added to answers that are there";
}

}  // namespace
}  // namespace crowdbench::bench
