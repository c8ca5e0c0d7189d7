#include <algorithm>
#include <cmath>

#include "bench/commands/score_json.h"
#include "bench/commands/tune_output.h"
#include "bench/experiments/tune_measure.h"

namespace crowdbench::bench {
namespace {

Json interval_json(const Interval& interval) {
  return {{"low", json_number(interval.low)}, {"high", json_number(interval.high)}};
}

Json candidate_json(const TuneReport& report, const TuneMeasured& measured, size_t c) {
  Json out = {{"representation", candidate_name(report, c)},
              {"refused", measured.refused[c].empty() ? Json(nullptr) : Json(measured.refused[c])},
              {"heights", Json::array()}};
  for (size_t b = 0; b < report.request.heights_px.size(); ++b) {
    const TuneError& error = measured.errors[c][b];
    const bool none = error.values.empty();
    Json row = {{"height_px", report.request.heights_px[b]}, {"allowed", error.allowed}};
    row["mean"] = none ? Json(nullptr) : json_number(error.mean);
    row["worst_5_percent"] = none ? Json(nullptr) : json_number(error.tail);
    row["interval"] = none ? Json(nullptr) : interval_json(error.interval);
    row["promised"] = none ? Json(nullptr) : json_number(error.promised);
    row["agent_ns"] = measured.refused[c].empty() ? Json(measured.table.cost[c][b]) : Json(nullptr);
    out["heights"].push_back(row);
  }
  out["costs"] = Json::array();
  for (size_t h = 0; h < measured.costs.costs[c].size(); ++h) {
    const AgentCost& cost = measured.costs.costs[c][h];
    out["costs"].push_back({{"height_px", measured.cost_heights_px[h]},
                            {"agents", measured.costs.agents[h]},
                            {"agent_ns", cost.ns},
                            {"interval", cost.resolved ? interval_json(cost.interval) : Json(nullptr)},
                            {"resolved", cost.resolved}});
  }
  return out;
}

// What the rules of thumb would do, by their names; null where a rule says nothing of such a candidate.
Json predicted_json(const std::vector<PredictedSwitch>& rules) {
  Json out = {{"one_texel_a_pixel", nullptr}, {"an_error_of_one_pixel", nullptr}};
  for (const PredictedSwitch& predicted : rules) {
    const TuneError& error = *predicted.error;
    const bool known = !predicted.beyond && !error.values.empty();
    std::string key = predicted.rule;
    std::replace(key.begin(), key.end(), ' ', '_');
    out[key] = {{"height_px", predicted.height_px},
                {"depth_m", predicted.depth_m},
                {"pixels_at_the_switch", predicted.pixels},
                {"promised", known ? json_number(error.promised) : Json(nullptr)},
                {"allowed", known ? Json(error.allowed) : Json(nullptr)},
                {"agent_ns", known ? Json(predicted.cost_ns) : Json(nullptr)}};
  }
  return out;
}

Json switch_json(const TuneReport& report, size_t subject, const TuneSwitch& one) {
  const EngineSizes engines = engines_in_report(report, subject, one.height_px);
  const std::optional<double> godot_pixels = godot_pixels_in_report(report, subject, one);
  return {{"from", candidate_name(report, one.change.from)},
          {"to", candidate_name(report, one.change.to)},
          {"height_px", one.height_px},
          {"next_taller_px", report.request.heights_px[one.change.bin - 1]},
          {"interval_px", one.certainty.height_px ? interval_json(*one.certainty.height_px) : Json(nullptr)},
          {"share_of_resamples", one.certainty.share},
          {"decided", one.certainty.decided()},
          {"depth_m", depth_in_report(report, subject, one.height_px)},
          {"pop", json_number(one.pop.tail)},
          {"hysteresis", one.hysteresis},
          {"unity_screen_relative_height", engines.unity_height},
          {"unreal_screen_size", engines.unreal_size},
          {"godot_visibility_range_m", engines.godot_metres},
          {"godot_threshold_pixels", godot_pixels ? Json(*godot_pixels) : Json(nullptr)},
          {"predicted", predicted_json(predicted_switches(report, subject, one.change.to, one.height_px))}};
}

Json budget_json(const TuneReport& report, const TuneAnswer& answer) {
  if (!answer.budget) return nullptr;
  const TuneBudgetAnswer& budget = *answer.budget;
  const auto ms = [](double ns) { return std::isfinite(ns) ? Json(1e-6 * ns) : Json(nullptr); };
  Json out = {{"budget_ms", 1e-6 * report.request.budget_ns},
              {"frame_without_agents_ms", ms(budget.base_ns)},
              {"cheapest_frame_ms", ms(budget.cheapest_ns)},
              {"fits", answer.plan.has_value()}};
  out["plan_frame_ms"] = answer.plan ? ms(budget.base_ns + answer.plan->cost) : Json(nullptr);
  out["measured_frame_ms"] = budget.measured_ns ? ms(*budget.measured_ns) : Json(nullptr);
  out["correction"] = budget.factor;
  out["loss"] = answer.plan ? Json(answer.plan->error) : Json(nullptr);
  out["loss_bound"] = answer.plan ? Json(budget.bound) : Json(nullptr);
  return out;
}

// The members that an answer has, whether of all characters or of one.
Json answer_json(const TuneReport& report, size_t subject, const TuneAnswer& answer) {
  Json out = {{"agents", Json::array()}, {"chosen", Json::array()}, {"switches", Json::array()}};
  double agents = 0;
  for (const double in_bin : answer.table.agents) {
    out["agents"].push_back(in_bin);
    agents += in_bin;
  }
  if (answer.plan)
    for (const size_t c : answer.plan->candidate) out["chosen"].push_back(candidate_name(report, c));
  for (const TuneSwitch& one : answer.switches) out["switches"].push_back(switch_json(report, subject, one));
  out["not_chosen"] = Json::array();
  for (const UnchosenCandidate& one : unchosen_candidates(report, subject, answer))
    out["not_chosen"].push_back({{"representation", candidate_name(report, one.candidate)},
                                 {"keeps_threshold_from_px", one.kept_px ? Json(*one.kept_px) : Json(nullptr)},
                                 {"predicted", predicted_json(one.rules)}});
  const std::optional<MeshLodCurve> curve = mesh_lod_in_report(report, subject, answer);
  out["unity_mesh_lod"] = curve ? Json({{"slope", curve->slope}, {"bias", curve->bias}}) : Json(nullptr);
  out["representation"] = answer.plan ? Json(tuned_representation(report.request, answer).text()) : Json(nullptr);
  out["no_plan"] = answer.plan ? Json(nullptr) : Json(no_plan_text(report, answer));
  out["budget"] = budget_json(report, answer);
  out["reference_over_plan"] = nullptr;
  if (answer.plan && agents > 0)
    out["reference_over_plan"] = {{"value", answer.reference_cost / std::max(answer.plan->cost, 1e-9)},
                                  {"low", answer.saving.low},
                                  {"high", answer.saving.high}};
  return out;
}

Json seeds_json(const std::vector<SeedTimes>& seeds) {
  Json out = Json::array();
  for (const SeedTimes& one : seeds)
    out.push_back({{"seed", one.seed},
                   {"reference_over_plan", one.ratio},
                   {"interval", interval_json(one.interval)},
                   {"reference_ms", 1e-6 * one.reference_ns},
                   {"plan_ms", 1e-6 * one.plan_ns}});
  return out;
}

Json scores_json(const std::vector<SeedScores>& seeds) {
  Json out = Json::array();
  for (const SeedScores& one : seeds) {
    Json values = Json::array();
    for (const double value : one.by_place) values.push_back(json_number(value));
    out.push_back({{"seed", one.seed},
                   {"figures", one.figures},
                   {"mean", json_number(one.mean)},
                   {"worst_5_percent", json_number(one.tail)},
                   {"values", std::move(values)}});
  }
  return out;
}

Json drawn_json(const CharacterDrawn& one) {
  return {{"character", one.character},
          {"representation", one.representation},
          {"reference_over_plan", one.ratio},
          {"mean", json_number(one.mean)},
          {"worst_5_percent", json_number(one.tail)},
          {"seeds", seeds_json(one.times)},
          {"scores", scores_json(one.scores)}};
}

Json promise_json(const TuneReport& report) {
  if (!report.promise) return nullptr;
  Json out = {{"reference_over_plan", report.promise->ratio},
              {"on_another_seed", interval_json(report.promise->on_another_seed)},
              {"plan_ms", 1e-6 * report.promise->plan_ns},
              {"seeds", seeds_json(report.promise->seeds)}};
  out["score"] = {{"mean", json_number(report.score_promise->mean)},
                  {"on_another_seed", interval_json(report.score_promise->on_another_seed)},
                  {"degrees_of_freedom", report.score_promise->degrees},
                  {"seeds", scores_json(report.score_promise->seeds)}};
  return out;
}

// Of characters that were not tuned; with why_not where nothing is promised.
Json others_json(const TuneReport& report) {
  if (!report.others) return {{"why_not", why_no_others(report)}};
  const OthersPromise& promise = *report.others;
  Json left_out = Json::array();
  for (const CharacterDrawn& one : promise.left_out) left_out.push_back(drawn_json(one));
  return {{"why_not", nullptr},
          {"reference_over_plan", promise.ratio},
          {"reference_over_plan_of_another", interval_json(promise.ratio_of_another)},
          {"mean", json_number(promise.mean)},
          {"mean_of_another", interval_json(promise.mean_of_another)},
          {"worst_5_percent", json_number(promise.tail)},
          {"worst_5_percent_of_another", interval_json(promise.tail_of_another)},
          {"left_out", left_out}};
}

Json proof_json(const TuneReport& report) {
  if (!report.proof) return nullptr;
  const TuneProof& proof = *report.proof;
  Json out = {{"character", nullptr}, {"holds", proof.holds()}};
  if (proof.other) {
    out["character"] = proof.other->drawn.character;
    out["drawn"] = drawn_json(proof.other->drawn);
    out["speed_within"] = proof.other->ratio_within;
    out["mean_within"] = proof.other->mean_within;
    out["worst_5_percent_within"] = proof.other->tail_within;
    return out;
  }
  out["speed"] = {
      {"within", proof.speed.within}, {"holds", proof.speed.holds}, {"seeds", seeds_json(proof.speed.seeds)}};
  out["score"] = {
      {"within", proof.score.within}, {"holds", proof.score.holds}, {"seeds", scores_json(proof.score.seeds)}};
  out["errors"] = Json::array();
  for (const ErrorProof& one : proof.errors)
    out["errors"].push_back({{"subject", one.subject},
                             {"figures", one.views},
                             {"worse_than_promised", one.worse},
                             {"over_threshold", one.over_threshold},
                             {"worst_5_percent", json_number(one.tail)},
                             {"worst", json_number(one.worst)},
                             {"worst_height_px", one.worst_height_px},
                             {"holds", one.holds}});
  return out;
}

Json spreads_json(const TuneReport& report) {
  if (!report.lenses) return nullptr;
  Json out = Json::array();
  for (const LensSpread& one : lens_spreads(report)) {
    const auto number = [&](double value) { return one.conditions == 0 ? Json(nullptr) : json_number(value); };
    const TuneError& error = report.result.subjects[one.subject].errors[one.candidate][one.bin];
    out.push_back({{"subject", one.subject},
                   {"representation", candidate_name(report, one.candidate)},
                   {"height_px", report.request.heights_px[one.bin]},
                   {"conditions", one.conditions},
                   {"skipped", one.skipped},
                   {"as_tuned", number(one.tuned)},
                   {"interval", interval_json(error.interval)},
                   {"low", number(one.low)},
                   {"high", number(one.high)},
                   {"kept", one.conditions == 0 ? Json(nullptr) : Json(one.kept)},
                   {"within", one.conditions == 0 ? Json(nullptr) : Json(one.within)},
                   {"as_if_switched_at_px", one.height_px ? interval_json(*one.height_px) : Json(nullptr)}});
  }
  return out;
}

Json lenses_json(const TuneReport& report) {
  if (!report.lenses) return nullptr;
  Json out = Json::array();
  for (const TuneLensCheck& one : *report.lenses) {
    const auto number = [&](double value) { return one.skipped ? Json(nullptr) : json_number(value); };
    out.push_back({{"subject", one.subject},
                   {"rows", one.lens.rows},
                   {"fov_y_deg", one.lens.fov_y_deg},
                   {"representation", candidate_name(report, one.candidate)},
                   {"height_px", report.request.heights_px[one.bin]},
                   {"skipped", one.skipped},
                   {"views", one.views},
                   {"worst_5_percent", number(one.tail)},
                   {"worst_5_percent_as_tuned", number(one.tuned_tail)},
                   {"mean_difference", number(one.mean_difference)},
                   {"largest_difference", number(one.largest_difference)},
                   {"worse_than_promised", one.worse},
                   {"holds", one.skipped ? Json(nullptr) : Json(one.holds)}});
  }
  return out;
}

}  // namespace

Json tune_json(const TuneReport& report) {
  const TuneResult& result = report.result;
  const TuneRequest& request = report.request;
  Json out = {{"score", request.error.score->name},
              {"threshold", request.error.value},
              {"pop_score", request.pop.score->name},
              {"pop_threshold", request.pop.value},
              {"width", request.cost.width},
              {"height", request.cost.height},
              {"fov_y_deg", glm::degrees(request.cost.fov_y)},
              {"clock", result.subjects[0].costs.clock},
              {"renderer", report.run.gl_renderer},
              {"software", report.run.software},
              {"times", times_text(report)},
              {"crowd", report.crowd},
              {"characters", Json::array()}};
  for (size_t s = 0; s < result.subjects.size(); ++s) {
    Json one = {{"character", request.subjects[s].character->name},
                {"views", result.subjects[s].views},
                {"tail_bounded", result.subjects[s].views >= kTailValues},
                {"candidates", Json::array()}};
    for (size_t c = 0; c < request.candidates.size(); ++c)
      one["candidates"].push_back(candidate_json(report, result.subjects[s], c));
    one["alone"] = result.alone.empty() ? Json(nullptr) : answer_json(report, s, result.alone[s]);
    out["characters"].push_back(one);
  }
  const Json together = answer_json(report, 0, result.together);
  for (const char* key : {"agents", "chosen", "switches", "not_chosen", "representation", "no_plan", "unity_mesh_lod",
                          "budget", "reference_over_plan"})
    out[key] = together.at(key);
  out["promise"] = promise_json(report);
  out["promise_of_others"] = others_json(report);
  out["lenses"] = lenses_json(report);
  out["lens_spreads"] = spreads_json(report);
  out["proof"] = proof_json(report);
  return out;
}

}  // namespace crowdbench::bench
