#include "bench/commands/tune_output.h"

#include <fmt/format.h>

#include <algorithm>

#include "bench/commands/score_json.h"
#include "core/error.h"

namespace crowdbench::bench {
namespace {

std::string name_of(const TuneReport& report, size_t candidate) { return report.request.candidates[candidate].text(); }

double depth_of(const TuneReport& report, double height_px) {
  const SwitchCostRequest& lens = report.request.cost;
  return depth_of_height(report.request.character->placement.height, height_px, lens.height, lens.fov_y);
}

EngineSizes engines_at(const TuneReport& report, double height_px) {
  const SwitchCostRequest& lens = report.request.cost;
  return engine_sizes(report.bounds, depth_of(report, height_px), lens.fov_y,
                      static_cast<double>(lens.width) / lens.height);
}

Json interval_json(const Interval& interval) { return {{"low", interval.low}, {"high", interval.high}}; }

Json candidate_json(const TuneReport& report, size_t c) {
  const TuneResult& result = report.result;
  Json out = {{"representation", name_of(report, c)},
              {"refused", result.refused[c].empty() ? Json(nullptr) : Json(result.refused[c])},
              {"heights", Json::array()}};
  for (size_t b = 0; b < report.request.heights_px.size(); ++b) {
    const TuneError& error = result.errors[c][b];
    Json row = {{"height_px", report.request.heights_px[b]}, {"allowed", error.allowed}};
    row["mean"] = error.values.empty() ? Json(nullptr) : json_number(error.mean);
    row["worst_5_percent"] = error.values.empty() ? Json(nullptr) : json_number(error.tail);
    row["interval"] = error.values.empty() ? Json(nullptr) : interval_json(error.interval);
    row["agent_ns"] = result.refused[c].empty() ? Json(result.table.cost[c][b]) : Json(nullptr);
    out["heights"].push_back(row);
  }
  out["costs"] = Json::array();
  for (size_t h = 0; h < result.costs.costs[c].size(); ++h) {
    const AgentCost& cost = result.costs.costs[c][h];
    out["costs"].push_back({{"height_px", result.cost_heights_px[h]},
                            {"agents", result.costs.agents[h]},
                            {"agent_ns", cost.ns},
                            {"interval", cost.resolved ? interval_json(cost.interval) : Json(nullptr)},
                            {"resolved", cost.resolved}});
  }
  return out;
}

Json switch_json(const TuneReport& report, size_t i) {
  const TuneSwitch& one = report.result.switches[i];
  const EngineSizes engines = engines_at(report, one.height_px);
  return {{"from", name_of(report, one.change.from)},
          {"to", name_of(report, one.change.to)},
          {"height_px", one.height_px},
          {"interval_px", one.certainty.height_px ? interval_json(*one.certainty.height_px) : Json(nullptr)},
          {"share_of_resamples", one.certainty.share},
          {"decided", one.certainty.decided()},
          {"depth_m", depth_of(report, one.height_px)},
          {"pop", json_number(one.pop.tail)},
          {"hysteresis", one.hysteresis},
          {"one_texel_a_pixel_px", json_number(report.predicted_px[i])},
          {"unity_screen_relative_height", engines.unity_height},
          {"unreal_screen_size", engines.unreal_size},
          {"godot_visibility_range_m", engines.godot_metres}};
}

double expected_agents(const TuneReport& report) {
  double sum = 0;
  for (const double agents : report.request.agents) sum += agents;
  return sum;
}

void print_heights(const TuneReport& report) {
  const metrics::Score& score = *report.request.error.score;
  fmt::print("{:>8} {:>8} {:>8}", "height", "depth", "agents");
  for (size_t c = 0; c < report.request.candidates.size(); ++c) fmt::print("  {:>24.24}", name_of(report, c));
  fmt::print("\n{:>8} {:>8} {:>8}", "pixels", "m", "");
  for (size_t c = 0; c < report.request.candidates.size(); ++c)
    fmt::print("  {:>24}", fmt::format("{:.9} us an agent", score.column));
  fmt::print("\n");
  for (size_t b = 0; b < report.request.heights_px.size(); ++b) {
    const double height = report.request.heights_px[b];
    fmt::print("{:>8.1f} {:>8.1f} {:>8.0f}", height, depth_of(report, height), report.request.agents[b]);
    for (size_t c = 0; c < report.request.candidates.size(); ++c) {
      const TuneError& error = report.result.errors[c][b];
      const std::string cell =
          error.values.empty() ? std::string("n/a")
                               : fmt::format("{}{:.{}f} {:>8.2f}",
                                             report.result.plan && report.result.plan->candidate[b] == c ? "> " : "",
                                             error.tail, score.digits, 1e-3 * report.result.table.cost[c][b]);
      fmt::print("  {:>24}", cell);
    }
    fmt::print("\n");
  }
}

std::string switch_text(const TuneReport& report, size_t i) {
  const TuneSwitch& one = report.result.switches[i];
  const metrics::Score& pop = *report.request.pop.score;
  const EngineSizes engines = engines_at(report, one.height_px);
  const std::string sure =
      one.certainty.decided()
          ? fmt::format("in resamples {:.1f} to {:.1f} pixels", one.certainty.height_px->low,
                        one.certainty.height_px->high)
          : fmt::format("undecided: {:.1f} % of the resamples switch between these two", 100 * one.certainty.share);
  std::string text = fmt::format(
      "from {:.1f} pixels ({:.1f} m) on {} instead of {}; {}\n  the switch shows {} {:.{}f}; Unity {:.4f} of the "
      "screen's "
      "height at lodBias 1, Unreal screen size {:.4f}, Godot visibility range {:.2f} m",
      one.height_px, depth_of(report, one.height_px), name_of(report, one.change.to), name_of(report, one.change.from),
      sure, pop.title, one.pop.tail, pop.digits, engines.unity_height, engines.unreal_size, engines.godot_metres);
  if (const auto& predicted = report.predicted_px[i])
    text += fmt::format("\n  one texel a pixel would switch at {:.1f} pixels ({:.1f} m)", *predicted,
                        depth_of(report, *predicted));
  return text;
}

std::string no_plan_text(const TuneReport& report) {
  const auto bin = first_forbidden_bin(report.result.table);
  if (!bin) return "no chain of switches keeps the pop threshold";
  return fmt::format("no candidate keeps {} {:g} at {:.1f} pixels", report.request.error.score->title,
                     report.request.error.value, report.request.heights_px[*bin]);
}

}  // namespace

void print_tune(const TuneReport& report) {
  const TuneResult& result = report.result;
  fmt::print("{}: {} at the bad end's 5 % of {} views and moments, threshold {:g}; {} of one more agent; {}x{}\n",
             printable(report.request.character->name), report.request.error.score->title,
             report.request.azimuths_deg.size() * report.request.elevations_deg.size() * report.request.moments,
             report.request.error.value, result.costs.clock, report.request.cost.width, report.request.cost.height);
  for (size_t c = 0; c < report.request.candidates.size(); ++c)
    if (!result.refused[c].empty()) fmt::print("{} is left out: {}\n", name_of(report, c), result.refused[c]);
  print_heights(report);
  for (size_t c = 0; c < report.request.candidates.size(); ++c)
    for (size_t h = 0; h < result.costs.costs[c].size(); ++h)
      if (!result.costs.costs[c][h].resolved)
        fmt::print("{} at {:.1f} pixels: one more agent is within the noise; the whole frame's time over its agents\n",
                   name_of(report, c), result.cost_heights_px[h]);
  if (!result.plan) {
    fmt::print("{}\n", no_plan_text(report));
    return;
  }
  if (result.switches.empty())
    fmt::print("{} at every height: nothing cheaper is allowed\n", name_of(report, result.plan->candidate[0]));
  for (size_t i = 0; i < result.switches.size(); ++i) fmt::print("{}\n", switch_text(report, i));
  fmt::print("draws as: {}\n", tuned_representation(report.request, result).text());
  if (expected_agents(report) > 0)
    fmt::print(
        "{:.0f} agents in view: {:.2f} times as fast as {} ({:.2f} to {:.2f}), what a frame costs anyhow not counted\n",
        expected_agents(report), result.reference_cost / std::max(result.plan->cost, 1e-9),
        renderers::reference_spec().text(), result.saving.low, result.saving.high);
}

Json tune_json(const TuneReport& report) {
  const TuneResult& result = report.result;
  const TuneRequest& request = report.request;
  Json out = {{"character", request.character->name},
              {"score", request.error.score->name},
              {"threshold", request.error.value},
              {"pop_score", request.pop.score->name},
              {"pop_threshold", request.pop.value},
              {"width", request.cost.width},
              {"height", request.cost.height},
              {"fov_y_deg", glm::degrees(request.cost.fov_y)},
              {"clock", result.costs.clock},
              {"renderer", report.renderer},
              {"agents", Json::array()},
              {"candidates", Json::array()},
              {"chosen", Json::array()},
              {"switches", Json::array()}};
  for (const double agents : request.agents) out["agents"].push_back(agents);
  for (size_t c = 0; c < request.candidates.size(); ++c) out["candidates"].push_back(candidate_json(report, c));
  if (result.plan)
    for (const size_t c : result.plan->candidate) out["chosen"].push_back(name_of(report, c));
  for (size_t i = 0; i < result.switches.size(); ++i) out["switches"].push_back(switch_json(report, i));
  out["representation"] = result.plan ? Json(tuned_representation(request, result).text()) : Json(nullptr);
  out["no_plan"] = result.plan ? Json(nullptr) : Json(no_plan_text(report));
  if (result.plan && expected_agents(report) > 0)
    out["reference_over_plan"] = {{"value", result.reference_cost / std::max(result.plan->cost, 1e-9)},
                                  {"low", result.saving.low},
                                  {"high", result.saving.high}};
  else
    out["reference_over_plan"] = nullptr;
  return out;
}

}  // namespace crowdbench::bench
