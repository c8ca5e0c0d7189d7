#include "bench/sweep/sweep_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/counted.h"
#include "core/error.h"
#include "core/short_numbers.h"
#include "core/statistics.h"
#include "renderers/representation.h"

namespace crowdbench::bench::sweep {
namespace {

constexpr const char* kRepresentation = "representation";
constexpr const char* kAgentsAt = "agents_at_ms";

struct MeasuredValue {
  double value = 0;
  std::optional<double> low, high;
};

// A point with all that is known of it.
struct PointView {
  const SweepPointRow* row = nullptr;
  std::map<std::string, std::string> settings;
  const RunRow* run = nullptr;
  const MeasurementRow* measurement = nullptr;
  const ComparisonRow* comparison = nullptr;
};

using Views = std::vector<PointView>;

// By axis and value what stands for it in a table.
using AxisTexts = std::map<std::string, std::map<std::string, std::string>>;
AxisTexts texts_of(const Views& views) {
  std::map<std::string, std::set<std::string>> values;
  for (const PointView& view : views)
    for (const auto& [axis, text] : view.settings) values[axis].insert(text);
  AxisTexts out;
  for (const auto& [axis, texts] : values) out[axis] = short_numbers(texts);
  return out;
}
std::string text_on(const AxisTexts& texts, const std::string& axis, const std::string& value) {
  const auto of = texts.find(axis);
  if (of == texts.end()) return value;
  const auto found = of->second.find(value);
  return found == of->second.end() ? value : found->second;
}

Views views_of(const StoreContents& contents) {
  std::map<int64_t, const RunRow*> runs;
  std::map<int64_t, const MeasurementRow*> measurements;
  std::map<int64_t, const ComparisonRow*> comparisons;
  for (const RunRow& row : contents.runs) runs[row.id] = &row;
  for (const MeasurementRow& row : contents.measurements) measurements[row.id] = &row;
  for (const ComparisonRow& row : contents.comparisons) comparisons[row.id] = &row;
  const auto find = [](const auto& rows, const std::optional<int64_t>& id) {
    const auto found = id ? rows.find(*id) : rows.end();
    return found == rows.end() ? nullptr : found->second;
  };
  Views views;
  for (const SweepPointRow& row : contents.sweep_points) {
    PointView view;
    view.row = &row;
    const nlohmann::json settings = nlohmann::json::parse(row.settings, nullptr, false);
    if (settings.is_object())
      for (const auto& [axis, text] : settings.items())
        if (text.is_string()) view.settings[axis] = text.get<std::string>();
    view.settings[kRepresentation] = row.representation;
    view.run = find(runs, row.run);
    view.measurement = find(measurements, row.measurement);
    view.comparison = find(comparisons, row.comparison);
    views.push_back(std::move(view));
  }
  return views;
}

std::optional<MeasuredValue> milliseconds(const std::optional<TimeSummary>& time) {
  if (!time) return std::nullopt;
  return MeasuredValue{time->median / 1e6, time->low / 1e6, time->high / 1e6};
}

std::optional<MeasuredValue> headline_ms(const PointView& view) {
  if (view.measurement == nullptr || view.run == nullptr) return std::nullopt;
  if (view.run->headline == "cpu") return milliseconds(view.measurement->cpu_ns);
  return milliseconds(view.run->headline == "gpu" ? view.measurement->gpu_ns : view.measurement->frame_ns);
}

template <typename T>
std::optional<MeasuredValue> scaled(const std::optional<T>& value, double by) {
  if (!value) return std::nullopt;
  return MeasuredValue{static_cast<double>(*value) * by, {}, {}};
}

// A measure that is not a score.
struct MeasureDoc {
  const char* name;
  const char* title;
  int digits;
  bool timed;
  std::optional<MeasuredValue> (*of)(const PointView&);
};

template <auto Member>
std::optional<MeasuredValue> time_of(const PointView& view) {
  return view.measurement == nullptr ? std::nullopt : milliseconds(view.measurement->*Member);
}
template <auto Member, int Exponent>
std::optional<MeasuredValue> amount_of(const PointView& view) {
  return view.measurement == nullptr ? std::nullopt : scaled(view.measurement->*Member, std::pow(10, Exponent));
}
std::optional<MeasuredValue> ratio_of(const PointView& view) {
  if (!view.row->ratio) return std::nullopt;
  return MeasuredValue{*view.row->ratio, view.row->ratio_low, view.row->ratio_high};
}
std::optional<MeasuredValue> speed_of(const PointView& view) {
  return view.row->role == "aa" ? std::nullopt : ratio_of(view);
}
std::optional<MeasuredValue> aa_of(const PointView& view) {
  return view.row->role == "aa" ? ratio_of(view) : std::nullopt;
}

const std::vector<MeasureDoc>& measure_docs() {
  using M = MeasurementRow;
  static const std::vector<MeasureDoc> all = {
      {"time_ms", "time, ms", 3, true, headline_ms},
      {"frame_ms", "wall time, ms", 3, true, time_of<&M::frame_ns>},
      {"cpu_ms", "CPU time, ms", 3, true, time_of<&M::cpu_ns>},
      {"gpu_ms", "GPU time, ms", 3, true, time_of<&M::gpu_ns>},
      {"speed", "times as fast as the reference", 2, true, speed_of},
      {"aa", "A/A ratio", 3, true, aa_of},
      {"occupancy", "occupancy", 3, false, amount_of<&M::achieved_occupancy, 0>},
      {"triangles", "triangles an agent", 0, false, amount_of<&M::triangles_per_agent, 0>},
      {"texture_mb", "textures, MB", 2, false, amount_of<&M::texture_bytes, -6>},
      {"buffer_mb", "buffers, MB", 2, false, amount_of<&M::buffer_bytes, -6>},
      {"bake_s", "bake (cold), s", 2, false, amount_of<&M::bake_seconds, 0>},
      {kAgentsAt, "agents", 0, true, headline_ms},
  };
  return all;
}

// A measure by its name: one of the above, or a score.
struct Measure {
  std::string name, title;
  int digits = 3;
  std::function<std::optional<MeasuredValue>(const PointView&)> of;
};

std::optional<MeasuredValue> score_of(const PointView& view, std::string_view name) {
  if (view.comparison == nullptr) return std::nullopt;
  for (const ScoreRow& score : view.comparison->scores)
    if (score.name == name && score.value) return MeasuredValue{*score.value, {}, {}};
  return std::nullopt;
}

std::optional<Measure> measure_of(const std::string& name) {
  for (const MeasureDoc& doc : measure_docs())
    if (doc.name == name) return Measure{name, doc.title, doc.digits, doc.of};
  for (const metrics::Score* score : metrics::scores())
    if (score->name == name) {
      std::string title(score->title);
      if (!score->unit.empty()) title += fmt::format(", {}", score->unit);
      return Measure{name, title, score->digits, [name](const PointView& view) { return score_of(view, name); }};
    }
  return std::nullopt;
}

std::string cell_text(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c);
  return out;
}

std::string value_text(const std::vector<MeasuredValue>& values, int digits) {
  if (values.empty()) return "-";
  if (values.size() == 1) {
    const MeasuredValue& one = values.front();
    std::string text = fmt::format("{:.{}f}", one.value, digits);
    if (one.low && one.high) text += fmt::format(" [{:.{}f}, {:.{}f}]", *one.low, digits, *one.high, digits);
    return text;
  }
  std::vector<double> numbers;
  for (const MeasuredValue& value : values) numbers.push_back(value.value);
  std::sort(numbers.begin(), numbers.end());
  if (numbers.front() == numbers.back()) return fmt::format("{:.{}f}", numbers.front(), digits);
  const double middle = 0.5 * (numbers[(numbers.size() - 1) / 2] + numbers[numbers.size() / 2]);
  return fmt::format("{:.{}f} (of {})", middle, digits, numbers.size());
}

// How many agents are drawn in so many milliseconds, between points along a power law.
std::string agents_text(const std::map<double, std::vector<double>>& times, double ms) {
  std::vector<std::pair<double, double>> curve;
  for (const auto& [agents, of] : times) curve.emplace_back(agents, median(of));
  if (curve.empty()) return "-";
  if (curve.front().second > ms) return fmt::format("< {:g}", curve.front().first);
  for (size_t i = 0; i + 1 < curve.size(); ++i) {
    const auto [x0, y0] = curve[i];
    const auto [x1, y1] = curve[i + 1];
    if (y1 <= ms || y1 <= y0 || x0 <= 0) continue;
    const double share = std::log(ms / y0) / std::log(y1 / y0);
    return fmt::format("{:.0f}", std::exp(std::log(x0) + share * (std::log(x1) - std::log(x0))));
  }
  return fmt::format("> {:g}", curve.back().first);
}

bool is_at(const PointView& view, const std::string& axis, const std::string& value) {
  if (axis.empty()) return true;
  const auto found = view.settings.find(axis);
  return found != view.settings.end() && found->second == value;
}

// The different values on an axis, in the order in which points have them; numbers in no order (samples, points listed
// besides) ascend.
std::vector<std::string> values_on(const Views& views, const std::string& axis) {
  std::vector<std::string> out;
  for (const PointView& view : views) {
    const auto found = view.settings.find(axis);
    if (found != view.settings.end() && std::find(out.begin(), out.end(), found->second) == out.end())
      out.push_back(found->second);
  }
  std::vector<double> numbers;
  for (const std::string& text : out) {
    double number = 0;
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (fault != std::errc{} || end != text.data() + text.size()) return out;
    numbers.push_back(number);
  }
  if (std::is_sorted(numbers.begin(), numbers.end()) || std::is_sorted(numbers.rbegin(), numbers.rend())) return out;
  std::vector<std::pair<double, std::string>> ascending;
  for (size_t i = 0; i < out.size(); ++i) ascending.emplace_back(numbers[i], out[i]);
  std::sort(ascending.begin(), ascending.end());
  for (size_t i = 0; i < out.size(); ++i) out[i] = ascending[i].second;
  return out;
}

// Whether a column is of the reference alone, which has no such value: a score of it against itself.
bool is_empty_reference(const Views& views, const std::string& axis, const std::string& value, const Measure& measure) {
  return std::all_of(views.begin(), views.end(), [&](const PointView& view) {
    return view.row->role == "aa" || !is_at(view, axis, value) || (view.row->role == "reference" && !measure.of(view));
  });
}

std::string cell_of(const Views& views, const TableRequest& request, const Measure& measure, const std::string& row,
                    const std::string& column) {
  std::vector<MeasuredValue> values;
  std::map<double, std::vector<double>> by_agents;
  const bool by_representation = request.rows == kRepresentation || request.columns == kRepresentation;
  for (const PointView& view : views) {
    // What points are held against is a point of its own only where representations are told apart.
    if (view.row->role == "reference" && !by_representation) continue;
    if (!is_at(view, request.rows, row) || !is_at(view, request.columns, column)) continue;
    const std::optional<MeasuredValue> value = measure.of(view);
    if (!value) continue;
    values.push_back(*value);
    if (view.measurement != nullptr) by_agents[view.measurement->key.agents].push_back(value->value);
  }
  if (measure.name == kAgentsAt) return agents_text(by_agents, request.at.value_or(0));
  return value_text(values, measure.digits);
}

std::string markdown_row(const std::vector<std::string>& cells) {
  std::string line = "|";
  for (const std::string& cell : cells) line += " " + cell_text(cell) + " |";
  return line + "\n";
}
std::string markdown_rule(size_t names, size_t numbers) {
  std::string line = "|";
  for (size_t i = 0; i < names; ++i) line += "---|";
  for (size_t i = 0; i < numbers; ++i) line += "--:|";
  return line + "\n";
}

bool any_has(const Views& views, const Measure& measure) {
  return std::any_of(views.begin(), views.end(), [&](const PointView& view) { return measure.of(view).has_value(); });
}

// One row a point.
std::string long_table(const Plan& plan, const Views& views) {
  std::vector<std::string> axes = plan.axes;
  std::erase(axes, kRepresentation);
  axes.emplace_back(kRepresentation);
  std::vector<Measure> shown;
  std::vector<std::string> names = {"time_ms", "speed", "texture_mb"};
  for (const metrics::Score* score : plan.measures.scores) names.emplace_back(score->name);
  for (const std::string& name : names)
    if (const std::optional<Measure> measure = measure_of(name); measure && any_has(views, *measure))
      shown.push_back(*measure);
  std::vector<std::string> head = axes;
  for (const Measure& measure : shown) head.push_back(measure.title);
  head.emplace_back("state");
  std::string out = markdown_row(head) + markdown_rule(axes.size(), shown.size() + 1);
  const AxisTexts texts = texts_of(views);
  for (const PointView& view : views) {
    if (view.row->role == "aa") continue;
    std::vector<std::string> cells;
    for (const std::string& axis : axes) {
      const auto found = view.settings.find(axis);
      cells.push_back(found == view.settings.end() ? "" : text_on(texts, axis, found->second));
    }
    for (const Measure& measure : shown) {
      const std::optional<MeasuredValue> value = measure.of(view);
      cells.push_back(value_text(value ? std::vector{*value} : std::vector<MeasuredValue>{}, measure.digits));
    }
    cells.push_back(view.row->role == "reference" ? "reference" : view.row->state);
    out += markdown_row(cells);
  }
  return out;
}

std::string aa_text(const Views& views) {
  size_t pairs = 0;
  size_t apart = 0;
  double widest = 0;
  for (const PointView& view : views) {
    const std::optional<MeasuredValue> ratio = aa_of(view);
    if (!ratio || !ratio->low || !ratio->high) continue;
    ++pairs;
    apart += *ratio->low > 1 || *ratio->high < 1 ? 1 : 0;
    widest = std::max(widest, std::abs(std::log(ratio->value)));
  }
  if (pairs == 0) return {};
  return fmt::format(
      "A/A: of {} of the reference with itself the 95 % interval of {} leaves 1 out; the farthest is {:.1f} % "
      "off.\n",
      counted(pairs, "pair", "pairs"), apart, 100 * (std::exp(widest) - 1));
}

// A speed against the whole reference says little of what would be drawn instead: a level of detail of it.
std::string no_levels_text(const Views& views) {
  const std::string reference = renderers::reference_spec().text();
  bool speed = false;
  for (const PointView& view : views) {
    if (view.row->representation.starts_with(reference + ":")) return {};
    speed = speed || (view.row->representation != reference && speed_of(view));
  }
  if (!speed) return {};
  return fmt::format(
      "No level of detail of {} was measured beside these speeds: bench/plans/levels_of_detail.toml sets each beside "
      "the "
      "levels of equal error and of equal cost.\n",
      reference);
}

std::string reasons_text(const Views& views) {
  std::map<std::string, std::pair<size_t, const PointView*>> by_reason;
  for (const PointView& view : views) {
    if (view.row->state == "done") continue;
    auto& [count, first] = by_reason[view.row->state + ": " + view.row->reason];
    if (count++ == 0) first = &view;
  }
  std::string out;
  for (const auto& [reason, where] : by_reason)
    out += fmt::format("{} {} ({}{})\n", where.first, where.first == 1 ? "point" : "points", reason,
                       where.first > 1 ? "; the first: " + where.second->row->representation : "");
  return out;
}

}  // namespace

