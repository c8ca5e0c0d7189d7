#include "reports/charts/chart_frame.h"

#include <fmt/format.h>

#include <algorithm>

namespace crowdbench::reports {
namespace {

constexpr const char* kSchema = "https://vega.github.io/schema/vega-lite/v6.json";  // a name; nothing loads it
constexpr const char* kGrid = "#e4e7eb";

Json config() {
  return {{"background", "transparent"},
          {"view", {{"stroke", nullptr}}},
          {"axis",
           {{"labelFontSize", 12},
            {"labelLimit", 0},  // Vega's own cuts options off long names
            {"titleFontSize", 12},
            {"titleFontWeight", 600},
            {"titlePadding", 10},
            {"labelColor", kChartInk},
            {"titleColor", kChartInk},
            {"gridColor", kGrid},
            {"domainColor", "#9aa5b1"},
            {"tickColor", "#9aa5b1"}}},
          {"legend",
           {{"labelFontSize", 12},
            {"labelLimit", 0},
            {"titleFontSize", 12},
            {"labelColor", kChartInk},
            {"titleColor", kChartInk},
            {"orient", "top"},
            // Two legends one over the other: beside each other they are wider than a phone.
            {"layout", {{"top", {{"direction", "vertical"}, {"anchor", "start"}, {"margin", 2}}}}},
            {"title", nullptr}}}};
}

}  // namespace

Json chart_frame() { return {{"$schema", kSchema}, {"config", config()}}; }

Json chart_frame(int height) {
  Json frame = chart_frame();
  frame["width"] = "container";
  frame["height"] = height;
  frame["autosize"] = {{"type", "fit-x"}, {"contains", "padding"}};
  return frame;
}

}  // namespace crowdbench::reports
