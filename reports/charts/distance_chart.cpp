#include "reports/charts/distance_chart.h"

#include <fmt/format.h>

#include <cmath>
#include <set>

#include "reports/charts/chart_frame.h"
#include "reports/charts/charts.h"

namespace crowdbench::reports {
namespace {

Json finite(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json bins_of(const ScoreDoc& doc, const DistanceGraph& graph, size_t& drawn) {
  Json values = Json::array();
  for (const DistanceSeries& series : graph.series)
    for (const DistanceBin& bin : series.bins) {
      drawn += std::isfinite(bin.value) ? 1 : 0;
      const bool band = std::isfinite(bin.low) && std::isfinite(bin.high);
      values.push_back({{"representation", series.representation},
                        {"x", bin.x},
                        {"value", finite(bin.value)},
                        {"low", band ? Json(bin.low) : Json(nullptr)},
                        {"high", band ? Json(bin.high) : Json(nullptr)},
                        {"where", fmt::format("{:.4g}{}{}", bin.x, graph.unit.empty() ? "" : " ", graph.unit)},
                        {"text", fmt::format("{}, 95 %: {} to {}", score_text(doc, bin.value), score_text(doc, bin.low),
                                             score_text(doc, bin.high))},
                        {"agents", bin.agents}});
    }
  return values;
}

Json points_of(const DistanceGraph& graph) {
  Json values = Json::array();
  for (const DistanceSeries& series : graph.series)
    for (const DistancePoint& point : series.points)
      if (std::isfinite(point.value))
        values.push_back({{"representation", series.representation}, {"x", point.x}, {"value", point.value}});
  return values;
}

Json thresholds_of(const DistanceGraph& graph) {
  std::set<double> found;
  for (const DistanceSeries& series : graph.series)
    for (const DistanceThresholdText& threshold : series.thresholds) found.insert(threshold.value);
  Json values = Json::array();
  for (const double value : found) values.push_back({{"value", value}});
  return values;
}

Json colour_of(const DistanceGraph& graph) {
  std::vector<std::string> names;
  for (const DistanceSeries& series : graph.series) names.push_back(series.representation);
  // The first colour is the reference's, which has no curve here.
  std::vector<std::string> colours = representation_colours(names.size() + 1);
  colours.erase(colours.begin());
  return {{"field", "representation"},
          {"type", "nominal"},
          {"scale", {{"domain", names}, {"range", colours}}},
          {"legend", {{"title", nullptr}, {"symbolOpacity", 1}}}};
}

Json tip(const char* field, const std::string& title) {
  return {{"field", field}, {"type", "nominal"}, {"title", title}};
}

}  // namespace

std::string distance_chart(const ScoreDoc& doc, const DistanceGraph& graph) {
  size_t drawn = 0;
  const Json bins = bins_of(doc, graph, drawn);
  if (drawn == 0) return {};
  const std::string title = graph.against + (graph.unit.empty() ? "" : ", " + graph.unit);
  const Json x = {{"field", "x"},
                  {"type", "quantitative"},
                  {"scale", {{"zero", false}, {"nice", true}, {"reverse", graph.far_is_low}}},
                  {"axis", {{"title", title}, {"tickCount", 8}, {"format", ".4~r"}}}};
  const auto y = [&](const char* field) {
    return Json{{"field", field},
                {"type", "quantitative"},
                {"scale", {{"zero", false}, {"nice", true}}},
                // The heading above names the score.
                {"axis", {{"title", doc.unit}, {"tickCount", 5}}}};
  };
  const Json colour = colour_of(graph);
  Json spec = chart_frame(220);
  spec["data"] = {{"values", bins}};
  Json layers = Json::array();
  // A layer without values would have no range, of which the page's console is told.
  if (Json points = points_of(graph); !points.empty())
    layers.push_back({{"data", {{"values", std::move(points)}}},
                      {"mark", {{"type", "point"}, {"filled", true}, {"size", 14}, {"opacity", 0.3}, {"clip", true}}},
                      {"encoding", {{"x", x}, {"y", y("value")}, {"color", colour}}}});
  layers.push_back({{"mark", {{"type", "area"}, {"opacity", 0.2}, {"invalid", "break-paths-show-domains"}}},
                    {"encoding", {{"x", x}, {"y", y("low")}, {"y2", {{"field", "high"}}}, {"color", colour}}}});
  layers.push_back({{"mark", {{"type", "line"}, {"strokeWidth", 2}, {"invalid", "break-paths-show-domains"}}},
                    {"encoding", {{"x", x}, {"y", y("value")}, {"color", colour}}}});
  if (Json thresholds = thresholds_of(graph); !thresholds.empty())
    layers.push_back({{"data", {{"values", std::move(thresholds)}}},
                      {"mark", {{"type", "rule"}, {"strokeDash", {4, 4}}, {"color", kChartInk}}},
                      {"encoding", {{"y", y("value")}}}});
  layers.push_back({{"mark", {{"type", "point"}, {"filled", true}, {"size", 40}, {"opacity", 1}}},
                    {"encoding",
                     {{"x", x},
                      {"y", y("value")},
                      {"color", colour},
                      {"tooltip", Json::array({tip("representation", "representation"), tip("where", graph.against),
                                               tip("text", "median"), tip("agents", "agents")})}}}});
  spec["layer"] = std::move(layers);
  return spec.dump();
}

}  // namespace crowdbench::reports