void check_table(const TableRequest& request, const std::vector<std::string>& axes, const Measures& measures) {
  std::vector<std::string> known = axes;
  known.emplace_back(kRepresentation);
  const auto check_axis = [&](const char* key, const std::string& name) {
    if (std::find(known.begin(), known.end(), name) != known.end()) return;
    const std::string near = nearest_name(name, known);
    throw Error(
        request.place, fmt::format("`{}`: there is no axis '{}'", key, printable(name, 60)),
        near.empty() ? fmt::format("choose of {}", fmt::join(known, ", ")) : fmt::format("did you mean `{}`?", near));
  };
  check_axis("rows", request.rows);
  if (!request.columns.empty()) check_axis("columns", request.columns);
  if (!measure_of(request.value)) {
    std::vector<std::string> names;
    for (const MeasureDoc& doc : measure_docs()) names.emplace_back(doc.name);
    for (const metrics::Score* score : measures.scores) names.emplace_back(score->name);
    const std::string near = nearest_name(request.value, names);
    throw Error(
        request.place, fmt::format("`value`: there is no measure '{}'", printable(request.value, 60)),
        near.empty() ? fmt::format("choose of {}", fmt::join(names, ", ")) : fmt::format("did you mean `{}`?", near));
  }
  const bool score = std::any_of(metrics::scores().begin(), metrics::scores().end(),
                                 [&](const metrics::Score* s) { return s->name == request.value; });
  if (score && std::none_of(measures.scores.begin(), measures.scores.end(),
                            [&](const metrics::Score* s) { return s->name == request.value; }))
    throw Error(request.place, fmt::format("the score '{}' is not measured", request.value),
                "name it in [measure] `scores`");
  for (const MeasureDoc& doc : measure_docs())
    if (doc.name == request.value && doc.timed && !measures.times)
      throw Error(request.place, fmt::format("'{}' needs times", request.value), "set [measure] `times` to true");
  if ((request.value == kAgentsAt) != request.at.has_value())
    throw Error(request.place, fmt::format("`at` and the measure {} belong together", kAgentsAt),
                "give at = 33, in milliseconds, or another measure");
}

