#include "studies/analysis/analysis.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <set>

#include "core/error.h"
#include "core/multiple_tests.h"
#include "core/probability.h"

namespace crowdbench::studies {
namespace {

using Rows = std::vector<const Answer*>;

constexpr size_t kMostBootstrapItems = 20;  // of which every two were compared: a minute

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

bool is_paired(const Rows& rows) { return rows.front()->item_a.has_value(); }

std::map<uint32_t, Rows> by_participant(const Rows& rows) {
  std::map<uint32_t, Rows> out;
  for (const Answer* row : rows)
    if (row->participant) out[*row->participant].push_back(row);
  return out;
}

std::string condition_name(const Answers& answers, const Answer& row) {
  return row.condition ? answers.conditions[*row.condition] : "";
}

// Rows by condition and, of comparisons, by pair, in the order of their first row. Within a pair all rows have one
// order of the two items: `turned` holds those that had to be turned around.
struct Groups {
  std::vector<std::pair<std::string, Rows>> all;
  std::vector<std::unique_ptr<Answer>> turned;
};
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

// ---- shares

std::optional<SignalDetection> detection_of(const Rows& rows, TieRule rule) {
  Rows signals;
  Rows noises;
  for (const Answer* row : rows)
    if (row->signal) (*row->signal ? signals : noises).push_back(row);
  const Decided hit = decided(signals, rule);
  const Decided alarm = decided(noises, rule);
  return signal_detection(hit.yes, hit.of, alarm.yes, alarm.of);
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
  // One participant's trials say nothing of others.
  if (shares.size() == 1 && !by_participant(rows).empty()) {
    out.verdict = Verdict::not_enough_data;
    out.more_participants = std::max<uint64_t>(1, out.more_participants);
  }
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

// Every two conditions whose answers are alike enough to be compared.
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
      p.push_back(out.back().equivalence.different_score);
    }
  const std::vector<double> corrected = holm(p);
  for (size_t i = 0; i < out.size(); ++i) out[i].holm = corrected[i];
  return out;
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

// ---- curves

std::vector<Level> levels_of(const Rows& rows, TieRule rule) {
  std::map<double, std::array<uint64_t, 3>> counts;
  for (const Answer* row : rows) {
    auto& [yes, ties, no] = counts[*row->level];
    yes += row->yes;
    ties += row->ties;
    no += row->no;
  }
  std::vector<Level> out;
  for (const auto& [x, c] : counts) {
    const Decided d = decided(c[0], c[1], c[2], rule);
    out.push_back({x, d.yes, d.of});
  }
  return out;
}

CurveResult curve_of(const std::string& name, const Rows& rows, const AnalysisSettings& s) {
  CurveResult out;
  out.condition = name;
  const std::vector<Level> levels = levels_of(rows, s.ties);
  CurveSettings settings = s.curve;
  settings.confidence = s.confidence;
  out.fit = fit_curve(levels, settings);
  std::vector<std::vector<Level>> people;
  for (const auto& [participant, theirs] : by_participant(rows)) people.push_back(levels_of(theirs, s.ties));
  if (people.size() < 2) people.clear();
  out.by_participant = !people.empty();
  out.bootstrap = bootstrap_threshold(out.fit, levels, people, settings, s.seed, s.resamples);
  return out;
}

// ---- mixed models

MixedSettings mixed_settings(const Rows& rows, const AnalysisSettings& s, bool with_level) {
  MixedSettings out;
  out.link = s.link;
  out.guess = with_level && s.curve.guess_rate == Rate::fixed ? s.curve.guess : 0;
  out.slopes = with_level && (s.random == RandomEffects::slope || s.random == RandomEffects::independent_slope);
  out.correlated = s.random == RandomEffects::slope;
  std::set<uint32_t> clips;
  for (const Answer* row : rows)
    if (row->clip) clips.insert(*row->clip);
  out.clips = clips.size() > 1;
  const bool scalar = !out.slopes && !out.clips;
  out.integration = s.integration.value_or(scalar ? Integration::quadrature : Integration::laplace);
  // Quadrature over two dimensions is not offered: the Laplace of the same information stands in.
  if (!scalar && out.integration == Integration::quadrature) out.integration = Integration::laplace_observed;
  return out;
}

// conditions: those that get a contrast to the first; none where they are fitted apart.
MixedResult mixed_of(const std::string& name, const Rows& rows, const std::vector<uint32_t>& conditions,
                     const Answers& answers, const AnalysisSettings& s) {
  MixedResult out;
  out.condition = name;
  const bool with_level = rows.front()->level.has_value();
  out.settings = mixed_settings(rows, s, with_level);
  out.effects = {"intercept"};
  if (with_level) out.effects.emplace_back("level");
  for (size_t i = 1; i < conditions.size(); ++i) out.effects.push_back(answers.conditions[conditions[i]]);
  std::map<uint32_t, uint32_t> participants;
  std::map<uint32_t, uint32_t> clips;
  std::vector<MixedRow> data;
  for (const Answer* row : rows) {
    const Decided d = decided(row->yes, row->ties, row->no, s.ties);
    if (d.of == 0 || !row->participant) continue;
    MixedRow one{.yes = d.yes, .of = d.of};
    one.participant = participants.emplace(*row->participant, static_cast<uint32_t>(participants.size())).first->second;
    if (out.settings.clips)
      one.clip = clips.emplace(row->clip.value_or(0), static_cast<uint32_t>(clips.size())).first->second;
    one.fixed.assign(out.effects.size(), 0);
    one.fixed[0] = 1;
    if (with_level) one.fixed[1] = one.slope = *row->level;
    for (size_t i = 1; i < conditions.size(); ++i)
      one.fixed[(with_level ? 1 : 0) + i] = row->condition == conditions[i] ? 1 : 0;
    data.push_back(std::move(one));
  }
  out.fit = fit_mixed(data, out.settings);
  if (out.fit.state != MixedState::fitted && out.fit.state != MixedState::singular) return out;
  if (with_level) {
    out.ratio = likelihood_ratio(data, out.settings, out.fit, 1);
    out.threshold = mixed_threshold(out.fit, out.settings, s.curve.level, s.confidence);
  } else if (out.effects.size() == 1) {
    out.population = population_probability(out.fit, out.settings, {1});
  }
  return out;
}

std::vector<MixedResult> mixed_models(const Answers& answers, const Rows& rows, const Groups& groups,
                                      const AnalysisSettings& s) {
  std::vector<MixedResult> out;
  if (s.random == RandomEffects::none || !rows.front()->participant) return out;
  if (rows.front()->level || !rows.front()->condition) {
    for (const auto& [name, theirs] : groups.all) out.push_back(mixed_of(name, theirs, {}, answers, s));
    return out;
  }
  std::vector<uint32_t> conditions;
  for (const Answer* row : rows)
    if (std::find(conditions.begin(), conditions.end(), *row->condition) == conditions.end())
      conditions.push_back(*row->condition);
  out.push_back(mixed_of("", rows, conditions, answers, s));
  return out;
}

// ---- ranking

// Items of a task, by their place in Answers::items: those of others and of catch trials are not in its ranking.
using Places = std::map<uint32_t, uint32_t>;
Places places_of(const Rows& rows) {
  Places out;
  for (const Answer* row : rows)
    for (const uint32_t item : {*row->item_a, *row->item_b}) out.emplace(item, 0U);
  uint32_t next = 0;
  for (auto& [item, place] : out) place = next++;
  return out;
}

Wins wins_of(const Rows& rows, const Places& places) {
  Wins out(places.size(), std::vector<double>(places.size(), 0));
  for (const Answer* row : rows) {
    const double half = static_cast<double>(row->ties) / 2;
    const size_t a = places.at(*row->item_a);
    const size_t b = places.at(*row->item_b);
    out[a][b] += static_cast<double>(row->yes) + half;
    out[b][a] += static_cast<double>(row->no) + half;
  }
  return out;
}

RankingResult ranking_of(const Answers& answers, const Rows& rows, const AnalysisSettings& s) {
  RankingResult out;
  std::set<std::string> conditions;
  for (const Answer* row : rows) conditions.insert(condition_name(answers, *row));
  out.conditions = conditions.size();
  const Places places = places_of(rows);
  for (const auto& [item, place] : places) out.items.push_back(answers.items[item]);
  std::vector<Comparison> comparisons;
  for (const Answer* row : rows)
    comparisons.push_back(
        {places.at(*row->item_a), places.at(*row->item_b), row->shown_first_is_a, row->yes, row->ties, row->no});
  const auto known = static_cast<size_t>(
      std::count_if(rows.begin(), rows.end(), [](const Answer* row) { return row->shown_first_is_a.has_value(); }));
  if (known != 0 && known != rows.size())
    throw Error(answers.sources.front(), "says of some comparisons only which item stood first",
                "name the column `shown_first` of every table, or of none");
  out.worths = fit_worths(comparisons, out.items.size(), known > 0);
  if (known > 0 && out.worths.state == WorthState::fitted) {
    const Worths without = fit_worths(comparisons, out.items.size(), false);
    const double chi_squared = std::max(0.0, 2 * (out.worths.log_likelihood - without.log_likelihood));
    out.position = LikelihoodRatio{chi_squared, chi_squared_tail(chi_squared, 1)};
  }
  const Wins wins = wins_of(rows, places);
  out.jod = fit_jod(wins, JodPrior::none);
  out.jod_with_prior = fit_jod(wins, JodPrior::gaussian);
  std::vector<Wins> people;
  for (const auto& [participant, theirs] : by_participant(rows)) people.push_back(wins_of(theirs, places));
  if (people.size() > 1 && s.resamples > 0 && out.items.size() <= kMostBootstrapItems &&
      out.jod_with_prior.state == WorthState::fitted)
    out.intervals =
        bootstrap_jod(people, bootstrap_draws(people.size(), s.resamples, s.seed), JodPrior::gaussian, s.confidence);
  return out;
}

// ---- objective scores

using Values = std::vector<std::optional<double>>;

// The stimuli that rows name, with their scores: rows of one stimulus have one name.
class Stimuli {
 public:
  Stimuli(const Answers& answers, const ScoreTable& scores) : answers_(answers), scores_(scores) {
    for (size_t i = 0; i < scores.keys.size(); ++i) of_[scores.keys[i]] = &scores.values[i];
  }
  // Nothing where the row does not say what the scores are of.
  std::optional<uint32_t> of(const Answer& row) {
    std::string name;
    Values values(scores_.scores.size());
    if (scores_.key == ScoreTable::Key::item) {
      if (!row.item_a) return std::nullopt;
      const std::string& a = answers_.items[*row.item_a];
      const std::string& b = answers_.items[*row.item_b];
      name = fmt::format("{}:{}{}", a.size(), a, b);
      if (const Values* x = find(a), *y = find(b); x != nullptr && y != nullptr)
        for (size_t s = 0; s < values.size(); ++s)
          if ((*x)[s] && (*y)[s]) values[s] = *(*x)[s] - *(*y)[s];
    } else {
      const auto& which = scores_.key == ScoreTable::Key::clip ? row.clip : row.condition;
      if (!which) return std::nullopt;
      name = (scores_.key == ScoreTable::Key::clip ? answers_.clips : answers_.conditions)[*which];
      if (const Values* found = find(name)) values = *found;
    }
    const auto [place, added] = index_.emplace(name, static_cast<uint32_t>(found_.values.size()));
    if (added) found_.values.push_back(std::move(values));
    return place->second;
  }
  PredictedAnswers& found() { return found_; }

