// Based on: Hanley and McNeil, "The meaning and use of the area under a receiver operating characteristic curve"
// (1982); Cox, "Two further applications of a model for binary regression" (1958) for calibration; Owen, "The
// pigeonhole bootstrap" (2007); Westfall and Young, "Resampling-based multiple testing" (1993) for the simultaneous
// intervals.
#include "studies/analysis/score_prediction.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "core/probability.h"
#include "core/random.h"

namespace crowdbench::studies {
namespace {

constexpr uint64_t kDrawParticipants = 0x70726564;
constexpr uint64_t kDrawStimuli = 0x70726573;
constexpr double kSeparated = 30;  // |logit| beyond which a regression runs off
constexpr size_t kFewestStimuli = 4;

// Answers by stimulus, each with the weight of its participant and its stimulus.
struct Weighed {
  std::vector<double> yes, no;
};

// What all scores are judged by: stimuli that all of them have values of.
class Judged {
 public:
  Judged(const PredictedAnswers& answers, const std::vector<size_t>& scores) : answers_(answers) {
    place_.assign(answers.values.size(), -1);
    for (size_t stimulus = 0; stimulus < answers.values.size(); ++stimulus) {
      const auto& values = answers.values[stimulus];
      if (!std::all_of(scores.begin(), scores.end(), [&](size_t s) { return values[s].has_value(); })) continue;
      place_[stimulus] = static_cast<int64_t>(stimuli_++);
      for (const size_t s : scores) values_[s].resize(stimuli_, *values[s]);
    }
  }
  size_t stimuli() const { return stimuli_; }
  // Of a score, by stimulus; of comparisons the same from the other side behind them.
  std::vector<double> values(size_t score) const {
    std::vector<double> out = values_.at(score);
    if (answers_.comparisons)
      for (size_t i = 0; i < stimuli_; ++i) out.push_back(-out[i]);
    return out;
  }
  bool has(const PredictedCell& cell) const { return place_[cell.stimulus] >= 0; }
  Weighed weigh(const std::vector<double>& participants, const std::vector<double>& stimuli) const {
    const size_t n = stimuli_ * (answers_.comparisons ? 2 : 1);
    Weighed out{std::vector<double>(n), std::vector<double>(n)};
    for (const PredictedCell& cell : answers_.cells) {
      if (!has(cell)) continue;
      const auto at = static_cast<size_t>(place_[cell.stimulus]);
      const double weight = participants[cell.participant] * stimuli[at];
      const double share = static_cast<double>(cell.yes) + static_cast<double>(cell.halves) / 2;
      const double yes = weight * share;
      const double no = weight * (static_cast<double>(cell.of) - share);
      out.yes[at] += yes;
      out.no[at] += no;
      if (!answers_.comparisons) continue;
      out.yes[at + stimuli_] += no;
      out.no[at + stimuli_] += yes;
    }
    return out;
  }

