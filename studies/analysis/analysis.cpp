#include "studies/analysis/analysis.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "core/error.h"
#include "studies/analysis/analysis_parts.h"

namespace crowdbench::studies {
namespace {

using parts::Groups;
using parts::Rows;

TaskResult task_of(const Answers& answers, const std::string& name, const Rows& rows, const AnalysisSettings& s,
                   const ScoreTable& scores) {
  TaskResult out;
  out.name = name;
  const bool paired = rows.front()->item_a.has_value();
  const Groups groups = parts::groups_of(answers, rows, paired);
  out.conditions = parts::conditions_of(answers, groups, s);
  out.differences = parts::differences_of(groups, out.conditions, s);
  if (!scores.empty()) out.prediction = parts::prediction_of(answers, groups, s, scores);
  if (paired) {
    out.ranking = parts::ranking_of(answers, rows, s);
    return out;
  }
  out.side = parts::side_of(rows, s);
  if (rows.front()->level) out.curves = parts::curves_of(groups, s);
  out.mixed = parts::mixed_models(answers, rows, groups, out.curves, s);
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
    if (row.simulated) ++out.simulated_rows;
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
  if (scores.empty() || any_scored) return;
  const auto paired = [](const auto& task) { return task.second.front()->item_a.has_value(); };
  if (scores.key != ScoreTable::Key::item && std::all_of(tasks.begin(), tasks.end(), paired))
    throw Error(scores.source, "has scores of what was shown, which do not say which of two items is chosen",
                "give a table of scores of items, with a column `item`");
  throw Error(scores.source, "has scores of nothing that the answers name",
              "the answers need the column (`stimulus`, `clip`, `condition`; items of pairs) that the scores are of");
}

// Stimuli have the same ids in every study.
void require_scores_of_these(const ScoreTable& scores, const Answers& answers) {
  const auto& known = answers.studies;
  if (scores.study.empty() || known.empty() || std::find(known.begin(), known.end(), scores.study) != known.end())
    return;
  throw Error(scores.source,
              fmt::format("is of the study {}, and the answers are of {}", printable(scores.study.substr(0, 12)),
                          printable(known.front().substr(0, 12))),
              "give the study.json of the export that was answered");
}

}  // namespace

Decided decided(uint64_t yes, uint64_t ties, uint64_t no, TieRule rule) {
  if (rule == TieRule::no) return {yes, yes + ties + no};
  if (rule == TieRule::split) return {yes + ties / 2, yes + no + ties / 2 * 2};
  return {yes, yes + no};
}

Counted counted(uint64_t yes, uint64_t ties, uint64_t no, TieRule rule) {
  if (rule == TieRule::split) return {yes, yes + ties + no, ties};
  const Decided d = decided(yes, ties, no, rule);
  return {d.yes, d.of, 0};
}

LevelAxis axis_of_factor(const std::string& factor) { return {factor, factor.ends_with("_px")}; }

std::string axis_unit(const LevelAxis& axis) {
  if (axis.in_pixels) return "pixels";
  return axis.name.ends_with("_m") ? "m" : "";
}

std::string axis_title(const LevelAxis& axis) {
  const std::string unit = axis_unit(axis);
  const std::string name = axis.name.empty() ? "level" : printable(axis.name, 60);
  return unit.empty() ? name : fmt::format("{} ({})", name, unit);
}

std::optional<ThresholdInterval> threshold_interval(const CurveResult& c) {
  if (!c.fit.threshold) return std::nullopt;
  const auto none = [](std::string why) { return ThresholdInterval{{}, {}, "", std::move(why)}; };
  const JackknifeState spread = c.jackknife ? c.jackknife->state : JackknifeState::alike;
  if (spread == JackknifeState::done) {
    const bool over_clips = c.jackknife->clips > 0;
    return ThresholdInterval{
        c.jackknife->threshold.low, c.jackknife->threshold.high,
        over_clips ? "jackknife over participants and clips" : "jackknife over participants",
        fmt::format("{} differ, and Student's t with {:.3g} degrees of freedom counts how few they are",
                    over_clips ? "participants and clips" : "participants", c.jackknife->degrees),
        over_clips};
  }
  if (spread == JackknifeState::too_few && c.participants > 1)
    return none(fmt::format("{} participants do not say how much people differ; that takes {}", c.participants,
                            kLeastJackknifeGroups));
  if (spread == JackknifeState::one_decides)
    return none("without one of the participants the others have no threshold");
  if (spread == JackknifeState::one_clip_decides) return none("without one of the clips the others have no threshold");
  const std::string why = c.participants == 1 ? "of this one participant, not of people"
                          : c.jackknife       ? "the participants' answers show no spread between them"
                                              : "it is not known whose answers these are";
  if (c.bootstrap && !c.by_participant && c.bootstrap->has_interval())
    return ThresholdInterval{c.bootstrap->threshold.low, c.bootstrap->threshold.high, "parametric bootstrap", why};
  const CurveFit::Ends& ends = c.fit.threshold_profile;
  if (!ends.low && !ends.high) return none("the answers exclude no value");
  return ThresholdInterval{ends.low, ends.high, "profile likelihood", why};
}

Analysis analyse(Answers answers, const AnalysisSettings& settings, const ScoreTable& scores) {
  Analysis out;
  require_scores_of_these(scores, answers);
  out.settings = settings;
  out.sources = answers.sources;
  const auto is_catch = [](const Answer& row) { return !row.catch_kind.empty(); };
  out.left_out = leave_out(answers, settings.trials);
  out.catch_rows = static_cast<size_t>(std::count_if(answers.rows.begin(), answers.rows.end(), is_catch));
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
