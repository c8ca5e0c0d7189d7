// Tables in, results out: through the one door that all answers take, as `study analyze` does.
#include "studies/analysis/analysis.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "core/random.h"
#include "studies/analysis/analysis_output.h"
#include "tests/studies/answer_tables.h"
#include "tests/studies/ground_truth.h"

namespace crowdbench::studies {
namespace {

using test::answers_of;

using Expected = nlohmann::json;

Expected json_of(const Analysis& analysis) { return Expected::parse(analysis_json(analysis).dump()); }

// 40 % cannot tell, 29 % chose the mesh, 31 % the impostors: the form in which such a study is printed. The counts are
// of 100 made-up answers.
TEST(AnalysisOfTables, PrintsSharesAsStudiesDo) {
  const Answers answers = answers_of("condition,item_a,item_b,yes,ties,no\nd = 10 m,mesh,impostors,29,40,31\n");
  const Analysis analysis = analyse(answers, {.margin = 0.2, .resamples = 0});
  const std::string page = analysis_markdown(analysis);
  EXPECT_NE(page.find("| d = 10 m: mesh over impostors | - | 29 (29 %) | 40 (40 %) | 31 (31 %) | 29 / 60 (48 %) |"),
            std::string::npos)
      << page;
  EXPECT_NE(page.find("| d = 10 m: mesh over impostors | equivalent |"), std::string::npos) << page;
  const Expected c = json_of(analysis).at("tasks")[0].at("conditions")[0];
  EXPECT_EQ(c.at("chosen"), 29);
  EXPECT_EQ(c.at("decided"), 60);
  const ConditionResult split = analyse(answers, {.ties = TieRule::split, .resamples = 0}).tasks[0].conditions[0];
  EXPECT_EQ(split.chosen, 49U);
  EXPECT_EQ(split.decided, 100U);
  const ConditionResult no = analyse(answers, {.ties = TieRule::no, .resamples = 0}).tasks[0].conditions[0];
  EXPECT_EQ(no.chosen, 29U);
  EXPECT_EQ(no.decided, 100U);
}

// Where a row is one answer, a tie that is split weighs as half a yes and half a no, in the mixed model and in its
// export.
TEST(AnalysisOfTables, SplitTiesWeighInMixedModels) {
  const auto table_of = [](bool with_ties) {
    std::string out = "participant,condition,answer,expected\n";
    const auto add = [&](int who, const char* answer, int times) {
      for (int t = 0; t < times; ++t) out += fmt::format("{},c,{},upper\n", who, answer);
    };
    for (int who = 0; who < 8; ++who) {
      add(who, "upper", 4 + who % 4);
      add(who, "lower", 3);
      if (with_ties) add(who, "cannot tell", 2);
      if (!with_ties) add(who, "upper", 1);
      if (!with_ties) add(who, "lower", 1);
    }
    return out;
  };
  const AnalysisSettings split = {.ties = TieRule::split, .resamples = 0};
  const Analysis tied = analyse(answers_of(table_of(true)), split);
  const MixedFit& halved = tied.tasks.at(0).mixed.at(0).fit;
  // Two of a participant's ties are a yes and a no of theirs.
  const MixedFit whole = analyse(answers_of(table_of(false)), split).tasks.at(0).mixed.at(0).fit;
  ASSERT_EQ(halved.fixed.size(), 1U);
  EXPECT_EQ(halved.answers, whole.answers);
  EXPECT_NEAR(halved.fixed[0].estimate, whole.fixed.at(0).estimate, 1e-6);
  EXPECT_NEAR(halved.participant_variance, whole.participant_variance, 1e-5);
  const MixedFit dropped = analyse(answers_of(table_of(true)), {.resamples = 0}).tasks.at(0).mixed.at(0).fit;
  EXPECT_EQ(dropped.answers + 16, halved.answers);
  EXPECT_GT(dropped.fixed.at(0).estimate, halved.fixed[0].estimate + 0.05);
  EXPECT_EQ(counted(1, 1, 0, TieRule::split).halves, 1U);
  EXPECT_EQ(counted(1, 1, 0, TieRule::no).of, 2U);
}

TEST(AnalysisOfTables, PairsMeetWhicheverWayAroundTheyAreWritten) {
  const Analysis analysis = analyse(
      answers_of("participant,item_a,item_b,shown_first,answer\n1,a,b,a,a\n1,b,a,b,b\n2,b,a,a,a\n2,a,b,b,cannot tell\n"
                 "1,b,c,b,c\n2,c,b,c,b\n1,a,c,a,a\n2,a,c,c,c\n"),
      {.resamples = 20});
  const TaskResult& task = analysis.tasks.at(0);
  ASSERT_EQ(task.conditions.size(), 3U);
  EXPECT_EQ(task.conditions[0].name, "a over b");
  EXPECT_EQ(task.conditions[0].yes, 2U);
  EXPECT_EQ(task.conditions[0].no, 1U);
  EXPECT_EQ(task.conditions[0].ties, 1U);
  ASSERT_TRUE(task.ranking);
  EXPECT_EQ(task.ranking->worths.state, WorthState::fitted);
  EXPECT_TRUE(task.ranking->position);
  EXPECT_TRUE(task.ranking->intervals);
  // Holm over three: none smaller than it was.
  for (const ConditionResult& c : task.conditions) EXPECT_GE(c.holm, c.test.two_sided);
}

// lme4's numbers through the table's door.
TEST(AnalysisOfTables, MixedModelComesThroughTheDoor) {
  const Expected& expected = test::statistics_expected();
  const Expected& set = expected.at("glmm").at("A_24x40");
  std::string text = "who,x,seen\n";
  for (size_t i = 0; i < set.at("data").at("y").size(); ++i)
    text += set.at("data").at("observer")[i].dump() + "," + set.at("data").at("x")[i].dump() + "," +
            set.at("data").at("y")[i].dump() + "\n";
  AnalysisSettings settings{.resamples = 0};
  settings.curve.guess = 0;
  const Expected got = json_of(analyse(answers_of(text, "participant=who,level=x,answer=seen"), settings));
  const Expected& mixed = got.at("tasks")[0].at("mixed_models")[0];
  const Expected& agq = set.at("fits")[0].at("glmer_agq25");
  EXPECT_EQ(mixed.at("state"), "fitted");
  EXPECT_EQ(mixed.at("integration"), "adaptive Gauss-Hermite, 25 nodes");
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(mixed.at("fixed")[i].at("estimate").get<double>(), agq.at("fixed")[i].get<double>(), 2e-3);
    EXPECT_NEAR(mixed.at("fixed")[i].at("se").get<double>() / agq.at("se")[i].get<double>(), 1, 1e-2);
  }
  EXPECT_NEAR(mixed.at("level_likelihood_ratio").at("chi_squared").get<double>(),
              agq.at("lrt_x").at("chi2").get<double>(), 5e-3);
}

TEST(AnalysisOfTables, ConditionsAreContrastsToTheFirst) {
  std::string text = "participant,condition,yes,no\n";
  for (int p = 0; p < 8; ++p)
    text += fmt::format("{},near,{},{}\n{},far,{},{}\n", p, 8 + p % 2, 2 - p % 2, p, 4 + p % 3, 6 - p % 3);
  const Analysis analysis = analyse(answers_of(text), {.margin = 0.1, .resamples = 0});
  const TaskResult& task = analysis.tasks[0];
  ASSERT_EQ(task.mixed.size(), 1U);
  EXPECT_EQ(task.mixed[0].effects, (std::vector<std::string>{"intercept", "far"}));
  EXPECT_LT(task.mixed[0].fit.fixed[1].estimate, -1);
  EXPECT_EQ(task.conditions[0].equivalence->verdict, Verdict::different);
  EXPECT_EQ(task.conditions[1].equivalence->verdict, Verdict::not_enough_data);
  EXPECT_GT(task.conditions[1].equivalence->more_trials, 100U);
}

TEST(AnalysisOfTables, NamesWhatHasNoAnswer) {
  const auto mixed_state = [](const std::string& text) {
    AnalysisSettings settings{.resamples = 0};
    settings.curve.guess = 0;
    return std::string(state_text(analyse(answers_of(text), settings).tasks[0].mixed.at(0).fit.state));
  };
  EXPECT_EQ(mixed_state("participant,level,answer\n1,1,yes\n1,2,no\n"), "one participant");
  EXPECT_EQ(mixed_state("participant,level,answer\n1,1,yes\n2,2,yes\n"), "all answers alike");
  EXPECT_EQ(mixed_state("participant,level,answer\n1,1,no\n2,1,no\n1,2,yes\n2,2,yes\n"), "separated");
  EXPECT_EQ(mixed_state("participant,level,answer\n1,1,cannot tell\n2,1,tie\n"), "no data");
  const Analysis ties = analyse(answers_of("answer\ncannot tell\n"), {});
  EXPECT_EQ(json_of(ties).at("tasks")[0].at("conditions")[0].at("state"), "no data");
  EXPECT_NE(analysis_markdown(ties).find("no data"), std::string::npos);
  EXPECT_THROW(analyse({}, {}), Error);
  EXPECT_THROW(analyse(answers_of("participant,catch,answer\n1,broken,no\n"), {.catch_least = 0.5}), Error);
  AnalysisSettings weibull;
  weibull.curve.curve = Curve::weibull;
  EXPECT_THROW(analyse(answers_of("level,answer\n-1,yes\n1,no\n"), weibull), Error);
}

TEST(AnalysisOfTables, NamesFromFilesAreHarmless) {
  const Analysis analysis = analyse(answers_of("condition,answer\n\"<script>|x\ny\",yes\n"), {});
  const std::string page = analysis_markdown(analysis);
  EXPECT_NE(page.find("| \\<script>\\|x?y |"), std::string::npos) << page;
}

// A table cut, doubled and spoilt anywhere is taken or refused in one line, and nothing else happens.
TEST(AnalysisOfTables, SpoiltTablesAreRefusedInOneLine) {
  const std::string sound =
      "participant,trial,condition,level,answer,rt,catch\nA,1,\"x, "
      "y\",1.5,yes,300,\nB,1,z,2,no,,broken\nA,2,z,-1e3,tie,1,no\n";
  size_t taken = 0;
  for (uint64_t i = 0; i < 4000; ++i) {
    std::string text = sound;
    for (uint64_t k = 0; k <= i % 3; ++k) {
      const size_t at = random_below(i, k, 1, text.size());
      switch (random_below(i, k, 2, 4)) {
        case 0: text[at] = static_cast<char>(random_below(i, k, 3, 256)); break;
        case 1: text.erase(at, random_below(i, k, 3, 20)); break;
        case 2: text.insert(at, text.substr(random_below(i, k, 3, text.size()))); break;
        default: text.insert(at, 1, "\",\n\r\t0-"[random_below(i, k, 3, 7)]);
      }
      if (text.empty()) text = "a";
    }
    try {
      answers_of(text);
      ++taken;
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
  EXPECT_GT(taken, 100U);
  EXPECT_LT(taken, 3500U);
}

TEST(Analysis, ARankingHoldsTheItemsOfItsOwnTask) {
  const Expected got =
      json_of(analyse(answers_of("task,item_a,item_b,yes,ties,no\nt1,x,y,6,0,4\nt2,u,v,3,0,7\n"), {.resamples = 0}));
  ASSERT_EQ(got.at("tasks").size(), 2U);
  for (const Expected& task : got.at("tasks")) {
    EXPECT_EQ(task.at("ranking").at("state"), "fitted") << task.dump(1);
    EXPECT_EQ(task.at("ranking").at("items").size(), 2U);
  }
}

TEST(Analysis, OneParticipantIsNotEnoughForEquivalence) {
  std::string text = "participant,condition,yes,ties,no\n";
  text += "1,near,200,0,200\n";
  const Analysis analysis = analyse(answers_of(text), {.margin = 0.1, .resamples = 0});
  const auto& equivalence = analysis.tasks.at(0).conditions.at(0).equivalence;
  ASSERT_TRUE(equivalence);
  EXPECT_LE(equivalence->exact.p, 0.05) << "its trials alone would say so";
  EXPECT_EQ(equivalence->verdict, Verdict::not_enough_data);
  EXPECT_GE(equivalence->more_participants, 1U);
}

}  // namespace
}  // namespace crowdbench::studies
