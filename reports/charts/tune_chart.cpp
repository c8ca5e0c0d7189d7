#include "reports/charts/tune_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/json.h"
#include "reports/charts/chart_frame.h"
#include "reports/charts/charts.h"

namespace crowdbench::reports {
namespace {

Json finite(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? Json(*value) : Json(nullptr);
}

struct Depths {
  double least = INFINITY, greatest = 0;
};
Depths depths_of(const TuneGraph& graph) {
  Depths out;
  for (const TuneCurve& curve : graph.curves)
    for (const TunePoint& point : curve.points) {
      out.least = std::min(out.least, point.depth);
      out.greatest = std::max(out.greatest, point.depth);
    }
  return out;
}

Json depth_x(const Depths& depths) {
  std::vector<double> ticks;
  for (int power = -3; power < 6; ++power)
    for (const double step : {1.0, 2.0, 5.0}) {
      const double tick = step * std::pow(10.0, power);
      if (tick >= depths.least / 1.001 && tick <= depths.greatest * 1.001) ticks.push_back(tick);
    }
  return {{"field", "depth"},
          {"type", "quantitative"},
          {"scale", {{"type", "log"}, {"domain", {depths.least / 1.05, depths.greatest * 1.05}}, {"nice", false}}},
          {"axis",
           {{"title", "distance along the view axis, m"},
            {"values", ticks},
            {"format", ",~r"},
            {"labelOverlap", "greedy"}}}};
}

Json colour_of(const TuneGraph& graph) {
  std::vector<std::string> names;
  for (const TuneCurve& curve : graph.curves) names.push_back(curve.representation);
  return {{"field", "representation"},
          {"type", "nominal"},
          {"scale", {{"domain", names}, {"range", representation_colours(names.size())}}},
          {"legend", nullptr}};
}

Json tip(const char* field, const char* title) { return {{"field", field}, {"type", "nominal"}, {"title", title}}; }

Json point_base(const TuneCurve& curve, double depth, double height_px, bool chosen) {
  return {{"representation", curve.representation},
          {"depth", depth},
          {"where", fmt::format("{:.1f} m, {:.1f} px tall", depth, height_px)},
          {"chosen", chosen}};
}

// Lines down at switches, within the depths that are shown.
void add_marks(Json& layers, const TuneGraph& graph, const Depths& depths, const Json& x, const Json& colour) {
  for (const bool predicted : {false, true}) {
    Json values = Json::array();
    for (const TuneMark& mark : graph.marks)
      if (mark.predicted == predicted && mark.depth >= depths.least && mark.depth <= depths.greatest)
        values.push_back({{"representation", mark.representation}, {"depth", mark.depth}, {"text", mark.text}});
    if (values.empty()) continue;
    Json mark = {{"type", "rule"}, {"strokeWidth", predicted ? 1.5 : 2.5}, {"opacity", 0.9}};
    if (predicted) mark["strokeDash"] = {2, 4};
    layers.push_back({{"data", {{"values", std::move(values)}}},
                      {"mark", std::move(mark)},
                      {"encoding",
                       {{"x", x},
                        {"color", colour},
                        {"tooltip", Json::array({tip("representation", "to"),
                                                 tip("text", predicted ? "rule of thumb" : "switch")})}}}});
  }
}

// Curves of the field `value`, with bands of `low` and `high` where `bands` says so.
Json curve_layers(const Json& x, const Json& y, const Json& y_low, const Json& colour, bool bands, const char* title) {
  Json layers = Json::array();
  if (bands)
    layers.push_back({{"mark", {{"type", "area"}, {"opacity", 0.16}, {"invalid", "break-paths-show-domains"}}},
                      {"encoding", {{"x", x}, {"y", y_low}, {"y2", {{"field", "high"}}}, {"color", colour}}}});
  layers.push_back({{"mark", {{"type", "line"}, {"strokeWidth", 1.6}, {"invalid", "break-paths-show-domains"}}},
                    {"encoding", {{"x", x}, {"y", y}, {"color", colour}}}});
  layers.push_back({{"mark", {{"type", "point"}, {"filled", true}, {"opacity", 1}}},
                    {"encoding",
                     {{"x", x},
                      {"y", y},
                      {"color", colour},
                      {"size", {{"condition", {{"test", "datum.chosen"}, {"value", 110}}}, {"value", 18}}},
                      {"tooltip", Json::array({tip("representation", "representation"), tip("where", "at"),
                                               tip("text", title)})}}}});
  return layers;
}

}  // namespace

std::string tune_error_chart(const TuneGraph& graph) {
  Json values = Json::array();
  size_t drawn = 0;
  bool bands = false;
  for (const TuneCurve& curve : graph.curves)
    for (const TunePoint& point : curve.points) {
      if (!point.tail) continue;
      Json one = point_base(curve, point.depth, point.height_px, point.chosen);
      const bool band = point.low && point.high && std::isfinite(*point.low) && std::isfinite(*point.high);
      drawn += std::isfinite(*point.tail) ? 1 : 0;
      bands = bands || band;
      one["value"] = finite(point.tail);
      one["low"] = band ? Json(*point.low) : Json(nullptr);
      one["high"] = band ? Json(*point.high) : Json(nullptr);
      one["text"] = fmt::format("{}, 95 %: {} to {}{}", score_text(graph.doc, *point.tail),
                                score_text(graph.doc, point.low.value_or(*point.tail)),
                                score_text(graph.doc, point.high.value_or(*point.tail)),
                                point.allowed   ? ""
                                : graph.bounded ? "; not allowed"
                                                : "");
      values.push_back(std::move(one));
    }
  if (drawn == 0) return {};
  const Depths depths = depths_of(graph);
  const Json x = depth_x(depths);
  const Json colour = colour_of(graph);
  const auto y = [&](const char* field) {
    return Json{{"field", field},
                {"type", "quantitative"},
                {"scale", {{"zero", false}, {"nice", true}}},
                {"axis", {{"title", graph.doc.unit}, {"tickCount", 6}}}};
  };
  Json spec = chart_frame(300);
  spec["data"] = {{"values", std::move(values)}};
  Json layers = curve_layers(x, y("value"), y("low"), colour, bands, "the worst 5 %");
  if (graph.bounded && std::isfinite(graph.threshold))
    layers.push_back({{"data", {{"values", Json::array({Json{{"value", graph.threshold}}})}}},
                      {"mark", {{"type", "rule"}, {"strokeDash", {6, 4}}, {"color", kChartInk}}},
                      {"encoding", {{"y", y("value")}}}});
  add_marks(layers, graph, depths, x, colour);
  spec["layer"] = std::move(layers);
  return spec.dump();
}

std::string tune_cost_chart(const TuneGraph& graph) {
  Json values = Json::array();
  double least = INFINITY;
  double greatest = 0;
  bool bands = false;
  for (const TuneCurve& curve : graph.curves)
    for (const TuneCost& cost : curve.costs) {
      Json one = point_base(curve, cost.depth, cost.height_px, false);
      const double low = 1e-3 * cost.low_ns.value_or(cost.ns);
      const double high = 1e-3 * cost.high_ns.value_or(cost.ns);
      const bool band = cost.low_ns && cost.high_ns && low > 0;
      least = std::min(least, band ? low : 1e-3 * cost.ns);
      greatest = std::max(greatest, high);
      bands = bands || band;
      one["value"] = 1e-3 * cost.ns;
      one["low"] = band ? Json(low) : Json(nullptr);
      one["high"] = band ? Json(high) : Json(nullptr);
      one["text"] = fmt::format("{:.3g} \u00b5s, {}", 1e-3 * cost.ns,
                                cost.low_ns ? fmt::format("95 %: {:.3g} to {:.3g}", low, high)
                                            : std::string("within the noise: the whole frame over its agents"));
      values.push_back(std::move(one));
    }
  if (values.empty()) return {};
  const Depths depths = depths_of(graph);
  const Json x = depth_x(depths);
  const Json colour = colour_of(graph);
  const auto y = [&](const char* field) {
    return Json{
        {"field", field},
        {"type", "quantitative"},
        {"scale", {{"type", "log"}, {"domain", {least / 1.3, greatest * 1.3}}, {"nice", false}}},
        {"axis", {{"title", "\u00b5s an agent"}, {"format", ",~r"}, {"tickCount", 5}, {"labelOverlap", "greedy"}}}};
  };
  Json spec = chart_frame(220);
  spec["data"] = {{"values", std::move(values)}};
  Json layers = curve_layers(x, y("value"), y("low"), colour, bands, "one more agent");
  add_marks(layers, graph, depths, x, colour);
  spec["layer"] = std::move(layers);
  return spec.dump();
}

}  // namespace crowdbench::reports
