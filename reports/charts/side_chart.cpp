#include "reports/charts/side_chart.h"

#include <fmt/format.h>

#include "core/json.h"
#include "reports/charts/chart_frame.h"
#include "reports/charts/charts.h"
#include "reports/model/number_text.h"

namespace crowdbench::reports {
namespace {

Json side_axis(const char* field, const std::string& title) {
  return {
      {"field", field},
      {"type", "quantitative"},
      {"scale", {{"type", "log"}, {"nice", true}}},
      {"axis",
       {{"title", title}, {"tickCount", 5}, {"format", "~g"}, {"labelOverlap", "greedy"}, {"labelSeparation", 10}}}};
}

Json side_tip(const char* field, const char* title) {
  return {{"field", field}, {"type", "nominal"}, {"title", title}};
}

Json side_values(const SideBySide& sides, const SideGroup& group, const std::string& representation, double occupancy) {
  Json values = Json::array();
  for (const SideRow& row : group.rows) {
    if (row.representation != representation || row.occupancy != occupancy || row.agents == 0) continue;
    for (size_t file = 0; file < sides.files.size(); ++file) {
      const RatioRow* ratio = row.cells[file].ratio;
      if (ratio == nullptr || !(ratio->low > 0)) continue;
      values.push_back({{"file", sides.files[file]},
                        {"agents", row.agents},
                        {"ratio", ratio->ratio},
                        {"low", ratio->low},
                        {"high", ratio->high},
                        {"text", side_text(row.cells[file])},
                        {"pairs", ratio->pairs}});
    }
  }
  return values;
}

}  // namespace

std::string side_chart(const SideBySide& sides, const SideGroup& group, const std::string& representation,
                       double occupancy) {
  const Json values = side_values(sides, group, representation, occupancy);
  if (values.empty()) return {};
  // The reference's own colour is not among those of the files.
  std::vector<std::string> colours = representation_colours(sides.files.size() + 1);
  colours.erase(colours.begin());
  const Json colour = {{"field", "file"},
                       {"type", "nominal"},
                       {"scale", {{"domain", sides.files}, {"range", colours}}},
                       {"legend", {{"title", nullptr}, {"symbolOpacity", 1}}}};
  const std::string title = "times as fast as " + group.scene->reference;
  const Json x = side_axis("agents", "agents");
  const Json y = side_axis("ratio", title);
  const Json low = side_axis("low", title);
  Json spec = chart_frame(260);
  spec["data"] = {{"values", values}};
  spec["layer"] = Json::array(
      {{{"data", {{"values", Json::array({{{"ratio", 1}}})}}},
        {"mark", {{"type", "rule"}, {"strokeWidth", 1.5}, {"color", kChartInk}}},
        {"encoding", {{"y", y}}}},
       {{"mark", {{"type", "area"}, {"opacity", 0.18}}},
        {"encoding", {{"x", x}, {"y", low}, {"y2", {{"field", "high"}}}, {"color", colour}}}},
       {{"mark", {{"type", "line"}, {"strokeWidth", 2.5}}}, {"encoding", {{"x", x}, {"y", y}, {"color", colour}}}},
       {{"mark", {{"type", "rule"}, {"strokeWidth", 1.5}}},
        {"encoding", {{"x", x}, {"y", low}, {"y2", {{"field", "high"}}}, {"color", colour}}}},
       {{"mark", {{"type", "point"}, {"filled", true}, {"size", 60}, {"opacity", 1}}},
        {"encoding",
         {{"x", x},
          {"y", y},
          {"color", colour},
          {"tooltip", Json::array({side_tip("file", "file"), side_tip("agents", "agents"),
                                   side_tip("text", "times as fast"), side_tip("pairs", "interleaved pairs")})}}}}});
  return spec.dump();
}

}  // namespace crowdbench::reports
