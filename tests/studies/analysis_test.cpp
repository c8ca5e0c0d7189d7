// Tables in, results out: through the one door that all answers take, as `study analyze` does.
#include "studies/analysis/analysis.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "core/random.h"
#include "core/screen_calibration.h"
#include "studies/analysis/analysis_output.h"
#include "studies/analysis/analysis_text.h"
#include "studies/analysis/verdict_sentences.h"
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

// ---- what is said is what was found

std::string said_of(const Analysis& a) {
  std::string out;
  const AnalysisText text = analysis_text(a);
  for (const std::string& sentence : text.tasks.at(0).verdicts) out += sentence + "\n";
  return out;
}

TEST(Analysis, AStepTakesTheLikelihoodsInterval) {
  // Six people, nobody yes at 1 and 2, everybody at 3 and 4: whoever is drawn anew, the answers are the same.
  std::string text = "participant,level,answer\n";
  for (int p = 0; p < 6; ++p)
    for (int level = 1; level <= 4; ++level) text += fmt::format("{},{},{}\n", p, level, level > 2 ? "yes" : "no");
  AnalysisSettings settings{.resamples = 50};
  settings.curve.guess = 0;
  const Analysis a = analyse(answers_of(text), settings);
  const CurveResult& c = a.tasks.at(0).curves.at(0);
  ASSERT_EQ(c.fit.state, CurveState::step);
  ASSERT_TRUE(c.bootstrap);
  EXPECT_TRUE(c.bootstrap->alike);
  const auto interval = threshold_interval(c);
  ASSERT_TRUE(interval);
  EXPECT_EQ(interval->method, "profile likelihood");
  EXPECT_NEAR(interval->low.value(), 2, 0.05);
  EXPECT_NEAR(interval->high.value(), 3, 0.05);
  EXPECT_NE(said_of(a).find("profile likelihood; the answers are a step"), std::string::npos) << said_of(a);
  const Expected json = json_of(a).at("tasks")[0].at("curves")[0];
  EXPECT_TRUE(json.at("threshold_bootstrap").at("interval").is_null());
  EXPECT_EQ(json.at("threshold_interval").at("method"), "profile likelihood");
  ASSERT_TRUE(c.jackknife);
  EXPECT_EQ(c.jackknife->state, JackknifeState::alike);
  EXPECT_NE(analysis_markdown(a).find("profile likelihood: the participants' answers show no spread"),
            std::string::npos);
  CurveResult none = c;
  none.fit.threshold_profile = {};
  TaskResult task = a.tasks[0];
  task.curves = {none};
  EXPECT_EQ(threshold_interval(none).value().method, "");
  EXPECT_NE(verdict_sentences(task, settings).back().find("give it no interval"), std::string::npos);
}

// n participants whose shares of yes rise with the level, every second one's by one more.
std::string rising_table(int n) {
  std::string text = "participant,level,yes,no\n";
  for (int p = 0; p < n; ++p)
    for (int level = 1; level <= 5; ++level)
      text += fmt::format("{},{},{},{}\n", p, level, 2 * level - 1 + (p % 2), 11 - 2 * level - (p % 2));
  return text;
}

TEST(Analysis, AnIntervalOverParticipantsTakesThree) {
  AnalysisSettings settings{.resamples = 50};
  settings.curve.guess = 0;
  settings.curve.level = 0.5;
  const auto told = [&](int n) {
    return threshold_interval(analyse(answers_of(rising_table(n)), settings).tasks.at(0).curves.at(0)).value();
  };
  const ThresholdInterval one = told(1);
  EXPECT_EQ(one.method, "parametric bootstrap");
  EXPECT_EQ(one.why, "of this one participant, not of people");
  const Analysis two = analyse(answers_of(rising_table(2)), settings);
  EXPECT_FALSE(threshold_interval(two.tasks[0].curves[0]).value().low);
  EXPECT_NE(said_of(two).find("no interval: 2 participants do not say how much people differ; that takes 3"),
            std::string::npos)
      << said_of(two);
  const Expected json = json_of(two).at("tasks")[0].at("curves")[0];
  EXPECT_TRUE(json.at("threshold_interval").at("interval").is_null());
  EXPECT_TRUE(json.at("threshold_bootstrap").at("interval").is_null()) << "of two people it is two people's thresholds";
  EXPECT_EQ(json.at("threshold_bootstrap").at("few"), true);
  const ThresholdInterval three = told(3);
  EXPECT_EQ(three.method, "jackknife over participants");
  EXPECT_NE(three.why.find("Student's t with 2 degrees of freedom"), std::string::npos) << three.why;
  const ThresholdInterval many = told(24);
  EXPECT_LT(*many.high - *many.low, *three.high - *three.low);
}

