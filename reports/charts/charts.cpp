#include "reports/charts/charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/json.h"
#include "reports/charts/chart_frame.h"
#include "reports/model/crossovers.h"
#include "reports/model/number_text.h"
#include "reports/model/scores.h"
#include "reports/model/shown.h"

namespace crowdbench::reports {
namespace {

// With a legend, the same in all layers of a chart: where they disagree, Vega-Lite warns and draws none. Names beside
// lines would lie on other lines wherever one is long or the screen narrow.
Json colour_of(const Scene& scene) {
  return {
      {"field", "representation"},
      {"type", "nominal"},
      {"scale", {{"domain", scene.representations}, {"range", representation_colours(scene.representations.size())}}},
      {"legend", {{"title", nullptr}, {"symbolOpacity", 1}}}};
}

// 1, 2, 5, 10, 20, 50, ... within a factor of the data.
std::vector<double> nice_ticks(double least, double greatest) {
  std::vector<double> ticks;
  for (int power = -6; power < 10; ++power)
    for (const double step : {1.0, 2.0, 5.0}) {
      const double tick = step * std::pow(10.0, power);
      if (tick >= least * 0.999 && tick <= greatest * 1.001) ticks.push_back(tick);
    }
  return ticks;
}

Json log_axis(const std::string& title, const std::vector<double>& ticks) {
  // "~r" writes 0.05, 20 and 1000 as they are.
  return {{"title", title}, {"values", ticks},          {"format", ",~r"},
          {"grid", true},   {"labelOverlap", "greedy"}, {"minExtent", 38}};
}

struct Range {
  double least = INFINITY;
  double greatest = -INFINITY;
  void take(double value) {
    if (!std::isfinite(value) || value <= 0) return;
    least = std::min(least, value);
    greatest = std::max(greatest, value);
  }
};

std::vector<double> agent_ticks(const Scene& scene) {
  std::vector<double> ticks;
  for (const uint32_t agents : shown_agents(scene))
    if (agents > 0) ticks.push_back(agents);
  return ticks;
}

Range agents_shown(const Scene& scene) {
  const std::vector<double> ticks = agent_ticks(scene);
  const double least = ticks.empty() ? 1 : ticks.front();
  const double greatest = ticks.empty() ? 10 : ticks.back();
  return {least / 1.15, greatest * 1.15};
}

Json agents_x(const Scene& scene) {
  const Range shown = agents_shown(scene);
  return {{"field", "agents"},
          {"type", "quantitative"},
          {"scale", {{"type", "log"}, {"domain", {shown.least, shown.greatest}}, {"nice", false}}},
          {"axis", log_axis("agents", agent_ticks(scene))}};
}

Json tooltip(std::initializer_list<std::pair<const char*, const char*>> fields) {
  Json list = Json::array();
  for (const auto& [field, title] : fields) list.push_back({{"field", field}, {"type", "nominal"}, {"title", title}});
  return list;
}

}  // namespace

std::vector<std::string> representation_colours(size_t count) {
  static const std::vector<std::string> set = {"#334155", "#d55e00", "#0072b2", "#009e73",
                                               "#cc79a7", "#b58900", "#56b4e9", "#7b4fa3"};
  std::vector<std::string> colours;
  for (size_t i = 0; i < count; ++i) colours.push_back(set[i % set.size()]);
  return colours;
}

std::string time_chart(const Scene& scene, double occupancy) {
  const std::string& metric = scene.run->headline;
  constexpr int kHeight = 330;
  Json values = Json::array();
  Range range;
  // One scale for every occupancy, so that the charts beside each other compare.
  for (const MeasurementRow* row : scene.rows)
    if (is_timed(*row) && time_of(*row, metric)) {
      range.take(time_of(*row, metric)->low / 1e6);
      range.take(time_of(*row, metric)->high / 1e6);
    }
  for (const std::string& name : scene.representations) {
    for (const uint32_t agents : shown_agents(scene)) {
      const MeasurementRow* row = scene.find(name, agents, occupancy);
      if (row == nullptr || !is_timed(*row) || !time_of(*row, metric) || agents == 0) continue;
      const TimeSummary& time = *time_of(*row, metric);
      Json point = {{"representation", name},
                    {"agents", agents},
                    {"ms", time.median / 1e6},
                    {"low", time.low / 1e6},
                    {"high", time.high / 1e6},
                    {"crowd", count_text(agents)},
                    {"median", time_text(time.median)},
                    {"interval", fmt::format("{} to {}", time_text(time.low), time_text(time.high))},
                    {"wall", row->frame_ns ? time_text(row->frame_ns->median) : ""},
                    {"covers", row->achieved_occupancy ? percent_text(*row->achieved_occupancy) : ""},
                    {"rounds", row->rounds}};
      if (const RatioRow* ratio = scene.ratio("speed", name, agents, occupancy, metric); ratio != nullptr)
        point["speed"] = fmt::format("{}\u00d7 [{}, {}]", factor_text(ratio->ratio), factor_text(ratio->low),
                                     factor_text(ratio->high));
      else
        point["speed"] = "\u2013";
      values.push_back(point);
    }
  }
  if (values.empty()) return {};
  Json crossings = Json::array();
  for (const CrossoverLine& line : crossovers_of(scene, metric))
    if (line.occupancy == occupancy && line.agents && (line.first == scene.reference || line.second == scene.reference))
      crossings.push_back(
          {{"agents", *line.agents},
           {"ms", line.time_ns / 1e6},
           {"pair", line.first + " and " + line.second},
           {"at", fmt::format("{:.0f} agents ({:.0f} to {:.0f})", *line.agents, line.agents_low, line.agents_high)},
           {"beyond", line.cheaper_beyond + " is cheaper"}});

  const double least = range.least / 1.3;
  const double greatest = range.greatest * 1.3;
  Json spec = chart_frame(kHeight);
  const Json x = agents_x(scene);
  Json y = {
      {"field", "ms"},
      {"type", "quantitative"},
      {"scale", {{"type", "log"}, {"domain", {least, greatest}}, {"nice", false}}},
      {"axis", log_axis(fmt::format("median {} a frame (ms)", metric_title(metric)), nice_ticks(least, greatest))}};
  Json interval_y = y;
  interval_y["field"] = "low";
  const Json tips = tooltip({{"representation", "representation"},
                             {"crowd", "agents"},
                             {"median", "median a frame"},
                             {"interval", "95 % interval"},
                             {"speed", "times as fast as the reference"},
                             {"wall", "wall clock"},
                             {"covers", "occupancy"},
                             {"rounds", "timed frames"}});
  spec["data"] = {{"values", values}};
  spec["layer"] = Json::array(
      {{{"mark", {{"type", "area"}, {"opacity", 0.18}}},
        {"encoding", {{"x", x}, {"y", interval_y}, {"y2", {{"field", "high"}}}, {"color", colour_of(scene)}}}},
       {{"mark", {{"type", "line"}, {"strokeWidth", 2.5}}},
        {"encoding", {{"x", x}, {"y", y}, {"color", colour_of(scene)}}}},
       {{"mark", {{"type", "rule"}, {"strokeWidth", 2}}},
        {"encoding", {{"x", x}, {"y", interval_y}, {"y2", {{"field", "high"}}}, {"color", colour_of(scene)}}}},
       {{"mark", {{"type", "point"}, {"filled", true}, {"size", 70}, {"opacity", 1}}},
        {"encoding", {{"x", x}, {"y", y}, {"color", colour_of(scene)}}}},
       {{"data", {{"values", crossings}}},
        {"mark", {{"type", "rule"}, {"strokeDash", {4, 4}}, {"color", "#7b8794"}}},
        {"encoding",
         {{"x", {{"field", "agents"}, {"type", "quantitative"}}},
          {"tooltip", tooltip({{"pair", "crossing of"}, {"at", "at"}, {"beyond", "beyond it"}})}}}},
       // Invisible and large, so that a tooltip is easily hit.
       {{"mark", {{"type", "point"}, {"filled", true}, {"size", 500}, {"opacity", 0}}},
        {"encoding", {{"x", x}, {"y", y}, {"tooltip", tips}}}}});
  return spec.dump();
}

std::string speed_chart(const Scene& scene) {
  const std::string& metric = scene.run->headline;
  constexpr int kHeight = 300;
  Json values = Json::array();
  const std::vector<double> occupancies = shown_occupancies(scene);
  Range range;
  range.take(1);
  for (const std::string& name : scene.representations) {
    if (name == scene.reference) continue;
    for (const double occupancy : occupancies) {
      const std::string covers = occupancy > 0 ? percent_text(occupancy) : "the scenario's view";
      for (const uint32_t agents : shown_agents(scene)) {
        const MeasurementRow* row = scene.find(name, agents, occupancy);
        const RatioRow* ratio = scene.ratio("speed", name, agents, occupancy, metric);
        if (row == nullptr || ratio == nullptr || !is_timed(*row) || agents == 0) continue;
        range.take(ratio->low);
        range.take(ratio->high);
        values.push_back({{"representation", name},
                          {"series", name + " at " + covers},
                          {"occupancy", covers},
                          {"agents", agents},
                          {"ratio", ratio->ratio},
                          {"low", ratio->low},
                          {"high", ratio->high},
                          {"crowd", count_text(agents)},
                          {"times", fmt::format("{}\u00d7", factor_text(ratio->ratio))},
                          {"interval", fmt::format("{} to {}", factor_text(ratio->low), factor_text(ratio->high))},
                          {"pairs", ratio->pairs}});
      }
    }
  }
  if (values.empty()) return {};
  const double least = range.least / 1.3;
  const double greatest = range.greatest * 1.3;
  Json spec = chart_frame(kHeight);
  const Json x = agents_x(scene);
  const Json y = {{"field", "ratio"},
                  {"type", "quantitative"},
                  {"scale", {{"type", "log"}, {"domain", {least, greatest}}, {"nice", false}}},
                  {"axis", log_axis("times as fast as " + scene.reference, nice_ticks(least, greatest))}};
  Json low = y;
  low["field"] = "low";
  const Json dash = {
      {"field", "occupancy"},
      {"type", "nominal"},
      {"sort", nullptr},
      {"legend", occupancies.size() > 1 ? Json({{"title", nullptr}, {"symbolType", "stroke"}}) : Json(nullptr)}};
  spec["data"] = {{"values", values}};
  spec["layer"] = Json::array(
      {{{"data", {{"values", Json::array({{{"ratio", 1}}})}}},
        {"mark", {{"type", "rule"}, {"strokeWidth", 1.5}, {"color", representation_colours(1)[0]}}},
        {"encoding", {{"y", y}}}},
       {{"mark", {{"type", "area"}, {"opacity", 0.18}}},
        {"encoding",
         {{"x", x},
          {"y", low},
          {"y2", {{"field", "high"}}},
          {"detail", {{"field", "series"}}},
          {"color", colour_of(scene)}}}},
       {{"mark", {{"type", "line"}, {"strokeWidth", 2.5}}},
        {"encoding",
         {{"x", x}, {"y", y}, {"detail", {{"field", "series"}}}, {"strokeDash", dash}, {"color", colour_of(scene)}}}},
       {{"mark", {{"type", "rule"}, {"strokeWidth", 1.5}}},
        {"encoding", {{"x", x}, {"y", low}, {"y2", {{"field", "high"}}}, {"color", colour_of(scene)}}}},
       {{"mark", {{"type", "point"}, {"filled", true}, {"size", 60}, {"opacity", 1}}},
        {"encoding", {{"x", x}, {"y", y}, {"color", colour_of(scene)}}}},
       {{"mark", {{"type", "point"}, {"filled", true}, {"size", 500}, {"opacity", 0}}},
        {"encoding",
         {{"x", x},
          {"y", y},
          {"tooltip", tooltip({{"representation", "representation"},
                               {"crowd", "agents"},
                               {"occupancy", "occupancy"},
                               {"times", "times as fast as the reference"},
                               {"interval", "95 % interval"},
                               {"pairs", "interleaved pairs"}})}}}}});
  return spec.dump();
}

std::string score_chart(const Scene& scene, const ScoreDoc& score) {
  const std::vector<ScoreByHeight> points = scores_by_height(scene, score.name);
  if (points.empty()) return {};
  Json values = Json::array();
  std::vector<double> heights;
  for (const ScoreByHeight& point : points) {
    values.push_back({{"representation", point.representation},
                      {"height", point.height_px},
                      {"mean", point.mean},
                      {"least", point.least},
                      {"greatest", point.greatest},
                      {"pixels", fmt::format("{:.0f}", point.height_px)},
                      {"value", score_text(score, point.mean)},
                      {"range", score_text(score, point.least) + " to " + score_text(score, point.greatest)},
                      {"views", point.views}});
    heights.push_back(point.height_px);
  }
  std::sort(heights.begin(), heights.end());
  heights.erase(std::unique(heights.begin(), heights.end()), heights.end());
  Json spec = chart_frame(240);
  const Json x = {
      {"field", "height"},
      {"type", "quantitative"},
      {"scale", {{"type", "log"}, {"domain", {heights.front() / 1.15, heights.back() * 1.15}}, {"nice", false}}},
      {"axis", log_axis("height of the figure (pixels)", heights)}};
  const Json y = {{"field", "mean"},
                  {"type", "quantitative"},
                  {"scale", {{"zero", false}, {"nice", true}}},
                  // The heading above names the score.
                  {"axis", {{"title", score.unit}, {"tickCount", 5}}}};
  Json least = y;
  least["field"] = "least";
  spec["data"] = {{"values", values}};
  spec["layer"] = Json::array(
      {{{"mark", {{"type", "area"}, {"opacity", 0.15}}},
        {"encoding", {{"x", x}, {"y", least}, {"y2", {{"field", "greatest"}}}, {"color", colour_of(scene)}}}},
       {{"mark", {{"type", "line"}, {"strokeWidth", 2.5}, {"point", {{"size", 60}, {"filled", true}}}}},
        {"encoding", {{"x", x}, {"y", y}, {"color", colour_of(scene)}}}},
       {{"mark", {{"type", "point"}, {"filled", true}, {"size", 500}, {"opacity", 0}}},
        {"encoding",
         {{"x", x},
          {"y", y},
          {"tooltip", tooltip({{"representation", "representation"},
                               {"pixels", "height in pixels"},
                               {"value", "mean over the views"},
                               {"range", "least to greatest"},
                               {"views", "views"}})}}}}});
  return spec.dump();
}

std::string pop_chart(const PopSize& size, const std::vector<ScoreDoc>& scores, size_t ranking, double high) {
  const auto text = [&](const PopPoint& point, size_t score, size_t kind) {
    const std::optional<double>& value = point.scores[score][kind];
    return value ? score_text(scores[score], *value) : std::string("too small");
  };
  Json values = Json::array();
  for (size_t w = 0; w < kPopSwitchKinds; ++w)
    for (const PopPoint& point : size.points) {
      const std::optional<double>& coloured = point.scores[ranking][w];
      if (!coloured) continue;
      Json value = {{"switch", kPopSwitchTitles[w]},
                    {"phase", fmt::format("phase {:g}", point.phase)},
                    {"azimuth", point.azimuth_deg},
                    {"elevation", point.elevation_deg},
                    {"coloured", std::isfinite(*coloured) ? Json(*coloured) : Json(high)}};
      for (size_t i = 0; i < scores.size(); ++i) value["score_" + scores[i].name] = text(point, i, w);
      values.push_back(std::move(value));
    }
  if (values.empty()) return {};
  Json spec = chart_frame();
  const auto tip = [](const std::string& field, const std::string& title) {
    return Json{{"field", field}, {"type", "nominal"}, {"title", title}};
  };
  spec["config"]["header"] = {{"labelFontSize", 12}, {"labelColor", kChartInk}, {"labelPadding", 4}};
  spec["config"]["title"] = {{"anchor", "start"}, {"fontSize", 12}, {"fontWeight", 600}, {"color", kChartInk}};
  spec["data"] = {{"values", values}};
  spec["spacing"] = 12;
  spec["vconcat"] = Json::array();
  for (size_t w = 0; w < kPopSwitchKinds; ++w) {
    const bool first = w == 0;
    const bool last = w + 1 == kPopSwitchKinds;
    Json encoding;
    encoding["x"] = {{"field", "azimuth"},
                     {"type", "ordinal"},
                     {"axis",
                      {{"title", last ? Json("azimuth, degrees") : Json(nullptr)},
                       {"labels", last},
                       {"ticks", last},
                       {"labelOverlap", "greedy"},
                       {"labelSeparation", 8},
                       {"labelAngle", 0},
                       {"format", "~r"}}}};
    encoding["y"] = {{"field", "elevation"},
                     {"type", "ordinal"},
                     {"sort", "descending"},
                     {"axis", {{"title", "elevation"}, {"labelOverlap", "greedy"}}}};
    encoding["color"] = {{"field", "coloured"},
                         {"type", "quantitative"},
                         {"scale", {{"scheme", "viridis"}, {"domain", {0, high}}}},
                         // One for all rows, which share the scale: every row must say the same.
                         {"legend", {{"title", heading(scores[ranking])}, {"gradientLength", 240}}}};
    encoding["tooltip"] = Json::array({tip("switch", "the mesh shows"), tip("phase", "clip"), tip("azimuth", "azimuth"),
                                       tip("elevation", "elevation")});
    for (const ScoreDoc& doc : scores) encoding["tooltip"].push_back(tip("score_" + doc.name, heading(doc)));
    Json column = {{"field", "phase"}, {"type", "nominal"}, {"sort", nullptr}};
    column["header"] = {{"title", nullptr}, {"labels", first}};
    Json row;
    row["title"] = kPopSwitchTitles[w];
    row["transform"] = Json::array({Json{{"filter", {{"field", "switch"}, {"equal", kPopSwitchTitles[w]}}}}});
    row["spacing"] = 10;
    row["facet"]["column"] = column;
    row["spec"] = {{"width", 236}, {"height", 76}, {"mark", "rect"}, {"encoding", encoding}};
    spec["vconcat"].push_back(row);
  }
  return spec.dump();
}

}  // namespace crowdbench::reports
