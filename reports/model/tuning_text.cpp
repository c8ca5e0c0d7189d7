#include "reports/model/tuning_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "reports/model/number_text.h"

namespace crowdbench::reports {
namespace {

std::string allowed_text(const TuningRow& row, const std::vector<ScoreDoc>& docs) {
  const auto bound = [&](const std::string& name, double value) {
    const ScoreDoc doc = doc_of(docs, name);
    return fmt::format("{} {} or {}", doc.title, score_text(doc, value), doc.higher_is_better ? "more" : "less");
  };
  const std::string pop = "a change may show " + bound(row.pop_score, row.pop_threshold);
  if (row.budget_ns) return fmt::format("The least error within {} a frame; {}.", time_text(*row.budget_ns), pop);
  return fmt::format("The cheapest with {} for the figures that each draws; {}.", bound(row.score, row.threshold), pop);
}

std::string drawn_text(const TuningRow& row) {
  if (row.switches.empty()) return fmt::format("Draw {} at every distance.", *row.representation);
  std::string text =
      fmt::format("From the eye to {:.1f} m draw {}", row.switches.front().depth, row.switches.front().from);
  for (const TunedSwitchRow& one : row.switches)
    text += fmt::format("; from {:.1f} m on (figures of {:.1f} pixels and less) {}", one.depth, one.height_px, one.to);
  return text + ".";
}

}  // namespace

std::vector<std::string> tuning_sentences(const TuningRow& row, const std::vector<ScoreDoc>& docs) {
  std::vector<std::string> out;
  if (!row.representation) {
    out.push_back(fmt::format("There is no rule: {}.", row.reason));
  } else {
    out.push_back(drawn_text(row));
    const auto unsure = std::ranges::count_if(row.switches, [](const TunedSwitchRow& one) { return !one.decided; });
    if (unsure > 0)
      out.push_back(fmt::format("Undecided, in fewer than 95 % of the resampled measurements: {} of {} changes.",
                                unsure, row.switches.size()));
  }
  out.push_back(allowed_text(row, docs));
  if (row.saving && row.saving_low && row.saving_high)
    out.push_back(fmt::format(
        "For what {} add to a frame the reference takes {:.3g} times as long "
        "(95 %: {:.3g} to {:.3g}).",
        agents_text(static_cast<uint64_t>(row.agents + 0.5)), *row.saving, *row.saving_low, *row.saving_high));
  if (row.promised && row.promised_low && row.promised_high)
    out.push_back(
        fmt::format("Promised of a whole frame of another seed: {:.3g} times as fast as the reference "
                    "(95 %: {:.3g} to {:.3g}){}.",
                    *row.promised, *row.promised_low, *row.promised_high,
                    !row.proof_holds   ? std::string("; not tried on unseen crowds and figures")
                    : *row.proof_holds ? std::string("; it held on unseen crowds and figures")
                                       : std::string("; it did NOT hold on unseen crowds and figures")));
  if (row.lenses_hold)
    out.push_back(fmt::format("In other pictures and through other lenses the rule in pixels {}.",
                              *row.lenses_hold ? "held" : "did NOT hold"));
  return out;
}

std::string certainty_text(const TunedSwitchRow& row) {
  const std::string share = fmt::format("{:.3g} % of the resamples", 100 * row.share);
  if (!row.decided || !row.low_px || !row.high_px) return "undecided: in " + share;
  return fmt::format("{:.1f} to {:.1f} px in {}", *row.low_px, *row.high_px, share);
}

}  // namespace crowdbench::reports
