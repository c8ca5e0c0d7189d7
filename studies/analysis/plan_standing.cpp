#include "studies/analysis/plan_standing.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/error.h"

namespace crowdbench::studies {
namespace {

constexpr size_t kShownOfHash = 12;

std::string short_hash(const std::string& hash) { return printable(hash.substr(0, kShownOfHash), 20); }

// Of the answers' plans: what is not the frozen one, nor one that it became by a recorded deviation.
std::vector<std::string> wrong_answers(const PlanFacts& plan, const Answers& answers) {
  std::vector<std::string> out;
  const bool all_say =
      std::all_of(answers.rows.begin(), answers.rows.end(), [](const Answer& row) { return row.study.has_value(); });
  if (!all_say) out.emplace_back("The answers do not say which plan they were given to: they have no column `study`.");
  for (const std::string& study : answers.studies) {
    const auto is_it = [&](const PlanFacts::Change& change) { return change.hash == study; };
    if (plan.frozen == study || std::any_of(plan.deviations.begin(), plan.deviations.end(), is_it)) continue;
    out.push_back(fmt::format("Answers were given to another plan, {}.", short_hash(study)));
  }
  return out;
}

}  // namespace

PlanStanding plan_standing(const PlanFacts& plan, const Answers& answers, const std::vector<std::string>& changed) {
  PlanStanding out;
  const std::string name = printable(plan.file, 80);
  if (!plan.frozen) {
    out.sentences.push_back(fmt::format("{} was not frozen before the first answer.", name));
  } else {
    const std::string& current = plan.deviations.empty() ? *plan.frozen : plan.deviations.back().hash;
    if (current != plan.hash)
      out.sentences.push_back(fmt::format("{} was changed since it was frozen, and no deviation is recorded.", name));
    for (std::string& sentence : wrong_answers(plan, answers)) out.sentences.push_back(std::move(sentence));
  }
  if (!changed.empty())
    out.sentences.push_back(
        fmt::format("Other than the plan says: {}.", printable(fmt::format("{}", fmt::join(changed, ", ")), 400)));
  out.standing = !out.sentences.empty()    ? Standing::not_planned
                 : plan.deviations.empty() ? Standing::planned
                                           : Standing::deviates;
  for (const PlanFacts::Change& change : plan.deviations)
    out.sentences.push_back(fmt::format("Deviation recorded: {}", printable(change.reason, 400)));
  if (out.standing == Standing::planned)
    out.sentences.push_back(
        fmt::format("Planned: {}, frozen as {} before the first answer.", name, short_hash(*plan.frozen)));
  return out;
}

std::string standing_title(Standing standing) {
  return standing == Standing::planned    ? "Planned"
         : standing == Standing::deviates ? "Deviates from the plan"
                                          : "Not the planned analysis";
}

}  // namespace crowdbench::studies
