// How the analysis of a task is put together: its rows by condition, and what is made of them. For the sources of this
// folder.
#pragma once
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "studies/analysis/analysis.h"

namespace crowdbench::studies::parts {

using Rows = std::vector<const Answer*>;

Decided decided(const Rows& rows, TieRule rule);
std::map<uint32_t, Rows> by_participant(const Rows& rows);
std::string condition_name(const Answers& answers, const Answer& row);

// Rows by condition and, of comparisons, by pair, in the order of their first row. Within a pair all rows have one
// order of the two items: `turned` holds those that had to be turned around.
struct Groups {
  std::vector<std::pair<std::string, Rows>> all;
  std::vector<std::unique_ptr<Answer>> turned;
};
Groups groups_of(const Answers& answers, const Rows& rows, bool pairs);

// Of every group, with Holm's correction over them.
std::vector<ConditionResult> conditions_of(const Answers& answers, const Groups& groups,
                                           const AnalysisSettings& settings);
// Every two conditions whose answers are alike enough to be compared.
std::vector<DifferenceResult> differences_of(const Groups& groups, const std::vector<ConditionResult>& conditions,
                                             const AnalysisSettings& settings);
std::vector<CurveResult> curves_of(const Groups& groups, const AnalysisSettings& settings);
// curves: of the same groups; a rate of guesses that they fit is held by the mixed models.
std::vector<MixedResult> mixed_models(const Answers& answers, const Rows& rows, const Groups& groups,
                                      const std::vector<CurveResult>& curves, const AnalysisSettings& settings);
// Nothing where the rows do not say it of both sides.
std::optional<SideResult> side_of(const Rows& rows, const AnalysisSettings& settings);
RankingResult ranking_of(const Answers& answers, const Rows& rows, const AnalysisSettings& settings);
ScorePredictions prediction_of(const Answers& answers, const Groups& groups, const AnalysisSettings& settings,
                               const ScoreTable& scores);

}  // namespace crowdbench::studies::parts