 private:
  const PredictedAnswers& answers_;
  std::vector<int64_t> place_;  // of a stimulus among those that count; -1: it does not
  size_t stimuli_ = 0;
  std::map<size_t, std::vector<double>> values_;
};

// How often each of n is drawn in n draws.
std::vector<double> drawn(size_t n, uint64_t seed, size_t resample, uint64_t purpose) {
  std::vector<double> out(n, 0);
  for (size_t i = 0; i < n; ++i) ++out[random_below(mix64(seed + purpose), resample, i, n)];
  return out;
}

std::vector<size_t> order_of(const std::vector<double>& values) {
  std::vector<size_t> out(values.size());
  std::iota(out.begin(), out.end(), size_t{0});
  std::stable_sort(out.begin(), out.end(), [&](size_t a, size_t b) { return values[a] < values[b]; });
  return out;
}

// Where higher values go with yes. Nothing where there are no yes or no others.
std::optional<double> area(const std::vector<double>& values, const std::vector<size_t>& order, const Weighed& w) {
  double no_below = 0;
  double sum = 0;
  double yes_all = 0;
  for (size_t i = 0; i < order.size();) {
    double yes = 0;
    double no = 0;
    const double value = values[order[i]];
    for (; i < order.size() && values[order[i]] == value; ++i) {
      yes += w.yes[order[i]];
      no += w.no[order[i]];
    }
    sum += yes * (no_below + no / 2);
    no_below += no;
    yes_all += yes;
  }
  if (no_below == 0 || yes_all == 0) return std::nullopt;
  return sum / (no_below * yes_all);
}

// ---- calibration

struct Line {
  double intercept = 0;
  double slope = 0;
};

// Logistic regression on x with weighed answers. Nothing where it has no finite estimate.
std::optional<Line> logistic_line(const std::vector<double>& x, const Weighed& w) {
  Line line;
  for (int step = 0; step < 50; ++step) {
    double g0 = 0;
    double g1 = 0;
    double h00 = 0;
    double h01 = 0;
    double h11 = 0;
    for (size_t i = 0; i < x.size(); ++i) {
      const double n = w.yes[i] + w.no[i];
      const double p = logistic_cdf(line.intercept + line.slope * x[i]);
      const double weight = n * p * (1 - p);
      g0 += w.yes[i] - n * p;
      g1 += (w.yes[i] - n * p) * x[i];
      h00 += weight;
      h01 += weight * x[i];
      h11 += weight * x[i] * x[i];
    }
    const double determinant = h00 * h11 - h01 * h01;
    if (!(determinant > 1e-12 * h00 * h11)) return std::nullopt;
    const double by0 = (h11 * g0 - h01 * g1) / determinant;
    const double by1 = (h00 * g1 - h01 * g0) / determinant;
    // Steps of more than a few logits leave the region in which the quadratic holds.
    const double most = std::max(std::fabs(by0), std::fabs(by1));
    const double part = most > 2 ? 2 / most : 1;
    line.intercept += part * by0;
    line.slope += part * by1;
    if (std::fabs(line.intercept) > kSeparated || std::fabs(line.slope) > kSeparated) return std::nullopt;
    if (most < 1e-10) return line;
  }
  return std::nullopt;
}

// In units of their own spread about their mean.
std::vector<double> standardised_values(std::vector<double> values) {
  const auto n = static_cast<double>(values.size());
  double mean = 0;
  double square = 0;
  for (const double v : values) mean += v / n;
  for (const double v : values) square += (v - mean) * (v - mean) / n;
  for (double& v : values) v = square > 0 ? (v - mean) / std::sqrt(square) : 0;
  return values;
}

// The logit of the prediction for every stimulus by the answers to all others. Empty where there is none.
std::vector<double> predictions(const std::vector<double>& values, const Weighed& w, bool comparisons) {
  const std::vector<double> x = standardised_values(values);
  std::vector<double> distinct = values;
  std::sort(distinct.begin(), distinct.end());
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  if (distinct.size() < kFewestStimuli) return {};
  std::vector<double> out(x.size());
  const size_t units = comparisons ? x.size() / 2 : x.size();
  for (size_t i = 0; i < units; ++i) {
    Weighed others = w;
    // A comparison goes together with its other side.
    for (size_t at = i; at < x.size(); at += units) others.yes[at] = others.no[at] = 0;
    const std::optional<Line> line = logistic_line(x, others);
    if (!line) return {};
    for (size_t at = i; at < x.size(); at += units) out[at] = line->intercept + line->slope * x[at];
  }
  return out;
}

// ---- intervals

std::optional<Interval> percentile(std::vector<double> values, double confidence, double estimate) {
  if (values.empty()) return std::nullopt;
  const double tail = (1 - confidence) / 2;
  return Interval{std::min(quantile(values, tail), estimate), std::max(quantile(values, 1 - tail), estimate)};
}

// One score and what it is judged by.
struct Subject {
  size_t score = 0;  // of ScorePredictions::scores
  std::vector<double> values;
  std::vector<size_t> order;
  std::vector<double> logits;                     // predictions; may be empty
  std::vector<double> areas, slopes, intercepts;  // of resamples
};

void resample(const Judged& judged, const PredictedAnswers& answers, uint64_t seed, size_t resamples,
              std::vector<Subject>& subjects, const ScorePredictions& all) {
  const std::vector<double> one(std::max<size_t>(answers.participants, 1), 1);
  for (size_t r = 0; r < resamples; ++r) {
    const std::vector<double> people =
        answers.participants > 1 ? drawn(answers.participants, seed, r, kDrawParticipants) : one;
    const Weighed w = judged.weigh(people, drawn(judged.stimuli(), seed, r, kDrawStimuli));
    for (Subject& subject : subjects) {
      const std::optional<double> up = area(subject.values, subject.order, w);
      if (!up) break;  // all answers alike: none of the scores has an area
      subject.areas.push_back(all.scores[subject.score].falls ? 1 - *up : *up);
      if (subject.logits.empty()) continue;
      if (const auto line = logistic_line(subject.logits, w)) {
        subject.slopes.push_back(line->slope);
        subject.intercepts.push_back(line->intercept);
      }
    }
  }
}

// subjects: the best first. All have equally many areas, of the same resamples.
void hold_contests(const std::vector<Subject>& subjects, double confidence, ScorePredictions& out) {
  std::vector<double> spread;
  std::vector<double> largest(subjects.empty() ? 0 : subjects.front().areas.size(), 0);
  for (size_t i = 0; i < subjects.size(); ++i)
    for (size_t j = i + 1; j < subjects.size(); ++j) {
      ScoreContest contest{subjects[i].score, subjects[j].score};
      contest.difference = out.scores[contest.a].auc - out.scores[contest.b].auc;
      std::vector<double> off;
      double square = 0;
      for (size_t r = 0; r < largest.size(); ++r) {
        off.push_back(subjects[i].areas[r] - subjects[j].areas[r] - contest.difference);
        square += off.back() * off.back() / static_cast<double>(largest.size());
      }
      spread.push_back(std::sqrt(square));
      if (square > 0)
        for (size_t r = 0; r < largest.size(); ++r)
          largest[r] = std::max(largest[r], std::fabs(off[r]) / spread.back());
      out.contests.push_back(contest);
    }
  if (largest.empty()) return;
  const double reach = quantile(largest, confidence);
  for (size_t i = 0; i < out.contests.size(); ++i) {
    ScoreContest& contest = out.contests[i];
    contest.interval = Interval{contest.difference - reach * spread[i], contest.difference + reach * spread[i]};
    contest.distinguishable = spread[i] > 0 && contest.interval->low > 0;
  }
}

// Fills the state, the direction and the area of a score; false where it has none.
bool judge(const std::vector<double>& values, const std::vector<size_t>& order, const Weighed& w,
           ScorePrediction& out) {
  if (values.empty() || values[order.front()] == values[order.back()]) {
    out.state = values.empty() ? PredictionState::no_values : PredictionState::one_value;
    return false;
  }
  const std::optional<double> up = area(values, order, w);
  out.state = up ? PredictionState::fitted : PredictionState::all_alike;
  if (!up) return false;
  out.falls = *up < 0.5;
  out.auc = std::max(*up, 1 - *up);
  return true;
}

}  // namespace

std::string_view state_text(PredictionState state) {
  switch (state) {
    case PredictionState::fitted: return "fitted";
    case PredictionState::no_values: return "no values";
    case PredictionState::one_value: return "one value";
    case PredictionState::all_alike: break;
  }
  return "all answers alike";
}

ScorePredictions predict_by_scores(const std::vector<std::string>& names, const PredictedAnswers& answers,
                                   double confidence, uint64_t seed, size_t resamples) {
  ScorePredictions out;
  std::vector<size_t> there;
  for (size_t s = 0; s < names.size(); ++s) {
    out.scores.push_back({.score = names[s]});
    if (std::any_of(answers.values.begin(), answers.values.end(), [&](const auto& v) { return v[s].has_value(); }))
      there.push_back(s);
  }
  out.participants = answers.participants;
  if (there.empty()) {
    for (const PredictedCell& cell : answers.cells) out.without_scores += cell.of;
    return out;
  }
  const Judged judged(answers, there);
  out.stimuli = judged.stimuli();
  for (const PredictedCell& cell : answers.cells) (judged.has(cell) ? out.answers : out.without_scores) += cell.of;
  if (judged.stimuli() == 0) return out;
  const Weighed w = judged.weigh(std::vector<double>(std::max<size_t>(answers.participants, 1), 1),
                                 std::vector<double>(judged.stimuli(), 1));
  std::vector<Subject> subjects;
  for (const size_t s : there) {
    Subject subject{s, judged.values(s), {}, {}, {}, {}, {}};
    subject.order = order_of(subject.values);
    if (!judge(subject.values, subject.order, w, out.scores[s])) continue;
    subject.logits = predictions(subject.values, w, answers.comparisons);
    if (!subject.logits.empty())
      if (const auto line = logistic_line(subject.logits, w)) {
        out.scores[s].calibration_slope = line->slope;
        out.scores[s].calibration_intercept = line->intercept;
      }
    subjects.push_back(std::move(subject));
  }
  std::stable_sort(subjects.begin(), subjects.end(), [&](const Subject& a, const Subject& b) {
    return out.scores[a.score].auc > out.scores[b.score].auc;
  });
  out.resamples = subjects.empty() ? 0 : resamples;
  if (!subjects.empty()) out.best = subjects.front().score;
  resample(judged, answers, seed, resamples, subjects, out);
  for (const Subject& subject : subjects) {
    ScorePrediction& p = out.scores[subject.score];
    p.auc_interval = percentile(subject.areas, confidence, p.auc);
    if (!p.calibration_slope) continue;
    p.slope_interval = percentile(subject.slopes, confidence, *p.calibration_slope);
    p.intercept_interval = percentile(subject.intercepts, confidence, *p.calibration_intercept);
  }
  if (!subjects.empty())
    out.best_interval = percentile(subjects.front().areas, 1 - (1 - confidence) / static_cast<double>(subjects.size()),
                                   out.scores[*out.best].auc);
  hold_contests(subjects, confidence, out);
  return out;
}

}  // namespace crowdbench::studies
