#include "bench/sweep/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "bench/sweep/axes.h"
#include "bench/sweep/character_files.h"
#include "bench/sweep/expression.h"
#include "bench/sweep/sweep_table.h"
#include "core/error.h"
#include "core/files.h"
#include "core/hash.h"
#include "scene/cast/scenario_table.h"
#include "scene/scenario/scenario_writer.h"
#include "scene/scenario/toml_table.h"

namespace crowdbench::bench::sweep {
namespace {

using scene::TomlNode;
using scene::TomlTable;

// What decides what a point's rows hold, beside its scenario and its representation.
std::string fingerprint(const Measures& measures) {
  std::string text = fmt::format("{} {} {} {} {} {} {}", measures.reference.text(), measures.times, measures.aa,
                                 measures.rounds, measures.time_limit_s, measures.pictures, measures.bake_budget);
  for (const metrics::Score* score : measures.scores) text += fmt::format(" {}", score->name);
  return text;
}

Measures read_measures(const TomlNode* node, const std::string& where) {
  Measures out;
  out.reference = renderers::reference_spec();
  for (const metrics::Score* score : metrics::scores())
    if ((score->uses & metrics::kInTables) != 0) out.scores.push_back(score);
  if (node == nullptr) return out;
  const TomlTable table(
      *node, "measure", where,
      {"reference", "aa", "times", "rounds", "time_limit_s", "scores", "pictures", "together", "bake_budget_mib"});
  std::string reference;
  table.text("reference", reference);
  if (!reference.empty()) try {
      out.reference = renderers::parse_spec(renderers::parse_spec(reference).text());
    } catch (const Error& error) {
      throw Error(table.place("reference"), "`reference`: " + error.wrong, error.advice);
    }
  table.flag("aa", out.aa);
  table.flag("times", out.times);
  table.whole("rounds", kLeastRounds, 100'000, out.rounds);
  table.number("time_limit_s", 0, 1e6, out.time_limit_s);
  table.flag("pictures", out.pictures);
  table.whole("together", 1, 256, out.together);
  uint64_t mib = out.bake_budget >> 20U;
  table.whole("bake_budget_mib", 1, 1 << 20, mib);
  out.bake_budget = mib << 20U;
  if (const TomlNode* const scores = table.find("scores")) {
    if (!scores->is_list())
      table.fail(*scores, fmt::format("`scores` is {}", scores->type_name()), "give a list of names");
    out.scores.clear();
    std::vector<std::string> known;
    for (const metrics::Score* score : metrics::scores()) known.emplace_back(score->name);
    for (const TomlNode& name : scores->list) {
      const auto found = std::find(known.begin(), known.end(), name.text);
      if (!name.is_text() || found == known.end()) {
        const std::string near = nearest_name(name.text, known);
        table.fail(name, fmt::format("there is no score '{}'", printable(name.text, 60)),
                   near.empty() ? "see `crowdbench schema --scores`" : fmt::format("did you mean `{}`?", near));
      }
      const metrics::Score* const score = metrics::scores()[static_cast<size_t>(found - known.begin())];
      if (std::find(out.scores.begin(), out.scores.end(), score) == out.scores.end()) out.scores.push_back(score);
    }
  }
  if (!out.times && out.scores.empty())
    table.fail(*node, "neither times nor scores are wanted", "set times = true, or name scores");
  return out;
}

struct PointsTable {
  std::vector<Expression> where;
  Sampling sampling;
  std::string sample_place;
  int repetitions = 1;
  std::vector<std::vector<AxisValue>> also;
};

void read_sample(const TomlNode& node, const std::string& where, PointsTable& out) {
  const TomlTable table(node, "sample", where, {"method", "count", "seed"});
  out.sample_place = node.place(where);
  std::string method = "halton";
  table.text("method", method);
  if (method != "halton" && method != "random")
    throw Error(table.place("method"), fmt::format("`method` is '{}'", printable(method, 60)),
                "choose \"halton\" (low discrepancy) or \"random\"");
  out.sampling.halton = method == "halton";
  table.whole("count", 1, static_cast<int64_t>(kMostPoints), out.sampling.count);
  table.whole("seed", 0, INT64_MAX, out.sampling.seed);
  if (out.sampling.count == 0) throw Error(out.sample_place, "`sample` has no count", "add count = 20");
}

PointsTable read_points(const TomlNode* node, const std::string& where, const std::filesystem::path& folder,
                        const std::vector<Axis>& axes) {
  PointsTable out;
  if (node == nullptr) return out;
  const TomlTable table(*node, "points", where, {"where", "sample", "repetitions", "also"});
  std::vector<std::string> names;
  for (const Axis& axis : axes) names.push_back(axis.name);
  if (const TomlNode* const list = table.find("where")) {
    std::vector<TomlNode> texts = list->list;
    if (list->is_text()) texts = {*list};
    if (!list->is_text() && !list->is_list())
      table.fail(*list, fmt::format("`where` is {}", list->type_name()), "give a list of conditions in quotes");
    for (const TomlNode& text : texts) {
      if (!text.is_text()) table.fail(text, fmt::format("`where` holds {}", text.type_name()), "write it in quotes");
      out.where.emplace_back(text.text, text.place(where), names);
    }
  }
  if (const TomlNode* const sample = table.find("sample")) read_sample(*sample, where, out);
  table.whole("repetitions", 1, 1000, out.repetitions);
  for (const TomlNode* const point : table.tables("also")) out.also.push_back(read_listed(*point, where, folder, axes));
  return out;
}

// From combinations of values to conditions.
class Grouping {
 public:
  Grouping(const scene::Scenario& base, const PointsTable& points, std::string where, std::filesystem::path folder)
      : base_(base), points_(points), where_(std::move(where)), files_(std::move(folder)) {}

  void add(const std::vector<AxisValue>& values) {
    scene::Scenario scenario = base_;
    for (const bool named : {true, false})
      for (const AxisValue& value : values)
        if (value.change && value.named == named) value.change(scenario);
    PlannedPoint point = point_of(scenario, values);
    if (!wanted(point)) return;
    try {
      check_scenario(scenario, [&](const char*) { return where_; });
    } catch (const Error& error) {
      throw Error(where_, fmt::format("the point {}: {}", describe(point), error.wrong),
                  "leave it out by a condition in [points] `where`");
    }
    scenario.representation = "reference";
    const std::string text = scene::to_toml(scenario);
    const auto [found, fresh] = by_scenario_.emplace(text, conditions_.size());
    if (fresh) {
      std::string files = files_.fingerprint(scenario);
      conditions_.push_back({std::move(scenario), text, sha256_hex(text), {}, std::move(files)});
    }
    std::vector<PlannedPoint>& here = conditions_[found->second].points;
    if (std::none_of(here.begin(), here.end(), [&](const auto& p) { return p.representation == point.representation; }))
      here.push_back(std::move(point));
  }
  // No condition with more points than `together`.
  std::vector<Condition> take(size_t together) {
    std::vector<Condition> out;
    for (Condition& condition : conditions_) {
      std::vector<PlannedPoint> points = std::exchange(condition.points, {});
      for (size_t i = 0; i < points.size(); ++i) {
        if (i % together == 0) out.push_back(condition);
        out.back().points.push_back(std::move(points[i]));
      }
    }
    return out;
  }

 private:
  // Puts the options into the representation, and into the components of that name.
  static bool set_option(renderers::Spec& spec, const AxisValue& value) {
    bool any = false;
    if (spec.name == value.representation) {
      std::erase_if(spec.options, [&](const auto& option) { return option.first == value.option; });
      spec.options.emplace_back(value.option, value.setting.text);
      any = true;
    }
    for (renderers::Spec& component : spec.components) any = set_option(component, value) || any;
    return any;
  }

  PlannedPoint point_of(const scene::Scenario& scenario, const std::vector<AxisValue>& values) const {
    PlannedPoint point;
    try {
      point.spec = renderers::parse_spec(scenario.representation);
    } catch (const Error& error) {
      throw Error(where_, fmt::format("the representation '{}': {}", printable(scenario.representation), error.wrong),
                  error.advice);
    }
    for (const AxisValue& value : values)
      if (value.option.empty() || set_option(point.spec, value)) put(point.settings, value.setting);
    point.representation = point.spec.text();
    point.spec = renderers::parse_spec(point.representation);
    return point;
  }
  static void put(std::vector<Setting>& settings, const Setting& setting) {
    for (Setting& other : settings)
      if (other.axis == setting.axis) {
        other = setting;
        return;
      }
    settings.push_back(setting);
  }
  static std::string describe(const PlannedPoint& point) {
    std::string text;
    for (const Setting& setting : point.settings)
      text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", setting.axis, printable(setting.text, 80));
    return text;
  }

  bool wanted(const PlannedPoint& point) const {
    std::map<std::string, AxisNumberOrText> values;
    for (const Setting& setting : point.settings)
      values[setting.axis] = setting.number ? AxisNumberOrText(*setting.number) : AxisNumberOrText(setting.text);
    return std::all_of(points_.where.begin(), points_.where.end(), [&](const Expression& condition) {
      const bool says = std::all_of(condition.names().begin(), condition.names().end(),
                                    [&](const std::string& name) { return values.contains(name); });
      return !says || condition.holds(values);
    });
  }

  const scene::Scenario& base_;
  const PointsTable& points_;
  std::string where_;
  CharacterFiles files_;
  std::vector<Condition> conditions_;
  std::map<std::string, size_t> by_scenario_;
};

// An option that no point's representation has would be dropped without a word.
void require_used(const std::vector<Condition>& conditions, const std::vector<std::string>& names,
                  const std::vector<Axis>& axes, const std::string& points_place) {
  std::set<std::string> used;
  for (const Condition& condition : conditions)
    for (const PlannedPoint& point : condition.points)
      for (const Setting& setting : point.settings) used.insert(setting.axis);
  for (const std::string& name : names) {
    if (used.contains(name)) continue;
    const auto axis = std::find_if(axes.begin(), axes.end(), [&](const Axis& one) { return one.name == name; });
    throw Error(axis == axes.end() ? points_place : axis->place,
                fmt::format("`{}` changes nothing: no point draws `{}`", name, name.substr(0, name.find('.'))),
                fmt::format("add it to the axis `representation`, or leave `{}` out", name));
  }
}

void check_sampling(const std::vector<Axis>& axes, const PointsTable& points) {
  const auto sampled = std::find_if(axes.begin(), axes.end(), [](const Axis& axis) { return axis.sampled(); });
  if (sampled != axes.end() && points.sampling.count == 0)
    throw Error(sampled->place, fmt::format("the range of `{}` has no `steps`", sampled->name),
                "add steps = 5, or say how it is sampled: [points] sample = { method = \"halton\", count = 20 }");
  if (sampled == axes.end() && points.sampling.count > 0)
    throw Error(points.sample_place, "no axis is left for `sample`", "write a range without `steps`");
}

std::vector<TableRequest> read_tables(const TomlTable& top, const std::string& where, const Plan& plan) {
  std::vector<TableRequest> out;
  for (const TomlNode* const node : top.tables("table")) {
    const TomlTable table(*node, "table", where, {"title", "rows", "columns", "value", "at"});
    TableRequest request;
    request.place = node->place(where);
    table.text("title", request.title);
    table.text("rows", request.rows);
    table.text("columns", request.columns);
    table.text("value", request.value);
    double at = 0;
    table.number("at", 1e-6, 1e9, at);
    if (at > 0) request.at = at;
    check_table(request, plan.axes, plan.measures);
    out.push_back(std::move(request));
  }
  return out;
}

}  // namespace

size_t Plan::points() const {
  size_t count = 0;
  for (const Condition& condition : conditions) count += condition.points.size();
  return count * static_cast<size_t>(repetitions);
}

std::string Plan::key(const Condition& condition, const PlannedPoint& point, int repetition) const {
  Sha256 digest;
  if (!condition.character_files.empty()) digest.text(condition.character_files);
  digest.text(condition.scenario_text)
      .text(point.representation)
      .text(fingerprint(measures))
      .value(int64_t{repetition});
  return digest.hex().substr(0, 16);
}

Plan parse_plan(const std::string& toml, const std::string& where, const std::filesystem::path& folder) {
  const TomlNode document = scene::parse_toml(toml, where);
  const TomlTable top(document, "", where, {"name", "look_for", "scenario", "axes", "points", "measure", "table"});
  Plan plan;
  plan.name = std::filesystem::path(where).stem().string();
  plan.text = toml;
  plan.folder = folder;
  top.text("name", plan.name);
  top.text("look_for", plan.look_for);
  plan.measures = read_measures(top.find("measure"), where);

  scene::Scenario base;
  if (const TomlNode* const node = top.find("scenario")) {
    if (!node->is_table()) top.fail(*node, fmt::format("`scenario` is {}", node->type_name()), "write [scenario]");
    scene::change_by_table(base, *node, where, folder);
  }
  std::vector<Axis> axes;
  if (const TomlNode* const node = top.find("axes")) axes = read_axes(*node, where, folder);
  for (const Axis& axis : axes) plan.axes.push_back(axis.name);
  const PointsTable points = read_points(top.find("points"), where, folder, axes);
  check_sampling(axes, points);
  if (axes.empty() && points.also.empty())
    throw Error(where, "nothing varies: there are no axes", "add [axes] with crowd.agents = [1, 10, 100]");
  plan.repetitions = points.repetitions;

  Grouping grouping(base, points, top.place("axes"), folder);
  if (!axes.empty())
    for (const auto& values : combine(axes, points.sampling, top.place("axes"))) grouping.add(values);
  for (const auto& values : points.also) {
    grouping.add(values);
    for (const AxisValue& value : values)
      if (std::find(plan.axes.begin(), plan.axes.end(), value.setting.axis) == plan.axes.end())
        plan.axes.push_back(value.setting.axis);
  }
  plan.conditions = grouping.take(plan.measures.together);
  if (plan.conditions.empty())
    throw Error(top.place("points"), "the conditions leave no point", "loosen [points] `where`");
  require_used(plan.conditions, plan.axes, axes, top.place("points"));
  if (plan.points() > kMostPoints)
    throw Error(where, fmt::format("{} points, more than {}", plan.points(), kMostPoints), "make several plans of it");
  plan.tables = read_tables(top, where, plan);
  Sha256 digest;
  for (const Condition& condition : plan.conditions)
    for (const PlannedPoint& point : condition.points) digest.text(plan.key(condition, point, 0));
  // Conditions are known by their numbers: how they were made is part of what they are.
  plan.hash =
      digest.value(int64_t{plan.repetitions}).value(static_cast<int64_t>(plan.measures.together)).hex().substr(0, 16);
  return plan;
}

Plan read_plan(const std::filesystem::path& file) {
  return parse_plan(read_text(file, scene::kScenarioBytes), file.string(), file.parent_path());
}

}  // namespace crowdbench::bench::sweep
