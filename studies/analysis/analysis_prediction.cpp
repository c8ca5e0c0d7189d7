// The objective scores of what was answered, brought to the answers.
#include <fmt/format.h>

#include <map>

#include "studies/analysis/analysis_parts.h"

namespace crowdbench::studies::parts {
namespace {

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
    // Yes is then a choice of item_a, which says nothing of the score of both together.
    if (row.item_a && scores_.key != ScoreTable::Key::item) return std::nullopt;
    if (scores_.key == ScoreTable::Key::item) {
      if (!row.item_a) return std::nullopt;
      const std::string& a = answers_.items[*row.item_a];
      const std::string& b = answers_.items[*row.item_b];
      name = fmt::format("{}:{}{}", a.size(), a, b);
      if (const Values* x = find(a), *y = find(b); x != nullptr && y != nullptr)
        for (size_t s = 0; s < values.size(); ++s)
          if ((*x)[s] && (*y)[s]) values[s] = *(*x)[s] - *(*y)[s];
    } else {
      const auto [which, names] = named_by(row);
      if (!*which) return std::nullopt;
      name = (*names)[**which];
      if (const Values* found = find(name)) values = *found;
    }
    const auto [place, added] = index_.emplace(name, static_cast<uint32_t>(found_.values.size()));
    if (added) found_.values.push_back(std::move(values));
    return place->second;
  }
  PredictedAnswers& found() { return found_; }

 private:
  // What the row says of the thing that has scores, and the names of all of its kind.
  std::pair<const std::optional<uint32_t>*, const std::vector<std::string>*> named_by(const Answer& row) const {
    if (scores_.key == ScoreTable::Key::stimulus) return {&row.stimulus, &answers_.stimuli};
    if (scores_.key == ScoreTable::Key::clip) return {&row.clip, &answers_.clips};
    return {&row.condition, &answers_.conditions};
  }
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

}  // namespace

ScorePredictions prediction_of(const Answers& answers, const Groups& groups, const AnalysisSettings& s,
                               const ScoreTable& scores) {
  Stimuli stimuli(answers, scores);
  PredictedAnswers& found = stimuli.found();
  found.comparisons = scores.key == ScoreTable::Key::item;
  std::map<uint32_t, uint32_t> participants;
  for (const auto& [name, rows] : groups.all)
    for (const Answer* row : rows) {
      const Counted d = counted(row->yes, row->ties, row->no, s.ties);
      const std::optional<uint32_t> stimulus = stimuli.of(*row);
      if (d.of == 0 || !stimulus) continue;
      uint32_t participant = 0;
      if (row->participant)
        participant = participants.emplace(*row->participant, static_cast<uint32_t>(participants.size())).first->second;
      found.cells.push_back({participant, *stimulus, d.yes, d.of, d.halves});
    }
  found.participants = participants.size();
  return predict_by_scores(scores.scores, found, s.confidence, s.seed, s.resamples);
}

}  // namespace crowdbench::studies::parts
