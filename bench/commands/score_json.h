// Scores as JSON, alike in every command: {"name": value}, null with its reason elsewhere, "inf" for infinity, and an
// object where a score has further pooled figures.
#pragma once
#include <optional>
#include <span>

#include "core/json.h"
#include "metrics/registry.h"

namespace crowdbench::bench {

// JSON has no infinity and no NaN: "inf", "-inf" and null.
Json json_number(const std::optional<double>& value);

// {"mean": ..., "weighted_median": ...} where there are pooled figures, else the bare value.
Json score_json(const metrics::ScoreResult& result);
// {"name", "given", "pixels_per_degree", "text"}
Json display_json(const metrics::ChosenDisplay& chosen);
// For people: metrics::display_text(), and that nobody chose it where it is so.
std::string display_line(const metrics::ChosenDisplay& chosen);

// Adds each score to `values` by its name, and its reason to `reasons` where it is absent. Both are objects.
void put_scores(Json& values, Json& reasons, std::span<const metrics::Scored> scores);

// {"name": "67.0206 pixels/degree"}: of the scores that depend on a choice and have a value.
Json conditions_json(std::span<const metrics::Scored> scores);

// {"name": {"q": 0.4}}: the details of those that have some.
Json details_json(std::span<const metrics::Scored> scores);

}  // namespace crowdbench::bench