std::string table_text(const TableRequest& request, const Plan& plan, const StoreContents& contents) {
  const Views views = views_of(contents);
  const Measure measure = measure_of(request.value).value();
  std::string what = measure.title;
  if (request.at) what += fmt::format(" in {:g} ms a frame", *request.at);
  std::vector<std::string> columns = {what};
  if (!request.columns.empty()) {
    columns = values_on(views, request.columns);
    std::erase_if(columns,
                  [&](const std::string& one) { return is_empty_reference(views, request.columns, one, measure); });
  }
  const AxisTexts texts = texts_of(views);
  std::vector<std::string> head = {request.rows};
  for (const std::string& column : columns) head.push_back(text_on(texts, request.columns, column));
  std::string out = fmt::format("**{}**{}\n\n", request.title.empty() ? plan.name : request.title,
                                request.columns.empty() ? "" : fmt::format(": {}, by {}", what, request.columns));
  out += markdown_row(head) + markdown_rule(1, columns.size());
  for (const std::string& row : values_on(views, request.rows)) {
    std::vector<std::string> cells = {text_on(texts, request.rows, row)};
    for (const std::string& column : columns) cells.push_back(cell_of(views, request, measure, row, column));
    out += markdown_row(cells);
  }
  return out;
}

std::string sweep_text(const Plan& plan, const StoreContents& contents) {
  std::string out;
  if (!plan.look_for.empty()) out += plan.look_for + "\n\n";
  const Views views = views_of(contents);
  for (const TableRequest& request : plan.tables) out += table_text(request, plan, contents) + "\n";
  if (plan.tables.empty()) out += long_table(plan, views) + "\n";
  return out + no_levels_text(views) + aa_text(views) + reasons_text(views);
}

}  // namespace crowdbench::bench::sweep
