#include "bench/commands/score_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace crowdbench::bench {

using nlohmann::ordered_json;

ordered_json json_number(const std::optional<double>& value) {
  if (!value || std::isnan(*value)) return nullptr;
  if (std::isinf(*value)) return *value > 0 ? "inf" : "-inf";
  return *value;
}

ordered_json score_json(const metrics::ScoreResult& result) {
  if (result.pooled.empty()) return json_number(result.value);
  ordered_json out = ordered_json::object();
  for (const auto& [name, value] : result.pooled) out[name] = json_number(value);
  return out;
}

void put_scores(ordered_json& values, ordered_json& reasons, std::span<const metrics::Scored> scores) {
  for (const auto& [score, result] : scores) {
    const std::string name(score->name);
    values[name] = score_json(result);
    if (!result.value) reasons[name] = result.reason;
  }
}

ordered_json conditions_json(std::span<const metrics::Scored> scores) {
  ordered_json out = ordered_json::object();
  for (const auto& [score, result] : scores)
    if (!result.conditions.empty()) out[std::string(score->name)] = result.conditions;
  return out;
}

ordered_json details_json(std::span<const metrics::Scored> scores) {
  ordered_json out = ordered_json::object();
  for (const auto& [score, result] : scores)
    for (const auto& [name, value] : result.details) out[std::string(score->name)][name] = json_number(value);
  return out;
}

}  // namespace crowdbench::bench
