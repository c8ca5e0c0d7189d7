#include "reports/charts/cost_charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/json.h"
#include "reports/charts/chart_frame.h"
#include "reports/charts/charts.h"
#include "reports/model/cost_text.h"
#include "reports/model/number_text.h"

namespace crowdbench::reports {
namespace {

constexpr double kBudgetMs = 1000.0 / 60;

Json colours(const Scene& scene, const char* field) {
  return {
      {"field", field},
      {"type", "nominal"},
      {"scale", {{"domain", scene.representations}, {"range", representation_colours(scene.representations.size())}}},
      {"legend", {{"title", nullptr}, {"symbolOpacity", 1}}}};
}

Json axis_of(const char* field, const char* title, bool log) {
  Json scale = {{"nice", true}};
  if (log)
    scale["type"] = "log";
  else
    scale["zero"] = false;
  return {
      {"field", field},
      {"type", "quantitative"},
      {"scale", scale},
      {"axis",
       {{"title", title}, {"tickCount", 5}, {"format", "~g"}, {"labelOverlap", "greedy"}, {"labelSeparation", 10}}}};
}

// Of a vertical axis whose title is a sentence: it lies over the axis, from the plot's left edge on. Upright beside a
// low chart it would be longer than the chart is high, and cut off. The legend goes above it.
void put_title_above(Json& spec, Json& y) {
  y["axis"].update(
      {{"titleAngle", 0}, {"titleAlign", "left"}, {"titleBaseline", "bottom"}, {"titleX", 0}, {"titleY", -10}});
  spec["config"]["legend"]["offset"] = 32;
}

Json tip(const char* field, const char* title) { return {{"field", field}, {"type", "nominal"}, {"title", title}}; }

double in_ms(double ns) { return 1e-6 * ns; }

// The headline time of a sample, nanoseconds.
std::optional<double> time_of_sample(const Scene& scene, const SampleRow& sample) {
  const std::string& metric = scene.run->headline;
  if (metric == "gpu") return sample.gpu_ns ? std::optional(static_cast<double>(*sample.gpu_ns)) : std::nullopt;
  return static_cast<double>(metric == "wall" ? sample.frame_ns : sample.cpu_ns);
}

Json sample_values(const Scene& scene, const std::vector<const MeasurementRow*>& rows, double& most) {
  Json values = Json::array();
  for (const MeasurementRow* row : rows)
    for (const SampleRow& sample : row->samples)
      if (const auto time = time_of_sample(scene, sample)) {
        most = std::max(most, in_ms(*time));
        values.push_back(
            {{"representation", row->key.representation}, {"round", sample.round + 1}, {"ms", in_ms(*time)}});
      }
  return values;
}

}  // namespace

std::string prediction_chart(const Scene& scene, const std::vector<CostModel>& models) {
  Json values = Json::array();
  double least = INFINITY;
  double most = 0;
  for (const CostModel& model : models)
    for (const CostPrediction& one : model.held_out) {
      const double measured = in_ms(one.point.time_ns);
      least = std::min(least, measured);
      most = std::max(most, measured);
      values.push_back({{"representation", model.representation},
                        {"measured", measured},
                        {"predicted", std::max(in_ms(one.predicted_ns), 1e-6)},
                        {"where", one.between ? "between the others" : "beyond the others"},
                        {"at", fmt::format("{}{}", agents_text(one.point.agents),
                                           one.point.occupancy > 0 ? ", " + percent_text(one.point.occupancy) : "")}});
    }
  if (values.empty()) return {};
  Json spec = chart_frame(280);
  spec["data"] = {{"values", values}};
  const Json x = axis_of("measured", "measured, ms", true);
  Json band = Json::array();
  for (const double at : {least / 1.2, most * 1.2})
    band.push_back({{"measured", at}, {"low", 0.85 * at}, {"high", 1.15 * at}});
  const Json low = axis_of("low", "predicted without that point, ms", true);
  spec["layer"] =
      Json::array({{{"data", {{"values", band}}},
                    {"mark", {{"type", "area"}, {"color", "#9aa5b1"}, {"opacity", 0.3}}},
                    {"encoding", {{"x", x}, {"y", low}, {"y2", {{"field", "high"}}}}}},
                   {{"mark", {{"type", "point"}, {"filled", true}, {"size", 55}, {"opacity", 0.85}}},
                    {"encoding",
                     {{"x", x},
                      {"y", axis_of("predicted", "predicted without that point, ms", true)},
                      {"color", colours(scene, "representation")},
                      {"tooltip", Json::array({tip("representation", "representation"), tip("at", "at"),
                                               tip("measured", "measured, ms"), tip("predicted", "predicted, ms"),
                                               tip("where", "where")})}}}}});
  return spec.dump();
}

std::string scatter_chart(const Scene& scene) {
  Json values = Json::array();
  constexpr size_t kMostPoints = 1000;
  const size_t step = 1 + scene.rows.size() / kMostPoints;
  for (size_t i = 0; i < scene.rows.size(); i += step) {
    const MeasurementRow* row = scene.rows[i];
    const auto& time = time_of(*row, scene.run->headline);
    if (!is_timed(*row) || !time || row->key.agents == 0) continue;
    values.push_back({{"representation", row->key.representation},
                      {"agents", row->key.agents},
                      {"ms", in_ms(time->median)},
                      {"low", in_ms(time->low)},
                      {"high", in_ms(time->high)},
                      {"occupancy", occupancy_text(row->key.requested_occupancy)},
                      {"median", time_text(time->median)}});
  }
  if (values.empty()) return {};
  Json spec = chart_frame(300);
  spec["data"] = {{"values", values}};
  const Json x = axis_of("agents", "agents", true);
  spec["layer"] =
      Json::array({{{"mark", {{"type", "rule"}, {"strokeWidth", 1.5}}},
                    {"encoding",
                     {{"x", x},
                      {"y", axis_of("low", "median, ms a frame", true)},
                      {"y2", {{"field", "high"}}},
                      {"color", colours(scene, "representation")}}}},
                   {{"mark", {{"type", "point"}, {"filled", true}, {"size", 45}, {"opacity", 0.85}}},
                    {"encoding",
                     {{"x", x},
                      {"y", axis_of("ms", "median, ms a frame", true)},
                      {"color", colours(scene, "representation")},
                      {"tooltip", Json::array({tip("representation", "representation"), tip("agents", "agents"),
                                               tip("occupancy", "occupancy"), tip("median", "median a frame")})}}}}});
  return spec.dump();
}

std::string cheapest_chart(const Scene& scene, const BreakEvenMap& map) {
  if (map.cells.empty()) return {};
  Json values = Json::array();
  std::vector<std::string> occupancies;
  for (const CheapestCell& cell : map.cells) {
    const std::string row = cell.occupancy > 0 ? percent_text(cell.occupancy) : std::string("own view");
    if (std::find(occupancies.begin(), occupancies.end(), row) == occupancies.end()) occupancies.push_back(row);
    std::string beside;
    for (const std::string& name : cell.not_told_apart) beside += (beside.empty() ? "" : ", ") + name;
    values.push_back({{"agents", count_text(static_cast<uint64_t>(cell.agents))},
                      {"order", cell.agents},
                      {"occupancy", row},
                      {"representation", cell.cheapest},
                      {"sure", cell.not_told_apart.empty()},
                      {"beside", beside.empty() ? std::string("nothing") : beside}});
  }
  std::reverse(occupancies.begin(), occupancies.end());
  Json spec = chart_frame(std::max<int>(60, 26 * static_cast<int>(occupancies.size())));
  spec["padding"] = {
      {"left", 5}, {"top", 5}, {"right", 10}, {"bottom", 5}};  // half of the last number is beyond its cell
  spec["data"] = {{"values", values}};
  spec["mark"] = {{"type", "rect"}};
  spec["encoding"] = {
      {"x",
       {{"field", "agents"},
        {"type", "ordinal"},
        {"sort", {{"field", "order"}}},
        {"axis", {{"title", "agents"}, {"labelAngle", 0}, {"labelOverlap", "greedy"}, {"labelSeparation", 10}}}}},
      {"y", {{"field", "occupancy"}, {"type", "ordinal"}, {"sort", occupancies}, {"axis", {{"title", "occupancy"}}}}},
      {"color", colours(scene, "representation")},
      {"opacity", {{"condition", {{"test", "datum.sure"}, {"value", 0.95}}}, {"value", 0.35}}},
      {"tooltip", Json::array({tip("representation", "cheapest"), tip("agents", "agents"),
                               tip("occupancy", "occupancy"), tip("beside", "not told apart from")})}};
  return spec.dump();
}

std::string front_chart(const Scene& scene, const ParetoFront& front) {
  Json values = Json::array();
  for (const ParetoEntry& entry : front.entries)
    if (entry.error && std::isfinite(*entry.error))
      values.push_back({{"representation", entry.representation},
                        {"time", entry.time},
                        {"low", entry.low},
                        {"high", entry.high},
                        {"error", *entry.error},
                        {"bytes", entry.bytes ? static_cast<double>(*entry.bytes) / (1 << 20) : 0.0},
                        {"size", entry.bytes ? bytes_text(*entry.bytes) : std::string("not known")},
                        {"front", entry.beaten_by.empty()},
                        {"state", front_text(front, entry)}});
  if (values.size() < 2) return {};
  Json spec = chart_frame(260);
  spec["data"] = {{"values", values}};
  const std::string title = heading(front.score);
  Json y = axis_of("error", title.c_str(), false);
  put_title_above(spec, y);
  spec["layer"] = Json::array(
      {{{"mark", {{"type", "rule"}}},
        {"encoding",
         {{"x", axis_of("low", "time over the reference's", true)},
          {"x2", {{"field", "high"}}},
          {"y", y},
          {"color", colours(scene, "representation")}}}},
       {{"mark", {{"type", "point"}, {"filled", true}}},
        {"encoding",
         {{"x", axis_of("time", "time over the reference's", true)},
          {"y", y},
          {"size",
           {{"field", "bytes"},
            {"type", "quantitative"},
            {"scale", {{"range", {60, 500}}, {"zero", true}}},
            {"legend", nullptr}}},
          {"color", colours(scene, "representation")},
          {"opacity", {{"condition", {{"test", "datum.front"}, {"value", 1}}}, {"value", 0.35}}},
          {"tooltip", Json::array({tip("representation", "representation"), tip("state", "state"), tip("time", "time"),
                                   tip("error", "error"), tip("size", "on the GPU")})}}}}});
  return spec.dump();
}

std::vector<const MeasurementRow*> sampled_rows(const Scene& scene, double occupancy) {
  std::vector<const MeasurementRow*> out;
  for (auto agents = scene.agents.rbegin(); agents != scene.agents.rend() && out.size() < 2; ++agents) {
    out.clear();
    for (const std::string& name : scene.representations) {
      const MeasurementRow* row = scene.find(name, *agents, occupancy);
      if (row != nullptr && is_timed(*row) && row->samples.size() > 1) out.push_back(row);
    }
  }
  return out;
}

std::string samples_chart(const Scene& scene, const std::vector<const MeasurementRow*>& rows) {
  double most = 0;
  const Json values = sample_values(scene, rows, most);
  if (values.empty()) return {};
  Json spec = chart_frame(220);
  spec["data"] = {{"values", values}};
  Json layers =
      Json::array({{{"mark", {{"type", "line"}, {"strokeWidth", 1.5}, {"point", {{"size", 18}}}}},
                    {"encoding",
                     {{"x",
                       {{"field", "round"},
                        {"type", "quantitative"},
                        {"scale", {{"zero", false}, {"nice", false}}},
                        {"axis", {{"title", "round"}, {"tickMinStep", 1}, {"tickCount", 8}, {"format", "d"}}}}},
                      {"y", axis_of("ms", "ms a frame", true)},
                      {"color", colours(scene, "representation")}}}}});
  if (most > kBudgetMs / 4)
    layers.push_back({{"data", {{"values", Json::array({{{"ms", kBudgetMs}}})}}},
                      {"mark", {{"type", "rule"}, {"strokeDash", {5, 4}}, {"color", kChartInk}}},
                      {"encoding", {{"y", axis_of("ms", "ms a frame", true)}}}});
  spec["layer"] = std::move(layers);
  return spec.dump();
}

std::string histogram_chart(const Scene& scene, const std::vector<const MeasurementRow*>& rows) {
  double most = 0;
  const Json values = sample_values(scene, rows, most);
  if (values.empty()) return {};
  Json spec = chart_frame(220);
  spec["data"] = {{"values", values}};
  // Bins even in the logarithm, so that a fast and a slow one are seen alike.
  spec["transform"] = Json::array({{{"calculate", "pow(10, floor(log(datum.ms) / LN10 * 40) / 40)"}, {"as", "from"}},
                                   {{"calculate", "datum.from * pow(10, 1 / 40)"}, {"as", "to"}},
                                   {{"aggregate", Json::array({{{"op", "count"}, {"as", "frames"}}})},
                                    {"groupby", {"representation", "from", "to"}}}});
  spec["mark"] = {{"type", "rect"}, {"opacity", 0.6}};
  spec["encoding"] = {{"x", axis_of("from", "ms a frame", true)},
                      {"x2", {{"field", "to"}}},
                      {"y",
                       {{"field", "frames"},
                        {"type", "quantitative"},
                        {"axis", {{"title", "frames"}, {"tickMinStep", 1}, {"tickCount", 5}}}}},
                      {"y2", {{"datum", 0}}},
                      {"color", colours(scene, "representation")}};
  return spec.dump();
}

}  // namespace crowdbench::reports
