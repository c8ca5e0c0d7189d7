#include "studies/analysis/analysis_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "studies/analysis/text_numbers.h"
#include "studies/analysis/verdict_sentences.h"

namespace crowdbench::studies {
namespace {

using text::counted;
using text::ends_text;
using text::named;
using text::number;
using text::p_text;
using text::percent;

Section shares(const TaskResult& t, const AnalysisSettings& s) {
  Section out{Topic::shares, "Shares of answers"};
  if (t.ranking) out.lead = "Yes: the first of the two was chosen; no: the second.";
  out.table = TextTable{{"condition", "participants", "yes", "cannot tell", "no", "chosen / decided",
                         fmt::format("{:.0f} % exact", 100 * s.confidence), "p", "p (Holm)"},
                        1,
                        {}};
  for (const ConditionResult& c : t.conditions) {
    const uint64_t all = c.yes + c.ties + c.no;
    const auto share = [&](uint64_t part) { return fmt::format("{} ({})", part, percent(part, all)); };
    std::vector<std::string> row = {named(c.name), c.participants > 0 ? fmt::format("{}", c.participants) : "-",
                                    share(c.yes), share(c.ties), share(c.no)};
    if (c.decided == 0)
      row.insert(row.end(), {"no data", "-", "-", "-"});
    else
      row.insert(row.end(), {fmt::format("{} / {} ({})", c.chosen, c.decided, percent(c.chosen, c.decided)),
                             fmt::format("{:.3f} to {:.3f}", c.exact.low, c.exact.high),
                             c.is_tested() ? p_text(c.test.two_sided) : "-", c.is_tested() ? p_text(c.holm) : "-"});
    out.table->rows.push_back(std::move(row));
  }
  return out;
}

// Below so many clips that differ much, intervals are too narrow although their few degrees of freedom are counted: of
// 3 clips they hold the truth in 92 % of studies in place of 95 (tests/studies/recovery_test.cpp).
constexpr size_t kFewClips = 5;

template <typename Result>
std::string still_needed(const Result& e) {
  if (e.verdict != Verdict::not_enough_data) return "";
  if (e.more_participants > 0)
    return counted(e.more_participants, "more participant", "more participants") +
           (e.more_trials > 0 ? fmt::format(" with {} trials or more", e.more_trials) : "");
  if (e.more_trials > 0) return counted(e.more_trials, "more trial", "more trials");
  return "none by the power asked for: this sample's interval crosses the margin";
}

std::string interval_text(const std::optional<Interval>& i, const char* format = "{:.3f} to {:.3f}") {
  return i ? fmt::format(fmt::runtime(format), i->low, i->high) : "-";
}

std::optional<Section> equivalences(const TaskResult& t, const AnalysisSettings& s) {
  if (!s.margin) return std::nullopt;
  Section out{Topic::equivalence, "Equivalence to chance"};
  out.lead = fmt::format(
      "Equivalence to {:g}, margin {:g}: two one-sided tests at {:g}, of trials and of participants; both must hold.",
      s.chance, *s.margin, s.alpha);
  out.table = TextTable{{"condition", "verdict", "p of trials", "p of participants",
                         fmt::format("{:.0f} % of the mean share", 100 * (1 - 2 * s.alpha)), "still needed"},
                        2,
                        {}};
  for (const ConditionResult& c : t.conditions) {
    if (!c.equivalence) continue;
    const Equivalence& e = *c.equivalence;
    out.table->rows.push_back({named(c.name), std::string(verdict_text(e.verdict)), p_text(e.exact.p),
                               e.by_participant ? p_text(e.by_participant->p) : "-", interval_text(e.interval),
                               still_needed(e)});
  }
  return out.table->rows.empty() ? std::nullopt : std::optional(out);
}

std::optional<Section> differences(const TaskResult& t, const AnalysisSettings& s) {
  if (t.differences.empty()) return std::nullopt;
  Section out{Topic::differences, "Conditions against each other"};
  out.lead = fmt::format(
      "Equivalence of two conditions' shares, margin {:g}: two one-sided tests at {:g} of trials (score, Miettinen and "
      "Nurminen) and of the differences within participants; both must hold.",
      *s.between, s.alpha);
  out.table = TextTable{{"conditions", "verdict", "difference", "p of trials", "p of participants",
                         fmt::format("{:.0f} % of the mean difference", 100 * (1 - 2 * s.alpha)), "p of no difference",
                         "p (Holm)", "still needed"},
                        2,
                        {}};
  for (const DifferenceResult& d : t.differences) {
    const DifferenceEquivalence& e = d.equivalence;
    std::string needed = still_needed(e);
    if (e.verdict == Verdict::not_enough_data && e.more_trials > 0) needed += " of either";
    out.table->rows.push_back(
        {fmt::format("{} - {}", named(t.conditions[d.first].name), named(t.conditions[d.second].name)),
         std::string(verdict_text(e.verdict)), fmt::format("{:+.3f}", e.difference), p_text(e.score.p),
         e.by_participant ? p_text(e.by_participant->p) : "-", interval_text(e.interval, "{:+.3f} to {:+.3f}"),
         p_text(e.different_score), p_text(d.holm), needed});
  }
  return out;
}

std::optional<Section> detections(const TaskResult& t) {
  Section out{Topic::detection, "Detection"};
  out.table = TextTable{{"condition", "d' (SE)", "criterion (SE)"}, 1, {}};
  for (const ConditionResult& c : t.conditions)
    if (c.detection)
      out.table->rows.push_back({named(c.name),
                                 fmt::format("{:.3f} ({:.3f})", c.detection->d_prime, c.detection->d_prime_se),
                                 fmt::format("{:.3f} ({:.3f})", c.detection->criterion, c.detection->criterion_se)});
  return out.table->rows.empty() ? std::nullopt : std::optional(out);
}

// The interval that is told; by which method stands below the table.
std::string told_text(const CurveResult& c) {
  const auto told = threshold_interval(c);
  if (!told || (!told->low && !told->high)) return "none";
  return ends_text(told->low, told->high);
}

std::vector<std::string> curve_row(const CurveResult& c) {
  const CurveFit& f = c.fit;
  std::vector<std::string> row = {named(c.condition), std::string(state_text(f.state)), number(f.threshold)};
  if (f.state != CurveState::fitted && f.state != CurveState::step) {
    row.resize(11, "-");
    return row;
  }
  std::string bootstrap = "-";
  if (c.bootstrap)
    bootstrap = c.bootstrap->few    ? "none: too few"
                : c.bootstrap->open ? "open"
                : c.bootstrap->alike
                    ? "none: draws alike"
                    : fmt::format("{:.4g} to {:.4g}", c.bootstrap->threshold.low, c.bootstrap->threshold.high);
  row.insert(row.end(),
             {told_text(c), ends_text(f.threshold_profile.low, f.threshold_profile.high), bootstrap,
              fmt::format("{:.4g}", f.at.location), fmt::format("{:.4g}", f.at.scale),
              fmt::format("{:.3g}", f.at.guess), fmt::format("{:.3g}", f.at.lapse), fmt::format("{:.2f}", f.deviance)});
  return row;
}

std::optional<Section> curves(const TaskResult& t, const AnalysisSettings& s) {
  if (t.curves.empty()) return std::nullopt;
  Section out{Topic::curves, "Thresholds"};
  out.lead = fmt::format("Psychometric function: {}{}, threshold at {:g}, over {}.", curve_name(s.curve.curve),
                         s.curve.falling ? ", falling" : "", s.curve.level, axis_title(s.axis));
  out.table = TextTable{{"condition", "state", "threshold", "interval", "by likelihood", "by bootstrap", "location",
                         "scale", "guess", "lapse", "deviance"},
                        2,
                        {}};
  for (const CurveResult& c : t.curves) {
    out.table->rows.push_back(curve_row(c));
    if (const auto told = threshold_interval(c))
      out.list.push_back(told->method.empty()
                             ? fmt::format("{}: no interval: {}", named(c.condition), told->why)
                             : fmt::format("{}: interval by {}: {}", named(c.condition), told->method, told->why));
    if (c.angle)
      out.list.push_back(fmt::format("{}: {}, of {} whose answers these are", named(c.condition),
                                     text::angle_text(*c.angle, s.confidence), c.participants));
    else if (s.axis.in_pixels && c.fit.threshold)
      out.list.push_back(named(c.condition) + ": no visual angle, since nobody's screen was calibrated");
  }
  return out;
}

std::string guess_text(const MixedResult& m) {
  switch (m.guess_from) {
    case GuessSource::no_level: return "";
    case GuessSource::settings: return fmt::format(" Guess held at {:.3g}.", m.settings.guess);
    case GuessSource::curve:
      return fmt::format(" Guess held at {:.3g}, the curve's estimate, whose error is not counted here.",
                         m.settings.guess);
    case GuessSource::none: break;
  }
  return " Guess held at 0, since the curve that was to estimate it is not fitted.";
}

Section mixed(const MixedResult& m, const AnalysisSettings& s) {
  Section out{Topic::mixed, "Mixed model"};
  out.lead = fmt::format(
      "Mixed-effects {} regression{}: {}, {} of {}.", m.settings.link == Link::logit ? "logistic" : "probit",
      m.condition.empty() ? "" : ", " + named(m.condition), state_text(m.fit.state),
      counted(m.fit.answers, "answer", "answers"), counted(m.fit.participants, "participant", "participants"));
  out.lead += guess_text(m);
  if (m.fit.fixed.empty()) return out;
  out.table = TextTable{{"effect", "estimate", "SE", "z", "p"}, 1, {}};
  for (size_t i = 0; i < m.effects.size(); ++i) {
    const MixedEffect& e = m.fit.fixed[i];
    out.table->rows.push_back({named(m.effects[i]), fmt::format("{:.4f}", e.estimate), fmt::format("{:.4f}", e.se),
                               fmt::format("{:.2f}", e.z), p_text(e.p)});
  }
  out.note = fmt::format("Variance of participants {:.4g}", m.fit.participant_variance);
  if (m.fit.slope_variance) out.note += fmt::format(", of their slopes {:.4g}", *m.fit.slope_variance);
  if (m.fit.clip_variance) out.note += fmt::format(", of clips {:.4g}", *m.fit.clip_variance);
  out.note += fmt::format("; log-likelihood {:.3f}.", m.fit.log_likelihood);
  if (m.threshold)
    out.note += fmt::format(
        " The typical participant's threshold: {:.4g} ({}).", m.threshold->at,
        m.threshold->interval ? ends_text(m.threshold->interval->low, m.threshold->interval->high) : "open");
  if (m.threshold && m.threshold->interval && m.fit.clips > 1 && m.fit.clips < kFewClips)
    out.note += fmt::format(
        " {} clips say little of how much clips differ: the interval holds the truth somewhat less often than {:.0f} "
        "%.",
        m.fit.clips, 100 * s.confidence);
  if (m.angle) out.note += fmt::format(" That is {}.", text::angle_text(*m.angle, s.confidence));
  if (m.population)
    out.note += fmt::format(" Share of the typical participant {:.3f}, average {:.3f}.", m.population->typical,
                            m.population->average);
  return out;
}

TextTable ranking_table(const RankingResult& r) {
  const bool worths = r.worths.state == WorthState::fitted;
  TextTable out{{"item", "log worth (SE)", "worth", "JOD, maximum likelihood", "JOD with prior", "interval"}, 1, {}};
  for (size_t i = 0; i < r.items.size(); ++i)
    out.rows.push_back({named(r.items[i]),
                        worths ? fmt::format("{:+.3f} ({:.3f})", r.worths.log_worth[i], r.worths.se[i]) : "-",
                        worths ? fmt::format("{:.3f}", r.worths.worth[i]) : "-",
                        r.jod.q.empty() ? "-" : fmt::format("{:+.3f}", r.jod.q[i]),
                        r.jod_with_prior.q.empty() ? "-" : fmt::format("{:+.3f}", r.jod_with_prior.q[i]),
                        r.intervals && !r.intervals->q.empty()
                            ? fmt::format("{:+.3f} to {:+.3f}", r.intervals->q[i].low, r.intervals->q[i].high)
                            : "-"});
  return out;
}

Section ranking(const RankingResult& r) {
  Section out{Topic::ranking, "Ranking"};
  out.lead = fmt::format("Ranking{}: {}.",
                         r.conditions > 1 ? fmt::format(" over all {} conditions together", r.conditions) : "",
                         state_text(r.worths.state));
  const bool worths = r.worths.state == WorthState::fitted;
  if (!worths && r.worths.groups.size() > 1) {
    out.lead += " There is no one scale for the groups of items that are listed.";
    for (const auto& group : r.worths.groups) {
      std::string items;
      for (const uint32_t item : group) items += (items.empty() ? "" : ", ") + named(r.items[item]);
      out.list.push_back(std::move(items));
    }
  }
  if (worths || r.jod_with_prior.state == WorthState::fitted) out.table = ranking_table(r);
  if (r.worths.log_nu) out.note = fmt::format("Ties: nu {:.3f}. ", std::exp(*r.worths.log_nu));
  if (r.worths.position && r.position)
    out.note += fmt::format("Standing first adds {:+.3f} (SE {:.3f}) to the log-worth, p {}.", *r.worths.position,
                            *r.worths.position_se, p_text(r.position->p));
  return out;
}

// "slope 0.9 (0.7 to 1.2)".
std::string with_interval(const std::optional<double>& value, const std::optional<Interval>& interval) {
  if (!value) return "-";
  return interval ? fmt::format("{:.2f} ({:.2f} to {:.2f})", *value, interval->low, interval->high)
                  : fmt::format("{:.2f}", *value);
}

Section prediction(const ScorePredictions& p, const AnalysisSettings& s) {
  Section out{Topic::prediction, "Which score predicts the answers"};
  out.lead = fmt::format(
      "{} to {}{}. AUC: the chance that a score tells an answer yes from an answer no; 0.5 is guessing. Calibration of "
      "predictions for each stimulus by a logistic regression over all others: right at slope 1 and intercept 0. "
      "Intervals ({:.0f} %): bootstrap over {}stimuli.",
      counted(p.answers, "answer", "answers"), counted(p.stimuli, "stimulus", "stimuli"),
      p.participants > 0 ? " by " + counted(p.participants, "participant", "participants") : "", 100 * s.confidence,
      p.participants > 1 ? "participants and " : "");
  if (p.without_scores > 0)
    out.lead += fmt::format(" Left out for want of scores: {}.", counted(p.without_scores, "answer", "answers"));
  out.table = TextTable{{"score", "a yes is likelier where it is", "AUC", "calibration slope", "intercept"}, 2, {}};
  for (const ScorePrediction& one : p.scores) {
    const bool fitted = one.state == PredictionState::fitted;
    out.table->rows.push_back({named(one.score),
                               fitted ? (one.falls ? "low" : "high") : std::string(state_text(one.state)),
                               fitted ? with_interval(one.auc, one.auc_interval) : "-",
                               with_interval(one.calibration_slope, one.slope_interval),
                               with_interval(one.calibration_intercept, one.intercept_interval)});
  }
  for (const ScoreContest& c : p.contests) {
    const std::string pair = fmt::format("{} against {}", named(p.scores[c.a].score), named(p.scores[c.b].score));
    if (c.interval)
      out.list.push_back(fmt::format("{}: {} (difference of AUC {:+.3f}, {:+.3f} to {:+.3f}, for all pairs at once)",
                                     pair, c.distinguishable ? "the first predicts better" : "not distinguishable",
                                     c.difference, c.interval->low, c.interval->high));
  }
  return out;
}

void add(std::vector<Section>& to, std::optional<Section> section) {
  if (section) to.push_back(std::move(*section));
}

TaskText task_text_of(const TaskResult& t, const AnalysisSettings& s) {
  TaskText out{t.name.empty() ? "Answers by condition" : named(t.name), verdict_sentences(t, s), {}};
  out.sections.push_back(shares(t, s));
  add(out.sections, equivalences(t, s));
  add(out.sections, differences(t, s));
  add(out.sections, detections(t));
  add(out.sections, curves(t, s));
  for (const MixedResult& m : t.mixed) out.sections.push_back(mixed(m, s));
  if (t.ranking) out.sections.push_back(ranking(*t.ranking));
  if (t.prediction) out.sections.push_back(prediction(*t.prediction, s));
  return out;
}

std::string who_is_excluded(const Analysis& a) {
  if (a.catch_rows == 0) return "No catch trial is among the answers that count.";
  std::string out = fmt::format("Set aside: {}.", counted(a.catch_rows, "catch trial", "catch trials"));
  if (a.left_out.hidden_catch > 0)
    out += fmt::format(" {} of them, during which the page was out of sight, {} as wrong.", a.left_out.hidden_catch,
                       a.left_out.hidden_catch == 1 ? "counts" : "count");
  if (a.excluded.empty()) return out + " Nobody is excluded.";
  out += fmt::format(" Excluded, with fewer than {:.0f} % of them right:", 100 * a.settings.catch_least);
  for (const Exclusion& e : a.excluded)
    out += fmt::format(" {} ({} of {}){}", named(e.participant), e.right, e.of, &e == &a.excluded.back() ? "." : ",");
  return out;
}

std::string what_is_left_out(const LeftOut& l, const TrialRules& rules) {
  std::string out;
  if (l.fast > 0)
    out += fmt::format(" Left out, answered within {:g} ms: {}.", rules.shortest_rt_ms,
                       counted(l.fast, "trial", "trials"));
  if (l.dropped > 0)
    out += fmt::format(" Left out, with more than {} not shown: {}.",
                       counted(rules.most_frames_dropped.value_or(0), "frame", "frames"),
                       counted(l.dropped, "trial", "trials"));
  if (l.hidden > 0)
    out += fmt::format(" Left out, with the page out of sight: {}.", counted(l.hidden, "trial", "trials"));
  return out;
}

}  // namespace

AnalysisText analysis_text(const Analysis& a) {
  AnalysisText out;
  out.who = a.simulated_rows == 0        ? "people"
            : a.simulated_rows == a.rows ? "simulated observers"
                                         : "people and simulated observers";
  if (a.simulated_rows > 0)
    out.lead.push_back(
        fmt::format("SIMULATED: {} of {} were answered by simulated observers. They say nothing of people.",
                    a.simulated_rows, counted(a.rows, "row", "rows")));
  if (a.answers.studies.size() > 1)
    out.lead.push_back(fmt::format("The answers are of {} studies, by the column `study`, and are analysed as of one.",
                                   a.answers.studies.size()));
  const std::string participants =
      a.participants > 0 ? " of " + counted(a.participants, "participant", "participants") : "";
  out.lead.push_back(fmt::format("{}{}. {}{}", counted(a.rows, "row", "rows"), participants, who_is_excluded(a),
                                 what_is_left_out(a.left_out, a.settings.trials)));
  out.lead.push_back(
      fmt::format("\"Cannot tell\": {}. P values are two-sided and exact against {:g}; those of trials take trials for "
                  "independent, "
                  "which those of one participant are not: the mixed model does not.",
                  a.settings.ties == TieRule::drop    ? "left out"
                  : a.settings.ties == TieRule::split ? "half for, half against; in shares and exact tests, "
                                                        "which count whole trials, one of an odd number is left out"
                                                      : "counted as no",
                  a.settings.chance));
  for (const TaskResult& t : a.tasks) out.tasks.push_back(task_text_of(t, a.settings));
  return out;
}

}  // namespace crowdbench::studies
