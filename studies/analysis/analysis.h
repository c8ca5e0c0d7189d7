// The analysis of a study's answers: every question that they can answer is asked, by task and by condition, and what
// cannot be answered says why. Numbers in, numbers out; analysis_output.h and analysis_text.h print them.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "studies/analysis/answers.h"
#include "studies/analysis/equivalence.h"
#include "studies/analysis/mixed_model.h"
#include "studies/analysis/paired_comparison.h"
#include "studies/analysis/proportions.h"
#include "studies/analysis/psychometric.h"
#include "studies/analysis/score_prediction.h"
#include "studies/analysis/visual_angle.h"

namespace crowdbench::studies {

// What "cannot tell" counts as wherever it is not modelled (the ranking models it as a tie).
enum class TieRule {
  drop,   // no answer
  split,  // half for and half against; where only whole trials count (shares, exact tests), of an odd number one is
          // dropped
  no,     // against: a difference that was not seen
};

// What is random in the mixed model, clips (where there are any) apart.
enum class RandomEffects { none, intercept, slope, independent_slope };

// What `level` is.
struct LevelAxis {
  std::string name;        // of the factor: "height_px"; empty: not known
  bool in_pixels = false;  // sizes in pixels of the clip: thresholds are told in degrees of visual angle, too
};
// Of a plan's factor: "height_px" is in pixels.
LevelAxis axis_of_factor(const std::string& factor);
// "height_px (pixels)", "switch_m (m)"; "level" where no name is known.
std::string axis_title(const LevelAxis& axis);
// "pixels", "m"; empty: none is known.
std::string axis_unit(const LevelAxis& axis);

// What a study asked, for the sentences that are written of it; empty: not known.
struct AskedQuestion {
  std::string text;
  std::string yes;  // what an answer "yes" means, as "that the half under test was chosen"
};

struct AnalysisSettings {
  AskedQuestion asked;
  double chance = 0.5;  // of a yes, where there is nothing to see
  double confidence = 0.95;
  TieRule ties = TieRule::drop;
  std::optional<double> margin;   // of equivalence to chance; nothing: not asked
  std::optional<double> between;  // of equivalence of every two conditions' shares; nothing: not asked
  double alpha = 0.05;
  double power = 0.8;  // that "how many more" is for
  LevelAxis axis;
  CurveSettings curve;
  RandomEffects random = RandomEffects::intercept;
  Link link = Link::logit;
  std::optional<Integration> integration;  // nothing: quadrature where it can be, else Laplace
  double catch_least = 0;                  // share of catch trials that a participant must get right
  TrialRules trials;
  uint64_t seed = 1;
  size_t resamples = 1000;  // of bootstrap intervals; 0: none
};

// The answers to one condition; of pairs, to one pair in one condition.
struct ConditionResult {
  std::string name;
  std::string condition, first, second;  // of pairs: what `name` is made of; `yes` chose the first
  uint64_t yes = 0, ties = 0, no = 0;
  size_t participants = 0;  // 0: not known
  // After the rule for ties: `chosen` of `decided`. Where nothing is decided, none of what follows exists.
  uint64_t chosen = 0, decided = 0;
  Interval exact, score;  // Clopper-Pearson and Wilson
  // Where is_tested():
  BinomialTest test;                         // against chance
  double holm = 1;                           // the two-sided p, corrected over the conditions of the task
  std::optional<Equivalence> equivalence;    // "different" holds after that correction, too
  std::optional<SignalDetection> detection;  // where trials with and without a signal are known

