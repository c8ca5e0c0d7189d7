#include "reports/model/cost_text.h"

#include <fmt/format.h>

#include <cmath>

#include "reports/model/number_text.h"

namespace crowdbench::reports {

std::string formula_text(const CostFit& fit) {
  std::string out;
  for (const CostCoefficient& term : fit.terms) {
    const std::string each = term.ns >= 1e3 ? time_text(term.ns) : fmt::format("{:.3g} ns", term.ns);
    out += fmt::format("{}{} {}", out.empty() ? "" : " + ", each, cost_term_text(term.term));
  }
  return out;
}

std::string accuracy_text(const CostModel& model) {
  std::string out = fmt::format("{} of {} within 15 % (95 % interval of the share {} to {}); error {:.1f} %",
                                model.within_15, model.held_out.size(), percent_text(model.within_share.low),
                                percent_text(model.within_share.high), 100 * model.error);
  if (model.between == model.held_out.size()) return out;
  if (model.between == 0) return out + "; each lies beyond the others";
  return out + fmt::format("; of those between the others {} of {}, error {:.1f} %", model.between_within_15,
                           model.between, 100 * model.between_error);
}

std::vector<std::string> break_even_sentences(const Scene& scene, const BreakEvenMap& map) {
  std::vector<std::string> out;
  for (const BreakEven& pair : map.pairs)
    if (pair.first == scene.reference)
      for (const BreakEvenPoint& point : pair.contour) out.push_back(break_even_text(pair, point));
  return out;
}

std::string time_ratio_text(const ParetoEntry& entry) {
  if (entry.low == entry.high) return "1";
  return fmt::format("{:.3g} ({:.3g} to {:.3g})", entry.time, entry.low, entry.high);
}

std::string front_text(const ParetoFront& front, const ParetoEntry& entry) {
  if (!entry.beaten_by.empty()) return "beaten by " + entry.beaten_by;
  return front.score.name.empty() || entry.error ? "on the front" : "not known, as it was not scored";
}

}  // namespace crowdbench::reports
