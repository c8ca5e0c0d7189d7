#include "bench/commands/distance_output.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>

#include "bench/commands/cause_output.h"
#include "bench/commands/score_json.h"
#include "bench/experiments/distance_rows.h"
#include "bench/experiments/score_rows.h"
#include "core/counted.h"
#include "core/csv.h"
#include "core/error.h"
#include "core/statistics.h"
#include "reports/page/distance_page.h"

namespace crowdbench::bench {
namespace {

constexpr AgentState kStates[] = {AgentState::counted, AgentState::occluded, AgentState::cut_off, AgentState::no_pixel};

// Agents in frames by state; those that a frame's view does not reach are out of view.
struct Counts {
  std::array<size_t, std::size(kStates)> by_state{};
  size_t out_of_view = 0;
  size_t of(AgentState state) const { return by_state[static_cast<size_t>(state)]; }
};

Counts counts_of(const DistanceReport& report) {
  Counts counts;
  for (const DistanceAgent& agent : report.result.agents) ++counts.by_state[static_cast<size_t>(agent.view.state)];
  counts.out_of_view =
      static_cast<size_t>(report.request.frames) * report.scenario.crowd.agents - report.result.agents.size();
  return counts;
}

const AgainstText& text_of(Against against) { return all_against()[static_cast<size_t>(against)]; }

std::string representation_of(const DistanceReport& report, size_t index) {
  return report.request.representations[index].text();
}

Json bin_json(const CurveBin& bin) {
  return {{"from", bin.from},
          {"to", bin.to},
          {"x", bin.x},
          {"median", json_number(bin.value)},
          {"low", json_number(bin.low)},
          {"high", json_number(bin.high)},
          {"points", bin.points},
          {"agents", bin.agents}};
}

Json curve_json(const DistanceReport& report, const DistanceCurve& of) {
  Json out = {{"representation", representation_of(report, of.representation)},
              {"score", report.request.scores[of.score]->name},
              {"against", text_of(of.against).name},
              {"points", of.curve.points},
              {"agents", of.curve.agents},
              {"rank_correlation", json_number(of.curve.rank_correlation)},
              {"bins", Json::array()},
              {"thresholds", Json::array()}};
  for (const CurveBin& bin : of.curve.bins) out["bins"].push_back(bin_json(bin));
  for (const auto& [value, place] : of.thresholds)
    out["thresholds"].push_back({{"value", value},
                                 {"status", reached_name(place.reached)},
                                 {"at", json_number(place.at)},
                                 {"low", json_number(place.low)},
                                 {"high", json_number(place.high)}});
  return out;
}

Json row_json(const DistanceReport& report, const DistanceAgent& agent) {
  const AgentView& view = agent.view;
  Json out = {{"tick", view.tick},
              {"agent", view.id - 1},
              {"character", view.character},
              {"distance_m", view.distance},
              {"height_px", view.height_px},
              {"alone_px", view.alone_px},
              {"visible_px", view.visible_px},
              {"state", state_name(view.state)},
              {"scores", Json::object()},
              {"pixels_per_texel", Json::object()}};
  for (size_t r = 0; r < agent.values.size(); ++r) {
    const std::string name = representation_of(report, r);
    Json& scores = out["scores"][name] = Json::object();
    for (size_t s = 0; s < agent.values[r].size(); ++s)
      scores[std::string(report.request.scores[s]->name)] = json_number(agent.values[r][s]);
    out["pixels_per_texel"][name] = json_number(pixels_per_texel(report.result, view, r));
  }
  return out;
}

std::string words_of_causes(const DistanceReport& report, size_t representation) {
  return cause_words(distance_causes(report.result, representation, report.scenario.seed), "agent");
}

Json all_causes_json(const DistanceReport& report) {
  Json out = Json::array();
  for (size_t r = 0; r < report.request.representations.size(); ++r) {
    const std::vector<CauseRange> ranges = distance_causes(report.result, r, report.scenario.seed);
    Json one = {{"representation", representation_of(report, r)},
                {"by_height", cause_ranges_json(ranges)},
                {"words", cause_words(ranges, "agent")},
                {"frames", Json::array()}};
    for (const DistanceCauses& frame : report.result.causes) {
      if (frame.representation != r) continue;
      Json of = {{"tick", frame.tick}};
      of.update(causes_json(frame.errors));
      one["frames"].push_back(std::move(of));
    }
    out.push_back(std::move(one));
  }
  return out;
}

void print_causes(const DistanceReport& report) {
  for (const DistanceCauses& frame : report.result.causes)
    fmt::print("\n{}, tick {}: squared error by cause, {} in all: {}\n",
               representation_of(report, frame.representation), frame.tick, frame.errors.whole.total,
               cause_shares_text(frame.errors.whole));
  for (size_t r = 0; r < report.request.representations.size(); ++r) {
    fmt::print("\n{}: the error is dominated by: {}\n", representation_of(report, r), words_of_causes(report, r));
    const auto told = std::find_if(report.result.causes.begin(), report.result.causes.end(),
                                   [&](const DistanceCauses& frame) { return frame.representation == r; });
    if (told != report.result.causes.end()) print_untold(told->errors);
  }
}

// The median of `against` over the counted agents as far away as the bin's.
std::optional<double> median_in(const DistanceReport& report, const CurveBin& bin, Against against,
                                size_t representation) {
  std::vector<double> values;
  for (const DistanceAgent& agent : report.result.agents) {
    const AgentView& view = agent.view;
    if (view.state != AgentState::counted || view.distance < bin.from || view.distance > bin.to) continue;
    const std::optional<double> value = against == Against::height
                                            ? std::optional(view.height_px)
                                            : pixels_per_texel(report.result, view, representation);
    if (value) values.push_back(*value);
  }
  if (values.empty()) return std::nullopt;
  return median(values);
}

void print_curve(const DistanceReport& report, const DistanceCurve& of) {
  const metrics::Score& score = *report.request.scores[of.score];
  fmt::print("\n{}: {}{}{}, {:g} = equal", representation_of(report, of.representation), score.title,
             score.unit.empty() ? "" : ", ", score.unit, metrics::best_value(score));
  if (of.curve.rank_correlation) fmt::print("; rank correlation with distance {:+.2f}", *of.curve.rank_correlation);
  fmt::print("\n{:>10} {:>17} {:>9} {:>9} {:>7} {:>10}  {}\n", "distance m", "of", "height px", "px/texel", "agents",
             "median", "95 %");
  for (const CurveBin& bin : of.curve.bins) {
    const auto number = [&](Against against) {
      const std::optional<double> value = median_in(report, bin, against, of.representation);
      return value ? fmt::format("{:.3g}", *value) : std::string("-");
    };
    fmt::print("{:>10.2f} {:>17} {:>9} {:>9} {:>7} {:>10}  {} to {}\n", bin.x,
               fmt::format("{:.2f} to {:.2f}", bin.from, bin.to), number(Against::height), number(Against::texel),
               bin.agents, metrics::value_text(score, bin.value), metrics::value_text(score, bin.low),
               metrics::value_text(score, bin.high));
  }
}

void print_thresholds(const DistanceReport& report) {
  const StoreContents rows = rows_of(report);
  bool first = true;
  for (const ThresholdRow& row : rows.thresholds) {
    const CurveRow& curve = rows.curves[static_cast<size_t>(row.curve - 1)];
    const size_t place = static_cast<size_t>(report.curves[static_cast<size_t>(row.curve - 1)].against);
    if (std::exchange(first, false)) fmt::print("\n");
    fmt::print("{}: {} of {:g} or better by {}: {}\n", curve.representation, curve.score, row.value,
               all_against()[place].title, reports::threshold_text(row, curve));
  }
}

std::string counts_text(const DistanceReport& report) {
  const Counts counts = counts_of(report);
  std::string text =
      report.request.frames == 1
          ? ""
          : fmt::format("of {} in all frames ",
                        counted(report.request.frames * report.scenario.crowd.agents, "agent", "agents"));
  text +=
      fmt::format("{} counted, {} occluded (less than {:g} % of the pixels that they cover alone), ",
                  counts.of(AgentState::counted), counts.of(AgentState::occluded), 100 * report.request.least_visible);
  text += fmt::format("{} cut off by the picture's edge, {} without a pixel, {} out of view",
                      counts.of(AgentState::cut_off), counts.of(AgentState::no_pixel), counts.out_of_view);
  return text;
}

std::string ticks_text(const DistanceRequest& request) {
  if (request.frames == 1) return fmt::format("tick {}", request.tick);
  return fmt::format("{} frames, ticks {} to {}", request.frames, request.tick,
                     request.tick + (request.frames - 1) * request.step);
}

}  // namespace

StoreContents rows_of(const DistanceReport& report, int64_t run) {
  return distance_rows(
      {report.cast, report.scenario.crowd.agents, report.scenario.occupancy.value_or(0), report.scenario.seed},
      report.request, report.result, report.curves, run);
}

Json distance_json(const DistanceReport& report) {
  const DistanceRequest& request = report.request;
  const Counts counts = counts_of(report);
  Json out = {{"scenario", report.scenario.name},     {"cast", report.cast},
              {"seed", report.scenario.seed},         {"width", report.scenario.width},
              {"height", report.scenario.height},     {"renderer", report.renderer},
              {"reference", request.reference.text()}};
  for (size_t r = 0; r < request.representations.size(); ++r)
    out["representations"].push_back(representation_of(report, r));
  for (uint64_t f = 0; f < request.frames; ++f) out["ticks"].push_back(request.tick + f * request.step);
  out["display"] = display_json(request.display);
  out["least_visible"] = request.least_visible;
  out["agents"] = {{"scenario", report.scenario.crowd.agents}};
  for (const AgentState state : kStates) out["agents"][state_name(state)] = counts.of(state);
  out["agents"]["out_of_view"] = counts.out_of_view;
  out["scores"] = out["curves"] = out["rows"] = Json::array();
  for (const metrics::Score* score : request.scores) out["scores"].push_back(score->name);
  for (const DistanceCurve& curve : report.curves) out["curves"].push_back(curve_json(report, curve));
  for (const DistanceAgent& agent : report.result.agents) out["rows"].push_back(row_json(report, agent));
  if (request.causes) out["causes"] = all_causes_json(report);
  return out;
}

std::string distance_csv(const DistanceReport& report) {
  std::string out =
      "representation,tick,agent,character,distance_m,height_px,pixels_per_texel,alone_px,visible_px,state";
  for (const metrics::Score* score : report.request.scores) out += fmt::format(",{}", score->name);
  out += "\n";
  for (const DistanceAgent& agent : report.result.agents) {
    const AgentView& view = agent.view;
    for (size_t r = 0; r < agent.values.size(); ++r) {
      const std::optional<double> ratio = pixels_per_texel(report.result, view, r);
      out +=
          fmt::format("{},{},{},{},{},{},{},{},{},{}", csv_field(representation_of(report, r)), view.tick, view.id - 1,
                      view.character, view.distance, view.height_px, ratio ? fmt::format("{}", *ratio) : "",
                      view.alone_px, view.visible_px, state_name(view.state));
      for (const std::optional<double>& value : agent.values[r]) out += value ? fmt::format(",{}", *value) : ",";
      out += "\n";
    }
  }
  return out;
}

void print_distance(const DistanceReport& report) {
  fmt::print("{} of {}, {} x {} pixels, {}, against {}; {}\n{}\n",
             counted(report.scenario.crowd.agents, "agent", "agents"), report.cast, report.scenario.width,
             report.scenario.height, ticks_text(report.request), report.request.reference.text(), report.renderer,
             counts_text(report));
  bool display = false;
  for (const DistanceCurve& of : report.curves) {
    const metrics::Score& score = *report.request.scores[of.score];
    if (of.against != Against::distance || (!report.list_all && (score.uses & metrics::kInTables) == 0)) continue;
    display = display || (score.needs & metrics::kNeedsDisplay) != 0;
    print_curve(report, of);
  }
  print_thresholds(report);
  if (report.request.causes) print_causes(report);
  if (display || report.request.display.given) fmt::print("\ndisplay {}\n", display_line(report.request.display));
}

std::string distance_page_of(const DistanceReport& report) {
  reports::DistancePage page;
  page.reference = report.request.reference.text();
  page.scene = fmt::format("{} of {}, {} x {} pixels, {}", counted(report.scenario.crowd.agents, "agent", "agents"),
                           report.cast, report.scenario.width, report.scenario.height, ticks_text(report.request));
  page.counts = counts_text(report);
  page.display = metrics::display_text(report.request.display);
  page.renderer = report.renderer;
  if (report.request.causes)
    for (size_t r = 0; r < report.request.representations.size(); ++r)
      page.causes.emplace_back(representation_of(report, r), words_of_causes(report, r));
  page.scores = reports::distance_scores(rows_of(report), 0, score_docs(report.request.scores));
  return reports::distance_page(page);
}

}  // namespace crowdbench::bench