TEST(Analysis, OneWhoDecidesGivesNoInterval) {
  // Two of three answer yes everywhere: without the third there is no threshold.
  std::string text = "participant,level,yes,no\n";
  for (int level = 1; level <= 5; ++level)
    text += fmt::format("a,{0},8,0\nb,{0},8,0\nc,{0},{1},{2}\n", level, level, 8 - level);
  AnalysisSettings settings{.resamples = 50};
  settings.curve.guess = 0;
  settings.curve.level = 0.8;
  const Analysis a = analyse(answers_of(text), settings);
  const CurveResult& c = a.tasks.at(0).curves.at(0);
  ASSERT_TRUE(c.fit.threshold) << state_text(c.fit.state);
  EXPECT_EQ(threshold_interval(c).value().method, "");
  EXPECT_NE(said_of(a).find("without one of the participants"), std::string::npos) << said_of(a);
}

TEST(Analysis, DrawsThatDifferKeepTheirInterval) {
  AnalysisSettings settings{.resamples = 50};
  settings.curve.guess = 0;
  const CurveResult c = analyse(answers_of(rising_table(6)), settings).tasks.at(0).curves.at(0);
  ASSERT_TRUE(c.bootstrap);
  EXPECT_FALSE(c.bootstrap->alike);
  EXPECT_TRUE(c.bootstrap->has_interval());
  EXPECT_NEAR(c.bootstrap->stretch, 2.570582 / 1.959964 * std::sqrt(6.0 / 5), 1e-6);
  EXPECT_EQ(threshold_interval(c).value().method, "jackknife over participants");
}

TEST(Analysis, WhatIsStillNeededIsOneNumber) {
  // One participant of eight trials, where the exact test needs 227: 219 more, by 28 people of eight trials each.
  const AnalysisSettings settings{.margin = 0.1, .random = RandomEffects::none, .resamples = 0};
  const Analysis one = analyse(answers_of("participant,yes,no\na,3,5\n"), settings);
  const Equivalence& e = one.tasks.at(0).conditions.at(0).equivalence.value();
  EXPECT_EQ(e.more_trials, e.trials_needed.value() - 8);
  EXPECT_EQ(e.more_participants, (e.more_trials + 7) / 8);
  EXPECT_NE(said_of(one).find(fmt::format("about {} more participants, with {} more trials or more in all,",
                                          e.more_participants, e.more_trials)),
            std::string::npos)
      << said_of(one);
  // Three who are almost alike: their spread asks for few people, their trials for many.
  const Analysis three = analyse(answers_of("participant,yes,no\na,4,4\nb,4,4\nc,4,4\n"), settings);
  const Equivalence& of_three = three.tasks.at(0).conditions.at(0).equivalence.value();
  ASSERT_EQ(of_three.verdict, Verdict::not_enough_data);
  EXPECT_EQ(of_three.more_participants, (of_three.trials_needed.value() - 24 + 7) / 8);
  // Nobody is known: trials alone.
  const Analysis nobody = analyse(answers_of("yes,no\n3,5\n"), settings);
  EXPECT_NE(said_of(nobody).find("about 219 more trials would be needed"), std::string::npos) << said_of(nobody);
}

// Same or different at levels, guesses of 0.2, everybody alike but for a shift.
std::string same_different_table() {
  std::string text = "participant,level,signal,yes,no\n";
  for (int p = 0; p < 12; ++p)
    for (int level = 0; level < 6; ++level) {
      const double f = 1 / (1 + std::exp(-(level - 2.5 - 0.3 * (p % 3 - 1)) * 1.6));
      const int yes = static_cast<int>(std::lround(40 * (0.2 + 0.8 * f)));
      text += fmt::format("{},{},1,{},{}\n{},{},0,8,32\n", p, level, yes, 40 - yes, p, level);
    }
  return text;
}

