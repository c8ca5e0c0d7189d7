#include "reports/charts/clip_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "reports/charts/chart_frame.h"

namespace crowdbench::reports {
namespace {

// From the least to the greatest finite value, with room for the worst frame's label on either side, but never beyond
// what the score can be. At least one value is finite.
Json axis_range(const ClipSeries& series) {
  double least = std::numeric_limits<double>::infinity();
  double greatest = -least;
  for (const std::optional<double>& value : series.by_frame) {
    if (!value || !std::isfinite(*value)) continue;
    least = std::min(least, *value);
    greatest = std::max(greatest, *value);
  }
  constexpr double kRoom = 0.15;  // of the span
  const double last_digit = std::pow(10.0, -series.doc.digits);
  const double room = std::max(kRoom * (greatest - least), 5 * last_digit);
  constexpr double kOpen = std::numeric_limits<double>::infinity();
  return {std::max(least - room, series.doc.least.value_or(-kOpen)),
          std::min(greatest + room, series.doc.greatest.value_or(kOpen))};
}

}  // namespace

std::string clip_chart(const ClipSeries& series, double fps) {
  const char* const at = fps > 0 ? "seconds" : "frame";
  Json values = Json::array();
  Json worst = Json::array();
  size_t drawn = 0;
  for (size_t frame = 0; frame < series.by_frame.size(); ++frame) {
    const std::optional<double>& value = series.by_frame[frame];
    Json point = {{"frame", frame}, {"value", nullptr}, {"text", value ? score_text(series.doc, *value) : "–"}};
    if (fps > 0) point["seconds"] = static_cast<double>(frame) / fps;
    if (value && std::isfinite(*value)) {
      point["value"] = *value;
      ++drawn;
      if (series.worst_frame == frame) {
        worst.push_back(point);
        worst.back()["label"] = fmt::format("frame {}", frame);
      }
    }
    values.push_back(std::move(point));
  }
  if (drawn == 0) return {};
  Json spec = chart_frame(180);
  const Json x = {{"field", at},
                  {"type", "quantitative"},
                  {"axis", {{"title", fps > 0 ? "seconds" : "frame"}, {"tickCount", 8}, {"labelSeparation", 8}}}};
  const Json y = {{"field", "value"},
                  {"type", "quantitative"},
                  {"scale", {{"zero", false}, {"nice", false}, {"domain", axis_range(series)}}},
                  // The heading above names the score.
                  {"axis", {{"title", series.doc.unit}, {"tickCount", 5}}}};
  const auto tip = [](const char* field, const char* title) {
    return Json{{"field", field}, {"type", "nominal"}, {"title", title}};
  };
  // The worst frame is an end of the curve: its label stands beyond it, towards the middle of the chart.
  const bool late = series.worst_frame && 2 * *series.worst_frame > series.by_frame.size();
  const Json label = {{"type", "text"},      {"align", late ? "right" : "left"},
                      {"dx", late ? -2 : 2}, {"dy", series.doc.higher_is_better ? 15 : -13},
                      {"fontSize", 12},      {"color", "#d55e00"}};
  const std::string colour = "#0072b2";
  const std::string mark = "#d55e00";
  spec["data"] = {{"values", values}};
  spec["layer"] = Json::array(
      {{{"mark", {{"type", "line"}, {"strokeWidth", 2}, {"color", colour}, {"invalid", "break-paths-show-domains"}}},
        {"encoding", {{"x", x}, {"y", y}}}},
       {{"data", {{"values", worst}}},
        {"mark", {{"type", "point"}, {"filled", true}, {"size", 80}, {"opacity", 1}, {"color", mark}}},
        {"encoding", {{"x", x}, {"y", y}}}},
       {{"data", {{"values", worst}}},
        {"mark", label},
        {"encoding", {{"x", x}, {"y", y}, {"text", {{"field", "label"}}}}}},
       {{"mark", {{"type", "point"}, {"filled", true}, {"size", 300}, {"opacity", 0}}},
        {"encoding", {{"x", x}, {"y", y}, {"tooltip", Json::array({tip("frame", "frame"), tip("text", "value")})}}}}});
  return spec.dump();
}

}  // namespace crowdbench::reports
