#include <cmath>

#include "core/hash.h"
#include "scene/scenario/scenario_writer.h"
#include "studies/plan/adaptive.h"
#include "studies/plan/plan.h"

namespace crowdbench::studies {
namespace {

Json maybe(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

Json rate_json(Rate rate, double value) {
  switch (rate) {
    case Rate::fixed: return value;
    case Rate::free: return "free";
    case Rate::penalised: return "penalised";
  }
  return {};
}

// JSON has no infinite numbers.
Json level_json(const FactorLevel& level) {
  if (!level.number) return level.text;
  return std::isfinite(*level.number) ? Json(*level.number) : Json("inf");
}

Json conditions_json(const StudyPlan& plan) {
  Json out = Json::array();
  for (const StudyCondition& c : plan.conditions) {
    Json levels = Json::object();
    for (size_t f = 0; f < plan.factors.size(); ++f) levels[plan.factors[f].name] = level_json(c.levels[f]);
    out.push_back({{"id", c.id},
                   {"name", c.name},
                   {"levels", std::move(levels)},
                   {"level", maybe(c.level)},
                   {"test", c.test.text()},
                   {"height_px", maybe(c.height_px)},
                   {"pixels_per_texel", maybe(c.pixels_per_texel)},
                   {"spacing_by_bodies", c.spacing_by_bodies},
                   {"scenario", scene::to_toml(c.scenario)}});
  }
  return out;
}

}  // namespace

Json analysis_plan_json(const PlannedAnalysis& analysis) {
  const AnalysisSettings& s = analysis.settings;
  static const char* const kTies[] = {"drop", "split", "no"};
  static const char* const kRandom[] = {"none", "intercept", "slope", "independent-slope"};
  return {{"level", analysis.level.empty() ? Json() : Json(analysis.level)},
          {"curve", curve_name(s.curve.curve)},
          {"falling", s.curve.falling},
          {"guess", rate_json(s.curve.guess_rate, s.curve.guess)},
          {"lapse", rate_json(s.curve.lapse_rate, s.curve.lapse)},
          {"threshold", s.curve.level},
          {"chance", s.chance},
          {"ties", kTies[static_cast<size_t>(s.ties)]},
          {"random", kRandom[static_cast<size_t>(s.random)]},
          {"link", s.link == Link::logit ? "logit" : "probit"},
          {"margin", maybe(s.margin)},
          {"alpha", s.alpha},
          {"power", s.power},
          {"confidence", s.confidence},
          {"correction", "holm"},
          {"resamples", s.resamples},
          {"seed", s.seed}};
}

Json StudyPlan::meaning() const {
  Json json;
  json["name"] = name;
  json["title"] = title;
  json["seed"] = seed;
  json["question"] = {{"ask", question_words()[static_cast<size_t>(question)]},
                      {"task", task_words()[static_cast<size_t>(task)]},
                      {"text", question_text},
                      {"consent_sha256", sha256_hex(consent)},
                      {"instructions_sha256", sha256_hex(instructions)},
                      {"debrief_sha256", sha256_hex(debrief)}};
  json["reference"] = reference.text();
  json["conditions"] = conditions_json(*this);
  json["stimulus"] = {{"seconds", stimulus.seconds},
                      {"fps", stimulus.fps},
                      {"lead_in_seconds", stimulus.lead_in_seconds},
                      {"seeds", seeds_words()[static_cast<size_t>(stimulus.seeds)]},
                      {"crowds", stimulus.crowds},
                      {"largest_px", stimulus.largest_px},
                      {"intersect", stimulus.intersect},
                      {"bar_px", stimulus.bar_px},
                      {"replays", stimulus.replays},
                      {"least_psnr", stimulus.least_psnr},
                      {"artefact_share", stimulus.artefact_share}};
  json["method"] = {{"kind", method_words()[static_cast<size_t>(method.method)]},
                    {"repeats", method.repeats},
                    {"blocks", method.blocks},
                    {"trials", method.trials}};
  if (method.method != Method::constant) json["method"].update(adaptive_meaning(*this));
  json["catch"] = {{"identical", catch_trials.identical},
                   {"broken", catch_trials.broken},
                   {"broken_by", catch_trials.broken_by.text()}};
  json["training"] = training;
  json["participants"] = {{"planned", participants.planned},
                          {"lists", participants.lists},
                          {"calibration", participants.calibration},
                          {"demographics", participants.demographics}};
  json["exclude"] = {{"catch_least", exclude.catch_least},
                     {"shortest_rt_ms", exclude.shortest_rt_ms},
                     {"most_dropped", exclude.most_dropped},
                     {"hidden", exclude.hidden}};
  json["analysis"] = analysis_plan_json(analysis);
  return json;
}

std::string StudyPlan::hash() const { return sha256_hex(meaning().dump()); }

}  // namespace crowdbench::studies