TEST(Analysis, AMixedModelHoldsTheGuessThatTheCurveFinds) {
  AnalysisSettings settings{.resamples = 0};
  settings.curve.guess_rate = Rate::free;
  const Analysis a = analyse(answers_of(same_different_table()), settings);
  const TaskResult& task = a.tasks.at(0);
  const MixedResult& mixed = task.mixed.at(0);
  EXPECT_NEAR(task.curves.at(0).fit.at.guess, 0.2, 0.03);
  EXPECT_EQ(mixed.settings.guess, task.curves[0].fit.at.guess);
  EXPECT_EQ(mixed.guess_from, GuessSource::curve);
  EXPECT_NEAR(mixed.fit.fixed.at(1).estimate, 1.6, 0.2) << "at a guess of 0 it is far shallower";
  EXPECT_NE(analysis_markdown(a).find("the curve's estimate, whose error is not counted here"), std::string::npos);
  const Expected json = json_of(a).at("tasks")[0].at("mixed_models")[0];
  EXPECT_EQ(json.at("guess_from"), "curve");
  EXPECT_EQ(json.at("guess").get<double>(), mixed.settings.guess);
  settings.curve.guess_rate = Rate::fixed;
  settings.curve.guess = 0.1;
  const Analysis held = analyse(answers_of(same_different_table()), settings);
  EXPECT_NE(analysis_markdown(held).find("Guess held at 0.1."), std::string::npos);
  EXPECT_EQ(json_of(held).at("tasks")[0].at("mixed_models")[0].at("guess_from"), "settings");
}

// ---- degrees of visual angle

TEST(VisualAngle, AddsTheCalibrationsVarianceByHand) {
  // 100 pixels (80 to 125) at 40 pixels a degree, known to a tenth: 2.5 degrees, half width
  // sqrt(ln(1.25)^2 + (1.959964 * 0.1)^2) = sqrt(0.0497930 + 0.0384146) = 0.2969975 of the logarithm.
  const std::vector<Calibration> one = {{40, 4}};
  const AngleThreshold a = threshold_in_degrees(100, 80, 125, one, 0.95).value();
  EXPECT_NEAR(a.degrees, 2.5, 1e-12);
  EXPECT_NEAR(a.calibration_share, 0.1, 1e-12);
  EXPECT_NEAR(a.low.value(), 2.5 * std::exp(-0.2969975), 1e-5);
  EXPECT_NEAR(a.high.value(), 2.5 * std::exp(0.2969975), 1e-5);
  // Sixteen eyes: a quarter of it. Exact screens: the pixels' interval and no more.
  const std::vector<Calibration> many(16, {40, 4});
  EXPECT_NEAR(threshold_in_degrees(100, 80, 125, many, 0.95).value().calibration_share, 0.025, 1e-12);
  const std::vector<Calibration> exact = {{40, 0}};
  EXPECT_NEAR(threshold_in_degrees(100, 80, 125, exact, 0.95).value().high.value(), 3.125, 1e-9);
  // 20 and 60 pixels a degree: the mean of 5 and 1.6667 degrees; errors of 0.1 and 0.2 of each, of their sum.
  const std::vector<Calibration> two = {{20, 2}, {60, 12}};
  const AngleThreshold b = threshold_in_degrees(100, std::nullopt, 125, two, 0.95).value();
  EXPECT_NEAR(b.degrees, (5 + 100.0 / 60) / 2, 1e-12);
  EXPECT_NEAR(b.calibration_share, std::hypot(0.1 / 20, 0.2 / 60) / (1.0 / 20 + 1.0 / 60), 1e-12);
  EXPECT_FALSE(b.low) << "an open end stays open";
  EXPECT_FALSE(threshold_in_degrees(100, -5, 125, two, 0.95).value().low);
  EXPECT_FALSE(threshold_in_degrees(-1, -5, 125, two, 0.95));
  EXPECT_FALSE(threshold_in_degrees(100, 80, 125, {}, 0.95));
}

// Heights in pixels, seen by people of whom each sits elsewhere; the last one's calibration is no screen's.
std::string heights_table(double css_px_per_clip_px) {
  std::string text = "participant,level,yes,no,pixels_per_degree,pixels_per_degree_se,css_px_per_clip_px\n";
  for (int p = 0; p < 5; ++p)
    for (int level = 1; level <= 5; ++level)
      text += fmt::format("{},{},{},{},{},4,{}\n", p, 20 * level, 2 * level - 1 + p % 2, 11 - 2 * level - p % 2,
                          p == 4 ? "1e+300" : "40", css_px_per_clip_px);
  return text;
}

