// The rows of a task by condition, and the shares of answers of each.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "core/multiple_tests.h"
#include "core/probability.h"
#include "studies/analysis/analysis_parts.h"

namespace crowdbench::studies::parts {

Decided decided(const Rows& rows, TieRule rule) {
  uint64_t yes = 0;
  uint64_t ties = 0;
  uint64_t no = 0;
  for (const Answer* row : rows) {
    yes += row->yes;
    ties += row->ties;
    no += row->no;
  }
  return decided(yes, ties, no, rule);
}

std::map<uint32_t, Rows> by_participant(const Rows& rows) {
  std::map<uint32_t, Rows> out;
  for (const Answer* row : rows)
    if (row->participant) out[*row->participant].push_back(row);
  return out;
}

std::string condition_name(const Answers& answers, const Answer& row) {
  return row.condition ? answers.conditions[*row.condition] : "";
}

Groups groups_of(const Answers& answers, const Rows& rows, bool pairs) {
  Groups out;
  std::map<std::string, size_t> index;
  for (const Answer* row : rows) {
    std::string name = condition_name(answers, *row);
    if (pairs) {
      if (*row->item_a > *row->item_b) {
        out.turned.push_back(std::make_unique<Answer>(*row));
        Answer& other = *out.turned.back();
        std::swap(other.item_a, other.item_b);
        std::swap(other.yes, other.no);
        row = &other;
      }
      name += fmt::format("{}{} over {}", name.empty() ? "" : ": ", answers.items[*row->item_a],
                          answers.items[*row->item_b]);
    }
    const auto [found, added] = index.emplace(name, out.all.size());
    if (added) out.all.emplace_back(name, Rows{});
    out.all[found->second].second.push_back(row);
  }
  return out;
}

namespace {

std::optional<SignalDetection> detection_of(const Rows& rows, TieRule rule) {
  Rows signals;
  Rows noises;
  for (const Answer* row : rows)
    if (row->signal) (*row->signal ? signals : noises).push_back(row);
  const Decided hit = decided(signals, rule);
  const Decided alarm = decided(noises, rule);
  return signal_detection(hit.yes, hit.of, alarm.yes, alarm.of);
}

// A verdict takes the trials and the participants that it needs: as many more people as give the larger of the two,
// each of as many trials as those who are there had on average.
template <typename Result>
void require_both(Result& e, uint64_t trials, size_t participants) {
  if (e.verdict != Verdict::not_enough_data || participants == 0 || trials == 0) return;
  const double each = static_cast<double>(trials) / static_cast<double>(participants);
  const auto for_trials = static_cast<uint64_t>(std::ceil(static_cast<double>(e.more_trials) / each));
  e.more_participants = std::max(e.more_participants, for_trials);
}

std::optional<Equivalence> equivalence_of(const Rows& rows, const AnalysisSettings& s) {
  if (!s.margin) return std::nullopt;
  std::vector<Share> shares;
  for (const auto& [participant, theirs] : by_participant(rows))
    if (const Decided d = decided(theirs, s.ties); d.of > 0) shares.push_back({d.yes, d.of});
  if (shares.empty()) {
    const Decided all = decided(rows, s.ties);
    shares.push_back({all.yes, all.of});
  }
  Equivalence out =
      judge_equivalence(shares, {.chance = s.chance, .margin = *s.margin, .alpha = s.alpha, .power = s.power});
  if (by_participant(rows).empty()) return out;
  // One participant's trials say nothing of others.
  if (shares.size() == 1) {
    out.verdict = Verdict::not_enough_data;
    out.more_trials = still_needed(out.trials_needed, decided(rows, s.ties).of);
    out.more_participants = std::max<uint64_t>(1, out.more_participants);
  }
  require_both(out, decided(rows, s.ties).of, shares.size());
  return out;
}

ConditionResult condition_of(const std::string& name, const Rows& rows, const AnalysisSettings& s) {
  ConditionResult out;
  out.name = name;
  for (const Answer* row : rows) {
    out.yes += row->yes;
    out.ties += row->ties;
    out.no += row->no;
  }
  out.participants = by_participant(rows).size();
  const Decided d = decided(out.yes, out.ties, out.no, s.ties);
  out.chosen = d.yes;
  out.decided = d.of;
  out.detection = detection_of(rows, s.ties);
  if (d.of == 0) return out;
  out.exact = clopper_pearson(d.yes, d.of, s.confidence);
  out.score = wilson(d.yes, d.of, s.confidence);
  // "Yes" to a signal and "yes" without one are opposite answers: their share is no measure of anything but bias.
  if (out.detection) return out;
  out.test = binomial_test(d.yes, d.of, s.chance);
  out.equivalence = equivalence_of(rows, s);
  return out;
}

// "Different" among several is not what it was alone.
template <typename Result>
void require_corrected(Result& e, double holm, double alpha, uint64_t trials, uint64_t participants) {
  if (e.verdict != Verdict::different || holm <= alpha) return;
  e.verdict = Verdict::not_enough_data;
  e.more_trials = still_needed(e.trials_needed, trials);
  e.more_participants = still_needed(e.participants_needed, participants);
  require_both(e, trials, participants);
}

void correct_for_many(std::vector<ConditionResult>& conditions) {
  std::vector<double> p;
  for (const ConditionResult& c : conditions)
    if (c.is_tested()) p.push_back(c.test.two_sided);
  const std::vector<double> corrected = holm(p);
  size_t at = 0;
  for (ConditionResult& c : conditions)
    if (c.is_tested()) c.holm = corrected[at++];
}

}  // namespace

std::vector<ConditionResult> conditions_of(const Answers& answers, const Groups& groups, const AnalysisSettings& s) {
  std::vector<ConditionResult> out;
  for (const auto& [name, theirs] : groups.all) {
    out.push_back(condition_of(name, theirs, s));
    const Answer& row = *theirs.front();
    out.back().condition = condition_name(answers, row);
    if (!row.item_a) continue;
    out.back().first = answers.items[*row.item_a];
    out.back().second = answers.items[*row.item_b];
  }
  correct_for_many(out);
  for (ConditionResult& c : out)
    if (c.equivalence) require_corrected(*c.equivalence, c.holm, s.alpha, c.decided, c.participants);
  return out;
}

std::vector<DifferenceResult> differences_of(const Groups& groups, const std::vector<ConditionResult>& conditions,
                                             const AnalysisSettings& s) {
  std::vector<DifferenceResult> out;
  if (!s.between) return out;
  const EquivalenceSettings settings{.margin = *s.between, .alpha = s.alpha, .power = s.power};
  std::vector<std::map<uint32_t, Share>> shares(conditions.size());
  for (size_t i = 0; i < conditions.size(); ++i)
    for (const auto& [participant, theirs] : by_participant(groups.all[i].second)) {
      const Decided d = decided(theirs, s.ties);
      shares[i][participant] = {d.yes, d.of};
    }
  std::vector<double> p;
  for (size_t i = 0; i < conditions.size(); ++i)
    for (size_t j = i + 1; j < conditions.size(); ++j) {
      if (!conditions[i].is_tested() || !conditions[j].is_tested()) continue;
      const bool known = conditions[i].participants > 0;
      std::map<uint32_t, SharePair> pairs;
      for (const auto& [participant, share] : shares[i]) pairs[participant].first = share;
      for (const auto& [participant, share] : shares[j]) pairs[participant].second = share;
      std::vector<SharePair> all;
      for (const auto& [participant, pair] : pairs) all.push_back(pair);
      if (!known)
        all.push_back({{conditions[i].chosen, conditions[i].decided}, {conditions[j].chosen, conditions[j].decided}});
      out.push_back({i, j, judge_difference(all, known, settings)});
      require_both(out.back().equivalence, std::min(conditions[i].decided, conditions[j].decided),
                   out.back().equivalence.participants);
      p.push_back(out.back().equivalence.different_score);
    }
  const std::vector<double> corrected = holm(p);
  for (size_t i = 0; i < out.size(); ++i) {
    DifferenceResult& d = out[i];
    d.holm = corrected[i];
    require_corrected(d.equivalence, d.holm, s.alpha,
                      std::min(conditions[d.first].decided, conditions[d.second].decided), d.equivalence.participants);
  }
  return out;
}

std::optional<SideResult> side_of(const Rows& rows, const AnalysisSettings& s) {
  struct Side {
    double yes = 0, of = 0;
    double share() const { return yes / of; }
  };
  using Sides = std::array<Side, 2>;  // second, first
  Sides all;
  std::map<uint32_t, Sides> people;
  for (const Answer* row : rows) {
    if (!row->yes_first) continue;
    const Counted c = counted(row->yes, row->ties, row->no, s.ties);
    const auto add = [&](Side& to) {
      to.yes += static_cast<double>(c.yes) + static_cast<double>(c.halves) / 2;
      to.of += static_cast<double>(c.of);
    };
    add(all[*row->yes_first ? 1 : 0]);
    if (row->participant) add(people[*row->participant][*row->yes_first ? 1 : 0]);
  }
  const auto chosen_first = [](const Sides& of) { return (of[1].share() + 1 - of[0].share()) / 2; };
  if (all[0].of == 0 || all[1].of == 0) return std::nullopt;
  SideResult out{.first = static_cast<uint64_t>(all[1].of), .of = static_cast<uint64_t>(all[0].of + all[1].of)};
  out.share = (all[0].share() + all[1].share()) / 2;
  out.chosen_first = chosen_first(all);
  std::vector<double> each;
  for (const auto& [participant, sides] : people)
    if (sides[0].of > 0 && sides[1].of > 0) each.push_back(chosen_first(sides));
  out.participants = each.size();
  if (each.size() < 2) return out;
  const auto n = static_cast<double>(each.size());
  const double mean = std::accumulate(each.begin(), each.end(), 0.0) / n;
  double squares = 0;
  for (const double one : each) squares += (one - mean) * (one - mean);
  const double half = student_t_quantile(1 - (1 - s.confidence) / 2, n - 1) * std::sqrt(squares / (n - 1) / n);
  out.interval = Interval{std::clamp(std::min(mean - half, out.chosen_first), 0.0, 1.0),
                          std::clamp(std::max(mean + half, out.chosen_first), 0.0, 1.0)};
  return out;
}

}  // namespace crowdbench::studies::parts
