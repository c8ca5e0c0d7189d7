// Which objective score predicts what people answer: how well each separates the stimuli that they answered yes to from
// the others, whether its predictions are calibrated, and which scores differ in that. Numbers in, numbers out.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/statistics.h"
#include "studies/analysis/answers.h"

namespace crowdbench::studies {

// Scores of stimuli, by the name of a stimulus, a clip, a condition or an item.
struct ScoreTable {
  enum class Key { stimulus, clip, condition, item };
  std::string source;  // what messages call it
  std::string study;   // the hash of the plan that they are of; empty: not known
  Key key = Key::stimulus;
  std::vector<std::string> scores;                         // names
  std::vector<std::string> keys;                           // of stimuli
  std::vector<std::vector<std::optional<double>>> values;  // by stimulus, by score; finite

  bool empty() const { return scores.empty(); }
};
constexpr size_t kMostScores = 64;

// Of a table that has one of the columns `stimulus`, `clip`, `condition` and `item`; every other column is a score,
// empty where there is none. Throws Error at "file:line": none or two of the four, a stimulus twice, what is no finite
// number, no scores or more than kMostScores.
ScoreTable score_table(const Table& table);
// Of a file: a table, or the study.json that `study export` wrote, whose stimuli have mean scores. Throws Error, of the
// latter too for a stimulus twice and for more than kMostScores.
ScoreTable read_scores(const std::filesystem::path& file);

// Answers to one stimulus by one participant.
struct PredictedCell {
  uint32_t participant = 0;
  uint32_t stimulus = 0;
  uint64_t yes = 0;
  uint64_t of = 0;
  uint64_t halves = 0;  // of `of`, and not of `yes`: answers that count half yes and half no
};
struct PredictedAnswers {
  // By stimulus, by score: the score of the clip, or of a comparison the difference of its two items'.
  std::vector<std::vector<std::optional<double>>> values;
  std::vector<PredictedCell> cells;
  size_t participants = 0;   // 0: not known
  bool comparisons = false;  // each is taken from both sides, so that it does not matter which item stands first
};

enum class PredictionState {
  fitted,
  no_values,  // the score has none for these stimuli
  one_value,  // or one alone
  all_alike,  // every answer is the same
};
std::string_view state_text(PredictionState state);

struct ScorePrediction {
  std::string score;
  PredictionState state = PredictionState::no_values;
  bool falls = false;  // the higher the score, the rarer the yes
  // The chance that of an answer yes and an answer no, drawn at random, the former's stimulus is the one that the score
  // says so of; equal scores count half. 0.5: no better than guessing. The direction is that of all the data.
  double auc = 0.5;
  std::optional<Interval> auc_interval;
  // Of predictions for every stimulus by a logistic regression on the score over all others: logit P(yes) = intercept +
  // slope logit(prediction). 0 and 1 where predictions are right; a slope below 1: they are too sure of themselves.
  // Nothing below four stimuli with different scores, or where the regression separates yes from no.
  std::optional<double> calibration_slope, calibration_intercept;
  std::optional<Interval> slope_interval, intercept_interval;
};
// Scores a and b, of which a has the higher AUC.
struct ScoreContest {
  size_t a = 0, b = 0;
  double difference = 0;  // of their AUC
  // Simultaneous over all pairs of scores: with the given confidence all of them hold.
  std::optional<Interval> interval;
  bool distinguishable = false;  // the interval excludes 0
};
struct ScorePredictions {
  uint64_t answers = 0;
  size_t stimuli = 0, participants = 0;
  uint64_t without_scores = 0;  // answers to stimuli that not all scores (of those that have any) have a value of
  size_t resamples = 0;
  std::vector<ScorePrediction> scores;  // in the order of the table
  std::vector<ScoreContest> contests;   // of fitted scores, the best first
  std::optional<size_t> best;           // the highest AUC
  // Of the best one's AUC, at 1 - (1 - confidence) / fitted scores (Bonferroni): it was chosen by looking at all of
  // them.
  std::optional<Interval> best_interval;
};

// Intervals are by the bootstrap that draws participants and stimuli anew at once (Owen 2007), which is a little wide;
// resamples 0: none. Contests: the difference plus or minus the quantile of the largest standardised deviation of any
// pair (single-step max-t). names: of the scores.
ScorePredictions predict_by_scores(const std::vector<std::string>& names, const PredictedAnswers& answers,
                                   double confidence, uint64_t seed, size_t resamples);

}  // namespace crowdbench::studies
