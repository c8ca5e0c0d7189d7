#include "studies/analysis/verdict_sentences.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/probability.h"
#include "studies/analysis/text_numbers.h"

namespace crowdbench::studies {
namespace {

using text::counted;
using text::ends_text;
using text::named;
using text::p_text;
using text::percent;

std::string p_is(double p) { return p < 0.001 ? "p < 0.001" : fmt::format("p = {:.3f}", p); }

// What a sentence begins with: of pairs the condition alone, where there is one, since both items follow.
std::string subject(const ConditionResult& c) {
  if (c.first.empty()) return named(c.name) + ": ";
  return c.condition.empty() ? "" : named(c.condition) + ": ";
}

// In the form in which such studies are printed: all answers, then those of who chose.
std::string shares_sentence(const ConditionResult& c) {
  const uint64_t all = c.yes + c.ties + c.no;
  std::string out = subject(c);
  if (all == 0) return named(c.name) + ": no answers.";
  if (c.ties > 0) out += fmt::format("{} cannot tell, ", percent(c.ties, all));
  if (c.first.empty())
    out += fmt::format("{} yes, {} no", percent(c.yes, all), percent(c.no, all));
  else
    out += fmt::format("{} chose {}, {} {}", percent(c.yes, all), named(c.first), percent(c.no, all), named(c.second));
  out += fmt::format(", of {}", counted(all, "answer", "answers"));
  if (c.participants > 0) out += fmt::format(" by {}", counted(c.participants, "participant", "participants"));
  if (c.ties > 0 && c.yes + c.no > 0) {
    const double share = std::round(100 * static_cast<double>(c.yes) / static_cast<double>(c.yes + c.no));
    out += fmt::format("; among those who chose {:.0f} / {:.0f} %", share, 100 - share);
  }
  return out + ".";
}

std::string chance_sentence(const ConditionResult& c, const AnalysisSettings& s) {
  const std::string interval =
      fmt::format("{:.0f} % interval {:.3f} to {:.3f}", 100 * s.confidence, c.exact.low, c.exact.high);
  const bool differs = c.holm <= 1 - s.confidence;
  if (differs)
    return fmt::format(" The share differs from {:g} (exact {}, {} after Holm's correction).", s.chance, interval,
                       p_is(c.holm));
  return fmt::format(" A difference from {:g} is not shown (exact {}, {} after Holm's correction){}.", s.chance,
                     interval, p_is(c.holm),
                     s.margin ? "" : ", which is no evidence that there is none: that takes a margin of equivalence");
}

template <typename Result>
std::string more_text(const Result& e, const char* of_either) {
  if (e.more_participants > 0)
    return fmt::format("about {}{} would be needed, were there no difference",
                       counted(e.more_participants, "more participant", "more participants"),
                       e.more_trials > 0 ? fmt::format(", with {} or more{} in all,",
                                                       counted(e.more_trials, "more trial", "more trials"), of_either)
                                         : "");
  if (e.more_trials > 0)
    return fmt::format("about {}{} would be needed, were there no difference",
                       counted(e.more_trials, "more trial", "more trials"), of_either);
  return "";  // none
}

constexpr const char* kAsManyAsAsked =
    "the answers are as many as the power asked for takes, and this sample's interval crosses the margin all the same; "
    "more of them than were planned would be another study";

std::string equivalence_sentence(const ConditionResult& c, const AnalysisSettings& s) {
  const Equivalence& e = *c.equivalence;
  const std::string people = e.by_participant ? fmt::format(", {} of participants", p_is(e.by_participant->p)) : "";
  const std::string interval = e.interval
                                   ? fmt::format("; mean share {:.3f}, {:.0f} % interval {:.3f} to {:.3f}", e.mean,
                                                 100 * (1 - 2 * s.alpha), e.interval->low, e.interval->high)
                                   : "";
  switch (e.verdict) {
    case Verdict::equivalent:
      return fmt::format(" Equivalent to {:g} within {:g}: two one-sided tests, {} of trials{}{}.", s.chance, *s.margin,
                         p_is(e.exact.p), people, interval);
    case Verdict::different: {
      const std::string of_people =
          e.different_by_participant ? fmt::format(", {} of participants", p_is(*e.different_by_participant)) : "";
      return fmt::format(" Different from {:g}: {} of trials after Holm's correction{}{}.", s.chance, p_is(c.holm),
                         of_people, interval);
    }
    case Verdict::not_enough_data: break;
  }
  const std::string more = more_text(e, "");
  return fmt::format(" {} whether it lies within {:g} of {:g}: {}{}.",
                     more.empty() ? "It is undecided" : "Not enough data to say", *s.margin, s.chance,
                     more.empty() ? kAsManyAsAsked : more, interval);
}

std::string difference_sentence(const TaskResult& t, const DifferenceResult& d, const AnalysisSettings& s) {
  const DifferenceEquivalence& e = d.equivalence;
  const std::string both =
      fmt::format("{} and {}", named(t.conditions[d.first].name), named(t.conditions[d.second].name));
  const std::string people = e.by_participant ? fmt::format(", {} of participants", p_is(e.by_participant->p)) : "";
  switch (e.verdict) {
    case Verdict::equivalent:
      return fmt::format("{} are equivalent within {:g}: difference {:+.3f}, {} of trials{}.", both, *s.between,
                         e.difference, p_is(e.score.p), people);
    case Verdict::different:
      return fmt::format("{} are different: {:+.3f}, {} after Holm's correction.", both, e.difference, p_is(d.holm));
    case Verdict::not_enough_data: break;
  }
  const std::string more = more_text(e, " of either");
  return fmt::format("{}: {} whether they differ by less than {:g} ({:+.3f}): {}.", both,
                     more.empty() ? "it is undecided" : "not enough data to say", *s.between, e.difference,
                     more.empty() ? kAsManyAsAsked : more);
}

// Of what clips the interval says something, where it is not over clips.
std::string for_clips(const CurveResult& c, const ThresholdInterval& interval) {
  if (interval.over_clips) return "";
  if (c.clips == 1) return " for the one clip that was shown";
  return c.clips == 0 ? " for the clips that were shown" : fmt::format(" for these {} clips", c.clips);
}

std::string curve_sentence(const CurveResult& c, const AnalysisSettings& s) {
  const std::string who = c.condition.empty() ? "" : named(c.condition) + ": ";
  if (c.fit.state == CurveState::no_slope)
    return fmt::format(
        "{}There is no threshold: no slope. The curve is one that {} with the level; `falling` turns it.", who,
        s.curve.falling ? "falls" : "rises");
  if (!c.fit.threshold) return fmt::format("{}There is no threshold: {}.", who, state_text(c.fit.state));
  const std::string unit = axis_unit(s.axis);
  const std::string threshold =
      fmt::format("{}The threshold{} at {:g} is {:.4g}{}", who, s.axis.name.empty() ? "" : " of " + named(s.axis.name),
                  s.curve.level, *c.fit.threshold, unit.empty() ? "" : " " + unit);
  const std::string angle = c.angle ? " That is " + text::angle_text(*c.angle, s.confidence) + "." : "";
  const std::optional<ThresholdInterval> interval = threshold_interval(c);
  if (!interval->low && !interval->high)
    return fmt::format("{}, and these answers give it no interval: {}.{}", threshold, interval->why, angle);
  return fmt::format("{} ({:.0f} % interval {}{}, {}{}).{}", threshold, 100 * s.confidence,
                     ends_text(interval->low, interval->high), for_clips(c, *interval), interval->method,
                     c.fit.state == CurveState::step ? "; the answers are a step, which may lie anywhere in it" : "",
                     angle);
}

// Who stands highest was chosen by looking: the interval of the gap is one over all pairs (Bonferroni).
bool stands_apart(const Worths& worths, size_t best, size_t worst, double confidence) {
  const auto items = static_cast<double>(worths.log_worth.size());
  const double pairs = items * (items - 1) / 2;
  const Difference gap = difference_of(worths, best, worst);
  return std::abs(gap.value) > normal_quantile(1 - (1 - confidence) / 2 / pairs) * gap.se;
}

// "a from b" of every two that are told apart.
std::vector<std::string> pairs_apart(const RankingResult& r, double confidence) {
  std::vector<std::string> out;
  for (size_t i = 0; i < r.items.size(); ++i)
    for (size_t j = i + 1; j < r.items.size(); ++j)
      if (stands_apart(r.worths, i, j, confidence))
        out.push_back(fmt::format("{} from {}", named(r.items[i]), named(r.items[j])));
  return out;
}

// "; not distinguishable from x: y": what may stand there as well as the highest and the lowest.
std::string unsure_ends(const RankingResult& r, size_t best, size_t worst, double confidence) {
  if (r.worths.state != WorthState::fitted)
    return fmt::format(" by the scale with a prior; which of them differ is not known ({})",
                       state_text(r.worths.state));
  std::string out;
  for (const size_t end : {best, worst}) {
    std::vector<std::string> alike;
    for (size_t i = 0; i < r.items.size(); ++i)
      if (i != end && !stands_apart(r.worths, end, i, confidence)) alike.push_back(named(r.items[i]));
    if (!alike.empty())
      out += fmt::format("; not distinguishable from {}: {}", named(r.items[end]), fmt::join(alike, ", "));
  }
  return out;
}

std::string ranking_sentence(const RankingResult& r, const AnalysisSettings& s) {
  const auto& q = r.jod_with_prior.q;
  if (r.worths.state == WorthState::all_ties) return "There is no ranking: nobody preferred anything.";
  if (q.empty()) return fmt::format("There is no ranking: {}.", state_text(r.worths.state));
  size_t best = 0;
  size_t worst = 0;
  for (size_t i = 1; i < q.size(); ++i) {
    if (q[i] > q[best]) best = i;
    if (q[i] < q[worst]) worst = i;
  }
  const std::string all = counted(r.items.size(), "item", "items");
  if (r.worths.log_worth.size() == q.size() && !stands_apart(r.worths, best, worst, s.confidence)) {
    const std::string widest =
        fmt::format("{} above {}, is {:.2f} JOD", named(r.items[best]), named(r.items[worst]), q[best] - q[worst]);
    const auto apart = pairs_apart(r, s.confidence);
    if (apart.empty())
      return fmt::format("Of {}, none is distinguishable from another: the widest gap, {}.", all, widest);
    return fmt::format("Of {}, the widest gap, {}, which is not distinguishable from none; distinguishable {}: {}.",
                       all, widest, apart.size() == 1 ? "is" : "are", fmt::join(apart, ", "));
  }
  return fmt::format("Of {}, {} stands highest and {} lowest, {:.2f} JOD apart{}.", all, named(r.items[best]),
                     named(r.items[worst]), q[best] - q[worst], unsure_ends(r, best, worst, s.confidence));
}

// The names of the scores that have the highest AUC.
std::vector<std::string> highest_scores(const ScorePredictions& p) {
  std::vector<std::string> out;
  for (const ScorePrediction& one : p.scores)
    if (one.state == PredictionState::fitted && one.auc >= p.scores[*p.best].auc - 1e-12)
      out.push_back(named(one.score));
  return out;
}

// The interval of the best of several, which is not the table's.
std::string best_interval_text(const ScorePredictions& p, size_t of, double confidence) {
  return fmt::format("AUC {:.2f}, {:.0f} % interval {:.2f} to {:.2f}{}", p.scores[*p.best].auc, 100 * confidence,
                     p.best_interval->low, p.best_interval->high,
                     of > 1 ? fmt::format(" by Bonferroni's rule, since it is the best of {}", of) : "");
}

std::string prediction_sentence(const ScorePredictions& p, double confidence) {
  if (!p.best) return "No score can be held against the answers.";
  const ScorePrediction& best = p.scores[*p.best];
  const auto fitted = static_cast<size_t>(std::count_if(
      p.scores.begin(), p.scores.end(), [](const auto& one) { return one.state == PredictionState::fitted; }));
  const std::vector<std::string> highest = highest_scores(p);
  if (highest.size() > 1 && highest.size() == fitted)
    return fmt::format("Of the objective scores, none stands highest: {} have one AUC, {:.2f}.",
                       fmt::join(highest, ", "), best.auc);
  if (!p.best_interval)
    return fmt::format("Of the objective scores, {} has the highest AUC, {:.2f}; without an interval none is best.",
                       named(best.score), best.auc);
  std::string alike;
  for (const ScoreContest& c : p.contests)
    if (c.a == *p.best && c.interval && !c.distinguishable)
      alike += (alike.empty() ? "" : ", ") + named(p.scores[c.b].score);
  const bool told_apart = alike.empty() && p.best_interval->low > 0.5;
  std::string out = fmt::format("Of the objective scores, {} {} ({})", fmt::join(highest, " and "),
                                told_apart           ? "predicts the answers best"
                                : highest.size() > 1 ? "stand highest alike, and neither is shown to be best"
                                                     : "stands highest, and is not shown to be best",
                                best_interval_text(p, fitted, confidence));
  if (p.best_interval->low <= 0.5) out += ", not distinguishable from guessing";
  return out + (alike.empty() ? "." : fmt::format("; not distinguishable from it: {}.", alike));
}

// What stands before all others: what was asked, and what is counted.
std::string asked_sentence(const AskedQuestion& asked) {
  std::string out;
  if (!asked.text.empty()) out = fmt::format("Asked was: \"{}\"", printable(asked.text, 300));
  if (!asked.yes.empty()) out += fmt::format("{}\"Yes\" means {}.", out.empty() ? "" : " ", named(asked.yes));
  return out;
}

std::string side_sentence(const SideResult& side, const AnalysisSettings& s) {
  std::string out = fmt::format(
      "The first side (above, or left) was chosen in {:.0f} % of the answers, both sides counted "
      "alike",
      100 * side.chosen_first);
  if (side.interval) {
    const bool preferred = side.interval->low > 0.5 || side.interval->high < 0.5;
    out +=
        fmt::format(" ({:.0f} % interval {:.0f} to {:.0f} % over {}): {}", 100 * s.confidence, 100 * side.interval->low,
                    100 * side.interval->high, counted(side.participants, "participant", "participants"),
                    preferred ? "a side is preferred, and fewer differences are found than without that"
                              : "that a side is preferred is not shown");
  }
  out += fmt::format(". What counts as yes stood first in {} of {}", side.first, side.of);
  const double balance = static_cast<double>(side.first) / static_cast<double>(side.of);
  constexpr double kEven = 0.02;  // of which a preference moves a share by less than a fiftieth of its own
  if (std::fabs(balance - 0.5) <= kEven) return out + ": shares are of both sides alike.";
  return out + fmt::format(", which moves shares of yes: of both sides alike it is {:.3f}.", side.share);
}

}  // namespace

std::vector<std::string> verdict_sentences(const TaskResult& t, const AnalysisSettings& s) {
  std::vector<std::string> out;
  if (std::string asked = asked_sentence(s.asked); !asked.empty()) out.push_back(std::move(asked));
  for (const ConditionResult& c : t.conditions) {
    out.push_back(shares_sentence(c));
    if (!c.is_tested()) continue;
    out.back() += c.equivalence ? equivalence_sentence(c, s) : chance_sentence(c, s);
  }
  for (const DifferenceResult& d : t.differences) out.push_back(difference_sentence(t, d, s));
  for (const CurveResult& c : t.curves) out.push_back(curve_sentence(c, s));
  if (t.ranking) out.push_back(ranking_sentence(*t.ranking, s));
  if (t.side) out.push_back(side_sentence(*t.side, s));
  if (t.prediction) out.push_back(prediction_sentence(*t.prediction, s.confidence));
  return out;
}

}  // namespace crowdbench::studies
