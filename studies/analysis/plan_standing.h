// Whether an analysis may be called planned: it is the one that was frozen before the first answer, and the answers
// were given to that plan. Whatever speaks against it is said.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "studies/analysis/answers.h"

namespace crowdbench::studies {

struct PlanFacts {
  std::string file;                   // what sentences call it
  std::string hash;                   // of the plan as it is now
  std::optional<std::string> frozen;  // the hash that was frozen first; nothing: it never was
  struct Change {
    std::string hash;  // of the plan from there on
    std::string reason;
  };
  std::vector<Change> deviations;  // recorded since
};

enum class Standing {
  planned,
  deviates,     // planned, but for deviations that were recorded
  not_planned,  // never frozen, changed without a word, other answers, or other settings
};
struct PlanStanding {
  Standing standing = Standing::not_planned;
  std::vector<std::string> sentences;
};
// changed: options of the command line that differ from the plan, as "--ties split".
PlanStanding plan_standing(const PlanFacts& plan, const Answers& answers, const std::vector<std::string>& changed);
// "Planned", "Deviates from the plan", "Not the planned analysis".
std::string standing_title(Standing standing);

}  // namespace crowdbench::studies