TEST(VisualAngle, StandsBesideThresholdsInPixels) {
  AnalysisSettings settings{.axis = axis_of_factor("height_px"), .resamples = 50};
  settings.curve.guess = 0;
  const Analysis a = analyse(answers_of(heights_table(1)), settings);
  const CurveResult& c = a.tasks.at(0).curves.at(0);
  ASSERT_TRUE(c.angle);
  EXPECT_NEAR(c.angle->degrees, c.fit.threshold.value() / 40, 1e-9);
  EXPECT_EQ(c.angle->calibrated, 4U) << "1e+300 is no calibration";
  EXPECT_EQ(c.participants, 5U);
  EXPECT_NEAR(c.angle->calibration_share, 0.1 / 2, 1e-12);
  const ThresholdInterval pixels = threshold_interval(c).value();
  EXPECT_GT(c.angle->high.value() / c.angle->low.value(), *pixels.high / *pixels.low) << "no error was added";
  ASSERT_TRUE(a.tasks[0].mixed.at(0).angle);
  // At two clip pixels a CSS pixel the same height is half the angle.
  const Analysis dense = analyse(answers_of(heights_table(0.5)), settings);
  EXPECT_NEAR(dense.tasks.at(0).curves.at(0).angle.value().degrees, c.angle->degrees / 2, 1e-9);
  const Expected json = json_of(a).at("tasks")[0].at("curves")[0].at("threshold_degrees");
  EXPECT_EQ(json.at("at").get<double>(), c.angle->degrees);
  EXPECT_EQ(json.at("interval")[1].get<double>(), *c.angle->high);
  EXPECT_EQ(json.at("participants_calibrated"), 4);
  EXPECT_NE(said_of(a).find("degrees of visual angle (95 % interval"), std::string::npos) << said_of(a);
  EXPECT_NE(said_of(a).find("with the error of calibration, 5.0 %, of 4 participants)"), std::string::npos);
  // What is not in pixels has no angle.
  settings.axis = axis_of_factor("switch_m");
  EXPECT_FALSE(analyse(answers_of(heights_table(1)), settings).tasks.at(0).curves.at(0).angle);
}

TEST(VisualAngle, NeedsNumbersInItsColumns) {
  EXPECT_THROW(answers_of("answer,pixels_per_degree,pixels_per_degree_se\nyes,x,1\n"), Error);
  const auto calibrated = [](const char* fields) {
    const Answers a = answers_of(std::string("answer,pixels_per_degree,pixels_per_degree_se\nyes,") + fields + "\n");
    return a.rows.at(0).pixels_per_degree.has_value();
  };
  for (const char* fields : {"40,0", "40,40", "5,0", "500,1"}) EXPECT_TRUE(calibrated(fields)) << fields;
  for (const char* fields : {"40,", ",4", "0,0", "-40,4", "40,-4", "40,41", "1e300,0", "4.9,0", "501,1"})
    EXPECT_FALSE(calibrated(fields)) << fields;
  EXPECT_FALSE(is_screen_calibration(std::nan(""), 1));
  EXPECT_FALSE(is_screen_calibration(40, std::nan("")));
}

// ---- names

TEST(Analysis, ThresholdsNameTheFactorAndItsUnit) {
  AnalysisSettings settings{.axis = axis_of_factor("height_px"), .resamples = 0};
  settings.curve.guess = 0;
  const Analysis a = analyse(answers_of("level,yes,no\n20,1,9\n40,5,5\n60,9,1\n"), settings);
  EXPECT_NE(said_of(a).find("The threshold of height_px at 0.75 is "), std::string::npos) << said_of(a);
  EXPECT_NE(said_of(a).find(" pixels (95 % interval"), std::string::npos) << said_of(a);
  EXPECT_EQ(axis_title(settings.axis), "height_px (pixels)");
  EXPECT_EQ(axis_title(axis_of_factor("switch_m")), "switch_m (m)");
  EXPECT_EQ(axis_title(axis_of_factor("mesh.triangles")), "mesh.triangles");
  EXPECT_EQ(axis_title({}), "level");
  // Escaped where it is Markdown, and nowhere else.
  EXPECT_NE(analysis_markdown(a).find("height\\_px"), std::string::npos);
  EXPECT_NE(analysis_plain(a).find("height_px"), std::string::npos);
  EXPECT_EQ(analysis_plain(a).find('\\'), std::string::npos) << analysis_plain(a);
}

}  // namespace
}  // namespace crowdbench::studies
