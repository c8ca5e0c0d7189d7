#include "reports/charts/study_chart.h"

#include <fmt/format.h>

#include <algorithm>

#include "reports/charts/chart_frame.h"
#include "reports/charts/charts.h"

namespace crowdbench::reports {
namespace {

constexpr int kRowHeight = 30;
constexpr int kLineHeight = 13;
constexpr size_t kMostLineBytes = 24;

Json end_of(const std::optional<double>& end) { return end ? Json(*end) : Json(nullptr); }

// A name in lines that fit beside a chart on a narrow screen: broken at spaces, and where a word is too long, within
// it. Nothing is cut off: names of conditions often differ at their ends alone.
std::vector<std::string> lines_of(const std::string& name) {
  std::vector<std::string> out = {""};
  const auto take = [&](std::string word) {
    if (!out.back().empty() && out.back().size() + 1 + word.size() > kMostLineBytes) out.emplace_back();
    if (!out.back().empty()) out.back() += ' ';
    while (word.size() > kMostLineBytes) {
      size_t end = kMostLineBytes;
      while (end > 1 && (static_cast<unsigned char>(word[end]) & 0xC0U) == 0x80U) --end;  // whole characters of UTF-8
      out.back() = word.substr(0, end);
      out.emplace_back();
      word.erase(0, end);
    }
    out.back() += word;
  };
  for (size_t at = 0; at <= name.size();) {
    const size_t end = std::min(name.find(' ', at), name.size());
    if (end > at) take(name.substr(at, end - at));
    at = end + 1;
  }
  return out;
}

// The rows' names as an axis, and how much room they take.
struct NameRows {
  size_t longest = 0, most_lines = 1;
  // The name as the data holds it: its lines.
  std::string add(const std::string& name) {
    std::string out;
    const std::vector<std::string> lines = lines_of(name);
    for (const std::string& line : lines) {
      longest = std::max(longest, line.size());
      out += (out.empty() ? "" : "\n") + line;
    }
    most_lines = std::max(most_lines, lines.size());
    return out;
  }
  int row_height() const { return std::max(kRowHeight, kLineHeight * static_cast<int>(most_lines) + 20); }
  // What the renderer measures is a fifth narrower than the page's font.
  Json axis() const {
    return {{"field", "name"},
            {"type", "nominal"},
            {"sort", nullptr},
            {"axis",
             {{"title", nullptr},
              {"ticks", false},
              {"minExtent", static_cast<int>(12 + longest * 7)},
              {"labelExpr", "split(datum.label, '\\n')"},
              {"labelBaseline", "middle"},
              {"labelLineHeight", kLineHeight},
              {"labelLimit", 0}}}};
  }
};

Json tooltip_of(const char* field, const char* title) {
  return {{"field", field}, {"type", "nominal"}, {"title", title}};
}

Json points_of_curves(const StudyTask& task, bool lines) {
  Json out = Json::array();
  for (const StudyCurve& curve : task.curves)
    for (const StudyCurve::At& at : lines ? curve.line : curve.points)
      out.push_back({{"name", curve.name},
                     {"x", at.x},
                     {"share", at.share},
                     {"low", end_of(at.low)},
                     {"high", end_of(at.high)},
                     {"text", at.low && at.high ? fmt::format("{:.3f}, {:.3f} to {:.3f}", at.share, *at.low, *at.high)
                                                : fmt::format("{:.3f}", at.share)}});
  return out;
}

Json thresholds_of_curves(const StudyTask& task) {
  Json out = Json::array();
  for (const StudyCurve& curve : task.curves)
    if (curve.threshold)
      out.push_back({{"name", curve.name},
                     {"x", *curve.threshold},
                     {"low", end_of(curve.threshold_low)},
                     {"high", end_of(curve.threshold_high)},
                     {"share", curve.level},
                     {"text", fmt::format("{:.4g}", *curve.threshold)}});
  return out;
}

}  // namespace

std::string study_shares_chart(const StudyTask& task) {
  if (task.shares.empty()) return {};
  Json values = Json::array();
  NameRows names;
  for (const StudyShares& s : task.shares) {
    const std::string name = names.add(s.name);
    const double all = s.yes + s.ties + s.no;
    const std::pair<const char*, double> answers[] = {{"yes", s.yes}, {"cannot tell", s.ties}, {"no", s.no}};
    int order = 0;
    for (const auto& [answer, count] : answers)
      values.push_back({{"name", name},
                        {"answer", answer},
                        {"order", order++},
                        {"share", all > 0 ? 100 * count / all : 0},
                        {"text", fmt::format("{:g} of {:g}", count, all)}});
  }
  Json spec = chart_frame(names.row_height() * static_cast<int>(task.shares.size()) + 20);
  spec["data"] = {{"values", std::move(values)}};
  spec["mark"] = {{"type", "bar"}, {"height", {{"band", 0.7}}}};
  spec["encoding"] = {
      {"y", names.axis()},
      {"x",
       {{"field", "share"},
        {"type", "quantitative"},
        {"stack", "zero"},
        {"scale", {{"domain", {0, 100}}}},
        {"axis", {{"title", "% of all answers"}, {"tickCount", 5}}}}},
      {"order", {{"field", "order"}, {"type", "quantitative"}}},
      {"color",
       {{"field", "answer"},
        {"type", "nominal"},
        {"scale", {{"domain", {"yes", "cannot tell", "no"}}, {"range", {"#0072b2", "#9aa5b1", "#d55e00"}}}},
        {"legend", {{"title", nullptr}, {"columnPadding", 28}}}}},
      {"tooltip",
       Json::array({tooltip_of("name", "condition"), tooltip_of("answer", "answer"), tooltip_of("text", "answers")})}};
  return spec.dump();
}

std::string study_curves_chart(const StudyTask& task) {
  Json points = points_of_curves(task, false);
  if (points.empty()) return {};
  std::vector<std::string> names;
  for (const StudyCurve& curve : task.curves) names.push_back(curve.name);
  std::vector<std::string> colours = representation_colours(names.size() + 1);
  colours.erase(colours.begin());  // the first is the axes' ink
  const Json colour = {{"field", "name"},
                       {"type", "nominal"},
                       {"scale", {{"domain", names}, {"range", colours}}},
                       {"legend", names.size() > 1 ? Json({{"title", nullptr}, {"symbolOpacity", 1}}) : Json(nullptr)}};
  const Json x = {{"field", "x"},
                  {"type", "quantitative"},
                  {"scale", {{"zero", false}, {"nice", true}}},
                  {"axis", {{"title", task.axis}, {"tickCount", 8}}}};
  const auto y = [](const char* field) {
    return Json{{"field", field},
                {"type", "quantitative"},
                {"scale", {{"domain", {0, 1}}}},
                {"axis", {{"title", "share of yes"}, {"tickCount", 5}}}};
  };
  Json spec = chart_frame(300);
  spec["data"] = {{"values", std::move(points)}};
  Json layers = Json::array();
  layers.push_back({{"mark", {{"type", "rule"}, {"strokeWidth", 1.5}, {"opacity", 0.5}}},
                    {"encoding", {{"x", x}, {"y", y("low")}, {"y2", {{"field", "high"}}}, {"color", colour}}}});
  if (Json line = points_of_curves(task, true); !line.empty())
    layers.push_back({{"data", {{"values", std::move(line)}}},
                      {"mark", {{"type", "line"}, {"strokeWidth", 2}}},
                      {"encoding", {{"x", x}, {"y", y("share")}, {"color", colour}}}});
  if (Json thresholds = thresholds_of_curves(task); !thresholds.empty()) {
    Json low = x;
    low["field"] = "low";
    // An axis over no number at all is none.
    const bool any_interval = std::any_of(task.curves.begin(), task.curves.end(),
                                          [](const StudyCurve& c) { return c.threshold && c.threshold_low; });
    if (any_interval)
      layers.push_back({{"data", {{"values", thresholds}}},
                        {"mark", {{"type", "rule"}, {"strokeWidth", 4}, {"opacity", 0.45}}},
                        {"encoding", {{"x", low}, {"x2", {{"field", "high"}}}, {"y", y("share")}, {"color", colour}}}});
    layers.push_back(
        {{"data", {{"values", std::move(thresholds)}}},
         {"mark", {{"type", "point"}, {"shape", "diamond"}, {"filled", true}, {"size", 110}, {"opacity", 1}}},
         {"encoding",
          {{"x", x},
           {"y", y("share")},
           {"color", colour},
           {"tooltip", Json::array({tooltip_of("name", "condition"), tooltip_of("text", "threshold")})}}}});
  }
  layers.push_back({{"mark", {{"type", "point"}, {"filled", true}, {"size", 45}, {"opacity", 1}}},
                    {"encoding",
                     {{"x", x},
                      {"y", y("share")},
                      {"color", colour},
                      {"tooltip", Json::array({tooltip_of("name", "condition"), tooltip_of("x", task.axis.c_str()),
                                               tooltip_of("text", "share")})}}}});
  spec["layer"] = std::move(layers);
  return spec.dump();
}

std::string study_rows_chart(const std::vector<StudyPoint>& rows, const std::string& axis) {
  if (rows.empty()) return {};
  Json values = Json::array();
  NameRows names;
  for (const StudyPoint& row : rows) {
    values.push_back({{"name", names.add(row.name)},
                      {"value", row.value},
                      {"low", end_of(row.low)},
                      {"high", end_of(row.high)},
                      {"text", row.text}});
  }
  const auto x = [&](const char* field) {
    return Json{{"field", field},
                {"type", "quantitative"},
                {"scale", {{"zero", false}, {"nice", true}}},
                {"axis", {{"title", axis}, {"tickCount", 4}}}};
  };
  Json spec = chart_frame(names.row_height() * static_cast<int>(rows.size()) + 20);
  spec["data"] = {{"values", std::move(values)}};
  Json layers = Json::array();
  if (std::any_of(rows.begin(), rows.end(), [](const StudyPoint& row) { return row.low.has_value(); }))
    layers.push_back({{"mark", {{"type", "rule"}, {"strokeWidth", 2}, {"color", "#0072b2"}, {"opacity", 0.6}}},
                      {"encoding", {{"y", names.axis()}, {"x", x("low")}, {"x2", {{"field", "high"}}}}}});
  layers.push_back({{"mark", {{"type", "point"}, {"filled", true}, {"size", 60}, {"opacity", 1}, {"color", "#0072b2"}}},
                    {"encoding",
                     {{"y", names.axis()},
                      {"x", x("value")},
                      {"tooltip", Json::array({tooltip_of("name", "name"), tooltip_of("text", "value")})}}}});
  spec["layer"] = std::move(layers);
  return spec.dump();
}

}  // namespace crowdbench::reports