  bool is_tested() const { return decided > 0 && !detection; }
};

// Two conditions of a task, by their place in its list.
struct DifferenceResult {
  size_t first = 0, second = 0;
  DifferenceEquivalence equivalence;  // "different" holds after the correction, too
  double holm = 1;                    // the two-sided p of "no difference", corrected over the pairs of the task
};

// Which side is chosen, of two, whatever stands there.
struct SideResult {
  uint64_t first = 0, of = 0;        // decided answers in which what counts as yes stood first, of all that say
  double share = 0.5;                // of yes, both sides counted alike
  double chosen_first = 0.5;         // share of answers that chose the first side, likewise
  size_t participants = 0;           // with answers to both; 0: not known
  std::optional<Interval> interval;  // of chosen_first, over participants by Student's t; of two or more
};

struct CurveResult {
  std::string condition;
  CurveFit fit;
  std::optional<CurveBootstrap> bootstrap;
  std::optional<CurveJackknife> jackknife;  // where participants are known
  bool by_participant = false;              // what the bootstrap draws
  size_t participants = 0;
  size_t clips = 0;                     // 0: not known
  std::optional<AngleThreshold> angle;  // of threshold_interval(); levels in pixels and calibrated participants
};

// The interval of a curve's threshold that is told and drawn. Of several participants the jackknife's, which counts
// that they differ, and that clips do, where there are enough of those: it is refused where there are too few
// participants, or one (or one clip) decides. Where the participants' answers show no spread,
// or they are not known, or there is one: the parametric bootstrap's, else the likelihood's.
struct ThresholdInterval {
  std::optional<double> low, high;  // nothing: open that way; both: there is none
  std::string method;       // "jackknife over participants (and clips)", "parametric bootstrap", "profile likelihood"
  std::string why;          // this method, or there is none
  bool over_clips = false;  // else it is of the clips that were shown, and not of others like them
};
// Nothing where there is no threshold.
std::optional<ThresholdInterval> threshold_interval(const CurveResult& curve);

// Where the rate of guesses that a mixed model holds comes from.
enum class GuessSource {
  no_level,  // no psychometric function: 0
  settings,  // held in the curve, too
  curve,     // the estimate of the curve of the same answers, whose error the mixed model does not count
  none,      // the curve was to fit it and could not: 0
};

struct MixedResult {
  std::string condition;  // empty: all together, with contrasts between conditions
  MixedSettings settings;
  GuessSource guess_from = GuessSource::no_level;
  MixedFit fit;
  std::vector<std::string> effects;                 // names of the fixed effects
  std::optional<LikelihoodRatio> ratio;             // of the level
  std::optional<MixedThreshold> threshold;          // on the level
  std::optional<AngleThreshold> angle;              // of the same, as of curves
  std::optional<PopulationProbability> population;  // where the intercept is the only fixed effect
};

struct RankingResult {
  std::vector<std::string> items;  // of this task
  size_t conditions = 1;           // whose comparisons are taken together
  Worths worths;
  std::optional<LikelihoodRatio> position;  // of the effect of standing first
  Jod jod;                                  // maximum likelihood, ties as half wins
  Jod jod_with_prior;
  std::optional<JodIntervals> intervals;  // of the latter, by participants drawn anew; of up to 20 items
};

struct TaskResult {
  std::string name;  // empty: the table names no tasks
  std::vector<ConditionResult> conditions;
  std::vector<DifferenceResult> differences;
  std::vector<CurveResult> curves;
  std::vector<MixedResult> mixed;
  std::optional<RankingResult> ranking;
  std::optional<SideResult> side;              // where answers say on which side what counts as yes stood
  std::optional<ScorePredictions> prediction;  // where there are scores
};

struct Analysis {
  std::vector<std::string> sources;
  size_t rows = 0;  // analysed
  size_t participants = 0;
  size_t simulated_rows = 0;  // of `rows`: answers of simulated observers
  size_t catch_rows = 0;      // set aside
  std::vector<Exclusion> excluded;
  LeftOut left_out;
  std::vector<TaskResult> tasks;
  AnalysisSettings settings;
  Answers answers;  // that were analysed
};

// What is more has to be asked in parts: nobody reads it, and fits take hours.
constexpr size_t kMostTaskConditions = 100;
constexpr size_t kMostItems = 50;
constexpr size_t kMostLevels = 500;       // of a condition
constexpr size_t kMostMixedNames = 2000;  // participants and clips of one mixed model

// scores: of what the answers name; empty: not asked. Throws Error where nothing is left to analyse, there is more than
// the above, a level is below 0 and the curve is Weibull's, positions are known of some comparisons only, or no
// stimulus has scores.
Analysis analyse(Answers answers, const AnalysisSettings& settings, const ScoreTable& scores = {});

// yes and ties and no after the rule for ties: so many chosen of so many decided.
struct Decided {
  uint64_t yes = 0;
  uint64_t of = 0;
};
Decided decided(uint64_t yes, uint64_t ties, uint64_t no, TieRule rule);

// The same for models whose likelihood takes weights (mixed models, what scores predict): none is dropped of an odd
// number. `halves` of `of` count half yes and half no, and are not in `yes`.
struct Counted {
  uint64_t yes = 0;
  uint64_t of = 0;
  uint64_t halves = 0;
};
Counted counted(uint64_t yes, uint64_t ties, uint64_t no, TieRule rule);

}  // namespace crowdbench::studies
