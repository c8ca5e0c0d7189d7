#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "studies/analysis/analysis_output.h"

namespace crowdbench::studies {
namespace {

// A name from a file, within a table's cell.
std::string cell(const std::string& name) {
  std::string out;
  for (const char c : printable(name, 80)) {
    if (c == '|' || c == '<' || c == '`' || c == '[' || c == '*' || c == '_' || c == '\\') out += '\\';
    out += c;
  }
  return out.empty() ? "all" : out;
}

std::string percent(uint64_t part, uint64_t whole) {
  return whole == 0 ? "-" : fmt::format("{:.0f} %", 100 * static_cast<double>(part) / static_cast<double>(whole));
}
std::string p_text(double p) { return p < 0.001 ? "< 0.001" : fmt::format("{:.3f}", p); }
std::string number(std::optional<double> value) { return value ? fmt::format("{:.4g}", *value) : "-"; }
// Ends that are not there are open.
std::string ends_text(const std::optional<double>& low, const std::optional<double>& high) {
  return fmt::format("{} to {}", low ? number(low) : "below all", high ? number(high) : "above all");
}

std::string shares(const TaskResult& t, const AnalysisSettings& s) {
  std::string out = fmt::format(
      "| condition | participants | yes | cannot tell | no | chosen / decided | {:.0f} % exact | p | p (Holm) |\n"
      "|---|--:|--:|--:|--:|--:|--:|--:|--:|\n",
      100 * s.confidence);
  for (const ConditionResult& c : t.conditions) {
    const uint64_t all = c.yes + c.ties + c.no;
    out += fmt::format("| {} | {} | {} ({}) | {} ({}) | {} ({}) | ", cell(c.name),
                       c.participants > 0 ? fmt::format("{}", c.participants) : "-", c.yes, percent(c.yes, all), c.ties,
                       percent(c.ties, all), c.no, percent(c.no, all));
    if (c.decided == 0)
      out += "no data | - | - | - |\n";
    else
      out += fmt::format("{} / {} ({}) | {:.3f} to {:.3f} | {} | {} |\n", c.chosen, c.decided,
                         percent(c.chosen, c.decided), c.exact.low, c.exact.high,
                         c.is_tested() ? p_text(c.test.two_sided) : "-", c.is_tested() ? p_text(c.holm) : "-");
  }
  return out;
}

std::string needed(const Equivalence& e) {
  if (e.verdict != Verdict::not_enough_data) return "";
  if (e.more_participants > 0) return fmt::format("{} more participants", e.more_participants);
  if (e.more_trials > 0) return fmt::format("{} more trials", e.more_trials);
  return "enough for the power asked for; it did not come out";
}

std::string equivalences(const TaskResult& t, const AnalysisSettings& s) {
  if (!s.margin) return "";
  std::string out = fmt::format(
      "\nEquivalence to {:g}, margin {:g}: two one-sided tests at {:g}, of trials and of participants; both must "
      "hold.\n\n"
      "| condition | verdict | p of trials | p of participants | {:.0f} % of the mean share | still needed |\n"
      "|---|---|--:|--:|--:|---|\n",
      s.chance, *s.margin, s.alpha, 100 * (1 - 2 * s.alpha));
  for (const ConditionResult& c : t.conditions) {
    if (!c.equivalence) continue;
    const Equivalence& e = *c.equivalence;
    out +=
        fmt::format("| {} | {} | {} | {} | {} | {} |\n", cell(c.name), verdict_text(e.verdict), p_text(e.exact.p),
                    e.by_participant ? p_text(e.by_participant->p) : "-",
                    e.interval ? fmt::format("{:.3f} to {:.3f}", e.interval->low, e.interval->high) : "-", needed(e));
  }
  return out;
}

std::string detections(const TaskResult& t) {
  std::string rows;
  for (const ConditionResult& c : t.conditions)
    if (c.detection)
      rows += fmt::format("| {} | {:.3f} ({:.3f}) | {:.3f} ({:.3f}) |\n", cell(c.name), c.detection->d_prime,
                          c.detection->d_prime_se, c.detection->criterion, c.detection->criterion_se);
  return rows.empty() ? "" : "\n| condition | d' (SE) | criterion (SE) |\n|---|--:|--:|\n" + rows;
}

std::string curves(const TaskResult& t, const AnalysisSettings& s) {
  if (t.curves.empty()) return "";
  std::string out = fmt::format(
      "\nPsychometric function: {}{}, threshold at {:g}.\n\n"
      "| condition | state | threshold | by likelihood | by bootstrap | location | scale | guess | lapse | deviance |\n"
      "|---|---|--:|--:|--:|--:|--:|--:|--:|--:|\n",
      curve_name(s.curve.curve), s.curve.falling ? ", falling" : "", s.curve.level);
  for (const CurveResult& c : t.curves) {
    const CurveFit& f = c.fit;
    if (f.state != CurveState::fitted && f.state != CurveState::step) {
      out += fmt::format("| {} | {} | {} | - | - | - | - | - | - | - |\n", cell(c.condition), state_text(f.state),
                         number(f.threshold));
      continue;
    }
    std::string bootstrap = "-";
    if (c.bootstrap)
      bootstrap = c.bootstrap->open
                      ? "open"
                      : fmt::format("{:.4g} to {:.4g}", c.bootstrap->threshold.low, c.bootstrap->threshold.high);
    out += fmt::format("| {} | {} | {} | {} | {} | {:.4g} | {:.4g} | {:.3g} | {:.3g} | {:.2f} |\n", cell(c.condition),
                       state_text(f.state), number(f.threshold),
                       ends_text(f.threshold_profile.low, f.threshold_profile.high), bootstrap, f.at.location,
                       f.at.scale, f.at.guess, f.at.lapse, f.deviance);
  }
  return out;
}

std::string mixed(const TaskResult& t) {
  std::string out;
  for (const MixedResult& m : t.mixed) {
    out += fmt::format("\nMixed-effects {} regression{}{}: {}, {} answers of {} participants.\n",
                       m.settings.link == Link::logit ? "logistic" : "probit", m.condition.empty() ? "" : ", ",
                       m.condition.empty() ? "" : cell(m.condition), state_text(m.fit.state), m.fit.answers,
                       m.fit.participants);
    if (m.fit.fixed.empty()) continue;
    out += "\n| effect | estimate | SE | z | p |\n|---|--:|--:|--:|--:|\n";
    for (size_t i = 0; i < m.effects.size(); ++i) {
      const MixedEffect& e = m.fit.fixed[i];
      out += fmt::format("| {} | {:.4f} | {:.4f} | {:.2f} | {} |\n", cell(m.effects[i]), e.estimate, e.se, e.z,
                         p_text(e.p));
    }
    out += fmt::format("\nVariance of participants {:.4g}", m.fit.participant_variance);
    if (m.fit.slope_variance) out += fmt::format(", of their slopes {:.4g}", *m.fit.slope_variance);
    if (m.fit.clip_variance) out += fmt::format(", of clips {:.4g}", *m.fit.clip_variance);
    out += fmt::format("; log-likelihood {:.3f}.", m.fit.log_likelihood);
    if (m.threshold)
      out += fmt::format(
          " The typical participant's threshold: {:.4g} ({}).", m.threshold->at,
          m.threshold->interval ? ends_text(m.threshold->interval->low, m.threshold->interval->high) : "open");
    if (m.population)
      out += fmt::format(" Share of the typical participant {:.3f}, average {:.3f}.", m.population->typical,
                         m.population->average);
    out += "\n";
  }
  return out;
}

std::string ranking(const RankingResult& r) {
  std::string out = r.conditions > 1 ? fmt::format("\nRanking over all {} conditions together", r.conditions)
                                     : std::string("\nRanking");
  out += fmt::format(": {}.\n", state_text(r.worths.state));
  const bool worths = r.worths.state == WorthState::fitted;
  if (!worths && r.worths.groups.size() > 1) {
    out += "There is no one scale for these groups of items:\n\n";
    for (const auto& group : r.worths.groups) {
      out += "-";
      for (const uint32_t item : group) out += " " + cell(r.items[item]) + (item == group.back() ? "" : ",");
      out += "\n";
    }
  }
  if (!worths && r.jod_with_prior.state != WorthState::fitted) return out;
  out +=
      "\n| item | log worth (SE) | worth | JOD, maximum likelihood | JOD with prior | interval "
      "|\n|---|--:|--:|--:|--:|--:|\n";
  for (size_t i = 0; i < r.items.size(); ++i)
    out += fmt::format("| {} | {} | {} | {} | {} | {} |\n", cell(r.items[i]),
                       worths ? fmt::format("{:+.3f} ({:.3f})", r.worths.log_worth[i], r.worths.se[i]) : "-",
                       worths ? fmt::format("{:.3f}", r.worths.worth[i]) : "-",
                       r.jod.q.empty() ? "-" : fmt::format("{:+.3f}", r.jod.q[i]),
                       r.jod_with_prior.q.empty() ? "-" : fmt::format("{:+.3f}", r.jod_with_prior.q[i]),
                       r.intervals && !r.intervals->q.empty()
                           ? fmt::format("{:+.3f} to {:+.3f}", r.intervals->q[i].low, r.intervals->q[i].high)
                           : "-");
  if (r.worths.log_nu) out += fmt::format("\nTies: nu {:.3f}.", std::exp(*r.worths.log_nu));
  if (r.worths.position && r.position)
    out += fmt::format("\nStanding first adds {:+.3f} (SE {:.3f}) to the log-worth, p {}.", *r.worths.position,
                       *r.worths.position_se, p_text(r.position->p));
  return out + "\n";
}

std::string excluded(const Analysis& a) {
  if (a.catch_rows == 0) return "There were no catch trials.";
  std::string out = fmt::format("{} catch trials are set aside.", a.catch_rows);
  if (a.excluded.empty()) return out + " Nobody is excluded.";
  out += fmt::format(" Excluded, with fewer than {:.0f} % of them right:", 100 * a.settings.catch_least);
  for (const Exclusion& e : a.excluded)
    out += fmt::format(" {} ({} of {}){}", cell(e.participant), e.right, e.of, &e == &a.excluded.back() ? "." : ",");
  return out;
}

}  // namespace

std::string analysis_markdown(const Analysis& a) {
  std::string out = fmt::format(
      "# Answers\n\n{} rows{}. {} \"Cannot tell\": {}. P values are two-sided and exact against {:g}; those of trials "
      "take "
      "trials for independent, which those of one participant are not: the mixed model does not.\n",
      a.rows, a.participants > 0 ? fmt::format(" of {} participants", a.participants) : "", excluded(a),
      a.settings.ties == TieRule::drop    ? "left out"
      : a.settings.ties == TieRule::split ? "half for, half against"
                                          : "counted as no",
      a.settings.chance);
  for (const TaskResult& t : a.tasks) {
    out += fmt::format("\n## {}\n\n", t.name.empty() ? "Answers by condition" : cell(t.name));
    out += shares(t, a.settings) + equivalences(t, a.settings) + detections(t) + curves(t, a.settings) + mixed(t);
    if (t.ranking) out += ranking(*t.ranking);
  }
  return out;
}

}  // namespace crowdbench::studies
