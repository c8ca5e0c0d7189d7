#include "bench/commands/score_json.h"

#include <cmath>

#include "core/json.h"

namespace crowdbench::bench {

Json json_number(const std::optional<double>& value) {
  if (!value || std::isnan(*value)) return nullptr;
  if (std::isinf(*value)) return *value > 0 ? "inf" : "-inf";
  return *value;
}

Json score_json(const metrics::ScoreResult& result) {
  if (result.pooled.empty()) return json_number(result.value);
  Json out = Json::object();
  for (const metrics::ScoreFigure& of : result.pooled) out[of.name] = json_number(of.value);
  return out;
}

Json display_json(const metrics::ChosenDisplay& chosen) {
  return {{"name", chosen.display.name},
          {"given", chosen.given},
          {"pixels_per_degree", chosen.display.pixels_per_degree},
          {"text", metrics::display_text(chosen.display)}};
}

std::string display_line(const metrics::ChosenDisplay& chosen) {
  return metrics::display_text(chosen) + (chosen.given ? "" : "; --display chooses");
}

void put_scores(Json& values, Json& reasons, std::span<const metrics::Scored> scores) {
  for (const auto& [score, result] : scores) {
    const std::string name(score->name);
    values[name] = score_json(result);
    if (!result.value) reasons[name] = result.reason;
  }
}

Json conditions_json(std::span<const metrics::Scored> scores) {
  Json out = Json::object();
  for (const auto& [score, result] : scores)
    if (!result.conditions.empty()) out[std::string(score->name)] = result.conditions;
  return out;
}

Json details_json(std::span<const metrics::Scored> scores) {
  Json out = Json::object();
  for (const auto& [score, result] : scores)
    for (const metrics::ScoreFigure& of : result.details)
      out[std::string(score->name)][of.name] = json_number(of.value);
  return out;
}

}  // namespace crowdbench::bench
