// Scores as JSON, alike in every command: {"name": value}, null with its reason elsewhere, "inf" for infinity, and an
// object where a score has further pooled figures.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>

#include "metrics/registry.h"

namespace crowdbench::bench {

// JSON has no infinity and no NaN: "inf", "-inf" and null.
nlohmann::ordered_json json_number(const std::optional<double>& value);

// {"mean": ..., "weighted_median": ...} where there are pooled figures, else the bare value.
nlohmann::ordered_json score_json(const metrics::ScoreResult& result);

// Adds each score to `values` by its name, and its reason to `reasons` where it is absent. Both are objects.
void put_scores(nlohmann::ordered_json& values, nlohmann::ordered_json& reasons,
                std::span<const metrics::Scored> scores);

// {"name": "67.0206 pixels/degree"}: of the scores that depend on a choice and have a value.
nlohmann::ordered_json conditions_json(std::span<const metrics::Scored> scores);

// {"name": {"q": 0.4}}: the details of those that have some.
nlohmann::ordered_json details_json(std::span<const metrics::Scored> scores);

}  // namespace crowdbench::bench
