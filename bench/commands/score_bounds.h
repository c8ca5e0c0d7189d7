// Scores by the names that users give, and bounds that they must keep: `compare --fail-above SCORE=VALUE`,
// `--fail-below SCORE=VALUE`.
#pragma once
#include <string>
#include <vector>

#include "core/json.h"
#include "metrics/registry.h"

namespace crowdbench::bench {

// By its name. option: the one that gave it. Throws Error with the nearest name.
const metrics::Score& score_named(const std::string& name, const std::string& option, metrics::ScoreTable table);

// "ssim,mae" in the table's own order, each once. Throws Error as score_named.
std::vector<const metrics::Score*> chosen_scores(const std::string& list, const std::string& option,
                                                 metrics::ScoreTable table);

struct ScoreValue {
  const metrics::Score* score = nullptr;
  double value = 0;  // finite
};
// "SCORE=VALUE". Throws Error as score_named, and on what is not of that shape.
ScoreValue parse_score_value(const std::string& text, const std::string& option, metrics::ScoreTable table);

struct ScoreBound {
  const metrics::Score* score = nullptr;
  double value = 0;
  bool above = true;  // fails above it; else below it
};

// above, below: "SCORE=VALUE" each. Throws Error: not of that shape, no such score (the nearest is named), a bound on
// the side on which the score is better, so that it would refuse good pictures.
std::vector<ScoreBound> parse_bounds(const std::vector<std::string>& above, const std::vector<std::string>& below,
                                     metrics::ScoreTable table);

struct BoundVerdict {
  ScoreBound bound;
  metrics::ScoreResult result;
  bool pass = false;  // a score that is not available does not pass
};
std::vector<BoundVerdict> check_bounds(const std::vector<ScoreBound>& bounds,
                                       const std::vector<metrics::Scored>& scores);
// [{"score", "fail_above" or "fail_below", "value", "pass"}]
Json bounds_json(const std::vector<BoundVerdict>& verdicts);
// "mae is 2.31, above 2"
std::string verdict_text(const BoundVerdict& verdict);
// Says those that are broken on stderr; the exit status: 1 where there is one, else 0.
int say_broken_bounds(const std::vector<BoundVerdict>& verdicts);

}  // namespace crowdbench::bench
