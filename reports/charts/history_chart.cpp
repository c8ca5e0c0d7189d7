#include "reports/charts/history_chart.h"

#include <fmt/format.h>

#include "reports/charts/chart_frame.h"

namespace crowdbench::reports {
namespace {

Json values_of(const HistorySeries& series) {
  Json values = Json::array();
  for (size_t i = 0; i < series.values.size(); ++i) {
    const HistoryValue& value = series.values[i];
    values.push_back({{"run", i + 1},
                      {"value", value.value},
                      {"low", value.low},
                      {"high", value.high},
                      {"text", fmt::format("{:.4g} [{:.4g}, {:.4g}]", value.value, value.low, value.high)},
                      {"revision", value.revision},
                      {"started", value.started}});
  }
  return values;
}

// The mean between neighbouring changes, drawn from the first run of a level to its last.
Json levels_of(const HistorySeries& series) {
  Json levels = Json::array();
  size_t from = 0;
  for (size_t change = 0; change <= series.changes.size(); ++change) {
    const size_t to = change < series.changes.size() ? series.changes[change].point.index : series.values.size();
    double mean = 0;
    for (size_t i = from; i < to; ++i) mean += series.values[i].value / static_cast<double>(to - from);
    levels.push_back({{"from", from + 1}, {"to", to}, {"mean", mean}});
    from = to;
  }
  return levels;
}

Json changes_of(const HistorySeries& series) {
  Json changes = Json::array();
  for (const HistoryChange& change : series.changes)
    changes.push_back({{"run", change.point.index + 1},
                       {"label", fmt::format("{} {:+.1f} %", change.revision,
                                             100 * (change.point.mean_after / change.point.mean_before - 1))}});
  return changes;
}

}  // namespace

std::string history_chart(const HistorySeries& series) {
  const char* const ink = "#0072b2";
  const char* const mark = "#d55e00";
  const auto of = [](const char* field) { return Json{{"field", field}, {"type", "quantitative"}}; };
  const auto tip = [](const char* field, const char* title) {
    return Json{{"field", field}, {"type", "nominal"}, {"title", title}};
  };
  Json x = of("run");
  x["axis"] = {{"title", "run"}, {"tickMinStep", 1}};
  Json y = of("value");
  y["scale"] = {{"zero", false}, {"nice", true}};
  y["axis"] = {{"title", "time over the reference's"}, {"tickCount", 5}};
  Json low = y;
  low["field"] = "low";
  Json level_x = x;
  level_x["field"] = "from";
  Json level_y = y;
  level_y["field"] = "mean";
  Json spec = chart_frame(220);
  spec["data"] = {{"values", values_of(series)}};
  spec["layer"] = Json::array(
      {{{"mark", {{"type", "rule"}, {"strokeWidth", 1.5}, {"color", ink}, {"opacity", 0.6}}},
        {"encoding", {{"x", x}, {"y", low}, {"y2", {{"field", "high"}}}}}},
       {{"mark", {{"type", "point"}, {"filled", true}, {"size", 50}, {"opacity", 1}, {"color", ink}}},
        {"encoding",
         {{"x", x},
          {"y", y},
          {"tooltip", Json::array({tip("revision", "revision"), tip("started", "started"), tip("text", "95 %")})}}}},
       {{"data", {{"values", levels_of(series)}}},
        {"mark", {{"type", "rule"}, {"strokeWidth", 2}, {"color", "#52606d"}}},
        {"encoding", {{"x", level_x}, {"x2", {{"field", "to"}}}, {"y", level_y}}}},
       {{"data", {{"values", changes_of(series)}}},
        {"mark", {{"type", "rule"}, {"strokeDash", {4, 4}}, {"color", mark}}},
        {"encoding", {{"x", of("run")}}}},
       {{"data", {{"values", changes_of(series)}}},
        {"mark", {{"type", "text"}, {"align", "left"}, {"dx", 5}, {"baseline", "top"}, {"color", mark}}},
        {"encoding", {{"x", of("run")}, {"y", {{"value", 2}}}, {"text", {{"field", "label"}}}}}}});
  return spec.dump();
}

}  // namespace crowdbench::reports