 private:
  const Values* find(const std::string& name) const {
    const auto at = of_.find(name);
    return at == of_.end() ? nullptr : at->second;
  }
  const Answers& answers_;
  const ScoreTable& scores_;
  std::map<std::string, const Values*> of_;
  std::map<std::string, uint32_t> index_;
  PredictedAnswers found_;
};

// groups: their rows, in which every pair of items has one order.
ScorePredictions prediction_of(const Answers& answers, const Groups& groups, const AnalysisSettings& s,
                               const ScoreTable& scores) {
  Stimuli stimuli(answers, scores);
  PredictedAnswers& found = stimuli.found();
  found.comparisons = scores.key == ScoreTable::Key::item;
  std::map<uint32_t, uint32_t> participants;
  for (const auto& [name, rows] : groups.all)
    for (const Answer* row : rows) {
      const Decided d = decided(row->yes, row->ties, row->no, s.ties);
      const std::optional<uint32_t> stimulus = stimuli.of(*row);
      if (d.of == 0 || !stimulus) continue;
      uint32_t participant = 0;
      if (row->participant)
        participant = participants.emplace(*row->participant, static_cast<uint32_t>(participants.size())).first->second;
      found.cells.push_back({participant, *stimulus, d.yes, d.of});
    }
  found.participants = participants.size();
  return predict_by_scores(scores.scores, found, s.confidence, s.seed, s.resamples);
}

// ---- all of a task

TaskResult task_of(const Answers& answers, const std::string& name, const Rows& rows, const AnalysisSettings& s,
                   const ScoreTable& scores) {
  TaskResult out;
  out.name = name;
  const bool paired = is_paired(rows);
  const Groups groups = groups_of(answers, rows, paired);
  for (const auto& [condition, theirs] : groups.all) out.conditions.push_back(condition_of(condition, theirs, s));
  correct_for_many(out.conditions);
  out.differences = differences_of(groups, out.conditions, s);
  if (!scores.empty()) out.prediction = prediction_of(answers, groups, s, scores);
  if (paired) {
    out.ranking = ranking_of(answers, rows, s);
    return out;
  }
  if (rows.front()->level)
    for (const auto& [condition, theirs] : groups.all) out.curves.push_back(curve_of(condition, theirs, s));
  out.mixed = mixed_models(answers, rows, groups, s);
  return out;
}

// All rows of a task answer in one form.
void require_one_form(const Answers& answers, const Rows& rows, const CurveSettings& curve) {
  const Answer& first = *rows.front();
  for (const Answer* row : rows) {
    const std::string where = fmt::format("{}:{}", answers.sources[row->source], row->line);
    if (row->item_a.has_value() != first.item_a.has_value() || row->level.has_value() != first.level.has_value() ||
        row->condition.has_value() != first.condition.has_value() ||
        row->participant.has_value() != first.participant.has_value())
      throw Error(where, "has other columns than the rows before it", "give tables of one task the same columns");
    if (curve.curve == Curve::weibull && row->level && *row->level < 0)
      throw Error(where, fmt::format("level {} is below 0, where Weibull's function is not defined", *row->level),
                  "choose --curve logistic or cumgauss");
  }
}

std::string task_text(const Answers& answers, const Rows& rows) {
  return rows.front()->task ? fmt::format(" of task '{}'", printable(answers.tasks[*rows.front()->task], 60)) : "";
}

// What nobody could read and no machine fit in a minute is refused before anything is computed.
void require_few(const Answers& answers, const Rows& rows, const AnalysisSettings& s) {
  std::map<std::optional<uint32_t>, std::set<double>> levels;
  std::set<uint32_t> items;
  std::set<uint32_t> participants;
  std::set<uint32_t> clips;
  for (const Answer* row : rows) {
    std::set<double>& of_condition = levels[row->condition];
    if (row->level) of_condition.insert(*row->level);
    if (row->item_a) items.insert({*row->item_a, *row->item_b});
    if (row->participant) participants.insert(*row->participant);
    if (row->clip) clips.insert(*row->clip);
  }
  size_t most_levels = 0;
  for (const auto& [condition, each] : levels) most_levels = std::max(most_levels, each.size());
  const auto refuse = [&](size_t count, size_t most, const char* what, const char* advice) {
    if (count > most)
      throw Error(answers.sources[rows.front()->source],
                  fmt::format("the answers{} have {} {}, and at most {} are analysed", task_text(answers, rows), count,
                              what, most),
                  advice);
  };
  refuse(levels.size(), kMostTaskConditions, "conditions", "join some of them, or take them in parts by --where");
  refuse(items.size(), kMostItems, "items", "take them in parts by --where");
  refuse(most_levels, kMostLevels, "levels in one condition", "round the levels to fewer");
  const bool crossed = clips.size() > 1 || s.random == RandomEffects::slope;
  if (s.random != RandomEffects::none && !participants.empty() && crossed && items.empty())
    refuse(participants.size() + clips.size(), kMostMixedNames, "participants and clips",
           "leave the mixed model out by --random none");
}

// Of every task one result, in the order of their first rows.
void analyse_tasks(Analysis& out, const ScoreTable& scores) {
  const Answers& answers = out.answers;
  std::map<uint32_t, Rows> tasks;
  std::set<uint32_t> participants;
  for (const Answer& row : answers.rows) {
    tasks[row.task.value_or(0)].push_back(&row);
    if (row.participant) participants.insert(*row.participant);
  }
  out.participants = participants.size();
  for (const auto& [task, rows] : tasks) {
    require_one_form(answers, rows, out.settings.curve);
    require_few(answers, rows, out.settings);
  }
  bool any_scored = false;
  for (const auto& [task, rows] : tasks) {
    out.tasks.push_back(task_of(answers, answers.tasks.empty() ? "" : answers.tasks[task], rows, out.settings, scores));
    const auto& prediction = out.tasks.back().prediction;
    any_scored = any_scored || (prediction && prediction->answers > 0);
  }
  if (!scores.empty() && !any_scored)
    throw Error(scores.source, "has scores of nothing that the answers name",
                "its first column names clips, conditions or items as the answers do");
}

}  // namespace

Decided decided(uint64_t yes, uint64_t ties, uint64_t no, TieRule rule) {
  if (rule == TieRule::no) return {yes, yes + ties + no};
  if (rule == TieRule::split) return {yes + ties / 2, yes + no + ties / 2 * 2};
  return {yes, yes + no};
}

Analysis analyse(Answers answers, const AnalysisSettings& settings, const ScoreTable& scores) {
  Analysis out;
  out.settings = settings;
  out.sources = answers.sources;
  const auto is_catch = [](const Answer& row) { return !row.catch_kind.empty(); };
  out.catch_rows = static_cast<size_t>(std::count_if(answers.rows.begin(), answers.rows.end(), is_catch));
  out.left_out = leave_out(answers, settings.trials);
  out.excluded = exclude_by_catch(answers, settings.catch_least);
  out.rows = answers.rows.size();
  if (answers.rows.empty())
    throw Error(out.sources.empty() ? "" : out.sources.front(), "no answers are left to analyse",
                fmt::format("participants excluded by their catch trials: {}; trials left out: {}; see --catch-least",
                            out.excluded.size(), out.left_out.fast + out.left_out.dropped + out.left_out.hidden));
  out.answers = std::move(answers);
  analyse_tasks(out, scores);
  return out;
}

}  // namespace crowdbench::studies
