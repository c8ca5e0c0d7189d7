#include "bench/commands/score_bounds.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "bench/commands/score_json.h"
#include "core/error.h"
#include "core/json.h"

namespace crowdbench::bench {
const metrics::Score& score_named(const std::string& name, const std::string& option, metrics::ScoreTable table) {
  std::vector<std::string> names;
  for (const metrics::Score* score : table) {
    if (score->name == name) return *score;
    names.emplace_back(score->name);
  }
  for (const metrics::Score* score : metrics::scores())
    if (score->name == name)
      throw Error(option, fmt::format("the score '{}' was not asked for", name), "name it in --scores too");
  const std::string nearest = nearest_name(name, names);
  throw Error(option, fmt::format("there is no score '{}'", printable(name)),
              nearest.empty() ? fmt::format("there are {}", fmt::join(names, ", "))
                              : fmt::format("did you mean '{}'?", nearest));
}

std::vector<const metrics::Score*> chosen_scores(const std::string& list, const std::string& option,
                                                 metrics::ScoreTable table) {
  std::vector<const metrics::Score*> named;
  for (size_t at = 0; at <= list.size();) {
    const size_t comma = std::min(list.find(',', at), list.size());
    named.push_back(&score_named(list.substr(at, comma - at), option, table));
    at = comma + 1;
  }
  std::vector<const metrics::Score*> out;
  for (const metrics::Score* score : table)
    if (std::find(named.begin(), named.end(), score) != named.end()) out.push_back(score);
  return out;
}

ScoreValue parse_score_value(const std::string& text, const std::string& option, metrics::ScoreTable table) {
  const size_t equals = text.find('=');
  double value = 0;
  bool fine = equals != std::string::npos;
  if (fine) {
    const char* const end = text.data() + text.size();
    const auto [stop, fault] = std::from_chars(text.data() + equals + 1, end, value);
    fine = fault == std::errc{} && stop == end && std::isfinite(value);
  }
  if (!fine)
    throw Error(option, fmt::format("'{}' is not a bound", printable(text)), "write SCORE=VALUE: mae=2 or ssim=0.98");
  const metrics::Score& score = score_named(text.substr(0, equals), option, table);
  if (value < score.least || value > score.greatest)
    throw Error(option, fmt::format("{} is never {:g}", score.name, value),
                fmt::format("choose from {:g} to {:g}", score.least, score.greatest));
  return {&score, value};
}

namespace {

ScoreBound parse_bound(const std::string& text, bool above, metrics::ScoreTable table) {
  const std::string option = above ? "--fail-above" : "--fail-below";
  const ScoreValue bound = parse_score_value(text, option, table);
  const metrics::Score& score = *bound.score;
  if (score.compute == nullptr)
    throw Error(option, fmt::format("{} is of clips, not of pictures", score.name), "bound a score of pictures");
  if (above != (score.direction == metrics::Direction::lower_is_better))
    throw Error(option, fmt::format("{} is better the {} it is", score.name, above ? "higher" : "lower"),
                fmt::format("write {} {}", above ? "--fail-below" : "--fail-above", printable(text)));
  return {&score, bound.value, above};
}

}  // namespace

std::vector<ScoreBound> parse_bounds(const std::vector<std::string>& above, const std::vector<std::string>& below,
                                     metrics::ScoreTable table) {
  std::vector<ScoreBound> bounds;
  for (const std::string& text : above) bounds.push_back(parse_bound(text, true, table));
  for (const std::string& text : below) bounds.push_back(parse_bound(text, false, table));
  return bounds;
}

std::vector<BoundVerdict> check_bounds(const std::vector<ScoreBound>& bounds,
                                       const std::vector<metrics::Scored>& scores) {
  std::vector<BoundVerdict> verdicts;
  for (const ScoreBound& bound : bounds) {
    BoundVerdict& verdict = verdicts.emplace_back();
    verdict.bound = bound;
    const auto scored = std::ranges::find(scores, bound.score, &metrics::Scored::score);
    verdict.result = scored != scores.end() ? scored->result : metrics::absent("needs what these pictures do not have");
    const std::optional<double>& value = verdict.result.value;
    verdict.pass = value && (bound.above ? *value <= bound.value : *value >= bound.value);
  }
  return verdicts;
}

Json bounds_json(const std::vector<BoundVerdict>& verdicts) {
  Json out = Json::array();
  for (const BoundVerdict& v : verdicts)
    out.push_back({{"score", v.bound.score->name},
                   {v.bound.above ? "fail_above" : "fail_below", v.bound.value},
                   {"value", score_json(v.result)},
                   {"pass", v.pass}});
  return out;
}

std::string verdict_text(const BoundVerdict& v) {
  if (!v.result.value) return fmt::format("{} is not available: {}", v.bound.score->name, v.result.reason);
  return fmt::format("{} is {:g}, {}{} {:g}", v.bound.score->name, *v.result.value, v.pass ? "not " : "",
                     v.bound.above ? "above" : "below", v.bound.value);
}

int say_broken_bounds(const std::vector<BoundVerdict>& verdicts) {
  int status = 0;
  for (const BoundVerdict& verdict : verdicts) {
    if (verdict.pass) continue;
    fmt::print(stderr, "crowdbench: {}\n", verdict_text(verdict));
    status = 1;
  }
  return status;
}

}  // namespace crowdbench::bench
